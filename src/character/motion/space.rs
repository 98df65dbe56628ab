//! What a character can ask of the world around it: sweeps, ground, bodies. World space, metres.
//!
//! Reads avian's colliders as the last physics step left them; writes nothing, so that characters can run in parallel.

use avian3d::{
    character_controller::move_and_slide::DepenetrationConfig,
    collider_tree::ColliderTrees,
    prelude::{
        AngularVelocity, Collider, ColliderAabb, ColliderOf, ComputedCenterOfMass, ComputedMass,
        CustomPositionIntegration, LinearVelocity, MoveAndSlide, Position, RigidBody, Rotation, SimpleCollider,
        SpatialQueryFilter,
    },
};
use bevy::{ecs::system::SystemParam, prelude::*};
use smallvec::SmallVec;

use super::{
    around::{Around, Solid},
    body::MotionBody,
    frame::Frame,
    heightfield::{Span, Sweep},
    movers::Movers,
};

/// Gap in metres that sweeps keep to what they hit, so that the next sweep starts in free space.
pub(super) const SKIN: f32 = 0.01;

/// Depth in metres up to which a contact is taken for resting, no reason to move.
const RESTING: f32 = 1e-3;

/// Depth in metres up to which a body is pushed out of another; deeper contacts are taken for nonsense.
const DEEPEST: f32 = 20.0;

/// The world as all characters see it.
#[derive(SystemParam)]
pub(super) struct Space<'w, 's> {
    pub(super) casts: MoveAndSlide<'w, 's>,
    trees: Res<'w, ColliderTrees>,
    movers: Res<'w, Movers>,
    owners: Query<'w, 's, &'static ColliderOf>,
    bounds: Query<'w, 's, &'static ColliderAabb>,
    kinds: Query<'w, 's, &'static RigidBody>,
    bodies: Query<
        'w,
        's,
        (
            &'static RigidBody,
            &'static Position,
            &'static Rotation,
            &'static LinearVelocity,
            &'static AngularVelocity,
            &'static ComputedCenterOfMass,
            &'static ComputedMass,
            Has<CustomPositionIntegration>,
            Option<&'static Transform>,
            Has<ChildOf>,
        ),
        Without<MotionBody>,
    >,
}

/// The world as one character sees it: without itself, in its collision layers.
pub(super) struct View<'a> {
    pub(super) space: &'a Space<'a, 'a>,
    pub(super) me: Entity,
    pub(super) filter: SpatialQueryFilter,
    /// What is near.
    pub(super) around: Around<'a>,
}

/// What a sweep met.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    /// Metres to go until it touches.
    pub(super) distance: f32,
    /// Metres to go until the skin is all that is left between.
    pub(super) safe: f32,
    /// Unit normal toward the character.
    pub(super) normal: Vec3,
    pub(super) point: Vec3,
    pub(super) collider: Entity,
    /// Whether the distance is exact already.
    pub(super) exact: bool,
}

/// A surface below.
#[derive(Clone, Copy, Debug)]
pub(super) struct Floor {
    pub(super) height: f32,
    pub(super) normal: Vec3,
    pub(super) collider: Entity,
}

/// The rigid body that a collider belongs to.
#[derive(Clone, Copy, Debug)]
pub(super) struct GroundBody {
    pub(super) entity: Entity,
    /// Where the casts see it.
    pub(super) now: Frame,
    /// Where it will be when the tick ends, as far as can be known.
    pub(super) next: Frame,
    /// World centre of mass.
    pub(super) centre: Vec3,
    pub(super) dynamic: bool,
    /// Mass in kg; infinite unless dynamic.
    pub(super) mass: f32,
}

impl GroundBody {
    /// Velocity of its point at `world` during this tick, m/s.
    pub(super) fn velocity_at(&self, world: Vec3, dt: f32) -> Vec3 {
        if dt <= 0.0 || self.now == self.next {
            return Vec3::ZERO;
        }
        (self.next.world(self.now.local(world)) - world) / dt
    }
}

impl<'a> Space<'a, 'a> {
    /// All that `me` may meet in a region, as `filter` lets it.
    pub(super) fn gather(&'a self, me: Entity, filter: &SpatialQueryFilter, around: &mut Around<'a>) {
        let region = around.region();
        let sound = region.least.is_finite() && region.most.is_finite();
        let bounds = ColliderAabb::from_min_max(region.least, region.most);
        let mut add = |collider: Entity| {
            // Sensors are not among these colliders.
            let (shape, position, rotation, layers) = self.casts.colliders.get(collider).ok()?;
            let body = self.owners.get(collider).ok()?.body;
            if body != me && filter.test(collider, layers.copied().unwrap_or_default()) {
                let frame = Frame { position: position.0, rotation: rotation.0 };
                let kind = self.kinds.get(body).copied().unwrap_or(RigidBody::Static);
                around.push(collider, body, kind, shape, frame, self.bounds.get(collider).ok()?);
            }
            Some(())
        };
        if !sound {
            return;
        }
        self.movers.near(region, |collider| {
            add(collider);
        });
        let ColliderTrees { dynamic_tree, static_tree, standalone_tree, .. } = &*self.trees;
        for tree in [dynamic_tree, static_tree, standalone_tree] {
            tree.aabb_traverse(bounds.into(), |id| {
                if let Some(proxy) = tree.get_proxy(id)
                    && self.bounds.get(proxy.collider).is_ok_and(|own| own.intersects(&bounds))
                {
                    add(proxy.collider);
                }
                true
            });
        }
    }
}

impl View<'_> {
    /// Gathers what is in `span`.
    pub(super) fn look_around(&mut self, span: Span) {
        self.around.set_region(span);
        self.space.gather(self.me, &self.filter, &mut self.around);
    }

    /// The surface straight below (or above) `from`, within `reach` metres.
    pub(super) fn floor(&self, from: Vec3, direction: Dir3, reach: f32) -> Option<Floor> {
        if !from.is_finite() || !reach.is_finite() {
            return None;
        }
        let span = Span::between(from, from + direction * reach);
        let mut nearest: Option<(f32, Floor)> = None;
        for solid in self.solids_in(span).iter().filter(|solid| solid.reaches_into(span)) {
            let reach = nearest.map_or(reach, |(distance, _)| distance);
            nearest = solid.cast_ray(from, direction, reach).or(nearest);
        }
        let (_, floor) = nearest?;
        (floor.height.is_finite() && floor.normal.is_finite()).then_some(floor)
    }

    /// Whether a body that may move by itself may have moved into the shape.
    pub(super) fn is_moved_into(&self, shape: &Collider, at: Vec3) -> bool {
        if !at.is_finite() {
            return false;
        }
        let bounds = shape.aabb(at, Quat::IDENTITY);
        let span = Span { least: bounds.min, most: bounds.max };
        let moves = |solid: &Solid| !solid.is_static && solid.reaches_into(span);
        self.solids_in(span).iter().any(|solid| moves(solid) && solid.may_hold(shape, at, RESTING))
    }

    /// The way out for a shape that may stand inside others; zero where it is free.
    pub(super) fn way_out(&self, shape: &Collider, at: Vec3) -> Vec3 {
        if !at.is_finite() {
            return Vec3::ZERO;
        }
        let bounds = shape.aabb(at, Quat::IDENTITY);
        let span = Span { least: bounds.min, most: bounds.max };
        let stands = Sweep { shape, from: at, way: Vec3::ZERO, span };
        let mut contacts = SmallVec::<[(Dir3, f32); 8]>::new();
        for solid in self.solids_in(span).iter().filter(|solid| solid.may_be_met(&stands)) {
            solid.ways_out((self.me, shape, at), RESTING, |way, depth| contacts.push((way, depth)));
        }
        if contacts.is_empty() {
            return Vec3::ZERO;
        }
        let config = DepenetrationConfig { penetration_rejection_threshold: DEEPEST, skin_width: 0.0, ..default() };
        let out = self.space.casts.depenetrate_intersections(&config, &contacts);
        if out.is_finite() { out } else { Vec3::ZERO }
    }

    /// The body of a collider; `None` for other characters and for what is gone.
    pub(super) fn body(&self, collider: Entity, dt: f32) -> Option<GroundBody> {
        let entity = self.space.owners.get(collider).ok()?.body;
        self.body_by_id(entity, dt)
    }

    /// The body with this id; `None` for other characters and for what is gone.
    pub(super) fn body_by_id(&self, entity: Entity, dt: f32) -> Option<GroundBody> {
        let (kind, position, rotation, linear, angular, centre, mass, custom, transform, child) =
            self.space.bodies.get(entity).ok()?;
        let now = Frame { position: position.0, rotation: rotation.0 };
        let steady = *kind != RigidBody::Static && !custom && (linear.0 != Vec3::ZERO || angular.0 != Vec3::ZERO);
        let mut next = now;
        if steady {
            next = now.after(centre.0, linear.0, angular.0, dt);
        } else if let (Some(transform), false) = (transform, child) {
            // Moved by its transform earlier in this tick; the casts see it only after the physics step.
            let moved = Frame { position: transform.translation, rotation: transform.rotation };
            if !moved.is_near(&now) {
                next = moved;
            }
        }
        let dynamic = *kind == RigidBody::Dynamic;
        let mass = if dynamic { mass.value() } else { f32::INFINITY };
        let sound = next.position.is_finite() && next.rotation.is_finite();
        let centre = now.world(centre.0);
        Some(GroundBody { entity, now, next: if sound { next } else { now }, centre, dynamic, mass })
    }
}
