//! Samples a moving figure into keys.

use super::super::clip::Clip;
use super::super::skeleton::index;
use super::body::{Figure, Joints};
use glam::{DQuat, Quat, Vec3};

/// Length and kind of a clip.
#[derive(Clone, Copy, Debug)]
pub struct Timing {
    pub seconds: f64,
    /// Keys per second, about: `seconds` is parted into whole steps.
    pub rate: f64,
    /// A loop with feet that run back at so many m/s (0: it stays in place); `None` plays once.
    pub ground_speed: Option<f64>,
}

/// What is recorded at one time.
#[derive(Clone, Debug)]
pub struct Moment {
    pub joints: Joints,
    /// How full the chest is, 0..1.
    pub breath: f64,
}

impl From<Figure> for Moment {
    fn from(figure: Figure) -> Self {
        Self { joints: figure.joints(), breath: 0.0 }
    }
}

/// The clip of what is seen `at` each time in seconds.
///
/// The last key of a loop equals its first. Joints that never leave their rest rotation get no track.
pub fn record(name: &'static str, timing: Timing, at: impl Fn(f64) -> Moment) -> Clip {
    let Timing { seconds, rate, ground_speed } = timing;
    let steps = (seconds * rate).round() as usize;
    let looping = ground_speed.is_some();
    let time = |key: usize| seconds * key as f64 / steps as f64;
    let moments: Vec<Moment> =
        (0..=steps).map(|key| at(if looping && key == steps { 0.0 } else { time(key) })).collect();
    let joint_count = moments[0].joints.rotations.len();
    let rotations = (0..joint_count)
        .map(|joint| (joint, continuous(moments.iter().map(|moment| moment.joints.rotations[joint]))))
        .filter(|(_, keys)| keys.iter().any(|key| key.angle_between(Quat::IDENTITY) > 1e-6))
        .collect();
    let hips: Vec<Vec3> = moments.iter().map(|moment| moment.joints.hips.as_vec3()).collect();
    // Eyes blink by themselves, whatever plays.
    let weights: Vec<[f32; 2]> = moments.iter().map(|moment| [0.0, moment.breath as f32]).collect();
    let has_weights = weights.iter().flatten().any(|&weight| weight > 0.0);
    Clip {
        name,
        looping,
        speed: ground_speed.unwrap_or(0.0) as f32,
        times: (0..=steps).map(|key| time(key) as f32).collect(),
        rotations,
        translations: vec![(index("hips"), hips)],
        weights: has_weights.then_some(weights),
    }
}

/// Single-precision keys, each in the hemisphere of the one before.
fn continuous(keys: impl Iterator<Item = DQuat>) -> Vec<Quat> {
    let mut last = DQuat::IDENTITY;
    keys.map(|key| {
        last = if last.dot(key) < 0.0 { -key } else { key };
        last.as_quat().normalize()
    })
    .collect()
}
