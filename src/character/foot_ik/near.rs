//! The colliders about one character, gathered once a frame, so that its many rays needn't each search the whole world.
//!
//! World space, metres. Heightfields are asked for their height; all else is cast at.

use arrayvec::ArrayVec;
use avian3d::{
    collider_tree::{ColliderTree, ColliderTrees},
    prelude::*,
};
use bevy::{ecs::system::SystemParam, math::Vec3A, prelude::*};

use super::{
    ground::{GroundHit, Probe, Reach},
    probe::{GroundFilter, NoGround, PhysicsProbe},
};
use crate::character::motion::{CharacterMotion, FieldGround, Movers, UprightField};

/// Colliders near one character beyond which the world is searched after all.
const MOST: usize = 24;

/// All that can be ground.
#[derive(SystemParam)]
pub struct Grounds<'w, 's> {
    spatial: SpatialQuery<'w, 's>,
    no_ground: Query<'w, 's, (), NoGround>,
    trees: Res<'w, ColliderTrees>,
    /// Where controllers run: spares a search among all characters.
    movers: Option<Res<'w, Movers>>,
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
    least: Vec3A,
    most: Vec3A,
    everywhere: PhysicsProbe<'a, 'w, 's>,
}

impl Grounds<'_, '_> {
    /// A probe that has [gathered](Self::gather) nothing yet: it searches the whole world.
    #[inline]
    pub fn probe<'a>(&'a self, filter: &'a GroundFilter) -> NearProbe<'a, 'a, 'a> {
        NearProbe {
            solids: ArrayVec::new_const(),
            least: Vec3A::INFINITY,
            most: Vec3A::NEG_INFINITY,
            everywhere: PhysicsProbe::new(&self.spatial, &self.no_ground, filter),
        }
    }

    /// Gathers the ground within `radius` metres, horizontally, of what `reach` looks around: in its place, since a probe is some
    /// kilobytes to move.
    pub fn gather<'a>(&'a self, filter: &GroundFilter, reach: Reach, radius: f32, near: &mut NearProbe<'a, '_, '_>) {
        let half = Vec3::new(radius, reach.tallest(radius), radius);
        near.solids.clear();
        let mut all = true;
        let region = ColliderAabb::from_min_max(reach.root - half, reach.root + half);
        let mut gather = |entity: Entity| {
            let Ok((collider, position, rotation, bounds, layers)) = self.solids.get(entity) else { return true };
            if !bounds.intersects(&region) || !filter.0.test(entity, layers.copied().unwrap_or_default()) {
                return true;
            }
            let field = collider.shape_scaled().as_heightfield();
            let field = field.and_then(|field| UprightField::new(field, position.0, rotation.0));
            let solid = Solid { entity, collider, position: position.0, rotation: *rotation, bounds: *bounds, field };
            all = near.solids.try_push(solid).is_ok();
            all
        };
        let mut search = |tree: &ColliderTree| {
            tree.aabb_traverse(region.into(), |id| tree.get_proxy(id).is_none_or(|proxy| gather(proxy.collider)));
        };
        search(&self.trees.static_tree);
        search(&self.trees.dynamic_tree);
        search(&self.trees.standalone_tree);
        match self.movers.as_ref().and_then(|movers| movers.others(&self.trees)) {
            Some(others) => others.iter().for_each(|other| {
                gather(*other);
            }),
            None => search(&self.trees.kinematic_tree),
        }
        let (least, most) = (reach.root - half, reach.root + half);
        (near.least, near.most) =
            if all { (least.into(), most.into()) } else { (Vec3A::INFINITY, Vec3A::NEG_INFINITY) };
    }
}

/// Ground of one collider.
enum Found<'a> {
    Field(FieldGround<'a>),
    Cast { height: f32, normal: Vec3 },
}

impl Found<'_> {
    fn height(&self) -> f32 {
        match self {
            Self::Field(ground) => ground.height,
            Self::Cast { height, .. } => *height,
        }
    }

    fn normal(&self) -> Vec3 {
        match self {
            Self::Field(ground) => ground.normal(),
            Self::Cast { normal, .. } => *normal,
        }
    }
}

impl Solid<'_> {
    /// Its ground straight below `start`, if that is higher than `lowest`.
    fn below(&self, start: Vec3, lowest: f32) -> Option<Found<'_>> {
        let found = match &self.field {
            Some(field) => Found::Field(field.below(start)?),
            None => self.cast(start, lowest).map(|(height, normal)| Found::Cast { height, normal })?,
        };
        (found.height() > lowest).then_some(found)
    }

    /// World height of that.
    #[inline]
    fn height_below(&self, start: Vec3, lowest: f32) -> Option<f32> {
        let height = match &self.field {
            Some(field) => field.height(start).filter(|height| *height <= start.y)?,
            None => self.cast(start, lowest)?.0,
        };
        (height > lowest).then_some(height)
    }

    /// World height and normal of what is no field.
    fn cast(&self, start: Vec3, lowest: f32) -> Option<(f32, Vec3)> {
        let (least, most) = (self.bounds.min, self.bounds.max);
        let misses = start.x < least.x || start.x > most.x || start.z < least.z || start.z > most.z;
        if misses || start.y < least.y || lowest > most.y {
            return None;
        }
        let (from, down) = (self.position, Vec3::NEG_Y);
        let (distance, normal) = self.collider.cast_ray(from, self.rotation, start, down, start.y - lowest, false)?;
        Some((start.y - distance, if normal.y < 0.0 { -normal } else { normal }))
    }
}

impl NearProbe<'_, '_, '_> {
    /// Whether all ground below `start` within `length` is known.
    #[inline]
    fn knows(&self, start: Vec3, length: f32) -> bool {
        let end = Vec3A::new(start.x, start.y - length, start.z);
        let start = Vec3A::from(start);
        (start.cmple(self.most) & end.cmpge(self.least)).all() && length > 0.0
    }

    /// The highest ground below `start` within `length`, and whose it is.
    fn highest(&self, start: Vec3, length: f32) -> Option<(Found<'_>, Entity)> {
        let mut lowest = start.y - length;
        let mut highest = None;
        for solid in &self.solids {
            if let Some(found) = solid.below(start, lowest) {
                lowest = found.height();
                highest = Some((found, solid.entity));
            }
        }
        highest
    }

    /// The field and whose it is, if there is but one about and nothing else, and it is known at a horizontal place.
    #[inline]
    fn sole_field(&self, place: Vec3) -> Option<(&UprightField<'_>, Entity)> {
        let [Solid { field: Some(field), entity, .. }] = self.solids.as_slice() else { return None };
        let (least, most) = (self.least, self.most);
        let known = place.x >= least.x && place.x <= most.x && place.z >= least.z && place.z <= most.z;
        known.then_some((field, *entity))
    }
}

impl Probe for NearProbe<'_, '_, '_> {
    fn down(&self, start: Vec3, length: f32) -> Option<GroundHit> {
        if !self.knows(start, length) {
            return self.everywhere.down(start, length);
        }
        let (found, entity) = self.highest(start, length)?;
        Some(GroundHit { point: start.with_y(found.height()), normal: found.normal(), entity })
    }

    fn height(&self, start: Vec3, length: f32) -> Option<f32> {
        if !self.knows(start, length) {
            return self.everywhere.height(start, length);
        }
        let mut highest = None;
        let mut lowest = start.y - length;
        for solid in &self.solids {
            if let Some(height) = solid.height_below(start, lowest) {
                lowest = height;
                highest = Some(height);
            }
        }
        highest
    }

    fn at(&self, place: Vec3, reach: &Reach) -> Option<GroundHit> {
        if let Some((field, entity)) = self.sole_field(place)
            && let Some(ground) = field.ground(place).filter(|ground| reach.reaches(ground.height))
        {
            return Some(GroundHit { point: place.with_y(ground.height), normal: ground.normal(), entity });
        }
        let (start, length) = reach.ray(place);
        self.down(start, length)
    }

    fn height_at(&self, place: Vec3, reach: &Reach) -> Option<f32> {
        if let Some((field, _)) = self.sole_field(place)
            && let Some(height) = field.height(place).filter(|height| reach.reaches(*height))
        {
            return Some(height);
        }
        let (start, length) = reach.ray(place);
        self.height(start, length)
    }
}
