//! Skins: which joint stands in which palette slot, and the inverse bind matrices.

use bevy::math::{Affine3A, Mat4};
use gltf::json::accessor::Type;

use super::{accessor::Source, error::RigError, nodes::Nodes};
use crate::anim::{matrix::JointMatrix, skin::Skin};

/// The skin's name, or its index where it has none.
pub(super) fn name(source: &Source, skin: usize) -> String {
    let name = source.json.skins.get(skin).and_then(|skin| skin.name.clone());
    name.unwrap_or_else(|| format!("skin{skin}"))
}

/// All skins of the file, by glTF index.
pub(super) fn read(source: &Source, nodes: &Nodes) -> Result<Vec<Skin>, RigError> {
    (0..source.json.skins.len()).map(|skin| read_one(source, nodes, skin)).collect()
}

fn read_one(source: &Source, nodes: &Nodes, index: usize) -> Result<Skin, RigError> {
    let skin = &source.json.skins[index];
    let fail = |problem: String| RigError::Skin { skin: name(source, index), problem };
    if skin.joints.is_empty() {
        return Err(fail("it has no joints".to_owned()));
    }
    let joints: Option<Vec<_>> = skin.joints.iter().map(|joint| nodes.joints.get(joint.value()).copied()?).collect();
    let joints = joints.ok_or_else(|| fail("one of its joints is no node".to_owned()))?;
    let inverse_bind = match skin.inverse_bind_matrices {
        None => vec![JointMatrix::IDENTITY; joints.len()],
        Some(accessor) => {
            let used_by = || format!("inverse bind matrices of skin `{}`", name(source, index));
            let matrices = source.floats::<16>(accessor.value(), Type::Mat4, &used_by)?;
            if matrices.len() < joints.len() {
                return Err(fail(format!("{} inverse bind matrices for {} joints", matrices.len(), joints.len())));
            }
            let matrix = |(slot, matrix): (usize, &[f32; 16])| {
                let matrix = Mat4::from_cols_array(matrix);
                if matrix.is_finite() {
                    Ok(Affine3A::from_mat4(matrix).into())
                } else {
                    let joint = nodes.skeleton.name(joints[slot]);
                    Err(fail(format!("the inverse bind matrix of joint `{joint}` is not finite")))
                }
            };
            matrices.iter().take(joints.len()).enumerate().map(matrix).collect::<Result<_, _>>()?
        }
    };
    Ok(Skin { joints, inverse_bind })
}
