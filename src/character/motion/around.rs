//! The colliders about a body, gathered once a tick, so that its casts needn't each search the whole world.
//!
//! World space, metres.

use std::borrow::Cow;

use avian3d::{
    collision::collider::contact_query::contact_manifolds,
    parry::{
        math::{Pose, Vector},
        query::{self, ShapeCastOptions},
        shape::HeightField,
    },
    prelude::{Collider, ColliderAabb, RigidBody, Rotation},
};
use bevy::prelude::*;

use super::{
    capsules::{UprightCapsule, sweep_capsule},
    field::UprightField,
    frame::Frame,
    heightfield::{Span, Sweep, reaches_into},
    space::{Floor, Hit, View},
};

/// A collider that a body may meet: no sensor, and on one of its layers.
#[derive(Clone, Copy)]
pub(super) struct Solid<'a> {
    pub(super) entity: Entity,
    /// The rigid body that it belongs to.
    pub(super) body: Entity,
    shape: &'a Collider,
    pub(super) frame: Frame,
    bounds: Span,
    /// Whether its body never moves by itself.
    pub(super) is_static: bool,
    pub(super) field: Option<&'a HeightField>,
    upright_field: Option<UprightField<'a>>,
}

/// All solids that reach into a region.
pub(super) struct Around<'a> {
    region: Span,
    solids: Vec<Solid<'a>>,
}

/// The same memory for solids of another tick: collecting in place keeps it.
pub(super) fn recycled<'b>(mut solids: Vec<Solid<'_>>) -> Vec<Solid<'b>> {
    solids.clear();
    solids.into_iter().map_while(|_| None).collect()
}

impl View<'_> {
    /// All solids that reach into `span`, and perhaps some more.
    pub(super) fn solids_in(&self, span: Span) -> Cow<'_, [Solid<'_>]> {
        if self.around.region.contains(span) {
            Cow::Borrowed(&self.around.solids)
        } else {
            let mut around = Around::new(span, Vec::new());
            self.space.gather(self.me, &self.filter, &mut around);
            Cow::Owned(around.solids)
        }
    }
}

impl<'a> Around<'a> {
    /// Of nothing yet; `solids` is memory to use.
    pub(super) fn new(region: Span, solids: Vec<Solid<'a>>) -> Self {
        Self { region, solids }
    }

    /// Has others gather what is in `region`.
    pub(super) fn set_region(&mut self, region: Span) {
        self.region = region;
    }

    pub(super) fn region(&self) -> Span {
        self.region
    }

    /// The memory that it used, empty.
    pub(super) fn into_memory<'b>(self) -> Vec<Solid<'b>> {
        recycled(self.solids)
    }

    pub(super) fn push(
        &mut self,
        entity: Entity,
        body: Entity,
        kind: RigidBody,
        shape: &'a Collider,
        frame: Frame,
        bounds: &ColliderAabb,
    ) {
        let field = shape.shape_scaled().as_heightfield();
        self.solids.push(Solid {
            entity,
            body,
            shape,
            frame,
            bounds: Span { least: bounds.min, most: bounds.max },
            is_static: kind == RigidBody::Static,
            field,
            upright_field: field.and_then(|field| UprightField::new(field, frame.position, frame.rotation)),
        });
    }
}

impl Solid<'_> {
    /// Whether its bounds reach into the span.
    pub(super) fn reaches_into(&self, span: Span) -> bool {
        self.bounds.meets(span)
    }

    /// Whether `shape`, upright at `at`, reaches into it by more than `depth` metres, or may do so: only capsules tell.
    pub(super) fn may_hold(&self, shape: &Collider, at: Vec3, depth: f32) -> bool {
        let mine = UprightCapsule::of(shape, Frame { position: at, rotation: Quat::IDENTITY });
        let theirs = UprightCapsule::of(self.shape, self.frame);
        mine.zip(theirs).is_none_or(|(mine, theirs)| mine.depth_in(&theirs) > depth)
    }

    /// Calls `found` with the way out and the depth, where `shape` of `me`, upright at `at`, stands in it deeper than `least`: for each
    /// part that it stands in.
    pub(super) fn ways_out(
        &self,
        (me, shape, at): (Entity, &Collider, Vec3),
        least: f32,
        mut found: impl FnMut(Dir3, f32),
    ) {
        let mut out = |way: Vec3, depth: f32| {
            if let (true, Ok(way)) = (depth > least, Dir3::new(way)) {
                found(way, depth);
            }
        };
        let mine = UprightCapsule::of(shape, Frame { position: at, rotation: Quat::IDENTITY });
        if let (Some(mine), Some(theirs)) = (mine, UprightCapsule::of(self.shape, self.frame)) {
            // Of two in one place each goes another way.
            let beside = if me < self.body { Vec3::X } else { Vec3::NEG_X };
            return out(mine.way_out_of(&theirs, beside), mine.depth_in(&theirs));
        }
        let mut manifolds = Vec::new();
        let Frame { position, rotation } = self.frame;
        contact_manifolds(shape, at, Quat::IDENTITY, self.shape, position, rotation, 0.0, &mut manifolds);
        for manifold in &manifolds {
            if let Some(deepest) = manifold.find_deepest_contact() {
                out(-manifold.normal, deepest.penetration);
            }
        }
    }

    /// Whether a shape on its way may touch it: its bounds, and the surface itself of a heightfield.
    pub(super) fn may_be_met(&self, sweep: &Sweep) -> bool {
        self.reaches_into(sweep.span) && self.field.is_none_or(|field| reaches_into(field, self.frame, sweep))
    }

    /// Where a ray first meets it within `reach` metres, and how far away that is.
    pub(super) fn cast_ray(&self, from: Vec3, direction: Dir3, reach: f32) -> Option<(f32, Floor)> {
        if let (Some(field), Dir3::NEG_Y) = (&self.upright_field, direction) {
            let ground = field.below(from).filter(|ground| from.y - ground.height < reach)?;
            let floor = Floor { height: ground.height, normal: ground.normal(), collider: self.entity };
            return Some((from.y - ground.height, floor));
        }
        let (position, rotation) = (self.frame.position, Rotation(self.frame.rotation));
        let (distance, normal) = self.shape.cast_ray(position, rotation, from, *direction, reach, true)?;
        let floor = Floor { height: from.y + direction.y * distance, normal, collider: self.entity };
        (distance < reach).then_some((distance, floor))
    }

    /// Where `shape`, upright at `from`, first touches it within `reach` metres. Starting within it counts if it goes deeper.
    pub(super) fn cast_shape(&self, shape: &Collider, from: Vec3, direction: Dir3, reach: f32) -> Option<Hit> {
        if let Some(obstacle) = UprightCapsule::of(self.shape, self.frame)
            && let Some(moving) = UprightCapsule::of(shape, Frame { position: from, rotation: Quat::IDENTITY })
        {
            return sweep_capsule(moving, direction, reach, obstacle).map(|touch| Hit {
                distance: touch.distance,
                safe: touch.distance,
                normal: touch.normal,
                point: touch.point,
                collider: self.entity,
                exact: true,
            });
        }
        let vector = |v: Vec3| Vector::new(v.x, v.y, v.z);
        let Frame { position, rotation } = self.frame;
        let pose = Pose::from_parts(vector(position), rotation);
        let options = ShapeCastOptions {
            max_time_of_impact: reach,
            target_distance: 0.0,
            stop_at_penetration: false,
            compute_impact_geometry_on_penetration: true,
        };
        let (theirs, ours) = (self.shape.shape_scaled(), shape.shape_scaled());
        let start = Pose::from_translation(vector(from));
        let hit = query::cast_shapes(
            &pose,
            Vector::ZERO,
            theirs.as_ref(),
            &start,
            vector(*direction),
            ours.as_ref(),
            options,
        );
        let hit = hit.ok().flatten().filter(|hit| hit.time_of_impact < reach)?;
        let (normal, point) = (hit.normal1, hit.witness1);
        let normal = rotation * Vec3::new(normal.x, normal.y, normal.z);
        let point = self.frame.world(Vec3::new(point.x, point.y, point.z));
        let distance = hit.time_of_impact;
        let sound = distance.is_finite() && normal.is_finite() && point.is_finite();
        sound.then_some(Hit { distance, safe: distance, normal, point, collider: self.entity, exact: false })
    }
}
