//! Who holds the film's camera: looks over the way before the walk, and films it from where all of the hero can be seen.
//!
//! World space, metres, seconds. Reads the route, the colliders and the hero's root; writes the camera's [`Transform`]. Walls do
//! not push this camera: it plans its way around them.

use core::f32::consts::TAU;

use avian3d::prelude::{Collider, ShapeCastConfig, SpatialQuery, SpatialQueryFilter};
use bevy::{math::ops, prelude::*, transform::TransformSystems};

use super::{
    route::{Moment, Route},
    shots::{View, plan},
    walk::OnRoute,
};
use crate::{
    camera::{OrbitCamera, OrbitCameraConfig, OrbitCameraState},
    character::foot_ik::GroundFilter,
    game::level::{Hero, Loading},
    math::{
        rotation::{heading, wrap_angle},
        spring::damp,
    },
    terrain::sky::sunlight,
};

/// Metres from the camera to the hero: the whole body in view with some ground before it.
const DISTANCE: f32 = 3.2;
/// Metres above the hero's feet of the picture's middle: low, since the film is about feet.
const AIM_HEIGHT: f32 = 0.8;
/// Pitch in radians from which ground and feet show best.
const PITCH: f32 = 0.34;
/// Seconds between the moments that are planned.
const SPACING: f32 = 0.25;
/// Seconds in which the camera makes up half of the hero's way.
const PROGRESS_HALF_LIFE: f32 = 0.12;
/// The camera swings between the hero's side and its face: middle and width of the swing in radians from behind the hero, and
/// seconds for one.
const SWING_MIDDLE: f32 = 2.0;
const SWING_WIDTH: f32 = 0.35;
const SWING_TIME: f32 = 12.0;

/// Where feet may be within a stride, as metres to the right and ahead of the root; each on ground of its own.
const FEET: [Vec2; 10] = [
    Vec2::new(-0.13, 0.55),
    Vec2::new(0.13, 0.55),
    Vec2::new(-0.13, 0.3),
    Vec2::new(0.13, 0.3),
    Vec2::new(-0.13, 0.05),
    Vec2::new(0.13, 0.05),
    Vec2::new(-0.13, -0.2),
    Vec2::new(0.13, -0.2),
    Vec2::new(-0.13, -0.45),
    Vec2::new(0.13, -0.45),
];
/// Metres above the ground at which a foot must be seen.
const FOOT_HEIGHT: f32 = 0.07;
/// The rest of the body, as metres to the right, above the root and ahead: knees, hands, shoulders, head.
const BODY: [Vec3; 7] = [
    Vec3::new(-0.15, 0.5, 0.25),
    Vec3::new(0.15, 0.5, 0.0),
    Vec3::new(-0.35, 0.9, 0.0),
    Vec3::new(0.35, 0.9, 0.0),
    Vec3::new(-0.25, 1.35, 0.0),
    Vec3::new(0.25, 1.35, 0.0),
    Vec3::new(0.0, 1.75, 0.0),
];
/// Radius in metres of the ball that must fit where the camera is, and how far it must be able to sink.
const ROOM: f32 = 0.35;
const BELOW: f32 = 0.4;
/// Costs of a hidden point of the body, of a camera inside of something, and of a thing that juts in right before the camera.
const HIDDEN: f32 = 8.0;
const STUCK: f32 = 60.0;
const JUTTING: f32 = 6.0;
/// Taste from which on a view is never chosen.
const WORST: f32 = 7.0;
/// Where in the picture nothing should jut in, as tangents to the right and up, and how far away that counts, as a part of
/// the camera's distance.
const FOREGROUND: [Vec2; 13] = [
    Vec2::new(-0.8, 0.35),
    Vec2::new(0.8, 0.35),
    Vec2::new(-0.8, 0.0),
    Vec2::new(0.8, 0.0),
    Vec2::new(-0.55, 0.2),
    Vec2::new(0.55, 0.2),
    Vec2::new(-0.5, -0.15),
    Vec2::new(0.5, -0.15),
    Vec2::new(-0.35, -0.35),
    Vec2::new(0.35, -0.35),
    Vec2::new(-0.6, -0.42),
    Vec2::new(0.6, -0.42),
    Vec2::new(0.0, -0.42),
];
const FOREGROUND_DEPTH: f32 = 0.66;

/// A camera that films the hero.
#[derive(Component, Default)]
#[require(Camera3d)]
pub(super) struct Operator {
    /// Metres of the way behind the hero, as filmed.
    travelled: f32,
    /// How smoothly it follows.
    orbit: OrbitCameraState,
}

/// The planned views, each with how many metres of the way lie behind the hero then.
#[derive(Component, Default)]
struct Shots(Vec<(f32, View)>);

pub(super) fn plugin(app: &mut App) {
    app.add_systems(
        PostUpdate,
        (rehearse.run_if(resource_equals(Loading::Done)), film).chain().before(TransformSystems::Propagate),
    );
}

/// Plans all views, once.
fn rehearse(
    cameras: Query<Entity, (With<Operator>, Without<Shots>)>,
    hero: Single<(&OnRoute, &GroundFilter), With<Hero>>,
    spatial: SpatialQuery,
    mut commands: Commands,
) {
    let (route, filter) = *hero;
    for camera in &cameras {
        let set = Set { spatial: &spatial, filter: &filter.0, ball: Collider::sphere(ROOM) };
        commands.entity(camera).insert(set.shots(&route.0));
    }
}

fn film(
    mut cameras: Query<(&mut Operator, &Shots, &mut Transform)>,
    hero: Single<(Entity, &Transform, &OnRoute), Without<Operator>>,
    time: Res<Time>,
) {
    let (entity, root, route) = *hero;
    let config = OrbitCameraConfig { pivot_height: AIM_HEIGHT, shoulder: 0.0, ..default() };
    let dt = time.delta_secs();
    for (mut operator, shots, mut place) in &mut cameras {
        let travelled = route.0.travelled(root.translation).max(operator.travelled);
        operator.travelled = damp(operator.travelled, travelled, PROGRESS_HALF_LIFE, dt);
        let View { yaw, pitch } = shots.at(operator.travelled);
        let orbit = OrbitCamera { target: entity, yaw, pitch, distance: DISTANCE };
        let arm = operator.orbit.advance(&orbit, &config, root.translation, dt);
        *place =
            Transform::from_translation(arm.root + arm.rotation * Vec3::Z * arm.length).with_rotation(arm.rotation);
    }
}

impl Shots {
    fn at(&self, travelled: f32) -> View {
        let after = self.0.partition_point(|(metres, _)| *metres <= travelled);
        match (after.checked_sub(1).and_then(|before| self.0.get(before)), self.0.get(after)) {
            (Some((from, view)), Some((to, next))) => view.lerp(*next, (travelled - from) / (to - from).max(1e-4)),
            (Some((_, view)), None) | (None, Some((_, view))) => *view,
            (None, None) => View::default(),
        }
    }
}

/// The place where the film is made.
struct Set<'a, 'w, 's> {
    spatial: &'a SpatialQuery<'w, 's>,
    filter: &'a SpatialQueryFilter,
    ball: Collider,
}

impl Set<'_, '_, '_> {
    fn shots(&self, route: &Route) -> Shots {
        let moments = route.moments(SPACING);
        let scenes: Vec<Scene> = moments.iter().map(|moment| self.scene(moment)).collect();
        let views = plan(scenes.len(), |moment, view| {
            let taste = taste(view, &scenes[moment], moment as f32 * SPACING);
            // From behind it is no use to look what is in the way.
            taste + if taste > WORST { STUCK } else { self.obstruction(view, &scenes[moment]) }
        });
        Shots(moments.iter().map(|moment| moment.travelled).zip(views).collect())
    }

    /// The hero as it will be at `moment`, on the ground of the course.
    fn scene(&self, moment: &Moment) -> Scene {
        let ahead = Vec3::new(moment.direction.x, 0.0, moment.direction.y);
        let right = ahead.cross(Vec3::Y);
        let above = Vec3::new(moment.position.x, 0.0, moment.position.y);
        let root = above.with_y(self.ground(above, 50.0));
        let feet = FEET.map(|point| {
            let place = root + right * point.x + ahead * point.y;
            place.with_y(self.ground(place, root.y + 0.6) + FOOT_HEIGHT)
        });
        let body = BODY.map(|point| root + right * point.x + Vec3::Y * point.y + ahead * point.z);
        Scene { root, facing: heading(ahead), feet, body }
    }

    /// Height of what one would stand on at a place, below the height `top`.
    fn ground(&self, place: Vec3, top: f32) -> f32 {
        let from = place.with_y(top);
        self.spatial.cast_ray(from, Dir3::NEG_Y, 200.0, true, self.filter).map_or(0.0, |hit| top - hit.distance)
    }

    /// What hides the hero from a view, or juts in.
    fn obstruction(&self, view: View, scene: &Scene) -> f32 {
        let turn = Quat::from_rotation_y(view.yaw) * Quat::from_rotation_x(-view.pitch);
        let eye = scene.root + Vec3::Y * AIM_HEIGHT + turn * Vec3::Z * DISTANCE;
        let hidden = scene.feet.iter().chain(&scene.body).filter(|point| self.blocked(**point, eye - **point)).count();
        let sink = ShapeCastConfig::from_max_distance(BELOW);
        let under = self.spatial.cast_shape(&self.ball, eye, Quat::IDENTITY, Dir3::NEG_Y, &sink, self.filter);
        let jutting: f32 = FOREGROUND
            .iter()
            .map(|at| turn * Vec3::new(at.x, at.y, -1.0) * (DISTANCE * FOREGROUND_DEPTH))
            .map(|way| self.hit(eye, way).map_or(0.0, |distance| 1.0 - distance / way.length()))
            .sum();
        HIDDEN * hidden as f32 + if under.is_some() { STUCK } else { 0.0 } + JUTTING * jutting
    }

    fn blocked(&self, from: Vec3, way: Vec3) -> bool {
        self.hit(from, way).is_some()
    }

    /// Metres to the first thing on `way`.
    fn hit(&self, from: Vec3, way: Vec3) -> Option<f32> {
        let hit = self.spatial.cast_ray(from, Dir3::new(way).ok()?, way.length(), true, self.filter);
        hit.map(|hit| hit.distance)
    }
}

/// The hero at one moment.
struct Scene {
    root: Vec3,
    /// Heading, radians about +Y.
    facing: f32,
    /// Points that must be seen, world space.
    feet: [Vec3; FEET.len()],
    body: [Vec3; BODY.len()],
}

/// How far a view is from the nicest one: between the hero's side and its face, in good light.
fn taste(view: View, scene: &Scene, seconds: f32) -> f32 {
    let from_behind = wrap_angle(view.yaw - scene.facing).abs();
    let wanted = SWING_MIDDLE + SWING_WIDTH * ops::sin(seconds * TAU / SWING_TIME);
    let aside = (from_behind - wanted) / 0.6;
    let tilt = (view.pitch - PITCH) / 0.15;
    let to_camera = Quat::from_rotation_y(view.yaw) * Vec3::Z;
    let against_light = to_camera.dot(sunlight().with_y(0.0).normalize_or_zero()).max(0.0);
    aside * aside + 0.3 * tilt * tilt + 0.6 * against_light
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_two_moments_the_view_is_between_too() {
        let view = |yaw| View { yaw, pitch: 0.3 };
        let shots = Shots(vec![(0.0, view(0.0)), (2.0, view(1.0))]);
        for (metres, yaw) in [(-1.0, 0.0), (1.0, 0.5), (9.0, 1.0)] {
            assert!((shots.at(metres).yaw - yaw).abs() < 1e-6, "{} at {metres} m", shots.at(metres).yaw);
        }
    }

    #[test]
    fn the_face_is_nicer_than_the_back() {
        let scene = Scene { root: Vec3::ZERO, facing: 0.0, feet: [Vec3::ZERO; FEET.len()], body: BODY };
        let from = |yaw| taste(View { yaw, pitch: PITCH }, &scene, 0.0);
        assert!(from(0.0) > from(2.0) + 1.0, "{} from behind, {} from the side", from(0.0), from(2.0));
    }
}
