//! Places joints in model space, parents first: lanes = characters.
//!
//! Reads the transposed rows, writes matrices between frames and positions (model space, metres).

use fearless_simd::Simd;

use super::{
    Actor,
    lanes::{Floats, LANES, Mat3s, Quats, Row, Vec3s, load, store},
    limb,
    sample::transpose_turns,
    species::{Joint, Species, Track},
};

/// A joint of eight characters: three rows of its matrix, then its position.
pub(super) type JointRows = [[Row; 3]; 4];

/// What joints do.
#[derive(Clone, Copy)]
pub(super) struct Lanes<'a> {
    /// Rows of eight characters.
    pub(super) poses: &'a [Row],
    /// Translations and scales, one number after the other, in all lanes.
    pub(super) numbers: &'a [Row],
}

/// Rotations of eight joints, in all lanes.
#[derive(Default)]
#[repr(C, align(32))]
struct Turns {
    rotations: [[Row; 4]; LANES],
    tile: Option<usize>,
}

impl Turns {
    /// The rotation at this place among those that move. Joints ask for them in order.
    #[inline(always)]
    fn at<S: Simd>(&mut self, simd: S, species: &Species, lanes: &Lanes, place: usize) -> Mat3s<S> {
        let tile = place / LANES;
        if self.tile != Some(tile) {
            transpose_turns(simd, lanes.poses, species.tracks.channels.width(), tile, &mut self.rotations);
            self.tile = Some(tile);
        }
        Mat3s::from_any_quats(simd, Quats::load(simd, &self.rotations[place % LANES]))
    }
}

/// Where a joint is, in all lanes.
#[derive(Clone, Copy)]
pub(super) struct Placed<S: Simd> {
    /// `model_from_joint`, without its frame's turn and scale.
    pub(super) matrix: Mat3s<S>,
    pub(super) position: Vec3s<S>,
}

impl<S: Simd> Placed<S> {
    #[inline(always)]
    pub(super) fn load(simd: S, [a, b, c, position]: &JointRows) -> Self {
        let matrix = Mat3s([Vec3s::load(simd, a), Vec3s::load(simd, b), Vec3s::load(simd, c)]);
        Self { matrix, position: Vec3s::load(simd, position) }
    }

    #[inline(always)]
    pub(super) fn store(self, [a, b, c, position]: &mut JointRows) {
        self.matrix.0[0].store(a);
        self.matrix.0[1].store(b);
        self.matrix.0[2].store(c);
        self.position.store(position);
    }
}

/// Writes what stands above the roots, the same for everyone.
#[inline(always)]
pub(super) fn place_roots<S: Simd>(simd: S, species: &Species, joints: &mut [JointRows]) {
    let [x, y, z] = species.above_roots;
    let matrix = Mat3s::splat(simd, [[x[0], x[1], x[2]], [y[0], y[1], y[2]], [z[0], z[1], z[2]]]);
    Placed { matrix, position: Vec3s::splat(simd, [x[3], y[3], z[3]]) }.store(&mut joints[0]);
}

/// Places every joint, and turns limbs onto the goals of `actors`.
#[inline(always)]
pub(super) fn place_joints<S: Simd>(
    simd: S,
    species: &Species,
    lanes: &Lanes,
    joints: &mut [JointRows],
    actors: &[Actor],
) {
    let mut turns = Turns::default();
    for (index, joint) in species.joints.iter().enumerate() {
        let (above, own) = joints.split_at_mut(index + 1);
        let (parent, own) = (&above[joint.parent], &mut own[0]);
        let translation = translation(simd, species, lanes, joint);
        match (&joint.rotation, &joint.scale) {
            (Track::Moving(place), Track::Identity) => {
                let turn = turns.at(simd, species, lanes, *place);
                place_joint(simd, parent, Some(&turn), translation, own);
            }
            (Track::Identity, Track::Identity) => place_joint(simd, parent, None, translation, own),
            _ => {
                let local = local(simd, species, lanes, joint, &mut turns);
                place_joint(simd, parent, Some(&local), translation, own);
            }
        }
        if let Some(limb) = joint.ends
            && !actors.is_empty()
        {
            limb::reach(simd, &species.limbs[limb], limb, actors, joints);
        }
    }
}

/// Places one joint: `local` is its rotation and scale between frames.
#[inline(always)]
fn place_joint<S: Simd>(
    simd: S,
    parent: &JointRows,
    local: Option<&Mat3s<S>>,
    translation: Vec3s<S>,
    own: &mut JointRows,
) {
    // Row by row, so that a parent's numbers need no registers before their turn.
    for row in 0..3 {
        let above = Vec3s::load(simd, &parent[row]);
        let turned = match local {
            Some(local) => local.row_times(above),
            None => above,
        };
        turned.store(&mut own[row]);
        store(above.dot_plus(translation, load(simd, &parent[3][row])), &mut own[3][row]);
    }
}

/// Rotation and scale of a joint as a matrix between frames.
#[inline(always)]
fn local<S: Simd>(simd: S, species: &Species, lanes: &Lanes, joint: &Joint, turns: &mut Turns) -> Mat3s<S> {
    let turn = match &joint.rotation {
        Track::Identity => Mat3s::from_quats(simd, Quats::identity(simd)),
        Track::Still(matrix) => Mat3s::splat(simd, **matrix),
        Track::Moving(place) => turns.at(simd, species, lanes, *place),
    };
    match &joint.scale {
        Track::Identity => turn,
        Track::Still(matrix) => turn.times(&Mat3s::splat(simd, **matrix)),
        Track::Moving(place) => turn.times(&scale(simd, species, lanes, joint, *place)),
    }
}

#[inline(always)]
fn translation<S: Simd>(simd: S, species: &Species, lanes: &Lanes, joint: &Joint) -> Vec3s<S> {
    match joint.translation {
        Track::Moving(place) => vector(simd, lanes, place, species.tracks.channels.translations.len()),
        Track::Still(translation) => Vec3s::splat(simd, translation),
        Track::Identity => Vec3s::splat(simd, [0.0; 3]),
    }
}

/// Scale along a joint's own axes, as a matrix between frames.
#[inline(always)]
fn scale<S: Simd>(simd: S, species: &Species, lanes: &Lanes, joint: &Joint, place: usize) -> Mat3s<S> {
    let scale = vector(simd, lanes, place, species.tracks.channels.scales.len());
    let [xx, yy, zz, xy, xz, yz] = *joint.scale_parts;
    let (xy, xz, yz) = (part(simd, scale, xy), part(simd, scale, xz), part(simd, scale, yz));
    Mat3s([
        Vec3s::new(part(simd, scale, xx), xy, xz),
        Vec3s::new(xy, part(simd, scale, yy), yz),
        Vec3s::new(xz, yz, part(simd, scale, zz)),
    ])
}

#[inline(always)]
fn vector<S: Simd>(simd: S, lanes: &Lanes, place: usize, step: usize) -> Vec3s<S> {
    let number = |part: usize| &lanes.numbers[place + part * step];
    Vec3s::new(load(simd, number(0)), load(simd, number(1)), load(simd, number(2)))
}

#[inline(always)]
fn part<S: Simd>(simd: S, scale: Vec3s<S>, axes: [f32; 3]) -> Floats<S> {
    scale.dot(Vec3s::splat(simd, axes))
}
