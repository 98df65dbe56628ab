//! What a character's model is made of, before it is spawned: parts, their meshes, materials and morph targets.

use bevy::{
    gltf::{Gltf, GltfMesh},
    prelude::*,
};

use super::{
    bounds::{PoseBounds, SlotBox},
    convert::{Binding, Converter},
    material::SkinnedMaterial,
    mesh::SkinMeshError,
    model::{ModelPart, PartOf},
    morphs::Morphs,
    palette::{Palette, SkinnedBy},
};
use crate::rig::Rig;

/// A part to be spawned.
pub(super) struct PartPlan {
    part: ModelPart,
    boxes: Vec<SlotBox>,
    meshes: Vec<MeshPlan>,
    /// Meshes that cannot be drawn, and why.
    pub(super) errors: Vec<(String, SkinMeshError)>,
}

struct MeshPlan {
    name: String,
    mesh: Handle<Mesh>,
    material: Handle<SkinnedMaterial>,
    /// Its place in [`Rig::meshes`].
    binding: usize,
    /// Morph targets by name, and their weights at rest.
    morphs: Vec<(String, f32)>,
}

/// What to spawn for `rig`'s meshes; `None` while something is still loading.
pub(super) fn plan(gltf: &Gltf, rig: &Rig, converter: &mut Converter) -> Option<Vec<PartPlan>> {
    let mut parts: Vec<PartPlan> = vec![];
    for (place, binding) in rig.meshes.iter().enumerate() {
        let Some(handle) = gltf.meshes.get(binding.mesh) else {
            warn!("mesh {} of {} is not in the glTF", binding.mesh, rig.meshes.len());
            continue;
        };
        let mesh = converter.gltf_mesh(handle)?;
        plan_mesh(&mesh, place, rig, converter, &mut parts)?;
    }
    Some(parts)
}

fn plan_mesh(
    mesh: &GltfMesh,
    place: usize,
    rig: &Rig,
    converter: &mut Converter,
    parts: &mut Vec<PartPlan>,
) -> Option<()> {
    let binding = rig.meshes.get(place)?;
    for (index, primitive) in mesh.primitives.iter().enumerate() {
        let influences = binding.influences.get(index);
        let material = converter.material(primitive.material.as_ref())?;
        let skin = binding.skin.and_then(|skin| Some((skin, rig.skins.get(skin)?)));
        let mut bound = match skin {
            None => (ModelPart::Joint(binding.joint), converter.mesh(&primitive.mesh, Binding::Rigid, None)),
            Some((index, skin)) => {
                let slot_count = skin.joints.len();
                let node = skin.joints.iter().position(|joint| *joint == binding.joint);
                let unweighted = node.and_then(|slot| u16::try_from(slot).ok()).unwrap_or(0);
                let how = Binding::Skin { skin: index, slot_count, unweighted };
                (ModelPart::Skin(index), converter.mesh(&primitive.mesh, how, influences))
            }
        };
        if matches!(bound.1, Err(SkinMeshError::Missing(_))) {
            bound = (ModelPart::Joint(binding.joint), converter.mesh(&primitive.mesh, Binding::Rigid, None));
        }
        let (part, converted) = bound;
        let plan = match parts.iter().position(|plan| plan.part == part) {
            Some(at) => &mut parts[at],
            None => {
                parts.push(PartPlan { part, boxes: vec![], meshes: vec![], errors: vec![] });
                parts.last_mut()?
            }
        };
        match converted {
            Err(error) => plan.errors.push((primitive.name.clone(), error)),
            Ok(converted) => {
                let rest = binding.morph_weights.iter().copied().chain(core::iter::repeat(0.0));
                let morphs = converted.morphs.iter().cloned().zip(rest).collect();
                plan.unite(&converted.boxes);
                let (name, mesh) = (primitive.name.clone(), converted.mesh);
                plan.meshes.push(MeshPlan { name, mesh, material, binding: place, morphs });
            }
        }
    }
    Some(())
}

impl PartPlan {
    fn unite(&mut self, boxes: &[SlotBox]) {
        self.boxes.resize(boxes.len().max(self.boxes.len()), SlotBox::EMPTY);
        for (sum, slot_box) in self.boxes.iter_mut().zip(boxes) {
            sum.unite(*slot_box);
        }
    }

    pub(super) fn spawn(self, character: Entity, morphs: &mut Morphs, commands: &mut Commands) {
        if self.meshes.is_empty() {
            return;
        }
        let part = commands
            .spawn((
                self.part,
                PartOf(character),
                ChildOf(character),
                Palette::new(self.boxes.len()),
                PoseBounds::new(self.boxes.into()),
                Transform::default(),
                Visibility::default(),
            ))
            .id();
        for plan in self.meshes {
            let mut mesh = commands.spawn((
                Name::new(plan.name),
                Mesh3d(plan.mesh),
                MeshMaterial3d(plan.material),
                SkinnedBy(part),
                ChildOf(part),
            ));
            if !plan.morphs.is_empty() {
                mesh.insert(morphs.join(plan.binding, plan.morphs));
            }
        }
    }
}
