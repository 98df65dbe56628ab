//! Walkers on paper, whose gait is known, and what the analysis makes of them.

use bevy::math::{Affine3A, ops};
use proptest::prelude::*;

use super::*;
use crate::anim::{
    bake::{ClipCurves, JointCurves},
    curve::{Curve, Interpolation},
    leg::SolePoint,
    skeleton::{JointIndex, JointTransform},
};

/// A body of two loose feet: enough to walk on paper.
struct Walker {
    size: f32,
    speed: f32,
    /// Share of the cycle that a foot stands.
    duty: f32,
    /// Share of the clip at which the left foot lands.
    lands: f32,
    duration: f32,
    /// Height of its steps, for a leg of the usual length.
    lift: f32,
    /// Whether the clip moves the body instead of the ground.
    root_motion: bool,
}

const WALK: Walker =
    Walker { size: 1.0, speed: 1.4, duty: 0.6, lands: 0.3, duration: 1.0, lift: 0.1, root_motion: false };

impl Walker {
    fn skeleton(&self) -> Skeleton {
        let at = |x: f32, y: f32| JointTransform {
            translation: Vec3::new(x, y, 0.0) * self.size,
            ..JointTransform::IDENTITY
        };
        let joint = |name: &str, parent, transform| (name.to_owned(), parent, transform);
        let root = Some(JointIndex(0));
        let joints = [
            joint("hips", None, at(0.0, 0.0)),
            joint("leftKnee", root, at(-0.1, 0.5)),
            joint("leftFoot", root, at(-0.1, 0.08)),
            joint("rightKnee", root, at(0.1, 0.5)),
            joint("rightFoot", root, at(0.1, 0.08)),
        ];
        Skeleton::new(joints, Affine3A::IDENTITY).unwrap()
    }

    fn legs(&self) -> [Leg; 2] {
        [(1, 2), (3, 4)].map(|(knee, foot)| {
            let point = |z: f32| SolePoint { joint: JointIndex(foot), offset: Vec3::new(0.0, -0.08, z) * self.size };
            Leg {
                upper: JointIndex(0),
                lower: JointIndex(knee),
                foot: JointIndex(foot),
                thigh: 0.4375 * self.size,
                shin: 0.4375 * self.size,
                heel: point(0.06),
                ball: point(-0.13),
                tip: point(-0.2),
                ..Leg::default()
            }
        })
    }

    /// Where a foot is, relative to the hips, at `phase` after its landing.
    fn foot(&self, phase: f32) -> (f32, f32) {
        let travel = self.speed * self.duration * self.duty;
        if phase < self.duty {
            return (0.0, travel * (phase / self.duty - 0.5));
        }
        let swing = (phase - self.duty) / (1.0 - self.duty);
        let eased = swing * swing * (3.0 - 2.0 * swing);
        (self.lift * self.size * ops::sin(swing * core::f32::consts::PI), travel * (0.5 - eased))
    }

    fn clip(&self) -> (Clip, Skeleton) {
        let skeleton = self.skeleton();
        let steps = 120;
        let times: Vec<f32> = (0..=steps).map(|i| self.duration * i as f32 / steps as f32).collect();
        let mut curves = ClipCurves { name: "walk".to_owned(), ..ClipCurves::default() };
        for (foot, offset) in [(2, 0.0), (4, 0.5)] {
            let rest = skeleton.rest()[foot].translation;
            let values = times.iter().map(|time| {
                let phase = wrapped(time / self.duration - self.lands - offset);
                let (up, back) = self.foot(phase);
                rest + Vec3::new(0.0, up, back)
            });
            let mut joint = JointCurves::new(JointIndex(foot as u16));
            joint.translation = Some(Curve::new(times.clone(), values.collect(), Interpolation::Linear).unwrap());
            curves.joints.push(joint);
        }
        if self.root_motion {
            let values = times.iter().map(|time| Vec3::NEG_Z * self.speed * *time).collect();
            let mut joint = JointCurves::new(JointIndex(0));
            joint.translation = Some(Curve::new(times, values, Interpolation::Linear).unwrap());
            curves.joints.insert(0, joint);
        }
        let mut clip = curves.bake(&skeleton);
        clip.looping = true;
        (clip, skeleton)
    }

    fn gait(&self) -> Gait {
        let (clip, skeleton) = self.clip();
        Gait::analyze(&clip, &skeleton, &self.legs())
    }
}

fn assert_near(what: &str, got: f32, want: f32, tolerance: f32) {
    assert!((got - want).abs() <= tolerance, "{what}: {got}, not {want} within {tolerance}");
}

#[test]
fn a_walk_gives_its_speed_stride_and_stances() {
    let gait = WALK.gait();
    assert_near("speed", gait.speed, 1.4, 0.01);
    assert_near("stride", gait.stride, 1.4, 0.01);
    assert!(gait.velocity.normalize().distance(Vec3::NEG_Z) < 0.01, "heads {}", gait.velocity);
    assert_near("phase offset", gait.phase_offset, 0.3, 0.02);
    assert_eq!([gait.contact[0].len(), gait.contact[1].len()], [1, 1]);
    assert_near("left landing", gait.contact[0][0].start, 0.0, 1e-6);
    assert_near("left lift-off", gait.contact[0][0].end, 0.6, 0.04);
    assert_near("right landing", gait.contact[1][0].start, 0.5, 0.03);
    assert_near("right lift-off", gait.contact[1][0].end, 1.1, 0.04);
    assert_near("sole", gait.sole_height[0], 0.0, 1e-3);
}

#[test]
fn a_run_has_flight() {
    let gait = Walker { speed: 3.5, duty: 0.35, duration: 0.7, ..WALK }.gait();
    assert_near("speed", gait.speed, 3.5, 0.05);
    assert_near("stance", gait.contact[0][0].end, 0.35, 0.05);
    assert_eq!([0, 1].map(|foot| gait.contact_weight(foot, 0.43)), [0.0; 2], "both feet are off the ground");
}

#[test]
fn feet_that_only_shuffle_never_fly() {
    let gait = Walker { duty: 0.45, lift: 0.035, ..WALK }.gait();
    for step in 0..50u8 {
        let phase = f32::from(step) / 50.0;
        let weights = [0, 1].map(|foot| gait.contact_weight(foot, phase));
        assert!(weights[0].max(weights[1]) > 0.49, "no foot stands at {phase}: {weights:?}");
    }
    let long = gait.contact.iter().map(|contact| contact[0].end - contact[0].start).fold(0.0, f32::max);
    assert!(long < 0.6, "a foot stands for {long} of the time");
}

#[test]
fn root_motion_counts_as_speed() {
    let gait = Walker { root_motion: true, ..WALK }.gait();
    assert_near("speed", gait.speed, 1.4, 0.02);
    assert_near("lift-off", gait.contact[0][0].end, 0.6, 0.05);
}

#[test]
fn feet_in_the_air_never_stand() {
    let (mut clip, skeleton) = WALK.clip();
    let mut legs = WALK.legs();
    for leg in &mut legs {
        for point in [&mut leg.heel, &mut leg.ball, &mut leg.tip] {
            point.offset.y += 0.3;
        }
    }
    clip.looping = true;
    let gait = Gait::analyze(&clip, &skeleton, &legs);
    assert_eq!(gait.contact, [vec![], vec![]]);
    assert_eq!((gait.contact_weight(0, 0.4), gait.phase_to_landing(0, 0.4), gait.speed), (0.0, None, 0.0));
}

#[test]
fn walking_backward_heads_backward() {
    let gait = Walker { speed: -1.0, ..WALK }.gait();
    assert_near("speed", gait.velocity.z, 1.0, 0.02);
}

#[test]
fn standing_feet_always_stand() {
    let gait = Walker { speed: 0.0, duty: 1.0, ..WALK }.gait();
    assert_eq!((gait.speed, gait.stride, gait.phase_offset), (0.0, 0.0, 0.0));
    assert_eq!(gait.contact, [vec![Contact { start: 0.0, end: 1.0 }], vec![Contact { start: 0.0, end: 1.0 }]]);
    assert_eq!(
        (gait.contact_weight(0, 0.7), gait.phase_to_landing(1, 0.2), gait.phase_to_lift(0, 0.2)),
        (1.0, Some(0.0), None)
    );
}

#[test]
fn a_clip_of_no_length_stands() {
    let skeleton = WALK.skeleton();
    let clip = ClipCurves::default().bake(&skeleton);
    let gait = Gait::analyze(&clip, &skeleton, &WALK.legs());
    assert_eq!((gait.speed, gait.contact_weight(0, 0.5)), (0.0, 1.0));
    assert_eq!((gait.phase_at(3.0, 0.0), gait.time_at(0.4, 0.0)), (0.0, 0.0));
}

#[test]
fn written_stances_take_the_place_of_found_ones() {
    let mut gait = WALK.gait();
    gait.set_contacts([vec![Contact { start: 0.25, end: 0.75 }], vec![Contact { start: 0.75, end: 1.25 }]]);
    gait.set_speed(2.0, 1.0);
    assert_eq!((gait.phase_offset, gait.stride), (0.25, 2.0));
    assert_eq!(gait.contact[1], vec![Contact { start: 0.5, end: 1.0 }]);
}

#[test]
fn edges_of_a_stance_are_half_firm() {
    let gait = WALK.gait();
    let Contact { start, end } = gait.contact[1][0];
    for edge in [start, end] {
        assert_near("weight", gait.contact_weight(1, edge), 0.5, 1e-3);
    }
    assert_eq!([start - 0.03, start + 0.03].map(|phase| gait.contact_weight(1, phase)), [0.0, 1.0]);
    assert_eq!(gait.contact_weight(1, f32::NAN), gait.contact_weight(1, 0.0));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn bodies_of_any_size_walk_alike(size in 0.3f32..3.0, duty in 0.5f32..0.7, lands in 0.0f32..1.0) {
        // Equal Froude number: speed and duration grow with the square root of the leg.
        let root = size.sqrt();
        let gait = Walker { size, speed: 1.3 * root, duration: root, duty, lands, ..WALK }.gait();
        prop_assert!((gait.speed / root - 1.3).abs() < 0.03, "speed {} at size {size}", gait.speed);
        prop_assert_eq!(gait.contact[0].len(), 1);
        let stance = gait.contact[0][0].end;
        prop_assert!((stance - duty).abs() < 0.05, "stance {stance}, not {duty}");
        let shift = wrapped(gait.phase_offset - lands + 0.5) - 0.5;
        prop_assert!(shift.abs() < 0.03, "lands at {}, not {lands}", gait.phase_offset);
    }

    #[test]
    fn weights_and_waits_stay_in_range(phase in -3.0f32..3.0, foot in 0usize..2) {
        let gait = WALK.gait();
        let weight = gait.contact_weight(foot, phase);
        prop_assert!((0.0..=1.0).contains(&weight), "weight {weight}");
        let (landing, lift) = (gait.phase_to_landing(foot, phase).unwrap(), gait.phase_to_lift(foot, phase).unwrap());
        prop_assert!((0.0..=1.0).contains(&landing) && (0.0..=1.0).contains(&lift), "{landing}, {lift}");
        prop_assert!(landing == 0.0 || lift == 0.0, "swings and stands at once");
    }
}
