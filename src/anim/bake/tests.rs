//! Baked clips against exact curves.

use bevy::math::{Affine3A, ops};

use super::*;
use crate::{
    anim::{
        curve::Curve,
        retarget::{Part, Pelvis, Retarget},
        skeleton::JointIndex,
    },
    math::rotation::angle_between,
};

/// Shoulder, elbow and wrist, each a metre above the other.
fn arm() -> Skeleton {
    let step = JointTransform { translation: Vec3::Y, ..JointTransform::IDENTITY };
    let joints = [
        ("shoulder".to_owned(), None, JointTransform::IDENTITY),
        ("elbow".to_owned(), Some(JointIndex(0)), step),
        ("wrist".to_owned(), Some(JointIndex(1)), step),
    ];
    Skeleton::new(joints, Affine3A::IDENTITY).unwrap()
}

fn turning(times: Vec<f32>, angles: &[f32], interpolation: Interpolation) -> ClipCurves {
    let values = angles.iter().map(|angle| Quat::from_rotation_z(*angle)).collect();
    let mut joint = JointCurves::new(JointIndex(0));
    joint.rotation = Some(Curve::rotation(times, values, interpolation).unwrap());
    ClipCurves { name: "turn".to_owned(), joints: vec![joint], ..ClipCurves::default() }
}

fn sampled(clip: &Clip, time: f32) -> Vec<JointTransform> {
    let mut out = vec![JointTransform::IDENTITY; 3];
    clip.sample(&arm(), time, &mut out);
    out
}

#[test]
fn a_smooth_clip_needs_thirty_frames_a_second() {
    let clip = turning(vec![0.0, 1.0], &[0.0, 0.5], Interpolation::Linear).bake(&arm());
    assert_eq!((clip.frame_count(), clip.frame_rate()), (31, 30.0));
    assert!(clip.report.max_error < 1e-4, "error {} m", clip.report.max_error);
    assert_eq!(clip.report.bytes, 31 * 16);
}

#[test]
fn keys_at_their_own_rate_are_kept_to_the_bit() {
    let times: Vec<f32> = (0..=24).map(|key| key as f32 / 24.0).collect();
    let angles: Vec<f32> = times.iter().map(|time| 0.4 * ops::sin(time * 6.0)).collect();
    let clip = turning(times, &angles, Interpolation::Linear).bake(&arm());
    assert_eq!((clip.frame_count(), clip.frame_rate()), (25, 24.0));
    assert!(clip.report.max_error < 1e-4, "error {} m", clip.report.max_error);
}

#[test]
fn baked_and_exact_pose_agree_at_any_time() {
    let times: Vec<f32> = (0..=10).map(|key| 0.13 * key as f32).collect();
    let angles: Vec<f32> = times.iter().map(|time| 0.8 * ops::sin(time * 5.0)).collect();
    let curves = turning(times, &angles, Interpolation::Linear);
    let clip = curves.bake(&arm());
    let mut exact = vec![JointTransform::IDENTITY; 3];
    for step in 0..=300 {
        let time = 1.3 * step as f32 / 300.0;
        curves.sample(&arm(), time, &mut exact);
        let error = angle_between(exact[0].rotation, sampled(&clip, time)[0].rotation);
        // Two metres of arm turn this angle into distance.
        assert!(2.0 * error <= clip.report.max_error + 2e-3, "{error} rad at {time} s");
    }
}

#[test]
fn channels_that_stand_still_cost_no_rows() {
    let mut curves = turning(vec![0.0, 1.0], &[0.3, 0.3], Interpolation::Linear);
    let mut elbow = JointCurves::new(JointIndex(1));
    elbow.translation = Some(Curve::new(vec![0.0, 1.0], vec![Vec3::Y; 2], Interpolation::Step).unwrap());
    elbow.scale = Some(Curve::new(vec![0.2], vec![Vec3::splat(2.0)], Interpolation::Linear).unwrap());
    curves.joints.push(elbow);
    let clip = curves.bake(&arm());
    assert_eq!(clip.frames.rows.len(), 0, "nothing moves");
    assert_eq!(clip.frames.still_translations.len(), 0, "the elbow is at rest");
    let pose = sampled(&clip, 0.4);
    assert!(angle_between(pose[0].rotation, Quat::from_rotation_z(0.3)) < 1e-3);
    assert_eq!((pose[1].translation, pose[1].scale), (Vec3::Y, Vec3::splat(2.0)));
}

#[test]
fn the_first_key_holds_from_the_start() {
    let clip = turning(vec![0.5, 1.0], &[0.2, 0.6], Interpolation::Linear).bake(&arm());
    assert_eq!(clip.duration, 1.0);
    let early = angle_between(sampled(&clip, 0.25)[0].rotation, Quat::from_rotation_z(0.2));
    assert!(early < 1e-3, "off by {early} rad");
}

#[test]
fn a_loop_is_told_by_its_seam_and_wraps() {
    let loops = turning(vec![0.0, 0.5, 1.0], &[0.1, 0.9, 0.1], Interpolation::Linear).bake(&arm());
    assert!(loops.looping && loops.report.seam < 1e-4, "seam {} m", loops.report.seam);
    assert_eq!([-0.25, 3.25, f32::NAN].map(|time| loops.wrap(time)), [0.75, 0.25, 0.0]);
    let ends = turning(vec![0.0, 1.0], &[0.1, 0.9], Interpolation::Linear).bake(&arm());
    assert!(!ends.looping, "seam {} m", ends.report.seam);
    assert_eq!([-0.25, 3.25].map(|time| ends.wrap(time)), [0.0, 1.0]);
}

#[test]
fn a_loop_can_lose_the_wait_before_its_first_key() {
    let clip = turning(vec![0.1, 0.6, 1.1], &[0.1, 0.9, 0.1], Interpolation::Linear).bake(&arm());
    assert!((clip.lead - 0.1).abs() < 1e-6, "lead of {} s", clip.lead);
    let cut = clip.without_lead();
    assert!((cut.duration - 1.0).abs() < 1e-5 && cut.lead < 1e-4, "{} s, lead {} s", cut.duration, cut.lead);
    for time in [0.0, 0.33, 1.0] {
        let apart = angle_between(sampled(&cut, time)[0].rotation, sampled(&clip, time + 0.1)[0].rotation);
        assert!(apart < 1e-4, "{apart} rad apart at {time} s");
    }
}

#[test]
fn a_clip_of_no_length_is_one_pose() {
    let clip = turning(vec![0.0], &[0.4], Interpolation::Linear).bake(&arm());
    assert_eq!((clip.duration, clip.frame_count()), (0.0, 1));
    for time in [0.0, 1.0, -1.0, f32::INFINITY] {
        let error = angle_between(sampled(&clip, time)[0].rotation, Quat::from_rotation_z(0.4));
        assert!(error < 1e-3, "off by {error} rad at {time} s");
    }
    let none = ClipCurves::default().bake(&arm());
    assert_eq!(sampled(&none, 0.3), arm().rest());
}

#[test]
fn morph_weights_are_kept_by_node() {
    let curve = |values: Vec<f32>| Curve::new(vec![0.0, 1.0], values, Interpolation::Linear).unwrap();
    let mut curves = turning(vec![0.0, 1.0], &[0.0, 0.5], Interpolation::Linear);
    for (node, weights) in [(1, vec![0.0, 1.0]), (2, vec![1.0, 0.5])] {
        curves.morphs.push(MorphCurves { node: JointIndex(node), weights: vec![curve(weights), curve(vec![0.0; 2])] });
    }
    let clip = curves.bake(&arm());
    let mut weights = [9.0; 2];
    assert!(clip.morph_weights(JointIndex(2), 0.5, &mut weights));
    assert!((weights[0] - 0.75).abs() < 1e-5 && weights[1].abs() < 1e-6, "{weights:?}");
    assert!(!clip.morph_weights(JointIndex(0), 0.5, &mut weights), "no weights on that node");
}

#[test]
fn clips_of_a_twin_with_other_axes_look_the_same() {
    // The same arm, in centimetres, every joint's axes turned.
    let turn = Quat::from_euler(bevy::math::EulerRot::XYZ, 0.4, -1.1, 0.7);
    let step = |rotation: Quat, translation: Vec3| JointTransform { translation, rotation, scale: Vec3::ONE };
    let up = turn.inverse() * Vec3::Y * 200.0;
    let joints = [
        ("a".to_owned(), None, step(turn, Vec3::ZERO)),
        ("b".to_owned(), Some(JointIndex(0)), step(Quat::IDENTITY, up)),
        ("c".to_owned(), Some(JointIndex(1)), step(Quat::IDENTITY, up)),
    ];
    let twin = Skeleton::new(joints, Affine3A::from_scale(Vec3::splat(0.01))).unwrap();
    let mut curves = turning(vec![0.0, 1.0], &[0.0, 1.0], Interpolation::Linear);
    let moves = vec![Vec3::ZERO, Vec3::X];
    curves.joints[0].translation = Some(Curve::new(vec![0.0, 1.0], moves, Interpolation::Linear).unwrap());
    let clip = curves.bake(&arm());
    let part = |joint: u16| Part {
        to: JointIndex(joint),
        from: [JointIndex(joint); 2],
        between: 0.0,
        carrier: Some(JointIndex(joint)),
        amount: 1.0,
        offset: Quat::IDENTITY,
    };
    let retarget = Retarget {
        from: &arm(),
        to: &twin,
        parts: [0, 1, 2].map(part).to_vec(),
        pelvis: Some(Pelvis { from: JointIndex(0), to: JointIndex(0), legs: None }),
        length: 2.0,
        sway: 1.0,
    };
    let foreign = retarget.clip(&clip);
    let (mut own, mut other) = (Pose::rest(&arm()), Pose::rest(&twin));
    for time in [0.0, 0.3, 0.8, 1.0] {
        clip.sample(&arm(), time, own.locals_mut());
        foreign.sample(&twin, time, other.locals_mut());
        own.update_model(&arm());
        other.update_model(&twin);
        let (want, got) = (2.0 * own.position(JointIndex(2)), other.position(JointIndex(2)));
        assert!(got.distance(want) < 1e-3, "wrist at {got}, not {want}, at {time} s");
    }
}

#[test]
fn a_stretched_clip_is_the_same_motion_in_more_time() {
    let mut clip = turning(vec![0.0, 1.0], &[0.0, 1.0], Interpolation::Linear).bake(&arm());
    clip.ground_speed = Some(3.0);
    let slow = clip.clone().stretched(1.5);
    assert_eq!((slow.duration, slow.ground_speed), (1.5, Some(2.0)));
    for time in [0.0, 0.31, 0.7, 1.0] {
        let turned = angle_between(sampled(&clip, time)[0].rotation, sampled(&slow, 1.5 * time)[0].rotation);
        assert!(turned < 1e-3, "off by {turned} rad at {time} s");
    }
}

#[test]
fn a_stretched_clip_jumps_as_much_later() {
    let clip = turning(vec![0.0, 0.517, 1.0], &[0.0, 1.2, 0.0], Interpolation::Step).bake(&arm()).stretched(2.0);
    for (time, angle) in [(1.032, 0.0), (1.036, 1.2), (1.998, 1.2)] {
        let error = angle_between(sampled(&clip, time)[0].rotation, Quat::from_rotation_z(angle));
        assert!(error < 1e-5, "off by {error} rad at {time} s");
    }
}

#[test]
fn a_moved_clip_is_the_same_motion_elsewhere() {
    let by = Vec3::new(0.3, -0.2, 0.1);
    let places = |interpolation| {
        let values = match interpolation {
            Interpolation::CubicSpline => vec![Vec3::ZERO, Vec3::Y, Vec3::X, Vec3::X, 2.0 * Vec3::Y, Vec3::ZERO],
            _ => vec![Vec3::Y, 2.0 * Vec3::Y],
        };
        let mut curves = turning(vec![0.0, 1.0], &[0.0, 0.5], Interpolation::Linear);
        curves.joints[0].translation = Some(Curve::new(vec![0.0, 0.7], values, interpolation).unwrap());
        curves.bake(&arm())
    };
    let still = turning(vec![0.0, 1.0], &[0.0, 0.5], Interpolation::Linear).bake(&arm());
    for clip in [still, places(Interpolation::Step), places(Interpolation::Linear), places(Interpolation::CubicSpline)]
    {
        let moved = clip.clone().moved(&arm(), JointIndex(0), by);
        for time in [0.0, 0.31, 0.69, 0.71, 1.0] {
            let (before, after) = (sampled(&clip, time), sampled(&moved, time));
            let off = (after[0].translation - before[0].translation).distance(by);
            assert!(off < 1e-6, "off by {off} m at {time} s");
            assert_eq!((after[0].rotation, after[1]), (before[0].rotation, before[1]), "only one place changes");
        }
    }
}

#[test]
fn a_step_between_frames_jumps_when_its_key_says() {
    let clip = turning(vec![0.0, 0.517, 1.0], &[0.0, 1.2, 0.0], Interpolation::Step).bake(&arm());
    for (time, angle) in [(0.516, 0.0), (0.518, 1.2), (0.999, 1.2)] {
        let error = angle_between(sampled(&clip, time)[0].rotation, Quat::from_rotation_z(angle));
        assert!(error < 1e-5, "off by {error} rad at {time} s");
    }
    assert!(clip.report.max_error < 1e-6, "error {} m", clip.report.max_error);
}

#[test]
fn a_fast_turn_at_odd_times_stays_on_its_arc() {
    let times = vec![0.0, 0.0137, 0.0291, 0.0533, 1.0];
    let curves = turning(times, &[0.0, 2.6, -0.3, 2.7, 0.0], Interpolation::Linear);
    let clip = curves.bake(&arm());
    assert!(clip.report.max_error < 1e-4, "error {} m", clip.report.max_error);
    let mut exact = vec![JointTransform::IDENTITY; 3];
    for step in 0..200 {
        let time = step as f32 / 200.0;
        curves.sample(&arm(), time, &mut exact);
        let error = angle_between(exact[0].rotation, sampled(&clip, time)[0].rotation);
        assert!(error < 1e-4, "off by {error} rad at {time} s");
    }
}

#[test]
fn a_clip_that_lost_its_wait_keeps_its_steps_in_time() {
    let mut curves = turning(vec![0.1, 0.617, 1.1], &[0.2, 1.2, 0.2], Interpolation::Step);
    curves.looping = Some(true);
    let clip = curves.bake(&arm());
    let cut = clip.without_lead();
    assert!(cut.duration < clip.duration, "nothing was cut: {} s", cut.duration);
    let jump = 0.617 - (clip.duration - cut.duration);
    for (time, angle) in [(jump - 0.002, 0.2), (jump + 0.002, 1.2)] {
        let error = angle_between(sampled(&cut, time)[0].rotation, Quat::from_rotation_z(angle));
        assert!(error < 1e-5, "off by {error} rad at {time} s");
    }
}

#[test]
fn morph_weights_between_frames_are_those_of_the_keys() {
    let mut curves = ClipCurves::default();
    let weights = Curve::new(vec![0.0, 0.011, 0.024, 1.0], vec![0.0, 1.0, 0.2, 0.0], Interpolation::Linear).unwrap();
    curves.morphs.push(MorphCurves { node: JointIndex(1), weights: vec![weights.clone()] });
    let clip = curves.bake(&arm());
    for step in 0..100 {
        let (time, mut got) = (step as f32 / 100.0, [9.0]);
        assert!(clip.morph_weights(JointIndex(1), time, &mut got), "the clip has weights for the node");
        assert!((got[0] - weights.sample(time)).abs() < 1e-5, "{} at {time} s", got[0]);
    }
}
