//! What all machines of one character file share: states, the clips and ways of each, transitions. Never changes.

use bevy::math::Vec2;

use super::{
    compass::Compass,
    facts::{ClipFacts, Facts, Stay, Taken, holds},
};
use crate::{
    math::spring::Spring,
    rig::tuning::locomotion::{Condition, LocomotionConfig, Pace, StateConfig, TransitionBlend},
};

/// States and the ways between them.
#[derive(Debug)]
pub(super) struct Plan {
    pub(super) states: Vec<State>,
    /// By state: the transitions out of it, first the one that is tried first.
    exits: Vec<Vec<Transition>>,
    pub(super) rate_range: (f32, f32),
    pub(super) stride_range: (f32, f32),
    pub(super) climb_cadence: f32,
    pub(super) blend_half_life: f32,
}

#[derive(Debug)]
pub(super) struct State {
    pub(super) name: String,
    pub(super) pace: Pace,
    pub(super) clips: Vec<ClipFacts>,
    /// Way of each clip in a cycle, ahead and to the left, metres.
    strides: Vec<Vec2>,
    compass: Compass,
    /// Place of its first clip among those of all states.
    first: usize,
}

#[derive(Clone, Debug)]
struct Transition {
    to: usize,
    when: Condition,
    fade: f32,
    blend: TransitionBlend,
}

impl Plan {
    /// `facts` tells what there is to know of a clip, by its name. Transitions that name no existing state are left out.
    pub(super) fn new(config: &LocomotionConfig, facts: impl Fn(&str) -> ClipFacts) -> Self {
        let mut first = 0;
        let state = |config: &StateConfig| {
            let clips: Vec<ClipFacts> = config.clips().map(&facts).collect();
            first += clips.len();
            State {
                name: config.name.clone(),
                pace: config.pace,
                compass: Compass::new(&clips),
                strides: clips.iter().map(|clip| Vec2::from_angle(clip.heading) * clip.stride).collect(),
                first: first - clips.len(),
                clips,
            }
        };
        let states: Vec<State> = config.states().iter().map(state).collect();
        let find = |name: &String| states.iter().position(|state| &state.name == name);
        let mut exits = vec![Vec::new(); states.len()];
        for transition in config.transitions() {
            let Some(to) = find(&transition.to) else { continue };
            let from: Vec<usize> = transition.from.iter().filter_map(find).collect();
            let leaves = |state: usize| state != to && (transition.from.is_empty() || from.contains(&state));
            for (_, exits) in exits.iter_mut().enumerate().filter(|(state, _)| leaves(*state)) {
                let (fade, blend) = (transition.fade, transition.blend);
                exits.push(Transition { to, when: transition.when.clone(), fade, blend });
            }
        }
        Self {
            states,
            exits,
            rate_range: config.rate_range,
            stride_range: config.stride_range,
            climb_cadence: config.climb_cadence,
            blend_half_life: config.blend_half_life,
        }
    }

    /// How many clips all states have together.
    pub(super) fn clip_count(&self) -> usize {
        self.states.iter().map(|state| state.clips.len()).sum()
    }

    /// The first transition out of `state` whose condition holds.
    pub(super) fn exit(&self, state: usize, facts: &Facts<'_>, stay: Stay) -> Option<Taken> {
        let open = self.exits[state].iter().find(|transition| holds(&transition.when, facts, stay))?;
        Some(Taken { to: open.to, fade: open.fade, blend: open.blend })
    }
}

impl State {
    /// What is its own of a list of all states' clips.
    pub(super) fn own<'a, T>(&self, of_all: &'a [T]) -> &'a [T] {
        &of_all[self.first..self.first + self.clips.len()]
    }

    pub(super) fn own_mut<'a, T>(&self, of_all: &'a mut [T]) -> &'a mut [T] {
        &mut of_all[self.first..self.first + self.clips.len()]
    }

    /// Moves the shares of its clips toward the mixture that goes with `velocity`; shares and goals are those of all states.
    pub(super) fn steer(&self, shares: &mut [Spring<f32>], goals: &mut [f32], velocity: Vec2, half_life: f32, dt: f32) {
        if self.clips.len() < 2 {
            return;
        }
        let (shares, goals) = (self.own_mut(shares), self.own_mut(goals));
        goals.fill(0.0);
        if !self.compass.shares(velocity, |clip, share| goals[clip] += share) {
            return;
        }
        for (share, goal) in shares.iter_mut().zip(goals) {
            share.step(*goal, half_life, dt);
            share.value = share.value.max(0.0);
        }
        let sum: f32 = shares.iter().map(|share| share.value).sum();
        if sum > 0.0 {
            shares.iter_mut().for_each(|share| share.value /= sum);
        }
    }

    /// Seconds of its clips' mixture; `shares` are those of all states.
    pub(super) fn duration(&self, shares: &[Spring<f32>]) -> f32 {
        if let [only] = &self.clips[..] {
            return only.duration;
        }
        let shares = self.own(shares);
        self.clips.iter().zip(shares).map(|(clip, share)| clip.duration * share.value).sum()
    }

    /// Ground that its feet cover in a cycle, metres: opposite ways cancel out.
    pub(super) fn stride(&self, shares: &[Spring<f32>]) -> f32 {
        if let [only] = &self.clips[..] {
            return only.stride;
        }
        let shares = self.own(shares);
        self.strides.iter().zip(shares).map(|(stride, share)| *stride * share.value).sum::<Vec2>().length()
    }

    /// Whether its clip has played to its end at `clock` seconds.
    pub(super) fn is_finished(&self, clock: f32) -> bool {
        self.clips.first().is_some_and(|clip| !clip.looping && clock >= clip.duration)
    }
}
