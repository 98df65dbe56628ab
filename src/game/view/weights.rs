//! Shows who moves each vertex: meshes coloured by their joints, as far as each has a hand in them.

use bevy::{mesh::VertexAttributeValues, prelude::*};

use super::subject::Viewed;
use crate::{
    rig::Rig,
    skinning::{
        SkinExtension, SkinnedBy, SkinnedMaterial,
        mesh::{ATTRIBUTE_SKIN_SLOTS, ATTRIBUTE_SKIN_WEIGHTS},
        model::ModelPart,
    },
};

/// Degrees of hue from one joint's colour to the next one's: the golden angle, which keeps neighbours apart.
const HUE_STEP: f32 = 137.508;

/// Whether weights are shown.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::game) struct ShowWeights(pub(in crate::game) bool);

/// Goes on a coloured mesh: what it looked like before.
#[derive(Component)]
struct Plain {
    mesh: Handle<Mesh>,
    material: Handle<SkinnedMaterial>,
}

pub(in crate::game) fn plugin(app: &mut App) {
    app.init_resource::<ShowWeights>().add_systems(Update, (colour, uncolour).chain());
}

fn colour(
    show: Res<ShowWeights>,
    viewed: Res<Viewed>,
    parts: Query<&ModelPart>,
    drawn: Query<(Entity, &SkinnedBy, &Mesh3d, &MeshMaterial3d<SkinnedMaterial>), Without<Plain>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<SkinnedMaterial>>,
    mut commands: Commands,
) {
    if !show.0 {
        return;
    }
    for (entity, owner, mesh, material) in &drawn {
        let (Ok(part), Some(source)) = (parts.get(owner.0), meshes.get(&mesh.0)) else { continue };
        let mut coloured = source.clone();
        coloured.insert_attribute(Mesh::ATTRIBUTE_COLOR, colours(source, *part, &viewed.rig));
        let base = StandardMaterial { perceptual_roughness: 0.9, cull_mode: None, ..default() };
        commands.entity(entity).insert((
            Plain { mesh: mesh.0.clone(), material: material.0.clone() },
            Mesh3d(meshes.add(coloured)),
            MeshMaterial3d(materials.add(SkinnedMaterial { base, extension: SkinExtension })),
        ));
    }
}

fn uncolour(show: Res<ShowWeights>, coloured: Query<(Entity, &Plain)>, mut commands: Commands) {
    if show.0 {
        return;
    }
    for (entity, plain) in &coloured {
        commands
            .entity(entity)
            .insert((Mesh3d(plain.mesh.clone()), MeshMaterial3d(plain.material.clone())))
            .remove::<Plain>();
    }
}

/// A colour a vertex, of its joints' colours by weight.
fn colours(mesh: &Mesh, part: ModelPart, rig: &Rig) -> Vec<[f32; 4]> {
    let joint_of = |slot: u16| match part {
        ModelPart::Joint(joint) => joint.index(),
        ModelPart::Skin(skin) => {
            let skin = rig.skins.get(skin);
            skin.and_then(|skin| skin.joints.get(usize::from(slot))).map_or(0, |joint| joint.index())
        }
    };
    match (mesh.attribute(ATTRIBUTE_SKIN_SLOTS), mesh.attribute(ATTRIBUTE_SKIN_WEIGHTS)) {
        (Some(VertexAttributeValues::Uint16x4(slots)), Some(VertexAttributeValues::Unorm16x4(weights))) => {
            let blend = |(slots, weights): (&[u16; 4], &[u16; 4])| {
                let mut sum = LinearRgba::NONE;
                for (slot, weight) in slots.iter().zip(weights) {
                    sum += colour_of(joint_of(*slot)) * (f32::from(*weight) / f32::from(u16::MAX));
                }
                sum.with_alpha(1.0).to_f32_array()
            };
            slots.iter().zip(weights).map(blend).collect()
        }
        _ => vec![colour_of(joint_of(0)).to_f32_array(); mesh.count_vertices()],
    }
}

fn colour_of(joint: usize) -> LinearRgba {
    Color::hsl((joint as f32 * HUE_STEP) % 360.0, 0.75, 0.55).to_linear()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joints_that_follow_each_other_differ_in_colour() {
        for joint in 0..300 {
            let [a, b] = [joint, joint + 1].map(|joint| Vec3::from_array(colour_of(joint).to_f32_array_no_alpha()));
            assert!(a.distance(b) > 0.2, "joints {joint} and {} look the same: {a} {b}", joint + 1);
        }
    }
}
