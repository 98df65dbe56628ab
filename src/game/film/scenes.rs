//! Short scenes on flat ground, one for each state of locomotion and some for changes between them. Pure.

use bevy::prelude::*;

use crate::character::intent::MoveIntent;

/// Pictures of a scene.
pub const PICTURES: usize = 12;

/// What an actor does, and which part of it is filmed.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Of the state that it shows, or of what happens.
    pub name: &'static str,
    /// Metres above the ground that it begins.
    pub height: f32,
    /// What is wanted, each from its second on.
    pub cues: Vec<(f32, MoveIntent)>,
    /// An action, begun after the first picture.
    pub action: Option<&'static str>,
    /// Second of the first picture.
    pub from: f32,
    /// Seconds from the first picture to where a thirteenth would be.
    pub span: f32,
}

impl Scene {
    fn new(name: &'static str, from: f32, span: f32, cues: &[(f32, MoveIntent)]) -> Self {
        Self { name, height: 0.0, cues: cues.to_vec(), action: None, from, span }
    }

    /// A gait that has settled, filmed for `span` seconds.
    fn gait(name: &'static str, span: f32, intent: MoveIntent) -> Self {
        Self::new(name, 2.5, span, &[(0.0, intent)])
    }

    /// What is wanted at `seconds`.
    #[must_use]
    pub fn intent_at(&self, seconds: f32) -> MoveIntent {
        let cue = self.cues.iter().rev().find(|(at, _)| *at <= seconds);
        cue.map_or_else(MoveIntent::default, |(_, intent)| intent.clone())
    }

    /// Second of picture number `picture`.
    #[must_use]
    pub fn time_of(&self, picture: usize) -> f32 {
        self.from + self.span * picture as f32 / PICTURES as f32
    }
}

fn go(speed: f32) -> MoveIntent {
    MoveIntent { velocity: Vec3::NEG_Z * speed, ..default() }
}

fn low(speed: f32) -> MoveIntent {
    MoveIntent { crouch: true, ..go(speed) }
}

fn jump(speed: f32) -> MoveIntent {
    MoveIntent { jump: true, ..go(speed) }
}

fn aim(velocity: Vec3) -> MoveIntent {
    MoveIntent { velocity, facing: Some(Vec3::NEG_Z), ..default() }
}

/// As [`aim`], with an arm that points so many degrees to the left and up.
fn point(velocity: Vec3, yaw: f32, pitch: f32) -> MoveIntent {
    let way = Quat::from_rotation_y(yaw.to_radians()) * Quat::from_rotation_x(pitch.to_radians()) * Vec3::NEG_Z;
    MoveIntent { aim: Some(way), ..aim(velocity) }
}

fn face(degrees: f32) -> MoveIntent {
    let facing = Quat::from_rotation_y(degrees.to_radians()) * Vec3::NEG_Z;
    MoveIntent { facing: Some(facing), ..default() }
}

/// All scenes.
#[must_use]
pub fn all() -> Vec<Scene> {
    let still = MoveIntent::default();
    let from_rest = |name, from, span, intent| Scene::new(name, from, span, &[(0.5, intent)]);
    vec![
        Scene::new("idle", 0.5, 8.0, &[]),
        Scene::gait("walk", 1.067, go(1.4)),
        Scene::gait("run", 0.7, go(3.5)),
        Scene::gait("sprint", 0.583, go(6.0)),
        Scene::new("crouch_idle", 1.0, 4.0, &[(0.0, low(0.0))]),
        Scene::gait("crouch_walk", 1.1, low(1.0)),
        Scene::gait("strafe_left", 0.6, aim(Vec3::NEG_X * 1.2)),
        Scene::gait("strafe_right", 0.6, aim(Vec3::X * 1.2)),
        Scene::gait("strafe_ahead_left", 0.8, aim(Vec3::new(-1.0, 0.0, -1.0))),
        Scene::gait("walk_back", 1.067, aim(Vec3::Z * 1.1)),
        Scene::gait("crouch_strafe", 0.6, MoveIntent { crouch: true, ..aim(Vec3::NEG_X * 1.2) }),
        Scene::gait("crouch_back", 1.067, MoveIntent { crouch: true, ..aim(Vec3::Z * 1.1) }),
        from_rest("jump", 0.5, 1.5, jump(0.0)),
        Scene::new("running_jump", 1.9, 1.2, &[(0.0, go(3.5)), (2.0, jump(3.5))]),
        Scene { height: 12.0, ..Scene::new("fall", 0.1, 1.2, &[]) },
        Scene { height: 0.6, ..Scene::new("land_light", 0.2, 0.72, &[]) },
        Scene { height: 3.5, ..Scene::new("land_hard", 0.65, 1.5, &[]) },
        from_rest("turn_left", 0.5, 0.9, face(90.0)),
        from_rest("turn_right", 0.5, 0.9, face(-90.0)),
        from_rest("turn_about", 0.5, 1.4, face(170.0)),
        Scene { action: Some("wave"), ..Scene::new("wave", 0.5, 3.0, &[]) },
        Scene { action: Some("wave"), ..Scene::new("wave_walking", 2.5, 3.0, &[(0.0, go(1.4))]) },
        Scene::new(
            "aim",
            0.45,
            2.4,
            &[
                (0.5, point(Vec3::ZERO, 0.0, 0.0)),
                (1.05, point(Vec3::ZERO, 25.0, 40.0)),
                (1.65, point(Vec3::ZERO, -45.0, -35.0)),
                (2.25, aim(Vec3::ZERO)),
            ],
        ),
        Scene::gait("aim_strafing", 0.6, point(Vec3::X * 1.2, 0.0, 5.0)),
        from_rest("start_walk", 0.45, 0.9, go(1.4)),
        from_rest("start_run", 0.45, 0.9, go(3.5)),
        Scene::new("stop_walk", 2.0, 0.9, &[(0.0, go(1.4)), (2.05, still.clone())]),
        Scene::new("stop_run", 2.0, 0.9, &[(0.0, go(3.5)), (2.05, still.clone())]),
        Scene::new("crouch_and_rise", 0.45, 1.8, &[(0.5, low(0.0)), (1.4, still)]),
        Scene::new("side_to_side", 1.9, 1.0, &[(0.0, aim(Vec3::NEG_X * 1.2)), (2.0, aim(Vec3::X * 1.2))]),
        Scene::new(
            "turn_at_a_run",
            1.9,
            1.2,
            &[(0.0, go(3.5)), (2.0, MoveIntent { velocity: Vec3::X * 3.5, ..default() })],
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::tuning::standard;

    #[test]
    fn every_state_has_a_scene() {
        let scenes: Vec<_> = all().iter().map(|scene| scene.name).collect();
        for state in standard::states() {
            let shown = scenes.iter().any(|scene| scene.starts_with(state.name.as_str()));
            assert!(shown, "{} has no scene among {scenes:?}", state.name);
        }
    }

    #[test]
    fn names_are_single_and_times_go_on() {
        let scenes = all();
        for (index, scene) in scenes.iter().enumerate() {
            assert!(scenes[..index].iter().all(|other| other.name != scene.name), "two scenes {}", scene.name);
            assert!(scene.from >= 0.0 && scene.span > 0.1, "{} films nothing", scene.name);
            assert!(scene.cues.windows(2).all(|pair| pair[0].0 < pair[1].0), "cues of {} out of order", scene.name);
        }
    }
}
