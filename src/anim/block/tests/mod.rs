//! Blocks against the scalar functions: the same palettes, within 1e-5 of a palette's size.

mod limbs;
mod locals;
mod reference;
mod shorts;

use bevy::math::Vec3;
use proptest::prelude::*;

use super::{
    Actor, Instructions, Layer, LayerMode, LimbJoints, Play, Precision, RowSource, Species, SpeciesError, SpeciesParts,
    Until, Workspace, pose, pose_until,
};
use crate::anim::{
    bake::{ClipCurves, JointCurves},
    curve::{Curve, Interpolation},
    ik::two_bone::Extension,
    matrix::JointMatrix,
    skeleton::{JointIndex, Skeleton},
    skin::Skin,
};
use reference::{Body, Dice, body, palette, posed};

/// Largest difference of two palettes' numbers over their largest number.
fn difference(got: &[JointMatrix], wanted: &[JointMatrix]) -> f32 {
    let numbers = |palette: &[JointMatrix]| palette.iter().flat_map(|m| m.0).flatten().collect::<Vec<f32>>();
    let (got, wanted) = (numbers(got), numbers(wanted));
    assert_eq!(got.len(), wanted.len(), "palettes of one skin");
    let size = wanted.iter().map(|x| x.abs()).fold(1.0, f32::max);
    got.iter().zip(&wanted).map(|(a, b)| if a.is_nan() { f32::NAN } else { (a - b).abs() / size }).fold(0.0, f32::max)
}

/// All kinds of instructions that this machine has.
fn all_instructions() -> [Instructions; 3] {
    [Instructions::best(), Instructions::avx2().unwrap_or_default(), Instructions::baseline()]
}

/// Palettes of `actors`, one after the other, with all kinds of instructions.
fn palettes(species: &Species, actors: &[Actor]) -> [Vec<JointMatrix>; 3] {
    all_instructions().map(|instructions| {
        let mut matrices = vec![JointMatrix([[f32::NAN; 4]; 3]); actors.len() * species.slot_count()];
        let actors: Vec<_> = actors
            .iter()
            .enumerate()
            .map(|(index, actor)| Actor { palette: index * species.slot_count(), ..*actor })
            .collect();
        pose(species, &actors, &mut Workspace::with(instructions), &mut matrices);
        matrices
    })
}

fn plays() -> impl Strategy<Value = Vec<Play>> {
    let play = (0usize..3, -1.0f32..4.0, -0.2f32..1.0).prop_map(|(clip, time, weight)| Play { clip, time, weight });
    prop::collection::vec(play, 0..5)
}

/// An own lower layer, one that a mask holds back, and a difference on top; of each character.
fn layers() -> impl Strategy<Value = Vec<(Vec<Play>, Vec<Play>, f32, Play, f32)>> {
    let added = (-1.0f32..4.0).prop_map(|time| Play { clip: 3, time, weight: 1.0 });
    prop::collection::vec((plays(), plays(), 0.0f32..1.0, added, 0.0f32..1.0), 1..11)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn blocks_give_the_palettes_of_the_scalar_functions(body in body(1..24, 0.4), layers in layers(), short in any::<bool>()) {
        let Body { skeleton, skin, clips, mask, .. } = &body;
        let reference = skeleton.rest();
        let precision = if short { Precision::Short } else { Precision::Float };
        let mut sources: Vec<_> = clips[..3].iter().map(|clip| RowSource::new(clip, Precision::Float)).collect();
        sources.push(RowSource { difference_from: Some(reference), ..RowSource::new(&clips[3], precision) });
        let parts = SpeciesParts { skeleton, skin, limbs: &[], clips: &sources, masks: &[mask.as_slice()] };
        let species = Species::new(&parts).unwrap();
        let stacks: Vec<_> = layers.iter().map(|(own, masked, share, added, much)| [
            Layer { mode: LayerMode::Override, weight: 1.0, mask: None, clips: own },
            Layer { mode: LayerMode::Override, weight: *share, mask: Some(0), clips: masked },
            Layer { mode: LayerMode::Add, weight: *much, mask: None, clips: core::slice::from_ref(added) },
        ]).collect();
        let actors: Vec<_> = stacks.iter().map(|layers| Actor { layers, ..Actor::default() }).collect();
        // 16 bits are that much coarser.
        let bar = if short { 2e-3 } else { 1e-5 };
        for matrices in palettes(&species, &actors) {
            for (index, actor) in actors.iter().enumerate() {
                let wanted = palette(&body, &[], actor);
                let got = &matrices[index * species.slot_count()..][..species.slot_count()];
                let off = difference(got, &wanted);
                prop_assert!(off < bar, "character {index} of {}: {off:e} off", actors.len());
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn still_joints_stay_at_rest_and_all_others_play(body in body(2..24, 0.4), plays in plays(), each in 1usize..4) {
        let still: Vec<_> = body.skeleton.joints().skip(1).step_by(each).collect();
        let sources: Vec<_> = body.clips[..3]
            .iter()
            .map(|clip| RowSource { still: &still, ..RowSource::new(clip, Precision::Float) })
            .collect();
        let parts =
            SpeciesParts { skeleton: &body.skeleton, skin: &body.skin, limbs: &[], clips: &sources, masks: &[] };
        let species = Species::new(&parts).unwrap();
        let layers = [Layer { weight: 1.0, clips: &plays, ..Layer::default() }];
        let actor = Actor { layers: &layers, ..Actor::default() };
        let mut pose = posed(&body, &actor);
        still.iter().for_each(|joint| pose.set_local(*joint, body.skeleton.rest()[joint.index()]));
        pose.update_model(&body.skeleton);
        let wanted: Vec<JointMatrix> = body.skin.palette(&pose).map(JointMatrix::from).collect();
        for matrices in palettes(&species, &[actor]) {
            let off = difference(&matrices, &wanted);
            prop_assert!(off < 1e-5, "{off:e} off");
        }
    }
}

#[test]
fn one_joint_and_a_thousand_are_posed_alike() {
    for count in [1, 1000] {
        let body = Dice(7).body(count, 0.0);
        let sources: Vec<_> = body.clips.iter().map(|clip| RowSource::new(clip, Precision::Float)).collect();
        let parts =
            SpeciesParts { skeleton: &body.skeleton, skin: &body.skin, limbs: &[], clips: &sources, masks: &[] };
        let species = Species::new(&parts).unwrap();
        let clips = [Play { clip: 0, time: 0.4, weight: 0.3 }, Play { clip: 1, time: 0.1, weight: 0.7 }];
        let layers = [Layer { weight: 1.0, clips: &clips, ..Layer::default() }];
        let actor = Actor { layers: &layers, ..Actor::default() };
        for matrices in palettes(&species, &[actor]) {
            let off = difference(&matrices, &palette(&body, &[], &actor));
            assert!(off < 1e-5, "{count} joints: {off:e} off");
        }
    }
}

#[test]
fn a_character_looks_the_same_in_every_place_of_a_block() {
    let body = Dice(7).body(20, 0.5);
    let sources: Vec<_> = body.clips.iter().map(|clip| RowSource::new(clip, Precision::Float)).collect();
    let parts = SpeciesParts { skeleton: &body.skeleton, skin: &body.skin, limbs: &[], clips: &sources, masks: &[] };
    let species = Species::new(&parts).unwrap();
    let clips: Vec<_> = (0..19).map(|i| [Play { clip: i % 3, time: i as f32 * 0.1, weight: 1.0 }]).collect();
    let layers: Vec<_> = clips.iter().map(|clips| [Layer { weight: 1.0, clips, ..Layer::default() }]).collect();
    let actors: Vec<_> = layers.iter().map(|layers| Actor { layers, ..Actor::default() }).collect();
    let [together, ..] = palettes(&species, &actors);
    for (index, actor) in actors.iter().enumerate() {
        let [alone, ..] = palettes(&species, &[*actor]);
        let block = &together[index * species.slot_count()..][..species.slot_count()];
        assert_eq!(alone, block, "character {index}");
    }
}

#[test]
fn without_clips_characters_stand_at_rest() {
    let body = Dice(7).body(12, 0.3);
    let parts = SpeciesParts { skeleton: &body.skeleton, skin: &body.skin, limbs: &[], clips: &[], masks: &[] };
    let species = Species::new(&parts).unwrap();
    let unknown = [Play { clip: 7, time: 0.0, weight: 1.0 }];
    let layers = [Layer { weight: 1.0, clips: &unknown, ..Layer::default() }];
    for actor in [Actor::default(), Actor { layers: &layers, ..Actor::default() }] {
        let off = difference(&palettes(&species, &[actor])[0], &palette(&body, &[], &Actor::default()));
        assert!(off < 1e-5, "{off:e} off");
    }
}

#[test]
fn nothing_is_written_before_the_last_stage() {
    let body = Dice(7).body(12, 0.3);
    let parts = SpeciesParts { skeleton: &body.skeleton, skin: &body.skin, limbs: &[], clips: &[], masks: &[] };
    let species = Species::new(&parts).unwrap();
    let empty = JointMatrix([[7.0; 4]; 3]);
    for until in [Until::Sampled, Until::Modelled, Until::Reached] {
        let mut matrices = vec![empty; species.slot_count()];
        pose_until(&species, &[Actor::default()], &mut Workspace::default(), &mut matrices, until);
        assert!(matrices.iter().all(|matrix| *matrix == empty), "{until:?} wrote a palette");
    }
}

#[test]
fn parts_that_do_not_fit_are_refused_by_name() {
    let joint = |name: &str, parent| (name.to_owned(), parent, crate::anim::skeleton::JointTransform::IDENTITY);
    let joints = [joint("hip", None), joint("knee", Some(JointIndex(0))), joint("hand", Some(JointIndex(0)))];
    let skeleton = Skeleton::new(joints, bevy::math::Affine3A::from_translation(Vec3::ZERO)).unwrap();
    let skin = Skin { joints: vec![JointIndex(9)], inverse_bind: vec![JointMatrix::IDENTITY] };
    let none = Skin::default();
    let limb =
        LimbJoints { upper: JointIndex(0), lower: JointIndex(1), end: JointIndex(2), extension: Extension::default() };
    let fails = |skin: &Skin, limbs: &[LimbJoints], masks: &[&[f32]]| {
        let parts = SpeciesParts { skeleton: &skeleton, skin, limbs, clips: &[], masks };
        Species::new(&parts).expect_err("parts don't fit")
    };
    assert_eq!(fails(&skin, &[], &[]).to_string(), "palette slot 0 names joint 9 of 3");
    assert_eq!(fails(&none, &[limb], &[]).to_string(), "limb 0: `hand` does not hang below `knee`");
    let error = fails(&none, &[], &[&[1.0]]);
    assert_eq!(error, SpeciesError::Count { what: "mask", index: 0, found: 1, joints: 3 });
}

#[test]
fn clips_that_keep_keys_are_refused_by_name() {
    let skeleton = Skeleton::new(
        [("hip".to_owned(), None, crate::anim::skeleton::JointTransform::IDENTITY)],
        bevy::math::Affine3A::IDENTITY,
    )
    .unwrap();
    let steps = Curve::new(vec![0.0, 0.5, 1.0], vec![Vec3::ZERO, Vec3::Y, Vec3::ZERO], Interpolation::Step).unwrap();
    let joints = vec![JointCurves { translation: Some(steps), ..JointCurves::new(JointIndex(0)) }];
    let clip = ClipCurves { name: "jerk".to_owned(), joints, ..ClipCurves::default() }.bake(&skeleton);
    let clips = [RowSource::new(&clip, Precision::Float)];
    let skin = Skin::default();
    let parts = SpeciesParts { skeleton: &skeleton, skin: &skin, limbs: &[], clips: &clips, masks: &[] };
    let error = Species::new(&parts).expect_err("rows don't hold steps");
    assert_eq!(error, SpeciesError::Keyed { index: 0, name: "jerk".to_owned() });
}
