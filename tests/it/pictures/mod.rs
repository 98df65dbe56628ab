//! Pictures of skinned characters, drawn on a software driver: the same as the engine's own skinning, and steady.

mod engine;
mod levels;
mod life;
mod mannequin;
mod motion;

use bevy::{
    math::Affine3A,
    mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    prelude::*,
};
use surefoot::skinning::{
    JointMatrix, Palette, PoseBounds, SkinArena, SkinExtension, SkinnedBy, SkinnedMaterial, mesh::slot_boxes, skin_mesh,
};

use crate::{render_support::Studio, tube::tube};

/// Joints of a test tube.
const JOINTS: usize = 8;

/// Two renderers of the same scene may round an edge differently: this many pixels of 57,600.
const EDGE_PIXELS: usize = 30;

/// Orange and rather rough.
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
        Self::of(studio, source, standard())
    }

    fn of(studio: &mut Studio, source: &Mesh, base: StandardMaterial) -> Self {
        let mesh = skin_mesh(source, JOINTS, 0).expect("a tube can be skinned");
        let bounds = PoseBounds::new(slot_boxes(&mesh, JOINTS).expect("and measured").into());
        let material = SkinnedMaterial { base, extension: SkinExtension };
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
fn spawn_built_in(
    studio: &mut Studio,
    source: &Mesh,
    base: StandardMaterial,
    place: Transform,
    palette: &[Affine3A],
) -> Entity {
    let joints = palette
        .iter()
        .map(|affine| studio.world().spawn(GlobalTransform::from(place.compute_affine() * *affine)).id())
        .collect();
    let bundle = (
        Mesh3d(studio.add(source.clone())),
        MeshMaterial3d(studio.add(base)),
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
