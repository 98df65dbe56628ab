//! Legs in the air move hardly faster than the playing clips move them: what is asked of them comes a few frames later.
//!
//! Ground that is seen late, or that lies high or low, asks a foot to be elsewhere within a frame or two. Local rotations,
//! radians.

use bevy::prelude::*;

use crate::{
    anim::{leg::Leg, pose::Pose, skeleton::Skeleton},
    math::rotation::angle_between,
};

/// How much faster than in the clips a leg may move: up to twice looks like the clip.
const LIVELIER: f32 = 1.9;
/// Share of what is asked by which a leg that is late makes more of it in every frame, until it has caught up.
const CATCHES_UP: f32 = 0.25;

/// How a leg's joints were turned in the last frame.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pace {
    last: Option<[Quat; 3]>,
    toes: Option<Quat>,
    /// Whether it is behind what was asked.
    late: bool,
    /// Share of what was asked that it made in the last frame.
    share: Option<[f32; 2]>,
}

impl Pace {
    /// Share of what was asked that the leg made in the last frame, 0..1.
    pub(super) fn share(&self) -> f32 {
        self.shares()[0]
    }

    /// Toes never turn faster than they may.
    fn keep_toes(&mut self, pose: &mut Pose, skeleton: &Skeleton, leg: &Leg, most: f32) {
        let Some(toes) = leg.toes else { return };
        let mut local = pose.local(toes);
        let asked = local.rotation;
        let last = self.toes.unwrap_or(asked);
        let turn = angle_between(last, asked);
        if turn > most {
            local.rotation = last.slerp(asked, most / turn);
            pose.set_local(toes, local);
            pose.update_model_below(skeleton, toes);
        }
        self.toes = Some(local.rotation);
    }

    fn shares(&self) -> [f32; 2] {
        self.share.unwrap_or([1.0; 2])
    }

    /// Whether the leg is behind what was asked.
    pub(super) fn is_late(&self) -> bool {
        self.late
    }

    /// Notes a pose that nobody asked anything of.
    pub(super) fn note(&mut self, pose: &Pose, leg: &Leg) {
        let rotation = |joint| pose.local(joint).rotation;
        *self = Self { last: Some(leg.joints().map(rotation)), toes: leg.toes.map(rotation), ..Self::default() };
    }

    /// Turns the leg no further than it may from where it was: by `most` radians. A leg that stands is where it stands,
    /// once it has arrived.
    pub(super) fn keep(&mut self, pose: &mut Pose, skeleton: &Skeleton, leg: &Leg, flies: bool, most: f32) {
        let most = LIVELIER * most;
        let joints = leg.joints();
        let asked = joints.map(|joint| pose.local(joint).rotation);
        let turns = self.last.map_or([0.0; 3], |last| [0, 1, 2].map(|joint| angle_between(last[joint], asked[joint])));
        // Hip and knee together, so that the foot keeps to its way; the ankle by itself.
        let shares = [turns[0].max(turns[1]), turns[2]].map(|turn| (most / turn.max(1e-6)).min(1.0));
        let shares = [0, 1].map(|part| shares[part].min(self.shares()[part] + CATCHES_UP).min(1.0));
        let late = shares[0].min(shares[1]) < 1.0;
        self.late = (flies || self.late) && late;
        self.share = None;
        if let Some(last) = self.last.filter(|_| self.late) {
            self.share = Some(shares);
            for (index, joint) in joints.into_iter().enumerate() {
                let mut local = pose.local(joint);
                local.rotation = last[index].slerp(asked[index], shares[index / 2]);
                pose.set_local(joint, local);
            }
            pose.update_model_below(skeleton, leg.upper);
        }
        self.keep_toes(pose, skeleton, leg, most);
        self.last = Some(joints.map(|joint| pose.local(joint).rotation));
    }
}
