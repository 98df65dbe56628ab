//! What clips played in the last two poses: enough to pose them again, or to show what lies between.

use smallvec::SmallVec;

use crate::{anim::block::Play, math::fade::Fade, rig::character::CharacterAsset};

/// Share of a pose below which a clip that goes counts for nothing.
const SILENT: f32 = 1e-3;
/// Share of a looping clip that may pass from one pose to the next; who goes further has jumped there.
const LARGEST_STEP: f32 = 0.25;

/// What was played in the last two poses.
#[derive(Clone, Debug, Default)]
pub(super) struct Past {
    /// Newest first.
    pub(super) plays: [SmallVec<[Play; 3]>; 2],
    /// Seconds between the two.
    pub(super) dt: f32,
    /// What a change of state left behind, where nothing else carries it over, and how much of the pose it still is.
    leaving: Vec<Play>,
    left: Fade,
}

impl Past {
    /// Takes what both poses played, to be put back; `None` before there were two.
    pub(super) fn played(&mut self) -> Option<[SmallVec<[Play; 3]>; 2]> {
        let known = self.plays.iter().all(|plays| !plays.is_empty());
        known.then(|| core::mem::take(&mut self.plays))
    }

    pub(super) fn push(&mut self, plays: &[Play], dt: f32) {
        self.plays.swap(0, 1);
        self.plays[0].clear();
        self.plays[0].extend(plays.iter().copied());
        self.dt = dt;
    }

    /// Fades out what was played until now, for `seconds`.
    pub(super) fn leave(&mut self, seconds: f32) {
        self.leaving.clear();
        self.leaving.extend(self.plays[0].iter().filter(|play| play.weight > SILENT));
        self.left = Fade::at(1.0);
        self.left.send_to(0.0, seconds);
    }

    /// Adds what is left of what was played before to `plays`, `dt` seconds later.
    pub(super) fn fade(&mut self, plays: &mut Vec<Play>, dt: f32) {
        self.left.advance(dt);
        let left = self.left.value();
        if left <= 0.0 {
            return;
        }
        plays.iter_mut().for_each(|play| play.weight *= 1.0 - left);
        plays.extend(self.leaving.iter().map(|play| Play { weight: play.weight * left, ..*play }));
    }

    /// Nothing is left of what was played before.
    pub(super) fn forget(&mut self) {
        self.leaving.clear();
        self.left = Fade::default();
    }

    /// What plays `share` of the way from the older pose to the newer one.
    pub(super) fn between(&self, asset: &CharacterAsset, share: f32, out: &mut Vec<Play>) {
        let [now, before] = &self.plays;
        let same = |plays: &[Play], index: usize, play: &Play| {
            let at_place = plays.get(index).filter(|other| other.clip == play.clip);
            at_place.or_else(|| plays.iter().find(|other| other.clip == play.clip)).copied()
        };
        out.clear();
        out.extend(now.iter().enumerate().map(|(index, play)| match same(before, index, play) {
            Some(was) => Play {
                time: time_between(asset, &was, play, share),
                weight: was.weight + (play.weight - was.weight) * share,
                ..*play
            },
            None => Play { weight: play.weight * share, ..*play },
        }));
        let gone = before.iter().enumerate().filter(|(index, play)| same(now, *index, play).is_none());
        out.extend(gone.map(|(_, play)| Play { weight: play.weight * (1.0 - share), ..*play }));
    }
}

/// Seconds into the clip that both play.
fn time_between(asset: &CharacterAsset, was: &Play, now: &Play, share: f32) -> f32 {
    let Some(clip) = asset.clips().get(now.clip).map(|clip| &clip.clip) else { return now.time };
    let step = now.time - was.time;
    let step = if clip.looping && clip.duration > 0.0 {
        // The shorter way round.
        step - (step / clip.duration).round() * clip.duration
    } else {
        step
    };
    if step.abs() > LARGEST_STEP * clip.duration { now.time } else { was.time + step * share }
}
