//! Feet that stand: at ease, after a landing, and under a root that turns.

use glam::Quat;

use super::{
    STANDS,
    body::{Body, SIDES},
};

#[test]
fn standing_feet_stay_where_they_are() {
    let body = Body::load();
    for (name, from) in [("idle", 0.0), ("crouch_idle", 0.0), ("wave", 0.0), ("land_light", 0.12), ("land_hard", 0.8)] {
        let clip = body.clip(name);
        let first = (from / clip.step()).ceil() as usize;
        for (side, side_name) in SIDES.iter().enumerate() {
            let planted = body.key(clip, first).sole(side);
            for key in first..=clip.last() {
                let sole = body.key(clip, key).sole(side);
                let moved = (0..3).map(|i| sole[i].distance(planted[i])).fold(0.0, f32::max) * 1000.0;
                assert!(moved < 0.05, "{name} {side_name}: sole moved {moved:.3} mm by key {key}");
            }
        }
    }
}

#[test]
fn feet_in_a_turn_stand_still_under_the_turning_root() {
    let body = Body::load();
    for (name, sign) in [("turn_left", 1.0_f32), ("turn_right", -1.0)] {
        let clip = body.clip(name);
        let root = |key: usize| {
            let t = key as f32 / clip.last() as f32;
            Quat::from_rotation_y(sign * t * core::f32::consts::FRAC_PI_2)
        };
        for (side, side_name) in SIDES.iter().enumerate() {
            for key in 0..clip.last() {
                let [here, next] = [key, key + 1].map(|key| body.key(clip, key).sole(side).map(|p| root(key) * p));
                if here.iter().chain(&next).all(|point| point.y < STANDS) {
                    let moved = (0..3).map(|i| here[i].distance(next[i])).fold(0.0, f32::max) * 1000.0;
                    assert!(moved < 0.05, "{name} {side_name}: sole moved {moved:.3} mm after key {key}");
                }
            }
            let start = body.key(clip, 0).sole(side)[0];
            let end = body.key(clip, clip.last()).sole(side)[0];
            assert!(start.distance(end) < 1e-4, "{name} {side_name}: ends {end}, began {start}");
        }
    }
}
