//! Expressions of a face: named sets of morph weights, as VRM models bring them.
//!
//! How they are read: `gltf/expressions.rs`. How they are shown: `Morphs::express` of the skinning layer.

/// A named set of morph weights, `happy` or `blink`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Expression {
    /// Its name. Presets go by their names in VRM 1.0: `happy`, `angry`, `sad`, `relaxed`, `surprised`, `neutral`; mouths `aa`,
    /// `ih`, `ou`, `ee`, `oh`; eyes `blink`, `blinkLeft`, `blinkRight`, `lookUp`, `lookDown`, `lookLeft`, `lookRight`.
    pub name: String,
    /// What it moves.
    pub binds: Vec<ExpressionBind>,
    /// Whether it is shown in full or not at all: from a weight of more than a half on.
    pub binary: bool,
    /// What it does to blinks, so that eyes that laugh already don't shut farther.
    pub blink: Override,
    /// What it does to the mouths `aa`, `ih`, `ou`, `ee` and `oh`.
    pub mouth: Override,
}

/// A morph target, and how far an expression takes it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExpressionBind {
    /// Place of the mesh in [`Rig::meshes`](super::Rig::meshes).
    pub mesh: usize,
    /// Index of the target in the mesh.
    pub target: usize,
    /// Weight of the target when the expression is shown in full, 0..=1.
    pub weight: f32,
}

/// What an expression does to others of a kind while it is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Override {
    /// Nothing.
    #[default]
    None,
    /// They aren't shown at all.
    Block,
    /// They are shown the less the more it is.
    Blend,
}

impl Override {
    /// Share that it takes away from the others when its expression is shown by `strength`.
    #[must_use]
    pub fn taken(self, strength: f32) -> f32 {
        match self {
            Self::Block if strength > 0.0 => 1.0,
            Self::Blend => strength,
            Self::None | Self::Block => 0.0,
        }
    }
}

impl Expression {
    /// How far it is shown at `weight`, 0..=1; a weight that is not finite counts as 0.
    #[must_use]
    pub fn strength(&self, weight: f32) -> f32 {
        match weight.clamp(0.0, 1.0) {
            weight if weight.is_nan() => 0.0,
            weight if self.binary => f32::from(u8::from(weight > 0.5)),
            weight => weight,
        }
    }

    /// Whether it shuts eyes.
    #[must_use]
    pub fn blinks(&self) -> bool {
        ["blink", "blinkLeft", "blinkRight"].contains(&self.name.as_str())
    }

    /// Whether it is a mouth that speaks.
    #[must_use]
    pub fn speaks(&self) -> bool {
        ["aa", "ih", "ou", "ee", "oh"].contains(&self.name.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn percent<const N: usize>(weights: [f32; N]) -> [u32; N] {
        weights.map(|weight| (weight * 100.0).round() as u32)
    }

    #[test]
    fn binary_expressions_are_shown_in_full_or_not_at_all() {
        let binary = Expression { binary: true, ..Expression::default() };
        assert_eq!(percent([0.0, 0.5, 0.51, 7.0].map(|weight| binary.strength(weight))), [0, 0, 100, 100]);
        let plain = Expression::default();
        assert_eq!(percent([-1.0, 0.3, 2.0, f32::NAN].map(|weight| plain.strength(weight))), [0, 30, 100, 0]);
    }

    #[test]
    fn overrides_take_their_share() {
        let taken = |what: Override| percent([0.0, 0.4, 1.0].map(|strength| what.taken(strength)));
        assert_eq!(taken(Override::None), [0; 3]);
        assert_eq!(taken(Override::Block), [0, 100, 100]);
        assert_eq!(taken(Override::Blend), [0, 40, 100]);
    }
}
