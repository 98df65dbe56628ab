//! Ground probes and ground frames from the physics world.

use avian3d::prelude::*;
use bevy::{ecs::system::SystemParam, prelude::*};

use super::{
    ground::{GroundHit, Probe},
    surroundings::GroundFrames,
};
use crate::character::motion::CharacterMotion;

/// What feet never stand on: sensors, and characters.
pub type NoGround = Or<(With<Sensor>, With<CharacterMotion>)>;

/// What counts as ground for a character's feet: everything but characters and sensors, unless told otherwise.
#[derive(Component, Clone, Debug, Default)]
pub struct GroundFilter(pub SpatialQueryFilter);

/// Rays into avian's colliders; characters, sensors and what the filter leaves out are passed through.
pub struct PhysicsProbe<'a, 'w, 's> {
    spatial: &'a SpatialQuery<'w, 's>,
    no_ground: &'a Query<'w, 's, (), NoGround>,
    filter: &'a SpatialQueryFilter,
}

impl<'a, 'w, 's> PhysicsProbe<'a, 'w, 's> {
    /// Probes what `filter` lets through.
    #[must_use]
    pub fn new(
        spatial: &'a SpatialQuery<'w, 's>,
        no_ground: &'a Query<'w, 's, (), NoGround>,
        filter: &'a GroundFilter,
    ) -> Self {
        Self { spatial, no_ground, filter: &filter.0 }
    }
}

impl Probe for PhysicsProbe<'_, '_, '_> {
    fn down(&self, start: Vec3, length: f32) -> Option<GroundHit> {
        if !start.is_finite() || length.is_nan() || length <= 0.0 {
            return None;
        }
        let solid = |entity: Entity| !self.no_ground.contains(entity);
        let hit = self.spatial.cast_ray_predicate(start, Dir3::NEG_Y, length, false, self.filter, &solid)?;
        let normal = if hit.normal.y < 0.0 { -hit.normal } else { hit.normal };
        Some(GroundHit { point: start - Vec3::Y * hit.distance, normal, entity: hit.entity })
    }
}

/// Where ground entities are now, in a tick and in a frame: by their own transform and those of all that they hang on.
#[derive(SystemParam)]
pub struct Frames<'w, 's> {
    colliders: Query<'w, 's, (&'static Transform, Option<&'static ChildOf>), With<Collider>>,
    above: Query<'w, 's, (&'static Transform, Option<&'static ChildOf>)>,
}

impl GroundFrames for Frames<'_, '_> {
    fn frame(&self, entity: Entity) -> Option<Isometry3d> {
        let (place, mut parent) = self.colliders.get(entity).ok()?;
        if parent.is_none() {
            return Some(place.to_isometry());
        }
        let mut place = *place;
        while let Some(above) = parent {
            let (next, further) = self.above.get(above.parent()).ok()?;
            place = next.mul_transform(place);
            parent = further;
        }
        Some(place.to_isometry())
    }
}
