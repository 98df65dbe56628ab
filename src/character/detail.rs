//! Level of detail: how often a character is posed, and how thoroughly.
//!
//! Put a [`Detail`] on those that may be seen small or not at all; without one everything is done in every frame. Reads it and
//! what [`Locomotion`] has just done; writes [`Pacing`], which tells the stages after it whether a character is posed in this
//! frame. Controller and locomotion go on in any case, the controller with fewer looks where it is told to, so everyone stays in
//! step. What lies between poses is blended by `ease`.

use avian3d::prelude::RigidBodyDisabled;
use bevy::prelude::*;

use super::{
    Character,
    aim::Aiming,
    animator::Actions,
    bind::CharacterAssets,
    chains::Chains,
    crowd::PoseRead,
    ease::Ease,
    intent::MoveIntent,
    locomotion::Locomotion,
    motion::Glide,
    schedule::{MotionSystems, PoseClock, PoseSystems, stagger},
};
use crate::rig::{character::CharacterAsset, tuning::locomotion::TransitionBlend};

/// How thoroughly a character is posed. May change at any time: the pose goes on without a jump.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component)]
#[require(Pacing, Glide)]
pub struct Detail {
    /// Seconds between two poses, in whole ticks no less than this; what lies between is blended, so it is seen that much later.
    /// 0 poses in every tick. Default 0.
    ///
    /// Large: cheap, and quick motions are cut short. Cheapest are steps of whole ticks, such as 1/32 s, where joints jump by 1.4 times
    /// what they do in their clips; at 1/16 s by 2.3, for who is some pixels tall; posed in every tick by 1.1 (without feet).
    pub step: f32,
    /// Whether feet find the ground. Default true.
    ///
    /// Without, feet fade to where the clip has them: over slopes they float and sink.
    pub feet: bool,
    /// Whether the head turns to where it goes. Default true.
    pub look: bool,
    /// Whether clips alone pose it. Default false.
    ///
    /// True: with all others of its kind, in blocks, straight to skinning matrices, ten times as cheap as by itself. Feet, look
    /// and lean are off whatever the others say, and frames between two `step`s show the last again. [`CharacterPose`] stands
    /// still. Who plays an action, aims, has IK chains or a [`PoseRead`] is posed by itself nevertheless, and so is a model whose
    /// clips keep keys or whose meshes have no skin.
    ///
    /// [`CharacterPose`]: super::animator::CharacterPose
    pub clips_only: bool,
    /// Whether joints below hands, head and toes move while clips alone pose it. Default true.
    ///
    /// False: they are held as in the first clip of the first state, and cost nothing to sample. Change it together with
    /// `clips_only`: by itself the change is not blended.
    pub small_joints: bool,
    /// Whether it is posed at all. Default true.
    ///
    /// False for who isn't seen, its shadow included: its pose stands still, and jumps when it is posed again.
    pub posed: bool,
    /// Whether bodies that the physics engine moves are stopped by it. Default true.
    ///
    /// False: they pass through it, and it costs the engine less. Rays, casts and other characters meet it all the same.
    pub solid: bool,
    /// Seconds for which the controller may go on without looking where it goes (see [`Glide`]), and locomotion without looking
    /// at the controller while it isn't posed, when the root [hops](Glide::hops), too. Default 0.
    pub glide: f32,
}

impl Default for Detail {
    fn default() -> Self {
        Self {
            step: 0.0,
            feet: true,
            look: true,
            clips_only: false,
            small_joints: true,
            posed: true,
            solid: true,
            glide: 0.0,
        }
    }
}

/// When a character is posed; carried from frame to frame.
#[derive(Component, Clone, Debug, Default)]
pub struct Pacing {
    /// How it is posed now.
    pub mode: Mode,
    /// Seconds since the last pose, if it is posed in this frame.
    pub due: Option<f32>,
    /// It wasn't posed for a while: what was carried over from then doesn't hold.
    pub returns: bool,
    /// Clips alone posed it until now: what was carried over from before doesn't hold.
    pub joins: bool,
    /// [`Detail::small_joints`] of now, or of when clips alone posed it last.
    pub small_joints: bool,
    /// [`Detail::step`] of now, while clips alone pose it.
    pub shown_every: f32,
    waited: f32,
}

/// What decides on the next pose beside [`Detail`].
#[derive(Clone, Copy, Debug, Default)]
struct Wish {
    /// Clips alone may pose it, and shall.
    clips_only: bool,
    /// Nothing is left of what they didn't do.
    settled: bool,
    /// Something happened that may not wait.
    at_once: bool,
}

/// How far somebody has come whom clips alone pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClipsOnly {
    /// The last pose with everything; clips take over.
    Leaves,
    /// Clips, and what is left of everything else.
    Settles,
    /// Clips, in frames and in blocks: there is no pose of its own.
    Alone,
}

/// How a character is posed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Mode {
    /// In every frame.
    #[default]
    Every,
    /// In every frame still, until one step's poses are there to blend; for so many seconds already.
    Warming(f32),
    /// Every so many seconds.
    Stepped(f32),
    /// By clips alone.
    ClipsOnly(ClipsOnly),
    /// Never.
    Hidden,
}

/// Frames that come a little early still count as in time, seconds.
const EARLY: f32 = 1e-4;

impl Pacing {
    /// Seconds to pose a character for in this frame; `None` if it isn't posed. Without a `pacing` it is posed in every frame.
    #[must_use]
    pub fn due(pacing: Option<&Self>, dt: f32) -> Option<f32> {
        pacing.map_or(Some(dt), |pacing| pacing.due)
    }

    /// The same for what changes the clips' pose.
    #[must_use]
    pub fn whole(pacing: Option<&Self>, dt: f32) -> Option<f32> {
        Self::due(pacing, dt).filter(|_| pacing.is_none_or(|pacing| pacing.mode != Mode::ClipsOnly(ClipsOnly::Settles)))
    }

    /// Whether what it was before tells nothing of how it is now.
    #[must_use]
    pub fn begins(pacing: Option<&Self>) -> bool {
        pacing.is_some_and(|pacing| pacing.returns || pacing.joins)
    }

    /// One more frame in which nobody sees it.
    fn wait(&mut self, dt: f32) {
        self.waited += dt;
        (self.due, self.returns, self.joins) = (None, false, false);
    }

    /// One frame. Of those that change together each begins its steps
    /// `stagger` of one later, 0..1, so that they aren't posed in the same frame.
    fn advance(&mut self, detail: &Detail, wish: Wish, stagger: f32, dt: f32) {
        let step = if detail.step.is_finite() { detail.step.max(0.0) } else { 0.0 };
        let (hidden, stepped) = (self.mode == Mode::Hidden, matches!(self.mode, Mode::Stepped(_)));
        let by_clips = matches!(self.mode, Mode::ClipsOnly(_));
        self.waited += dt;
        self.mode = match self.mode {
            _ if !detail.posed => Mode::Hidden,
            before if wish.clips_only => Mode::ClipsOnly(match before {
                Mode::Hidden | Mode::ClipsOnly(ClipsOnly::Alone) => ClipsOnly::Alone,
                Mode::ClipsOnly(ClipsOnly::Settles) if wish.settled => ClipsOnly::Alone,
                Mode::ClipsOnly(_) => ClipsOnly::Settles,
                _ => ClipsOnly::Leaves,
            }),
            _ if step <= EARLY => Mode::Every,
            Mode::Warming(since) if since + dt + EARLY >= step => Mode::Stepped(step),
            Mode::Warming(since) => Mode::Warming(since + dt),
            Mode::Stepped(before) if (before - step).abs() <= EARLY => Mode::Stepped(before),
            _ => Mode::Warming(-stagger * step),
        };
        let due = match self.mode {
            Mode::Every | Mode::Warming(_) => true,
            Mode::ClipsOnly(stage) => stage != ClipsOnly::Alone,
            // The first step begins with a pose of its own.
            Mode::Stepped(step) => wish.at_once || !stepped || self.waited + EARLY >= step,
            Mode::Hidden => false,
        };
        self.due = due.then(|| core::mem::take(&mut self.waited));
        if self.mode == Mode::ClipsOnly(ClipsOnly::Alone) {
            self.waited = 0.0;
        }
        if matches!(self.mode, Mode::ClipsOnly(_)) {
            (self.small_joints, self.shown_every) = (detail.small_joints, step);
        }
        self.returns = hidden && self.mode != Mode::Hidden;
        self.joins = by_clips && !matches!(self.mode, Mode::ClipsOnly(_) | Mode::Hidden);
    }
}

/// Decides who is posed.
pub struct DetailPlugin;

impl Plugin for DetailPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Detail>()
            .register_type::<PoseRead>()
            .add_observer(give_everything_back)
            .add_systems(FixedUpdate, tell_bodies.before(MotionSystems::Move))
            .add_systems(FixedPostUpdate, pace.in_set(PoseSystems::Pace));
    }
}

/// Goes with a [`RigidBodyDisabled`] that a [`Detail`] asked for.
#[derive(Component)]
struct NotSolid;

/// Who has a [`Detail`] no more looks in every tick again, and stops what comes.
fn give_everything_back(removed: On<Remove, Detail>, mut commands: Commands, by_detail: Query<(), With<NotSolid>>) {
    let mut character = commands.entity(removed.entity);
    character.try_insert(Glide::default());
    if by_detail.contains(removed.entity) {
        character.try_remove::<(RigidBodyDisabled, NotSolid)>();
    }
}

fn tell_bodies(
    mut commands: Commands,
    mut characters: Query<(Entity, &Detail, &mut Glide, Has<NotSolid>, Has<RigidBodyDisabled>), Changed<Detail>>,
) {
    for (entity, detail, mut glide, by_detail, disabled) in &mut characters {
        glide.set_if_neq(Glide { seconds: detail.glide, hops: !detail.posed });
        if !detail.solid && !disabled {
            commands.entity(entity).insert((RigidBodyDisabled, NotSolid));
        } else if detail.solid && by_detail {
            commands.entity(entity).remove::<(RigidBodyDisabled, NotSolid)>();
        }
    }
}

/// Whose details change their poses, and what may keep clips from posing them alone.
type Paced = (
    Entity,
    &'static Character,
    Option<&'static Detail>,
    &'static mut Pacing,
    &'static Ease,
    Option<&'static Locomotion>,
    (Option<&'static Actions>, Option<&'static Aiming>, &'static MoveIntent, Has<Chains>, Has<PoseRead>),
);

pub(super) fn pace(clock: Res<PoseClock>, assets: CharacterAssets, mut characters: Query<Paced>) {
    characters.par_iter_mut().for_each(|(entity, character, detail, mut pacing, ease, locomotion, also)| {
        // Who has none any more has everything again.
        let detail = &detail.copied().unwrap_or_default();
        if !detail.posed && pacing.mode == Mode::Hidden {
            return pacing.wait(clock.delta_secs());
        }
        // An inertialized change of state begins with the pose that it leaves; others fade by themselves.
        let taken = locomotion.and_then(|locomotion| locomotion.taken);
        let at_once = taken.is_some_and(|taken| taken.blend != TransitionBlend::CrossFade);
        let (actions, aiming, intent, chains, read) = also;
        let acts = actions.is_some_and(|actions| !actions.is_idle());
        let aims = intent.aims().is_some() || aiming.is_some_and(|aiming| aiming.weight() > 0.0);
        let clips_only = detail.clips_only
            && !(acts || aims || chains || read)
            && assets.get(character).is_some_and(CharacterAsset::has_species);
        let stagger = stagger(entity);
        let wish = Wish { clips_only, settled: ease.is_over(), at_once };
        pacing.advance(detail, wish, stagger, clock.delta_secs());
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f32 = 1.0 / 60.0;

    /// Frames of one second in which `detail` has a character posed, once it has settled, and the seconds they are posed for.
    fn posed(detail: &Detail) -> (usize, f32) {
        let mut pacing = Pacing::default();
        let mut dues = (0..120).map(|_| {
            pacing.advance(detail, Wish::default(), 0.0, DT);
            pacing.due
        });
        let dues: Vec<f32> = dues.by_ref().skip(60).flatten().collect();
        (dues.len(), dues.iter().sum())
    }

    #[test]
    fn each_step_has_one_pose_and_no_time_is_lost() {
        for (step, frames) in [(0.0, 60), (1.0 / 30.0, 30), (1.0 / 15.0, 15), (0.1, 10)] {
            let (count, seconds) = posed(&Detail { step, ..Detail::default() });
            assert_eq!(count, frames, "poses in a second at steps of {step} s");
            assert!((seconds - 1.0).abs() < 0.02, "posed for {seconds} s in a second at steps of {step} s");
        }
        assert_eq!(posed(&Detail { posed: false, ..Detail::default() }).0, 0, "nobody sees it");
    }

    #[test]
    fn who_was_hidden_returns_with_all_the_time_that_passed() {
        let mut pacing = Pacing::default();
        let hidden = Detail { posed: false, ..Detail::default() };
        (0..30).for_each(|_| pacing.advance(&hidden, Wish { at_once: true, ..default() }, 0.0, DT));
        pacing.advance(&Detail::default(), Wish::default(), 0.0, DT);
        let due = pacing.due.expect("it is seen again");
        assert!(pacing.returns && (due - 31.0 * DT).abs() < 1e-4, "posed for {due} s");
    }

    #[test]
    fn a_change_of_state_does_not_wait() {
        let mut pacing = Pacing::default();
        let detail = Detail { step: 0.5, ..Detail::default() };
        (0..45).for_each(|_| pacing.advance(&detail, Wish::default(), 0.0, DT));
        assert_eq!(pacing.due, None);
        pacing.advance(&detail, Wish { at_once: true, ..default() }, 0.0, DT);
        assert!(pacing.due.is_some(), "it changed state");
    }

    #[test]
    fn a_crowd_that_changes_together_is_posed_by_turns() {
        let detail = Detail { step: 0.1, ..Detail::default() };
        let mut crowd = vec![Pacing::default(); 60];
        let mut most = 0;
        for frame in 0..120 {
            for (index, pacing) in crowd.iter_mut().enumerate() {
                pacing.advance(&detail, Wish::default(), index as f32 / 60.0, DT);
            }
            if frame > 30 {
                most = most.max(crowd.iter().filter(|pacing| pacing.due.is_some()).count());
            }
        }
        assert!(most <= 12, "{most} of 60 are posed in one frame, 10 would be even");
    }
}
