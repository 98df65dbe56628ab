//! Morph targets follow what plays: the mannequin blinks and breathes, whatever its limbs do.

use bevy::prelude::*;
use surefoot::{
    character::{
        animator::{Actions, MorphScratch, morph_weights},
        locomotion::Locomotion,
    },
    testing::{Stage, World},
};

/// The mannequin's targets, in the order of its file.
const BLINK: usize = 0;
const BREATH: usize = 1;

/// Weights of blink and breath as they are now; `None` when nothing that plays says anything of them.
fn weights(stage: &Stage, walker: Entity) -> Option<[f32; 2]> {
    let asset = stage.asset(walker).expect("loaded");
    let mesh = asset.rig.meshes.iter().find(|mesh| mesh.morph_weights.len() == 2).expect("the mannequin has targets");
    let (locomotion, actions) = (stage.get::<Locomotion>(walker), stage.get::<Actions>(walker));
    let mut scratch = MorphScratch::default();
    let told = morph_weights(asset, locomotion.expect("bound"), actions.expect("bound"), mesh, &mut scratch);
    told.then(|| [scratch.weights[BLINK], scratch.weights[BREATH]])
}

/// Least and greatest weight of each target in so many seconds, and the greatest change in a frame.
fn range(stage: &mut Stage, walker: Entity, seconds: u16) -> ([f32; 2], [f32; 2], f32) {
    let (mut least, mut most, mut change) = ([f32::MAX; 2], [f32::MIN; 2], 0.0f32);
    let mut last: Option<[f32; 2]> = None;
    for _ in 0..60 * seconds {
        stage.run_for(1.0 / 60.0);
        let now = weights(stage, walker).unwrap_or_default();
        for target in [BLINK, BREATH] {
            least[target] = least[target].min(now[target]);
            most[target] = most[target].max(now[target]);
            change = change.max(last.map_or(0.0, |last| (now[target] - last[target]).abs()));
        }
        last = Some(now);
    }
    (least, most, change)
}

#[test]
fn who_stands_blinks_and_breathes() {
    let mut stage = Stage::on(&World::flat());
    let walker = stage.spawn_walker().expect("the mannequin loads");
    stage.run_for(0.5);
    let (least, most, _) = range(&mut stage, walker, 9);
    assert!(least[BLINK] < 0.01 && most[BLINK] > 0.8, "blinks from {} to {}", least[BLINK], most[BLINK]);
    assert!(least[BREATH] < 0.1 && most[BREATH] > 0.9, "breathes from {} to {}", least[BREATH], most[BREATH]);
}

#[test]
fn a_wave_of_the_arm_leaves_the_face_alone() {
    let [mut waving, mut plain] = [(), ()].map(|()| {
        let mut stage = Stage::on(&World::flat());
        let walker = stage.spawn_walker().expect("the mannequin loads");
        stage.run_for(0.5);
        (stage, walker)
    });
    waving.0.app().world_mut().get_mut::<Actions>(waving.1).expect("bound").play("wave");
    for frame in 0..150 {
        waving.0.run_for(1.0 / 60.0);
        plain.0.run_for(1.0 / 60.0);
        let [with, without] = [&waving, &plain].map(|(stage, walker)| weights(stage, *walker));
        assert_eq!(with, without, "in frame {frame}");
    }
}

#[test]
fn weights_blend_with_the_clips_that_move_them() {
    let mut stage = Stage::on(&World::flat());
    let walker = stage.spawn_walker().expect("the mannequin loads");
    stage.run_for(1.5);
    for speed in [1.4, 0.0, 3.5, 0.0] {
        stage.walk(walker, Vec3::NEG_Z * speed);
        let (_, _, change) = range(&mut stage, walker, 2);
        // Lids close in 0.08 s, and fastest half-way.
        assert!(change < 0.35, "at {speed} m/s a weight jumps by {change}");
    }
}
