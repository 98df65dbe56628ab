//! The colliders about one character, gathered once a frame, so that its many rays needn't each search the whole world.
//!
//! World space, metres. Heightfields are asked for their height; all else is cast at.

use arrayvec::ArrayVec;
use avian3d::prelude::*;
use bevy::{ecs::system::SystemParam, prelude::*};

use super::{
    ground::{GroundHit, Probe, Reach},
    probe::{GroundFilter, NoGround, PhysicsProbe},
};
use crate::character::motion::{CharacterMotion, UprightField};

/// Colliders near one character beyond which the world is searched after all.
const MOST: usize = 24;

/// All that can be ground.
#[derive(SystemParam)]
pub struct Grounds<'w, 's> {
    spatial: SpatialQuery<'w, 's>,
    no_ground: Query<'w, 's, (), NoGround>,
    solids: Query<
        'w,
        's,
        (
            &'static Collider,
            &'static Position,
            &'static Rotation,
            &'static ColliderAabb,
            Option<&'static CollisionLayers>,
        ),
        (Without<Sensor>, Without<CharacterMotion>),
    >,
}

#[derive(Clone, Copy)]
struct Solid<'a> {
    entity: Entity,
    collider: &'a Collider,
    position: Vec3,
    rotation: Rotation,
    bounds: ColliderAabb,
    field: Option<UprightField<'a>>,
}

/// Rays into the colliders about a place; outside of it into the whole world.
pub struct NearProbe<'a, 'w, 's> {
    solids: ArrayVec<Solid<'a>, MOST>,
    /// Between these corners `solids` is all there is.
    region: ColliderAabb,
    everywhere: PhysicsProbe<'a, 'w, 's>,
}

impl Grounds<'_, '_> {
    /// The ground within `radius` metres, horizontally, of what `reach` looks around.
    pub fn near<'a>(&'a self, filter: &'a GroundFilter, reach: Reach, radius: f32) -> NearProbe<'a, 'a, 'a> {
        let half = Vec3::new(radius, reach.tallest(radius), radius);
        let mut near = NearProbe {
            solids: ArrayVec::new_const(),
            region: ColliderAabb::from_min_max(reach.root - half, reach.root + half),
            everywhere: PhysicsProbe::new(&self.spatial, &self.no_ground, filter),
        };
        let mut all = true;
        self.spatial.aabb_intersections_with_aabb_callback(near.region, |entity| {
            let Ok((collider, position, rotation, bounds, layers)) = self.solids.get(entity) else { return true };
            if !filter.0.test(entity, layers.copied().unwrap_or_default()) {
                return true;
            }
            let field = collider.shape_scaled().as_heightfield();
            let field = field.and_then(|field| UprightField::new(field, position.0, rotation.0));
            let solid =
                Solid { entity, collider, position: position.0, rotation: *rotation, bounds: *bounds, field };
            all = near.solids.try_push(solid).is_ok();
            all
        });
        if !all {
            near.region = ColliderAabb::INVALID;
        }
        near
    }
}

impl Solid<'_> {
    /// Metres from `start` straight down to it, and its normal there, if it is nearer than `length`.
    fn below(&self, start: Vec3, length: f32) -> Option<(f32, Vec3)> {
        let (least, most) = (self.bounds.min, self.bounds.max);
        let misses = start.x < least.x || start.x > most.x || start.z < least.z || start.z > most.z;
        if misses || start.y < least.y || start.y - length > most.y {
            return None;
        }
        if let Some(field) = &self.field {
            return field.below(start).map(|(height, normal)| (start.y - height, normal));
        }
        let cast = self.collider.cast_ray(self.position, self.rotation, start, Vec3::NEG_Y, length, false);
        cast.map(|(distance, normal)| (distance, if normal.y < 0.0 { -normal } else { normal }))
    }
}

impl Probe for NearProbe<'_, '_, '_> {
    fn down(&self, start: Vec3, length: f32) -> Option<GroundHit> {
        let (least, most) = (self.region.min, self.region.max);
        let inside = start.cmpge(least).all() && start.cmple(most).all() && start.y - length >= least.y;
        if !inside || length.is_nan() || length <= 0.0 {
            return self.everywhere.down(start, length);
        }
        let mut nearest: Option<GroundHit> = None;
        let mut left = length;
        for solid in &self.solids {
            let Some((distance, normal)) = solid.below(start, left).filter(|(distance, _)| *distance < left) else {
                continue;
            };
            left = distance;
            nearest = Some(GroundHit { point: start - Vec3::Y * distance, normal, entity: solid.entity });
        }
        nearest
    }
}
