//! Writes what the hero does and the player sees to a file, for scripts and tests: ten lines of JSON a second.
//!
//! Reads hero, camera and HUD after each fixed tick. World space, metres, seconds, radians.

use std::{
    fs::File,
    io::{BufWriter, Write},
    path::Path,
};

use bevy::prelude::*;

use super::{debug::DebugView, hud::Help, level::Hero};
use crate::{
    camera::OrbitCamera,
    character::{locomotion::Locomotion, motion::MotionState},
    math::rotation::heading,
};

/// Seconds between two lines.
const PERIOD: f32 = 0.1;

/// The open file.
#[derive(Resource)]
pub(super) struct Telemetry {
    sink: BufWriter<File>,
    /// Seconds until the next line.
    wait: f32,
}

impl Telemetry {
    /// Creates or empties `file`.
    ///
    /// # Errors
    /// What the system says.
    pub(super) fn create(file: &Path) -> std::io::Result<Self> {
        Ok(Self { sink: BufWriter::new(File::create(file)?), wait: 0.0 })
    }
}

pub(super) fn plugin(app: &mut App) {
    app.add_systems(FixedLast, report.run_if(resource_exists::<Telemetry>));
}

fn report(
    heroes: Query<(&Transform, &MotionState, Option<&Locomotion>), With<Hero>>,
    cameras: Query<&Transform, With<OrbitCamera>>,
    help: Query<&Visibility, With<Help>>,
    feet: Option<Res<DebugView>>,
    mut telemetry: ResMut<Telemetry>,
    time: Res<Time>,
    mut failed: Local<bool>,
) {
    telemetry.wait -= time.delta_secs();
    let Ok((root, motion, locomotion)) = heroes.single() else { return };
    if telemetry.wait > 0.0 {
        return;
    }
    telemetry.wait += PERIOD;
    let moment = Moment {
        seconds: time.elapsed_secs(),
        root,
        motion,
        state: locomotion.map_or("", Locomotion::state),
        camera: cameras.iter().next().map_or(Vec3::NAN, |camera| camera.translation),
        help: help.iter().any(|help| *help != Visibility::Hidden),
        feet: feet.is_some_and(|feet| feet.0),
    };
    // Flushed line by line, so that a reader sees it while the game runs.
    let written = writeln!(telemetry.sink, "{}", moment.line()).and_then(|()| telemetry.sink.flush());
    if let Err(error) = written
        && !std::mem::replace(&mut *failed, true)
    {
        warn!("telemetry can't be written: {error}");
    }
}

/// What one line says.
struct Moment<'a> {
    seconds: f32,
    root: &'a Transform,
    motion: &'a MotionState,
    state: &'a str,
    camera: Vec3,
    help: bool,
    feet: bool,
}

impl Moment<'_> {
    fn line(&self) -> String {
        let vector = |vector: Vec3| format!("[{}, {}, {}]", number(vector.x), number(vector.y), number(vector.z));
        format!(
            r#"{{"time": {}, "position": {}, "velocity": {}, "heading": {}, "grounded": {}, "crouched": {}, "state": "{}", "camera": {}, "help": {}, "feet": {}}}"#,
            number(self.seconds),
            vector(self.root.translation),
            vector(self.motion.velocity),
            number(heading(*self.root.forward())),
            self.motion.ground.is_some(),
            self.motion.crouched,
            self.state,
            vector(self.camera),
            self.help,
            self.feet,
        )
    }
}

/// A number as JSON knows it, to a tenth of a millimetre.
fn number(value: f32) -> String {
    if value.is_finite() { format!("{value:.4}") } else { "null".to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_json_even_of_values_that_are_no_numbers() {
        let motion = MotionState { velocity: Vec3::new(0.0, f32::NAN, 1.5), ..default() };
        let root = Transform::from_xyz(1.0, 2.0, -3.0);
        let (state, camera) = ("walk", Vec3::new(0.0, 1.5, 4.0));
        let moment = Moment { seconds: 0.25, root: &root, motion: &motion, state, camera, help: true, feet: false };
        assert_eq!(
            moment.line(),
            r#"{"time": 0.2500, "position": [1.0000, 2.0000, -3.0000], "velocity": [0.0000, null, 1.5000], "heading": 0.0000, "grounded": false, "crouched": false, "state": "walk", "camera": [0.0000, 1.5000, 4.0000], "help": true, "feet": false}"#
        );
    }
}
