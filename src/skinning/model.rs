//! A character's visuals: meshes and materials of its glTF, drawn with palettes that follow its pose.
//!
//! Reads [`CharacterPose`] or [`SkinPose`] (model space), writes [`SkinArena`]. Each skin in use, and each joint that carries an unskinned
//! mesh, is a part: a child with a [`Palette`], whose children are the part's meshes. Nobody's transform is a joint's.

use bevy::{gltf::Gltf, prelude::*};

use super::{
    arena::SkinArena,
    assemble::plan,
    convert::{Converted, Converter, follow_sources},
    layout::JointMatrix,
    morphs::{Morphs, apply_morphs, follow_clips},
    palette::Palette,
};
use crate::{
    anim::{pose::Pose, skeleton::JointIndex},
    character::{
        Character,
        animator::CharacterPose,
        crowd::{Crowd, PaletteJob},
        detail::Pacing,
        schedule::PoseSystems,
    },
    rig::{Rig, character::CharacterAsset},
};

/// Draws a character: spawns the meshes of `gltf` as children when both are loaded, again when either changes.
#[derive(Component, Clone, Debug)]
#[require(ModelStatus, Transform, Visibility)]
pub struct SkinnedModel {
    /// Meshes and materials.
    pub gltf: Handle<Gltf>,
    /// Skeleton and skins of the same file.
    pub rig: Handle<Rig>,
}

/// A pose of one's own: what a [`SkinnedModel`] on the same entity is drawn in, in place of its [`CharacterPose`].
/// With neither it is drawn in the rest pose.
#[derive(Component, Clone, Debug, Default)]
pub struct SkinPose(pub Pose);

/// How far a [`SkinnedModel`] is.
#[derive(Component, Clone, Debug, Default)]
pub struct ModelStatus {
    built: Option<(AssetId<Gltf>, AssetId<Rig>)>,
}

impl ModelStatus {
    /// Whether the meshes are there.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.built.is_some()
    }
}

/// Goes on a part: the character that it belongs to.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[relationship(relationship_target = ModelParts)]
pub struct PartOf(pub Entity);

/// The parts of a character's model.
#[derive(Component, Debug, Default)]
#[relationship_target(relationship = PartOf)]
pub struct ModelParts(Vec<Entity>);

/// What moves a part of a model.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelPart {
    /// The skin of this index in [`Rig::skins`].
    Skin(usize),
    /// One joint, rigidly.
    Joint(JointIndex),
}

/// Builds models and writes their palettes.
pub(super) struct SkinnedModelPlugin;

impl Plugin for SkinnedModelPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Converted>()
            .add_systems(
                Update,
                (follow_sources, forget_changed, build)
                    .chain()
                    .run_if(resource_exists::<Assets<Rig>>.and_then(resource_exists::<Assets<Gltf>>)),
            )
            .add_systems(
                PostUpdate,
                (
                    update_palettes.run_if(resource_exists::<Assets<Rig>>),
                    (follow_clips.run_if(resource_exists::<Assets<CharacterAsset>>), apply_morphs).chain(),
                )
                    .in_set(PoseSystems::Palette),
            );
    }
}

/// A model's file was loaded again: it is built again.
fn forget_changed(
    mut gltf_events: MessageReader<AssetEvent<Gltf>>,
    mut rig_events: MessageReader<AssetEvent<Rig>>,
    mut models: Query<&mut ModelStatus>,
) {
    let modified = |event: &AssetEvent<Gltf>| if let AssetEvent::Modified { id } = event { Some(*id) } else { None };
    let gltfs: Vec<_> = gltf_events.read().filter_map(modified).collect();
    let modified = |event: &AssetEvent<Rig>| if let AssetEvent::Modified { id } = event { Some(*id) } else { None };
    let rigs: Vec<_> = rig_events.read().filter_map(modified).collect();
    if gltfs.is_empty() && rigs.is_empty() {
        return;
    }
    for mut status in &mut models {
        if status.built.is_some_and(|(gltf, rig)| gltfs.contains(&gltf) || rigs.contains(&rig)) {
            status.built = None;
        }
    }
}

fn build(
    mut commands: Commands,
    mut models: Query<(Entity, &SkinnedModel, &mut ModelStatus, Option<&ModelParts>)>,
    gltfs: Res<Assets<Gltf>>,
    rigs: Res<Assets<Rig>>,
    server: Res<AssetServer>,
    mut converter: Converter,
) {
    for (character, model, mut status, old_parts) in &mut models {
        let wanted = (model.gltf.id(), model.rig.id());
        if status.built == Some(wanted) {
            continue;
        }
        let (Some(gltf), Some(rig)) = (gltfs.get(&model.gltf), rigs.get(&model.rig)) else { continue };
        let Some(parts) = plan(gltf, rig, &mut converter) else { continue };
        for old in old_parts.into_iter().flat_map(ModelParts::iter) {
            commands.entity(old).despawn();
        }
        let mut morphs = Morphs::default();
        for part in parts {
            for (name, error) in &part.errors {
                let file = server.get_path(model.gltf.id()).map_or_else(String::new, |path| format!("{path}: "));
                error!("{file}mesh `{name}` is not drawn: {error}");
            }
            part.spawn(character, &mut morphs, &mut commands);
        }
        if !morphs.is_empty() {
            morphs.learn(&rig.expressions);
            commands.entity(character).insert(morphs);
        }
        status.built = Some(wanted);
    }
}

/// Characters whose model moves.
type Moving = (
    Entity,
    &'static SkinnedModel,
    Option<Ref<'static, CharacterPose>>,
    Option<Ref<'static, SkinPose>>,
    Ref<'static, ModelParts>,
    (Option<&'static Character>, Option<&'static Pacing>),
);

/// Poses → palettes: of characters whose pose or model changed, and of all whom clips alone pose.
pub(super) fn update_palettes(
    characters: Query<Moving>,
    parts: Query<(Entity, &ModelPart, &Palette)>,
    rigs: Res<Assets<Rig>>,
    crowd: Crowd,
    mut arena: ResMut<SkinArena>,
    mut jobs: Local<Vec<PaletteJob>>,
    mut part_of: Local<Vec<Entity>>,
) {
    jobs.clear();
    part_of.clear();
    for (entity, _, animated, own, model_parts, (character, pacing)) in &characters {
        let kind = character.filter(|_| own.is_none()).and_then(|character| Crowd::kind(character, pacing));
        let changed = animated.is_some_and(|pose| pose.is_changed())
            || own.is_some_and(|pose| pose.is_changed())
            || model_parts.is_changed();
        let shown_anew = kind.is_some() && pacing.is_some_and(|pacing| crowd.is_due(entity, pacing));
        if !changed && !shown_anew {
            continue;
        }
        for (part_entity, part, palette) in parts.iter_many(model_parts.iter()) {
            let range = palette.range();
            let (part, kind) = match (*part, kind) {
                (ModelPart::Skin(skin), Some(kind)) => (skin, Some(kind)),
                _ => (part_of.len(), None),
            };
            if kind.is_none() {
                part_of.push(part_entity);
            }
            arena.note_written(range);
            jobs.push(PaletteJob { first: range.first(), len: range.len(), character: entity, part, kind });
        }
    }
    crowd.write(&mut jobs, arena.bare_matrices_mut(), |job, matrices| {
        let (Ok((_, model, animated, own, ..)), Some((_, part, _))) =
            (characters.get(job.character), part_of.get(job.part).and_then(|part| parts.get(*part).ok()))
        else {
            return;
        };
        let Some(rig) = rigs.get(&model.rig) else { return };
        let joint_count = rig.skeleton.len();
        let rest;
        let pose = match own.as_ref().map(|own| &own.0).or(animated.as_ref().map(|animated| &animated.pose)) {
            Some(pose) if pose.len() == joint_count => pose,
            Some(pose) if !pose.is_empty() => {
                warn_once!("a pose of {} joints cannot move a rig of {joint_count}", pose.len());
                return;
            }
            _ => {
                rest = Pose::rest(&rig.skeleton);
                &rest
            }
        };
        write_palette(*part, rig, pose, matrices);
    });
}

fn write_palette(part: ModelPart, rig: &Rig, pose: &Pose, matrices: &mut [JointMatrix]) {
    match part {
        ModelPart::Skin(skin) => {
            if let Some(skin) = rig.skins.get(skin) {
                skin.write_palette(pose, matrices);
            }
        }
        ModelPart::Joint(joint) => {
            if let Some(matrix) = matrices.first_mut().filter(|_| joint.index() < pose.len()) {
                *matrix = pose.model(joint).into();
            }
        }
    }
}
