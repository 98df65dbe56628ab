//! Motion vectors of the prepass.

use bevy::{
    asset::uuid_handle,
    core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass, NormalPrepass},
    light::NotShadowCaster,
    mesh::skinning::SkinnedMesh,
    prelude::*,
    render::render_resource::AsBindGroup,
    shader::ShaderRef,
};
use surefoot::skinning::SkinningPlugin;

use super::{EDGE_PIXELS, JOINTS, Stock, pose, spawn_built_in, standard, test_tube};
use crate::{render_support::Studio, tube::tube_palette};

/// Shows the prepass' motion vectors: 20 times as large, 0 as middle grey.
#[derive(Asset, TypePath, AsBindGroup, Clone)]
struct ShowMotion {}

const SHOW_MOTION: Handle<Shader> = uuid_handle!("0f6c1f4e-6a0e-4e0b-9d49-9a0d6c1d7a55");
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
    let mesh = spawn_built_in(&mut studio, &test_tube(), standard(), Transform::default(), &from);
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
