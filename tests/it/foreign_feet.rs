//! Feet of foreign bodies on ground that isn't made for them: long, stiff, or driven into the floor by their own clips.

use std::collections::BTreeMap;

use bevy::prelude::*;
use surefoot::{
    anim::clip::Clip,
    measure::summary::Measures,
    rig::{Rig, character::CharacterAsset, character_file::CharacterFile},
    testing::{Stage, World},
};

use crate::gltf_file::Body;

/// A body of boxes that plays the mannequin's clips; its feet are `feet` times as long as a human's and one piece each.
fn stiff_footed(size: f32, feet: f32) -> CharacterAsset {
    let mut file = Body { size, feet, toes: false, ..Body::default() }.build();
    file.root.as_object_mut().expect("an object").remove("animations");
    let rig = Rig::from_slice(&file.glb(), |_| Err("no files".to_owned())).expect("the file is good");
    let asset = CharacterAsset::resolve(CharacterFile::default(), "body.glb".into(), rig, &BTreeMap::new());
    asset.unwrap_or_else(|error| panic!("{error}"))
}

/// What `asset` did who goes straight ahead over `world` for five seconds.
fn goes(asset: CharacterAsset, world: &World, speed: f32) -> Measures {
    let mut stage = Stage::on(world);
    let walker = stage.spawn_loaded(asset, &[Transform::IDENTITY])[0];
    stage.run_for(0.5).start_recording(walker).walk(walker, Vec3::NEG_Z * speed).run_for(5.0);
    stage.measures(walker)
}

#[test]
fn stiff_feet_come_down_a_kerb_without_their_tips_in_the_road() {
    for (size, feet) in [(1.0, 1.0), (0.6, 1.4), (1.0, 2.0)] {
        let measures = goes(stiff_footed(size, feet), &World::curb(), 1.0);
        let deep = measures.penetration_max;
        assert!(deep <= 5.0, "size {size}, feet {feet} times as long: {deep} mm deep");
        assert!(measures.drift_max <= 5.0, "size {size}, feet {feet}: drifts {} mm", measures.drift_max);
    }
}

#[test]
fn long_stiff_feet_stand_on_the_edges_of_stairs() {
    // A metre of sole over treads of 29 cm.
    let world = World::stairs_up(12, 0.17, 0.29);
    let place = |step: u8| {
        let turn = Quat::from_rotation_y(0.55 * f32::from(step));
        Transform::from_xyz(0.0, 0.0, -3.2 - 0.1 * f32::from(step)).with_rotation(turn)
    };
    for place in world.on_ground(&[5, 6, 7].map(place)) {
        let mut stage = Stage::on(&world);
        let stands = stage.spawn_loaded(stiff_footed(2.0, 2.5), &[place])[0];
        stage.run_for(1.0).start_recording(stands).run_for(0.5);
        let deep = stage.measures(stands).penetration_max;
        assert!(deep <= 5.0, "{deep} mm deep at {}", place.translation);
    }
}

#[test]
fn feet_that_their_clip_drives_into_the_floor_clear_the_ground() {
    let glb = include_bytes!("../../assets/mannequin.glb");
    let mut rig = Rig::from_slice(glb, |_| Err("no files".to_owned())).expect("the mannequin is good");
    let hips = rig.skeleton.find("hips").expect("it has hips");
    for clip in rig.clips.iter_mut().filter(|clip| clip.name == "walk") {
        *clip = Clip::clone(clip).moved(&rig.skeleton, hips, Vec3::Y * -0.06).into();
    }
    let asset = CharacterAsset::resolve(CharacterFile::default(), "body.glb".into(), rig, &BTreeMap::new());
    let skate = goes(asset.expect("it walks"), &World::flat(), 1.4).skate;
    assert!(skate <= 0.8, "feet skate {skate} cm/s");
}

#[test]
fn who_stands_across_stairs_takes_treads_that_his_legs_reach() {
    // So steep that his feet, side by side, would stand two risers apart: four fifths of a leg.
    let world = World::stairs_up(14, 0.35, 0.12);
    for step in [0u8, 3, 7] {
        let turn = Quat::from_rotation_y(core::f32::consts::FRAC_PI_2);
        let place = Transform::from_xyz(0.0, 0.0, -3.4 - 0.03 * f32::from(step)).with_rotation(turn);
        let place = world.on_ground(&[place])[0];
        let mut stage = Stage::on(&world);
        let stands = stage.spawn_loaded(stiff_footed(1.0, 1.0), &[place])[0];
        stage.run_for(1.0).start_recording(stands).run_for(0.5);
        let measures = stage.measures(stands);
        assert!(measures.penetration_max <= 5.0, "{} mm deep at {}", measures.penetration_max, place.translation);
        assert!(measures.float_p95 <= 10.0, "{} mm over the ground at {}", measures.float_p95, place.translation);
    }
}
