//! The mannequin in its own skin.

use core::f32::consts::PI;
use std::time::{Duration, Instant};

use avian3d::prelude::{Collider, PhysicsPlugins, RigidBody};
use bevy::{mesh::morph::MeshMorphWeights, prelude::*};
use surefoot::{
    SurefootPlugins,
    anim::pose::Pose,
    character::{Character, intent::MoveIntent},
    rig::{Rig, character::CharacterAsset},
    skinning::{
        Morphs, PoseBounds, SkinArena, SkinPose, SkinnedBy, SkinnedModel, SkinningPlugin, Tint,
        model::{ModelParts, ModelStatus},
    },
};

use super::floor;
use crate::render_support::Studio;

/// A studio with mannequins at the given places, built and ready.
fn mannequins(places: &[Transform]) -> (Studio, Vec<Entity>) {
    let mut studio = Studio::new(SkinningPlugin::default());
    floor(&mut studio);
    let server = studio.world().resource::<AssetServer>().clone();
    let model = SkinnedModel { gltf: server.load("mannequin.glb"), rig: server.load("mannequin.glb") };
    let characters = places.iter().map(|place| studio.world().spawn((model.clone(), *place)).id()).collect();
    let deadline = Instant::now() + Duration::from_secs(60);
    while studio.world().query::<&ModelStatus>().iter(studio.app.world()).any(|status| !status.is_ready()) {
        assert!(Instant::now() < deadline, "mannequin.glb is not built after a minute");
        studio.step();
    }
    // The floor is one set of draws; a busy machine takes some frames more until the meshes are on the GPU.
    while studio.draw_sets().opaque < 2 {
        assert!(Instant::now() < deadline, "the mannequin is not drawn after a minute");
        studio.step();
    }
    (studio, characters)
}

/// The mannequin's skeleton in a pose that bends elbows, a knee, the neck and the back.
pub(super) fn bent(studio: &mut Studio) -> Pose {
    let rigs = studio.world().resource::<Assets<Rig>>();
    let (_, rig) = rigs.iter().next().expect("the mannequin's rig is loaded");
    let mut pose = Pose::rest(&rig.skeleton);
    let turns = [
        ("leftUpperArm", Quat::from_rotation_z(1.1)),
        ("rightUpperArm", Quat::from_rotation_x(-0.9)),
        ("leftLowerArm", Quat::from_rotation_x(-1.2)),
        ("rightLowerArm", Quat::from_rotation_y(1.3)),
        ("leftUpperLeg", Quat::from_rotation_x(1.0)),
        ("leftLowerLeg", Quat::from_rotation_x(-1.2)),
        ("spine", Quat::from_rotation_y(0.4)),
        ("neck", Quat::from_rotation_z(0.3)),
    ];
    for (name, turn) in turns {
        let joint = rig.skeleton.find(name).unwrap_or_else(|| panic!("no `{name}` among {:?}", rig.skeleton.names()));
        pose.update_model(&rig.skeleton);
        pose.rotate_model(&rig.skeleton, joint, turn * pose.rotation(joint));
    }
    pose.update_model(&rig.skeleton);
    pose
}

#[test]
fn the_mannequin_stands_and_bends() {
    let places = [
        Transform::from_xyz(-0.8, 0.0, 0.0).with_rotation(Quat::from_rotation_y(PI)),
        Transform::from_xyz(0.8, 0.0, 0.0).with_rotation(Quat::from_rotation_y(PI)),
    ];
    let (mut studio, characters) = mannequins(&places);
    studio.look(Vec3::new(0.0, 1.4, 3.0), Vec3::new(0.0, 0.95, 0.0));
    let resting = studio.picture();
    resting.save("mannequin_rest");
    let pose = bent(&mut studio);
    studio.world().entity_mut(characters[1]).insert((SkinPose(pose), Tint(LinearRgba::rgb(0.4, 0.7, 1.0))));
    let bent = studio.picture();
    bent.save("mannequin_bent");
    let changed = resting.difference(&bent, 20).beyond;
    assert!((500..20_000).contains(&changed), "{changed} pixels changed");
    let meshes = studio.world().query_filtered::<(), With<SkinnedBy>>().iter(studio.app.world()).count();
    assert!(meshes >= 2 && meshes % 2 == 0, "{meshes} meshes of two mannequins");
    assert!(studio.draw_sets().opaque <= 1 + meshes / 2, "{:?} for {meshes} meshes", studio.draw_sets());
}

#[test]
fn the_mannequin_blinks_while_it_stands_still() {
    let (mut studio, characters) = mannequins(&[Transform::from_rotation(Quat::from_rotation_y(PI))]);
    studio.look(Vec3::new(0.0, 1.66, 0.5), Vec3::new(0.0, 1.64, 0.0));
    let open = studio.picture();
    open.save("mannequin_eyes_open");
    let mut morphs = studio.world().get_mut::<Morphs>(characters[0]).expect("the mannequin has morph targets");
    assert!(morphs.set("blink", 1.0), "no `blink` among {:?}", morphs.names());
    let shut = studio.picture();
    shut.save("mannequin_eyes_shut");
    let changed = open.difference(&shut, 20).beyond;
    assert!((50..5_000).contains(&changed), "{changed} pixels changed");
    studio.world().get_mut::<Morphs>(characters[0]).expect("it still has").set("blink", 0.0);
    let again = studio.picture().difference(&open, 1);
    assert_eq!(again.beyond, 0, "open again: {again:?}");
}

#[test]
fn a_crowd_of_mannequins_costs_the_draws_of_one() {
    let (mut one, _) = mannequins(&[Transform::default()]);
    one.picture();
    let places: Vec<_> =
        (0..30).map(|i| Transform::from_xyz((i % 6) as f32 - 2.5, 0.0, -((i / 6) as f32) * 1.2)).collect();
    let (mut many, _) = mannequins(&places);
    many.look(Vec3::new(0.0, 3.0, 4.5), Vec3::new(0.0, 0.8, -2.0));
    many.picture().save("mannequin_crowd");
    assert_eq!(many.draw_sets(), one.draw_sets());
}

/// Steps until the model of `character` is built.
fn wait_for_model(studio: &mut Studio, character: Entity) {
    let deadline = Instant::now() + Duration::from_secs(60);
    while !studio.world().get::<ModelStatus>(character).is_some_and(ModelStatus::is_ready) {
        assert!(Instant::now() < deadline, "mannequin.character.ron is not drawn after a minute");
        studio.step();
    }
}

/// A studio with a character that stands in its skin.
fn character() -> (Studio, Entity) {
    let mut studio = Studio::with((PhysicsPlugins::default(), SurefootPlugins));
    floor(&mut studio);
    let collider = Collider::cuboid(40.0, 1.0, 40.0);
    studio.world().spawn((RigidBody::Static, collider, Transform::from_xyz(0.0, -0.5, 0.0)));
    let file = studio.world().resource::<AssetServer>().load("mannequin.character.ron");
    let place = Transform::from_xyz(1.0, 0.0, 0.0).with_rotation(Quat::from_rotation_y(1.2));
    let character = studio.world().spawn((Character(file), place)).id();
    wait_for_model(&mut studio, character);
    (studio, character)
}

#[test]
fn a_character_that_stands_breathes_and_blinks_in_its_skin() {
    let (mut studio, character) = character();
    let handle = studio.world().get::<Character>(character).expect("it is one").0.clone();
    let mut assets = studio.world().resource_mut::<Assets<CharacterAsset>>();
    assets.get_mut_untracked(&handle).expect("it is loaded").file.blink.interval = 1.0;
    let mut most = [0.0f32; 2];
    let mut shown = 0.0f32;
    for _ in 0..240 {
        studio.step();
        let morphs = studio.world().get::<Morphs>(character).expect("the mannequin has morph targets");
        let now = ["blink", "breath"].map(|name| morphs.weight(name).expect("it has it"));
        most = [most[0].max(now[0]), most[1].max(now[1])];
        let mut drawn = studio.world().query::<&MeshMorphWeights>();
        let weights = drawn.iter(studio.app.world()).filter_map(|drawn| match drawn {
            MeshMorphWeights::Value { weights } => weights.get(1),
            MeshMorphWeights::Reference(_) => None,
        });
        shown = weights.copied().fold(shown, f32::max);
    }
    assert!(most[0] > 0.8, "in four seconds the lids close by {}", most[0]);
    assert!(most[1] > 0.9 && shown > 0.9, "it breathes in by {}, its meshes by {shown}", most[1]);
}

#[test]
fn a_character_gets_its_skin_and_walks_in_it() {
    let (mut studio, character) = character();
    studio.look(Vec3::new(0.0, 1.3, 3.2), Vec3::new(0.0, 0.9, 0.0));
    let standing = studio.picture();
    standing.save("character_stands");
    studio.world().entity_mut(character).insert(MoveIntent { velocity: Vec3::NEG_X * 1.4, ..default() });
    let part = studio.world().get::<ModelParts>(character).expect("it is drawn").iter().next().expect("in one part");
    let (mut fitted, mut refits) = (None, 0);
    for _ in 0..60 {
        studio.step();
        let bounds = studio.world().get::<PoseBounds>(part).expect("parts have bounds").fitted();
        refits += usize::from(fitted.replace(bounds).is_some_and(|before| before != bounds));
    }
    let walking = studio.picture();
    walking.save("character_walks");
    let travelled = studio.world().get::<Transform>(character).expect("it lives").translation;
    assert!(travelled.x < 0.3, "in one second it went to {travelled}");
    let changed = standing.difference(&walking, 20).beyond;
    assert!(changed > 1_500, "{changed} pixels changed");
    assert!(refits <= 6, "the culling box changed {refits} times in 60 frames");
}

#[test]
fn a_mannequin_leaves_nothing_behind() {
    let (mut studio, characters) = mannequins(&[Transform::default(), Transform::from_xyz(1.0, 0.0, 0.0)]);
    for character in characters {
        studio.world().despawn(character);
    }
    studio.picture();
    let world = studio.world();
    assert_eq!(world.query::<&SkinnedBy>().iter(world).count(), 0);
    assert_eq!(world.resource::<SkinArena>().all_matrices().len(), 1, "all palettes came back");
}
