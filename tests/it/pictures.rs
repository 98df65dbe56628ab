//! Pictures of skinned characters, drawn on a software driver: the same as the engine's own skinning, and steady.

use core::f32::consts::PI;
use std::time::{Duration, Instant};

use avian3d::prelude::{Collider, PhysicsPlugins, RigidBody};
use bevy::{
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass, MotionVectorPrepass, NormalPrepass},
    light::NotShadowCaster,
    math::Affine3A,
    mesh::{
        MeshTag,
        morph::{MeshMorphWeights, MorphAttributes},
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    pbr::DefaultOpaqueRendererMethod,
    prelude::*,
    render::render_resource::AsBindGroup,
    shader::ShaderRef,
};
use surefoot::{
    SurefootPlugins,
    anim::pose::Pose,
    character::{Character, intent::MoveIntent},
    rig::Rig,
    skinning::{
        JointMatrix, Palette, PoseBounds, SkinArena, SkinExtension, SkinPose, SkinnedBy, SkinnedMaterial, SkinnedModel,
        SkinningPlugin, Tint,
        mesh::slot_boxes,
        model::{ModelParts, ModelStatus},
        skin_mesh,
    },
};

use crate::render_support::{DrawSets, Studio, tube, tube_palette};

const JOINTS: usize = 8;

/// Two renderers of the same scene may round an edge differently: this many pixels of 57,600.
const EDGE_PIXELS: usize = 30;

fn standard() -> StandardMaterial {
    StandardMaterial { base_color: Color::srgb(0.9, 0.5, 0.2), perceptual_roughness: 0.6, ..default() }
}

fn test_tube() -> Mesh {
    tube(16, 10, JOINTS)
}

/// Tubes of one mesh and one material.
struct Stock {
    mesh: Handle<Mesh>,
    material: Handle<SkinnedMaterial>,
    bounds: PoseBounds,
}

impl Stock {
    fn new(studio: &mut Studio, source: &Mesh) -> Self {
        let mesh = skin_mesh(source, JOINTS, 0).unwrap();
        let bounds = PoseBounds::new(slot_boxes(&mesh, JOINTS).unwrap().into());
        let material = SkinnedMaterial { base: standard(), extension: SkinExtension };
        Self { mesh: studio.add(mesh), material: studio.add(material), bounds }
    }

    /// An owner with a palette, and a mesh that it moves.
    fn spawn(&self, studio: &mut Studio, place: Transform) -> Entity {
        let world = studio.world();
        let owner = world.spawn((Palette::new(JOINTS), self.bounds.clone(), place, Visibility::default())).id();
        world.spawn((
            Mesh3d(self.mesh.clone()),
            MeshMaterial3d(self.material.clone()),
            SkinnedBy(owner),
            ChildOf(owner),
        ));
        owner
    }
}

fn pose(studio: &mut Studio, owner: Entity, palette: &[Affine3A]) {
    let world = studio.world();
    let range = world.get::<Palette>(owner).expect("owners have a palette").range();
    let mut arena = world.resource_mut::<SkinArena>();
    for (matrix, affine) in arena.matrices_mut(range).iter_mut().zip(palette) {
        *matrix = JointMatrix::from(*affine);
    }
}

/// The same mesh and pose through the engine's own skinning.
fn spawn_built_in(studio: &mut Studio, source: &Mesh, place: Transform, palette: &[Affine3A]) -> Entity {
    let joints = palette
        .iter()
        .map(|affine| studio.world().spawn(GlobalTransform::from(place.compute_affine() * *affine)).id())
        .collect();
    let bundle = (
        Mesh3d(studio.add(source.clone())),
        MeshMaterial3d(studio.add(standard())),
        SkinnedMesh {
            inverse_bindposes: studio.add(SkinnedMeshInverseBindposes::from(vec![Mat4::IDENTITY; palette.len()])),
            joints,
        },
        bevy::camera::visibility::NoFrustumCulling,
        place,
    );
    studio.world().spawn(bundle).id()
}

fn floor(studio: &mut Studio) {
    let mesh = studio.add(Plane3d::default().mesh().size(20.0, 20.0).build());
    let material = studio.add(StandardMaterial::from(Color::srgb(0.35, 0.45, 0.3)));
    studio.world().spawn((Mesh3d(mesh), MeshMaterial3d(material)));
}

/// Three tubes, uneven in place, turn and size, and one moment of their lives.
fn scene() -> [(Transform, Vec<Affine3A>); 3] {
    [-1.2, 0.0, 1.3].map(|x: f32| {
        let place = Transform::from_xyz(x, 0.0, 0.3 * x)
            .with_rotation(Quat::from_rotation_y(x))
            .with_scale(Vec3::splat(1.0 - 0.2 * x.abs()));
        (place, tube_palette(JOINTS, 0.8 + x, x * 3.0))
    })
}

fn compare_with_built_in(name: &str, source: &Mesh, prepare: impl Fn(&mut Studio), weights: Option<Vec<f32>>) {
    let mut studio = Studio::new(SkinningPlugin::default());
    prepare(&mut studio);
    floor(&mut studio);
    let morph = |studio: &mut Studio, entity: Entity| {
        if let Some(weights) = weights.clone() {
            studio.world().entity_mut(entity).insert(MeshMorphWeights::Value { weights });
        }
    };
    let stock = Stock::new(&mut studio, source);
    let mut owners = vec![];
    for (place, palette) in scene() {
        let owner = stock.spawn(&mut studio, place);
        pose(&mut studio, owner, &palette);
        let mesh = studio.world().get::<Children>(owner).expect("it has a mesh")[0];
        morph(&mut studio, mesh);
        owners.push(owner);
    }
    let ours = studio.picture();
    ours.save(&format!("{name}_ours"));
    for owner in owners {
        studio.world().despawn(owner);
    }
    let bare = studio.picture();
    for (place, palette) in scene() {
        let mesh = spawn_built_in(&mut studio, source, place, &palette);
        morph(&mut studio, mesh);
    }
    let engine = studio.picture();
    engine.save(&format!("{name}_engine"));
    let seen = engine.difference(&bare, 20);
    assert!(seen.beyond > 2_000, "{name}: the tubes cover only {} pixels", seen.beyond);
    let difference = ours.difference(&engine, 2);
    assert!(difference.beyond <= EDGE_PIXELS, "{name}: {difference:?}");
}

#[test]
fn looks_the_same_as_the_engines_skinning_with_shadows() {
    compare_with_built_in("forward", &test_tube(), |_| {}, None);
}

#[test]
fn looks_the_same_in_the_prepass_and_the_deferred_pass() {
    compare_with_built_in(
        "deferred",
        &test_tube(),
        |studio| {
            let camera = studio.camera;
            studio.world().entity_mut(camera).insert((DepthPrepass, DeferredPrepass));
            studio.world().insert_resource(DefaultOpaqueRendererMethod::deferred());
        },
        None,
    );
}

#[test]
fn looks_the_same_with_morph_targets() {
    let mut source = test_tube();
    let bulge = |v: usize| {
        let out = if v % 22 < 11 { 0.2 } else { 0.0 };
        MorphAttributes::new(Vec3::new(out, 0.0, 0.0), Vec3::new(0.1, 0.0, 0.0), Vec3::ZERO)
    };
    let lift = |_| MorphAttributes::new(Vec3::Y * 0.3, Vec3::ZERO, Vec3::ZERO);
    let count = source.count_vertices();
    source.set_morph_targets((0..count).map(bulge).chain((0..count).map(lift)).collect());
    compare_with_built_in("morphs", &source, |_| {}, Some(vec![0.7, 0.4]));
}

#[test]
fn vertex_colours_and_tints_multiply() {
    let mut source = test_tube();
    let count = source.count_vertices();
    source.insert_attribute(Mesh::ATTRIBUTE_COLOR, vec![[0.2, 1.0, 0.3, 1.0]; count]);
    compare_with_built_in("colours", &source, |_| {}, None);
}

#[test]
fn a_tint_colours_one_character_alone() {
    let mut studio = Studio::new(SkinningPlugin::default());
    let stock = Stock::new(&mut studio, &test_tube());
    let owner = stock.spawn(&mut studio, Transform::default());
    let plain = studio.picture().mean_drawn();
    studio.world().entity_mut(owner).insert(Tint(LinearRgba::rgb(0.1, 1.0, 1.0)));
    let tinted = studio.picture().mean_drawn();
    assert!(tinted[0] < 0.6 * plain[0], "red went from {} to {}", plain[0], tinted[0]);
    assert!((tinted[1] - plain[1]).abs() < 2.0, "green went from {} to {}", plain[1], tinted[1]);
    let other = stock.spawn(&mut studio, Transform::default());
    studio.world().despawn(owner);
    assert_eq!(studio.world().get::<MeshTag>(other), Some(&MeshTag(2)), "records stay where they are");
    let other = studio.picture().mean_drawn();
    assert_eq!(other, plain, "another character has no tint");
    assert_eq!(studio.draw_sets().opaque, 1);
}

/// Rows of tubes, each in its own pose.
fn crowd(studio: &mut Studio, stock: &Stock, count: usize) -> Vec<Entity> {
    (0..count)
        .map(|i| {
            let (row, column) = (i / 10, i % 10);
            let place = Transform::from_xyz(column as f32 * 0.7 - 3.1, 0.0, -(row as f32))
                .with_rotation(Quat::from_rotation_y(i as f32))
                .with_scale(Vec3::splat(0.5));
            let owner = stock.spawn(studio, place);
            pose(studio, owner, &tube_palette(JOINTS, 0.6, i as f32));
            owner
        })
        .collect()
}

#[test]
fn any_number_of_characters_is_one_draw() {
    let mut studio = Studio::new(SkinningPlugin::default());
    let stock = Stock::new(&mut studio, &test_tube());
    let few = crowd(&mut studio, &stock, 3);
    studio.picture();
    assert_eq!(studio.draw_sets(), DrawSets { opaque: 1, shadow: 1 }, "three characters");
    for owner in few {
        studio.world().despawn(owner);
    }
    crowd(&mut studio, &stock, 100);
    studio.picture().save("crowd");
    assert_eq!(studio.draw_sets(), DrawSets { opaque: 1, shadow: 1 }, "a hundred characters");
}

#[test]
fn growing_while_running_changes_no_pixel() {
    let mut roomy = Studio::new(SkinningPlugin::default());
    let stock = Stock::new(&mut roomy, &test_tube());
    crowd(&mut roomy, &stock, 40);
    let wanted = roomy.picture();

    let mut tight = Studio::new(SkinningPlugin { initial_joints: 20 });
    let stock = Stock::new(&mut tight, &test_tube());
    let early = crowd(&mut tight, &stock, 2);
    tight.picture();
    for owner in early {
        tight.world().despawn(owner);
    }
    crowd(&mut tight, &stock, 40);
    let frame = tight.step();
    assert!(tight.last_upload().buffers_made >= 2, "{:?}", tight.last_upload());
    let difference = tight.frame(frame).difference(&wanted, 0);
    assert_eq!(difference.beyond, 0, "in the very frame of the growth: {difference:?}");
}

#[test]
fn a_despawn_leaves_the_others_as_they_were() {
    let mut studio = Studio::new(SkinningPlugin { initial_joints: 64 });
    let stock = Stock::new(&mut studio, &test_tube());
    let stays = stock.spawn(&mut studio, Transform::from_xyz(0.8, 0.0, 0.0));
    pose(&mut studio, stays, &tube_palette(JOINTS, 1.0, 0.4));
    let wanted = studio.picture();
    for round in 0..6 {
        // Outside the picture, so that only a mix-up of palettes shows.
        let guests: Vec<_> =
            (0..=round).map(|_| stock.spawn(&mut studio, Transform::from_xyz(0.0, 0.0, 50.0))).collect();
        for guest in &guests {
            pose(&mut studio, *guest, &[Affine3A::from_translation(Vec3::splat(0.5)); JOINTS]);
        }
        let with_guests = studio.step();
        for guest in guests {
            studio.world().despawn(guest);
        }
        let without = studio.step();
        for frame in [with_guests, without] {
            let difference = studio.frame(frame).difference(&wanted, 0);
            assert_eq!(difference.beyond, 0, "round {round}, frame {frame}: {difference:?}");
        }
    }
    let arena = studio.world().resource::<SkinArena>();
    assert_eq!(arena.all_matrices().len(), 1 + JOINTS, "what guests had came back");
}

#[test]
fn nothing_is_uploaded_while_nothing_moves() {
    let mut studio = Studio::new(SkinningPlugin::default());
    let stock = Stock::new(&mut studio, &test_tube());
    let owner = stock.spawn(&mut studio, Transform::default());
    studio.picture();
    studio.step();
    assert_eq!(studio.last_upload().bytes, 0);
    pose(&mut studio, owner, &tube_palette(JOINTS, 0.5, 0.0));
    studio.step();
    let moved = studio.last_upload();
    assert_eq!(moved.bytes, 48 * (1 + JOINTS as u64) + 16, "one half of the matrices and the header");
    studio.step();
    assert_eq!(studio.last_upload().bytes, 16, "the header says that the last frame was the same");
    studio.step();
    assert_eq!((studio.last_upload().bytes, studio.last_upload().buffers_made), (0, 1));
}

/// Shows the prepass' motion vectors: 20 times as large, 0 as middle grey.
#[derive(Asset, TypePath, AsBindGroup, Clone)]
struct ShowMotion {}

const SHOW_MOTION: Handle<Shader> = bevy::asset::uuid_handle!("0f6c1f4e-6a0e-4e0b-9d49-9a0d6c1d7a55");
const SHOW_MOTION_WGSL: &str = "
#import bevy_pbr::{forward_io::VertexOutput, prepass_utils::prepass_motion_vector}
@fragment fn fragment(in: VertexOutput) -> @location(0) vec4<f32> {
    return vec4(0.5 + 20.0 * prepass_motion_vector(in.position, 0u), 0.5, 1.0);
}";

impl Material for ShowMotion {
    fn fragment_shader() -> ShaderRef {
        SHOW_MOTION.into()
    }
    fn alpha_mode(&self) -> AlphaMode {
        AlphaMode::Blend
    }
    fn enable_prepass() -> bool {
        false
    }
}

/// A studio whose pictures are motion vectors.
fn motion_studio() -> Studio {
    let mut studio = Studio::with((SkinningPlugin::default(), MaterialPlugin::<ShowMotion>::default()));
    let shader = Shader::from_wgsl(SHOW_MOTION_WGSL, "show_motion.wgsl");
    studio.world().resource_mut::<Assets<Shader>>().insert(&SHOW_MOTION, shader).expect("its id is free");
    let screen = (
        Mesh3d(studio.add(Rectangle::new(4.0, 4.0).into())),
        MeshMaterial3d(studio.add(ShowMotion {})),
        Transform::from_xyz(0.0, 0.0, -0.5),
        NotShadowCaster,
        ChildOf(studio.camera),
    );
    studio.world().spawn(screen);
    let camera = studio.camera;
    studio.world().entity_mut(camera).insert((DepthPrepass, NormalPrepass, MotionVectorPrepass));
    studio
}

#[test]
fn motion_vectors_show_the_motion_and_rest_when_it_does() {
    let mut studio = motion_studio();
    let stock = Stock::new(&mut studio, &test_tube());
    // One that never moves: what comes later is of a mesh that is drawn already, and seen from its first frame.
    stock.spawn(&mut studio, Transform::from_xyz(1.5, 0.0, 0.0));
    let still = studio.picture();
    let owner = stock.spawn(&mut studio, Transform::default());
    pose(&mut studio, owner, &tube_palette(JOINTS, 0.0, 0.3));
    let first = studio.step();
    pose(&mut studio, owner, &tube_palette(JOINTS, 0.05, 0.3));
    let moving = studio.step();
    let paused = studio.step();
    let later = studio.step();
    studio.frame(moving).save("motion");
    let motion = studio.frame(moving).difference(&still, 2);
    assert!(motion.beyond > 500, "a swaying tube moves {} pixels", motion.beyond);
    for (name, frame) in [("first", first), ("first paused", paused), ("second paused", later)] {
        let motion = studio.frame(frame).difference(&still, 1);
        assert_eq!(motion.beyond, 0, "{name} frame: {motion:?}");
    }
}

#[test]
fn motion_vectors_are_those_of_the_engines_skinning() {
    let mut studio = motion_studio();
    let stock = Stock::new(&mut studio, &test_tube());
    let [from, to] = [0.0, 0.05].map(|time| tube_palette(JOINTS, time, 0.3));
    let owner = stock.spawn(&mut studio, Transform::default());
    pose(&mut studio, owner, &from);
    studio.picture();
    pose(&mut studio, owner, &to);
    let frame = studio.step();
    let ours = studio.frame(frame);
    studio.world().despawn(owner);
    let mesh = spawn_built_in(&mut studio, &test_tube(), Transform::default(), &from);
    studio.picture();
    let joints = studio.world().get::<SkinnedMesh>(mesh).expect("just spawned").joints.clone();
    for (joint, affine) in joints.into_iter().zip(&to) {
        studio.world().entity_mut(joint).insert(GlobalTransform::from(*affine));
    }
    let frame = studio.step();
    let engine = studio.frame(frame);
    let difference = ours.difference(&engine, 2);
    assert!(difference.beyond <= EDGE_PIXELS, "{difference:?}");
}

#[test]
fn culling_follows_the_pose_and_not_the_bind_pose() {
    let mut studio = Studio::new(SkinningPlugin::default());
    let stock = Stock::new(&mut studio, &test_tube());
    // The palette carries the tube ten metres from where it was skinned: to where the camera looks.
    let owner = stock.spawn(&mut studio, Transform::default());
    pose(&mut studio, owner, &[Affine3A::from_translation(Vec3::X * 10.0); JOINTS]);
    studio.look(Vec3::new(10.0, 1.0, 4.0), Vec3::new(10.0, 1.0, 0.0));
    assert!(studio.picture().drawn() > 1_000, "drawn where the pose is");
    let mesh = studio.world().get::<Children>(owner).expect("it has a mesh")[0];
    let seen = |studio: &mut Studio| studio.world().get::<ViewVisibility>(mesh).expect("meshes have it").get();
    assert!(seen(&mut studio));
    studio.look(Vec3::new(30.0, 1.0, 4.0), Vec3::new(30.0, 1.0, 0.0));
    let mut suns = studio.world().query_filtered::<Entity, With<DirectionalLight>>();
    let sun = suns.single(studio.app.world()).expect("the studio has one sun");
    studio.world().despawn(sun);
    studio.step();
    assert!(!seen(&mut studio), "culled where nothing of it is");
}

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
    (studio, characters)
}

/// The mannequin's skeleton in a pose that bends elbows, a knee, the neck and the back.
fn bent(studio: &mut Studio) -> Pose {
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

#[test]
fn a_character_gets_its_skin_and_walks_in_it() {
    let mut studio = Studio::with((PhysicsPlugins::default(), SurefootPlugins));
    floor(&mut studio);
    let collider = Collider::cuboid(40.0, 1.0, 40.0);
    studio.world().spawn((RigidBody::Static, collider, Transform::from_xyz(0.0, -0.5, 0.0)));
    let file = studio.world().resource::<AssetServer>().load("mannequin.character.ron");
    let place = Transform::from_xyz(1.0, 0.0, 0.0).with_rotation(Quat::from_rotation_y(1.2));
    let character = studio.world().spawn((Character(file), place)).id();
    wait_for_model(&mut studio, character);
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

#[test]
fn without_a_gpu_palettes_live_and_nothing_is_drawn() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, SkinningPlugin::default()));
    app.finish();
    app.cleanup();
    let owner = app.world_mut().spawn(Palette::new(4)).id();
    app.update();
    let range = app.world().get::<Palette>(owner).expect("just spawned").range();
    assert_eq!(app.world_mut().resource_mut::<SkinArena>().matrices_mut(range).len(), 4);
    app.update();
}
