//! The mannequin's clips, measured in the file that ships: feet that stay where they stand, legs that never overreach,
//! loops that close, and a gait that is a person's.

mod body;
mod standing;

use body::{Body, Clip, Posed, SIDES};
use glam::Vec3;

/// A clip that goes somewhere.
struct Gait {
    name: &'static str,
    /// Metres per second over the ground.
    travel: Vec3,
    /// Share of a stride that each foot is on the ground.
    duty: [f32; 2],
    /// Degrees per second of the knee, metres per second squared of the pelvis.
    knee_speed: f32,
    pelvis: f32,
    /// Metres that a planted point may wander between two keys.
    between: f32,
}

const fn gait(name: &'static str, travel: Vec3, duty: [f32; 2], knee_speed: f32, pelvis: f32) -> Gait {
    Gait { name, travel, duty, knee_speed, pelvis, between: 0.0005 }
}

const GAITS: [Gait; 10] = [
    gait("walk", Vec3::new(0.0, 0.0, 1.4), [0.59, 0.64], 450.0, 6.0),
    gait("run", Vec3::new(0.0, 0.0, 3.5), [0.33, 0.38], 800.0, 15.0),
    Gait { between: 0.001, ..gait("sprint", Vec3::new(0.0, 0.0, 6.0), [0.22, 0.28], 1200.0, 15.0) },
    gait("crouch_walk", Vec3::new(0.0, 0.0, 1.0), [0.6, 0.7], 450.0, 6.0),
    gait("walk_back", Vec3::new(0.0, 0.0, -1.1), [0.6, 0.68], 450.0, 6.0),
    gait("crouch_back", Vec3::new(0.0, 0.0, -1.1), [0.6, 0.68], 450.0, 6.0),
    gait("crouch_left", Vec3::new(1.2, 0.0, 0.0), [0.55, 0.64], 550.0, 6.0),
    gait("crouch_right", Vec3::new(-1.2, 0.0, 0.0), [0.55, 0.64], 550.0, 6.0),
    gait("strafe_left", Vec3::new(1.2, 0.0, 0.0), [0.55, 0.64], 550.0, 6.0),
    gait("strafe_right", Vec3::new(-1.2, 0.0, 0.0), [0.55, 0.64], 550.0, 6.0),
];
const LOOPS: [&str; 13] = [
    "idle",
    "walk",
    "run",
    "sprint",
    "crouch_idle",
    "crouch_walk",
    "crouch_back",
    "crouch_left",
    "crouch_right",
    "walk_back",
    "strafe_left",
    "strafe_right",
    "fall",
];
const ONCE: [&str; 6] = ["jump", "land_light", "land_hard", "turn_left", "turn_right", "wave"];
/// A sole point this low, in metres, stands.
const STANDS: f32 = 0.000_05;

/// Calls `look` with every gait, its clip and each side.
fn gaits(mut look: impl FnMut(&Body, &Gait, &Clip, usize)) {
    let body = Body::load();
    for gait in &GAITS {
        for side in 0..2 {
            look(&body, gait, body.clip(gait.name), side);
        }
    }
}

fn poses<'a>(body: &'a Body, clip: &Clip) -> Vec<Posed<'a>> {
    (0..=clip.last()).map(|key| body.key(clip, key)).collect()
}

fn flat(v: Vec3) -> Vec3 {
    Vec3::new(v.x, 0.0, v.z)
}

#[test]
fn a_point_of_the_sole_that_stands_does_not_move_over_the_ground() {
    gaits(|body, gait, clip, side| {
        let step = clip.step();
        let soles: Vec<[Vec3; 3]> = poses(body, clip).iter().map(|pose| pose.sole(side)).collect();
        for point in 0..3 {
            let path: Vec<Vec3> = soles.iter().map(|sole| sole[point]).collect();
            let mut landed: Option<Vec3> = None;
            // Twice round, so that a stance over the seam counts too.
            for i in 0..2 * clip.last() {
                let (key, here) = (i % clip.last(), path[i % clip.last()]);
                let on_ground = flat(here) + gait.travel * (i as f32 * step);
                landed = (here.y < STANDS).then(|| landed.unwrap_or(on_ground));
                let Some(landed) = landed else { continue };
                let slip = landed.distance(on_ground) * 1000.0;
                assert!(slip < 0.1, "{} {} point {point} slipped {slip:.3} mm by key {key}", gait.name, SIDES[side]);
                if path[key + 1].y >= STANDS {
                    continue;
                }
                for part in [0.25, 0.5, 0.75] {
                    let there = body.at(clip, key, part).sole(side)[point];
                    let wander = there.distance(here - gait.travel * (part * step));
                    assert!(
                        wander < gait.between,
                        "{} {} point {point} wanders {:.3} mm after key {key}",
                        gait.name,
                        SIDES[side],
                        wander * 1000.0
                    );
                }
            }
        }
    });
}

#[test]
fn each_clip_names_the_speed_its_feet_run_at() {
    gaits(|body, gait, clip, side| {
        let soles: Vec<[Vec3; 3]> = poses(body, clip).iter().map(|pose| pose.sole(side)).collect();
        let stands = |key: usize| (0..3).find(|point| soles[key][*point].y.max(soles[key + 1][*point].y) < STANDS);
        let moved: Vec<Vec3> = (0..clip.last())
            .filter_map(|key| stands(key).map(|point| soles[key][point] - soles[key + 1][point]))
            .collect();
        let travel = moved.iter().sum::<Vec3>() / (moved.len() as f32 * clip.step());
        let error = travel.distance(gait.travel);
        assert!(error < 0.005, "{}: feet run at {travel} m/s, not {}", gait.name, gait.travel);
        let named = (clip.speed - gait.travel.length()).abs();
        assert!(named < 1e-6, "{} names {} m/s", gait.name, clip.speed);
    });
}

#[test]
fn no_sole_goes_under_the_ground() {
    let body = Body::load();
    for name in LOOPS.iter().chain(&ONCE) {
        let clip = body.clip(name);
        for key in 0..clip.last() {
            for (part, bar) in [(0.0, 0.05), (0.25, 1.0), (0.5, 1.0), (0.75, 1.0)] {
                let pose = body.at(clip, key, part);
                let depth = -1000.0 * pose.lowest(0).min(pose.lowest(1));
                assert!(depth < bar, "{name}: a sole is {depth:.3} mm deep {part} after key {key}");
            }
        }
    }
}

#[test]
fn feet_are_on_the_ground_for_a_persons_share_of_the_stride() {
    gaits(|body, gait, clip, side| {
        let standing = poses(body, clip)[..clip.last()].iter().filter(|pose| pose.lowest(side) < 0.0003).count();
        let duty = standing as f32 / clip.last() as f32;
        let [least, most] = gait.duty;
        assert!((least..=most).contains(&duty), "{} {}: duty factor {duty:.3}", gait.name, SIDES[side]);
    });
}

#[test]
fn walking_always_has_a_foot_down_and_running_flies() {
    let body = Body::load();
    for gait in &GAITS {
        let clip = body.clip(gait.name);
        let lowest: Vec<f32> = poses(&body, clip).iter().map(|pose| pose.lowest(0).min(pose.lowest(1))).collect();
        let highest = lowest.iter().copied().fold(0.0, f32::max) * 1000.0;
        if gait.duty[0] > 0.5 {
            assert!(highest < 1.0, "{} floats {highest:.2} mm", gait.name);
        } else {
            assert!(highest > 15.0, "{} flies only {highest:.2} mm high", gait.name);
        }
    }
}

#[test]
fn phase_zero_is_the_left_foots_contact_and_one_half_the_rights() {
    gaits(|body, gait, clip, side| {
        let low: Vec<bool> = poses(body, clip).iter().map(|pose| pose.lowest(side) < 0.0003).collect();
        let contact = (0..clip.last()).find(|key| low[*key] && !low[(key + clip.last() - 1) % clip.last()]).unwrap();
        let phase = contact as f32 / clip.last() as f32 - 0.5 * side as f32;
        let off = phase - phase.round();
        assert!(off.abs() < 0.025, "{} {}: contact {off:.3} of a stride off", gait.name, SIDES[side]);
    });
}

#[test]
fn legs_never_overreach_and_knees_bend_backward_only() {
    let body = Body::load();
    for name in LOOPS.iter().chain(&ONCE) {
        let clip = body.clip(name);
        for (key, pose) in poses(&body, clip).iter().enumerate() {
            for (side, name_of_side) in SIDES.iter().enumerate() {
                let (ratio, knee) = (pose.leg_ratio(side), pose.knee(side));
                assert!(ratio <= 0.9851, "{name} {name_of_side}: leg stretched to {ratio:.4} at key {key}");
                assert!((5.0..140.0).contains(&knee), "{name} {name_of_side}: knee at {knee:.1}° at key {key}");
            }
        }
    }
}

#[test]
fn knees_do_not_pop() {
    gaits(|body, gait, clip, side| {
        let knees: Vec<f32> = poses(body, clip).iter().map(|pose| pose.knee(side)).collect();
        let fastest = knees.windows(2).map(|pair| (pair[1] - pair[0]).abs() / clip.step()).fold(0.0, f32::max);
        assert!(fastest < gait.knee_speed, "{} {}: knee turns at {fastest:.0}°/s", gait.name, SIDES[side]);
    });
}

#[test]
fn the_pelvis_rides_smoothly() {
    let body = Body::load();
    for gait in &GAITS {
        let clip = body.clip(gait.name);
        let height = |key: usize| body.key(clip, key % clip.last()).joint("hips").0.y;
        let worst = (0..clip.last())
            .map(|key| (height(key) - 2.0 * height(key + 1) + height(key + 2)).abs() / (clip.step() * clip.step()))
            .fold(0.0, f32::max);
        assert!(worst < gait.pelvis, "{}: pelvis accelerates at {worst:.1} m/s²", gait.name);
    }
}

#[test]
fn loops_close_in_place_and_in_speed() {
    let body = Body::load();
    for name in LOOPS {
        let clip = body.clip(name);
        let poses = poses(&body, clip);
        let (last, count) = (clip.last(), body.joint_count());
        let turn = |a: usize, b: usize, joint: usize| {
            (poses[a].nth(joint).1.inverse() * poses[b].nth(joint).1).to_scaled_axis()
        };
        for joint in 0..count {
            let ((p, q), (p_end, q_end)) = (poses[0].nth(joint), poses[last].nth(joint));
            let off = p.distance(p_end).max((q * Vec3::ONE).distance(q_end * Vec3::ONE));
            assert!(off < 1e-5, "{name}: joint {joint} ends {off} from where it began");
        }
        // The change of speed over the seam is no larger than between keys elsewhere.
        let jolt = |i: usize| {
            let (a, b, c) = (i, (i + 1) % last, (i + 2) % last);
            (0..count).map(|joint| turn(a, b, joint).distance(turn(b, c, joint))).fold(0.0, f32::max) / clip.step()
        };
        let seam = jolt(last - 1);
        let elsewhere = (0..last - 1).map(jolt).fold(0.0, f32::max);
        assert!(seam <= 1.05 * elsewhere + 0.02, "{name}: {seam:.2} rad/s over the seam, {elsewhere:.2} elsewhere");
    }
}

#[test]
fn swinging_feet_clear_the_ground() {
    gaits(|body, gait, clip, side| {
        let poses = poses(body, clip);
        let last = clip.last();
        // The middle of swing, from a third to two thirds of the way between leaving and landing.
        let swing = 1.0 - gait.duty[1];
        let clearance = (0..last)
            .filter(|key| {
                let phase = (*key as f32 / last as f32 + 0.5 * side as f32).fract();
                (1.0 - swing * 0.67..1.0 - swing * 0.33).contains(&phase)
            })
            .map(|key| poses[key].lowest(side))
            .fold(f32::MAX, f32::min);
        assert!(clearance > 0.02, "{} {}: {:.1} mm clear", gait.name, SIDES[side], clearance * 1000.0);
    });
}

#[test]
fn arms_swing_against_legs_and_the_head_stays_level() {
    let body = Body::load();
    for name in ["walk", "run", "sprint"] {
        let clip = body.clip(name);
        let poses = poses(&body, clip);
        let ahead = |pose: &Posed, joint: &str| pose.joint(joint).0.z - pose.joint("hips").0.z;
        for side in SIDES {
            let (hand, foot) = (format!("{side}Hand"), format!("{side}Foot"));
            let mean = |joint: &str| poses.iter().map(|p| ahead(p, joint)).sum::<f32>() / poses.len() as f32;
            let (hand_mean, foot_mean) = (mean(&hand), mean(&foot));
            let product: f32 =
                poses.iter().map(|p| (ahead(p, &hand) - hand_mean) * (ahead(p, &foot) - foot_mean)).sum();
            let size = |joint: &str, mean: f32| poses.iter().map(|p| (ahead(p, joint) - mean).powi(2)).sum::<f32>();
            let correlation = product / (size(&hand, hand_mean) * size(&foot, foot_mean)).sqrt();
            assert!(correlation < -0.7, "{name}: {side} hand goes with its foot, correlation {correlation:.2}");
        }
        let tilt = poses.iter().map(|pose| (pose.joint("head").1 * Vec3::Y).angle_between(Vec3::Y).to_degrees());
        let most = tilt.fold(0.0, f32::max);
        assert!(most < 6.0, "{name}: head tilts {most:.1}°");
    }
}
