//! A palette: the skinning matrices of one entity, and the meshes that it moves.
//!
//! Observers take a piece of the [`SkinArena`] when a [`Palette`] arrives and give it back when it goes.

use bevy::{
    camera::visibility::NoAutoAabb,
    color::LinearRgba,
    ecs::lifecycle::{Discard, Insert},
    mesh::{MeshTag, morph::MeshMorphWeights},
    prelude::*,
};

use super::{
    arena::{SkinArena, SkinRange},
    model::ModelParts,
};

/// Skinning matrices of one entity, in model space. They live in the [`SkinArena`]:
/// `arena.matrices_mut(palette.range())`.
///
/// Replace it as a whole (insert a new one) to change its size; `MeshTag`s follow.
#[derive(Component, Debug)]
#[require(MeshTag)]
pub struct Palette {
    joint_count: u32,
    range: SkinRange,
}

impl Palette {
    /// Room for `joint_count` matrices, all identity at first.
    #[must_use]
    pub fn new(joint_count: usize) -> Self {
        Self { joint_count: u32::try_from(joint_count).unwrap_or(u32::MAX), range: SkinRange::default() }
    }

    /// Where its matrices are. Empty before it is on an entity, and when the arena is full.
    #[must_use]
    pub fn range(&self) -> SkinRange {
        self.range
    }
}

/// Goes on a mesh entity (`Mesh3d` of [`skin_mesh`](super::skin_mesh), a [`SkinnedMaterial`](super::SkinnedMaterial)):
/// draws it with that entity's [`Palette`].
///
/// The mesh is placed by its own transform, so it is usually a child of its owner at the origin.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[relationship(relationship_target = SkinnedMeshes)]
#[require(MeshTag, NoAutoAabb)]
pub struct SkinnedBy(pub Entity);

/// The meshes that this entity's [`Palette`] moves.
#[derive(Component, Debug, Default)]
#[relationship_target(relationship = SkinnedBy)]
pub struct SkinnedMeshes(Vec<Entity>);

/// Colours one character without a material of its own: multiplies the base colour.
///
/// Goes beside a [`Palette`], or on a character with a [`SkinnedModel`](super::SkinnedModel).
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component)]
pub struct Tint(pub LinearRgba);

pub(super) fn observe(app: &mut App) {
    app.add_observer(take).add_observer(give_back).add_observer(tag).add_observer(untag);
}

fn take(
    insert: On<Insert, Palette>,
    mut palettes: Query<(&mut Palette, Option<&SkinnedMeshes>)>,
    mut tags: Query<&mut MeshTag>,
    mut arena: ResMut<SkinArena>,
) {
    let Ok((mut palette, meshes)) = palettes.get_mut(insert.entity) else { return };
    palette.range = arena.allocate(palette.joint_count).unwrap_or_else(|full| {
        error_once!("{full}");
        SkinRange::default()
    });
    set_tags(&mut tags, insert.entity, meshes, palette.range.instance());
}

fn give_back(
    discard: On<Discard, Palette>,
    palettes: Query<(&Palette, Option<&SkinnedMeshes>)>,
    mut tags: Query<&mut MeshTag>,
    mut arena: ResMut<SkinArena>,
) {
    let Ok((palette, meshes)) = palettes.get(discard.entity) else { return };
    arena.free(palette.range);
    set_tags(&mut tags, discard.entity, meshes, 0);
}

fn tag(insert: On<Insert, SkinnedBy>, palettes: Query<&Palette>, mut meshes: Query<(&SkinnedBy, &mut MeshTag)>) {
    let Ok((owner, mut tag)) = meshes.get_mut(insert.entity) else { return };
    tag.set_if_neq(MeshTag(palettes.get(owner.0).map_or(0, |palette| palette.range.instance())));
}

fn untag(discard: On<Discard, SkinnedBy>, mut tags: Query<&mut MeshTag>) {
    set_tags(&mut tags, discard.entity, None, 0);
}

fn set_tags(tags: &mut Query<&mut MeshTag>, owner: Entity, meshes: Option<&SkinnedMeshes>, instance: u32) {
    for entity in meshes.into_iter().flat_map(SkinnedMeshes::iter).chain([owner]) {
        if let Ok(mut tag) = tags.get_mut(entity) {
            tag.set_if_neq(MeshTag(instance));
        }
    }
}

/// Has the engine look at every visible mesh with morph targets again.
///
/// It notes where a mesh's weights are only when the mesh changed, and does not know them in a mesh's first frame: a
/// character that stands still from then on would never blink.
pub(super) fn refresh_morphs(
    mut meshes: Query<(&ViewVisibility, &mut MeshTag), (With<SkinnedBy>, With<MeshMorphWeights>)>,
) {
    for (_, mut tag) in meshes.iter_mut().filter(|(visibility, _)| visibility.get()) {
        tag.set_changed();
    }
}

pub(super) fn apply_tints(
    changed: Query<
        (Option<&Tint>, Option<&Palette>, Option<&ModelParts>),
        Or<(Changed<Tint>, (With<Tint>, Or<(Changed<Palette>, Changed<ModelParts>)>))>,
    >,
    mut removed: RemovedComponents<Tint>,
    owners: Query<(Option<&Tint>, Option<&Palette>, Option<&ModelParts>)>,
    palettes: Query<&Palette>,
    mut arena: ResMut<SkinArena>,
) {
    let bared = removed.read().filter_map(|entity| owners.get(entity).ok());
    for (tint, palette, parts) in changed.iter().chain(bared) {
        let tint = tint.map_or(LinearRgba::WHITE, |tint| tint.0);
        let parts = parts.into_iter().flat_map(ModelParts::iter).filter_map(|part| palettes.get(part).ok());
        for palette in palette.into_iter().chain(parts) {
            arena.set_tint(palette.range, tint);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn app() -> App {
        let mut app = App::new();
        app.insert_resource(SkinArena::with_capacity(64)).add_systems(Update, apply_tints);
        observe(&mut app);
        app
    }

    fn tag_of(app: &App, entity: Entity) -> u32 {
        app.world().get::<MeshTag>(entity).expect("skinned meshes have a tag").0
    }

    #[test]
    fn a_mesh_carries_the_tag_of_its_owner_whichever_came_first() {
        let mut app = app();
        let owner = app.world_mut().spawn_empty().id();
        let early = app.world_mut().spawn(SkinnedBy(owner)).id();
        assert_eq!(tag_of(&app, early), 0, "no palette yet");
        app.world_mut().entity_mut(owner).insert(Palette::new(3));
        let late = app.world_mut().spawn(SkinnedBy(owner)).id();
        assert_eq!((tag_of(&app, early), tag_of(&app, late), tag_of(&app, owner)), (1, 1, 1));
    }

    #[test]
    fn a_despawned_owner_gives_its_range_back_and_frees_its_meshes() {
        let mut app = app();
        let owner = app.world_mut().spawn(Palette::new(3)).id();
        let mesh = app.world_mut().spawn(SkinnedBy(owner)).id();
        let range = app.world().get::<Palette>(owner).expect("just spawned").range();
        app.world_mut().despawn(owner);
        assert_eq!(tag_of(&app, mesh), 0);
        let heir = app.world_mut().spawn(Palette::new(3)).id();
        assert_eq!(app.world().get::<Palette>(heir).expect("just spawned").range(), range);
    }

    #[test]
    fn a_palette_of_another_size_takes_the_place_of_the_first() {
        let mut app = app();
        let owner = app.world_mut().spawn(Palette::new(3)).id();
        let mesh = app.world_mut().spawn(SkinnedBy(owner)).id();
        app.world_mut().entity_mut(owner).insert(Palette::new(20));
        let range = app.world().get::<Palette>(owner).expect("just inserted").range();
        assert_eq!((range.len(), tag_of(&app, mesh)), (20, range.instance()));
        assert_eq!(app.world().resource::<SkinArena>().all_matrices().len(), 21, "three given back, twenty taken");
    }

    #[test]
    fn a_tint_reaches_the_record_and_leaves_it() {
        let mut app = app();
        let owner = app.world_mut().spawn((Palette::new(3), Tint(LinearRgba::RED))).id();
        app.update();
        let tint = |app: &App| LinearRgba::from_f32_array(app.world().resource::<SkinArena>().all_instances()[1].tint);
        assert_eq!(tint(&app), LinearRgba::RED);
        app.world_mut().entity_mut(owner).remove::<Tint>();
        app.update();
        assert_eq!(tint(&app), LinearRgba::WHITE);
    }
}
