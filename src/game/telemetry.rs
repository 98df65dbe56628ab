//! Writes what the hero does to a file, for scripts and tests: ten lines of JSON a second.
//!
//! Reads the hero's root and [`MotionState`] after each fixed tick. World space, metres, seconds.

use std::{
    fs::File,
    io::{BufWriter, Write},
    path::Path,
};

use bevy::prelude::*;

use super::level::Hero;
use crate::character::motion::MotionState;

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
    heroes: Query<(&Transform, &MotionState), With<Hero>>,
    mut telemetry: ResMut<Telemetry>,
    time: Res<Time>,
    mut failed: Local<bool>,
) {
    telemetry.wait -= time.delta_secs();
    let Ok((root, motion)) = heroes.single() else { return };
    if telemetry.wait > 0.0 {
        return;
    }
    telemetry.wait += PERIOD;
    let line = line(time.elapsed_secs(), root.translation, motion);
    // Flushed line by line, so that a reader sees it while the game runs.
    let written = writeln!(telemetry.sink, "{line}").and_then(|()| telemetry.sink.flush());
    if let Err(error) = written
        && !std::mem::replace(&mut *failed, true)
    {
        warn!("telemetry can't be written: {error}");
    }
}

fn line(seconds: f32, position: Vec3, motion: &MotionState) -> String {
    let vector = |vector: Vec3| format!("[{}, {}, {}]", number(vector.x), number(vector.y), number(vector.z));
    format!(
        r#"{{"time": {}, "position": {}, "velocity": {}, "grounded": {}}}"#,
        number(seconds),
        vector(position),
        vector(motion.velocity),
        motion.ground.is_some(),
    )
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
        assert_eq!(
            line(0.25, Vec3::new(1.0, 2.0, -3.0), &motion),
            r#"{"time": 0.2500, "position": [1.0000, 2.0000, -3.0000], "velocity": [0.0000, null, 1.5000], "grounded": false}"#
        );
    }
}
