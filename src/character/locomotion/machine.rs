//! The state machine: facts about the body in, clip weights and times out. Pure; a system feeds it.

use bevy::math::{Vec2, ops};

use super::{
    compass::Compass,
    facts::{ClipFacts, Facts, Stay, Taken, holds},
    fade::Fades,
};
use crate::{
    math::spring::Spring,
    rig::tuning::locomotion::{Condition, LocomotionConfig, Pace, StateConfig, TransitionBlend},
};

/// Grade from which on steps get no quicker: stairs are about 0.6.
const STEEPEST: f32 = 0.7;

/// Weight below which a state is not seen.
const UNSEEN: f32 = 0.05;

#[derive(Clone, Debug)]
struct State {
    name: String,
    pace: Pace,
    clips: Vec<ClipFacts>,
    compass: Compass,
    /// How much of the state each clip is; they sum to one.
    shares: Vec<Spring<f32>>,
    /// Where the shares are going.
    goals: Vec<f32>,
    /// Seconds into its clip; for turns, at the clip's own rate.
    clock: f32,
}

#[derive(Clone, Debug)]
struct Transition {
    from: Vec<usize>,
    to: usize,
    when: Condition,
    fade: f32,
    blend: TransitionBlend,
}

/// The machine of one character, and where it is.
#[derive(Clone, Debug)]
pub struct Machine {
    states: Vec<State>,
    transitions: Vec<Transition>,
    rate_range: (f32, f32),
    stride_range: (f32, f32),
    climb_cadence: f32,
    blend_half_life: f32,
    current: usize,
    fades: Fades,
    time_in_state: f32,
    phase: f32,
    rate: f32,
    /// Turns on the spot per second, in runs of their clip.
    turn_rate: f32,
    stride_scale: f32,
}

impl Machine {
    /// A machine at its first state. `facts` tells what there is to know of a clip, by its name.
    ///
    /// Transitions that name no existing state are left out; the loader of character files refuses them before.
    #[must_use]
    pub fn new(config: &LocomotionConfig, facts: impl Fn(&str) -> ClipFacts) -> Self {
        let find = |name: &String| config.states().iter().position(|state| &state.name == name);
        let state = |config: &StateConfig| State::new(config, config.clips().map(&facts).collect());
        let states: Vec<State> = config.states().iter().map(state).collect();
        let transitions = config
            .transitions()
            .iter()
            .filter_map(|transition| {
                Some(Transition {
                    from: transition.from.iter().filter_map(find).collect(),
                    to: find(&transition.to)?,
                    when: transition.when.clone(),
                    fade: transition.fade,
                    blend: transition.blend,
                })
            })
            .collect();
        Self {
            fades: Fades::new(states.len(), 0),
            states,
            transitions,
            rate_range: config.rate_range,
            stride_range: config.stride_range,
            climb_cadence: config.climb_cadence,
            blend_half_life: config.blend_half_life,
            current: 0,
            time_in_state: 0.0,
            phase: 0.0,
            rate: 1.0,
            turn_rate: 0.0,
            stride_scale: 1.0,
        }
    }

    /// Goes on where `other` is, if it has a state of that name: for a character whose file has changed.
    pub fn take_over(&mut self, other: &Self) {
        let Some(old) = other.states.get(other.current) else { return };
        let Some(current) = self.states.iter().position(|state| state.name == old.name) else { return };
        self.fades.send_to(current, 0.0);
        self.fades.advance(0.0);
        self.current = current;
        self.states[current].clock = old.clock;
        if self.states[current].shares.len() == old.shares.len() {
            self.states[current].shares.clone_from(&old.shares);
        }
        self.time_in_state = other.time_in_state;
        self.phase = other.phase;
    }

    /// How many states there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.states.len()
    }

    /// Whether there is no state.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.states.is_empty()
    }

    /// Index of the state that the machine is in.
    #[must_use]
    pub fn current(&self) -> usize {
        self.current
    }

    /// Name of a state.
    #[must_use]
    pub fn name(&self, state: usize) -> &str {
        &self.states[state].name
    }

    /// Weight of a state's clip, 0..=1; all sum to one.
    #[must_use]
    pub fn weight(&self, state: usize) -> f32 {
        self.fades.weight(state)
    }

    /// Whether weights are moving.
    #[must_use]
    pub fn is_fading(&self) -> bool {
        self.fades.is_fading()
    }

    /// How much of a state its clip number `clip` is, 0..=1; those of a state sum to one.
    #[must_use]
    pub fn share(&self, state: usize, clip: usize) -> f32 {
        self.states[state].shares[clip].value
    }

    /// Where a state's clips are, in fractions of them: the shared phase for gaits, its own clock otherwise.
    #[must_use]
    pub fn clip_phase(&self, state: usize) -> f32 {
        let State { pace, clips, clock, .. } = &self.states[state];
        let ClipFacts { duration, looping, .. } = clips.first().copied().unwrap_or_default();
        match pace {
            Pace::Gait { .. } => self.phase,
            _ if duration <= 0.0 => 0.0,
            Pace::Clock if !looping => (clock / duration).min(1.0),
            _ => (clock / duration).rem_euclid(1.0),
        }
    }

    /// Whether a state's clip runs by the feet.
    #[must_use]
    pub fn is_gait(&self, state: usize) -> bool {
        matches!(self.states[state].pace, Pace::Gait { .. })
    }

    /// Whether the feet of a state's clips step over the ground: gaits, and turns on the spot.
    #[must_use]
    pub fn steps(&self, state: usize) -> bool {
        !matches!(self.states[state].pace, Pace::Clock)
    }

    /// Cycles per second at which a state that steps runs now.
    #[must_use]
    pub fn cycle_rate(&self, state: usize) -> f32 {
        if self.is_gait(state) { self.rate } else { self.turn_rate }
    }

    /// The gait's phase, 0..1; 0 is left contact.
    #[must_use]
    pub fn phase(&self) -> f32 {
        self.phase
    }

    /// Gait cycles per second at which the phase runs now.
    #[must_use]
    pub fn phase_rate(&self) -> f32 {
        self.rate
    }

    /// Factor on the clips' strides that makes up for what the playback rate can't.
    #[must_use]
    pub fn stride_scale(&self) -> f32 {
        self.stride_scale
    }

    /// One frame: takes a transition if one holds, moves weights, clocks and the phase on.
    pub fn advance(&mut self, facts: &Facts<'_>, dt: f32) -> Option<Taken> {
        if self.states.is_empty() {
            return None;
        }
        let dt = dt.max(0.0);
        self.time_in_state += dt;
        let taken = self.choose(facts);
        if let Some(taken) = taken {
            self.enter(taken, facts);
        }
        self.fades.advance(dt);
        for state in 0..self.len() {
            if self.weight(state) > 0.0 {
                self.states[state].steer(facts.velocity, self.blend_half_life, dt);
            }
        }
        self.run_clocks(facts, dt);
        self.pace(facts, dt);
        taken
    }

    fn choose(&self, facts: &Facts<'_>) -> Option<Taken> {
        let here = &self.states[self.current];
        let stay = Stay { seconds: self.time_in_state, finished: here.is_finished() };
        let open = |t: &&Transition| {
            t.to != self.current && (t.from.is_empty() || t.from.contains(&self.current)) && holds(&t.when, facts, stay)
        };
        self.transitions.iter().find(open).map(|t| Taken { to: t.to, fade: t.fade, blend: t.blend })
    }

    fn enter(&mut self, taken: Taken, facts: &Facts<'_>) {
        let gait_weight: f32 = (0..self.len()).filter(|i| self.is_gait(*i)).map(|i| self.weight(i)).sum();
        if self.weight(taken.to) < UNSEEN {
            self.states[taken.to].clock = 0.0;
            self.states[taken.to].steer(facts.velocity, 0.0, 1.0);
        }
        // A gait that is still to be seen goes on where it is.
        if let Pace::Gait { start_phase } = self.states[taken.to].pace
            && gait_weight < UNSEEN
        {
            // The foot of the side that it goes to steps first.
            let side = if facts.velocity.x < -0.5 * facts.speed { 0.5 } else { 0.0 };
            self.phase = (start_phase + side).rem_euclid(1.0);
        }
        self.current = taken.to;
        self.time_in_state = 0.0;
        self.fades.send_to(taken.to, if taken.blend == TransitionBlend::Inertialize { 0.0 } else { taken.fade });
    }

    fn run_clocks(&mut self, facts: &Facts<'_>, dt: f32) {
        self.turn_rate = 0.0;
        for index in 0..self.len() {
            if self.weight(index) <= 0.0 {
                continue;
            }
            let state = &mut self.states[index];
            match state.pace {
                Pace::Gait { .. } => {}
                Pace::Clock => state.clock += dt,
                Pace::Turn { angle } => {
                    let runs = facts.turned / angle;
                    state.clock += runs * state.duration();
                    self.turn_rate = if dt > 0.0 { runs.abs() / dt } else { 0.0 };
                }
            }
        }
    }

    fn pace(&mut self, facts: &Facts<'_>, dt: f32) {
        let (mut weights, mut duration, mut stride) = (0.0, 0.0, 0.0);
        for index in (0..self.len()).filter(|index| self.is_gait(*index)) {
            let weight = self.weight(index);
            weights += weight;
            duration += weight * self.states[index].duration();
            stride += weight * self.states[index].stride();
        }
        if weights <= 0.0 || duration <= 0.0 || stride <= 0.0 {
            self.stride_scale = 1.0;
            return;
        }
        // The weighted means over the gaits that are heard.
        let natural = stride / duration;
        let speed = facts.speed;
        let cadence = 1.0 + self.climb_cadence * facts.grade.abs().min(STEEPEST);
        let playback = (speed / natural).clamp(self.rate_range.0, self.rate_range.1) * cadence;
        self.rate = playback * weights / duration;
        let scale = (speed / (natural * playback)).clamp(self.stride_range.0, self.stride_range.1);
        // As much of it as there is of gaits: what doesn't step has no stride.
        self.stride_scale = 1.0 + (scale - 1.0) * weights.min(1.0);
        self.phase = (self.phase + self.rate * dt).rem_euclid(1.0);
    }
}

impl State {
    fn new(config: &StateConfig, clips: Vec<ClipFacts>) -> Self {
        let first = |clip| Spring::at(if clip == 0 { 1.0 } else { 0.0 });
        Self {
            name: config.name.clone(),
            pace: config.pace,
            compass: Compass::new(&clips),
            shares: (0..clips.len()).map(first).collect(),
            goals: vec![0.0; clips.len()],
            clips,
            clock: 0.0,
        }
    }

    /// Moves the shares of its clips toward the mixture that goes with `velocity`.
    fn steer(&mut self, velocity: Vec2, half_life: f32, dt: f32) {
        if self.clips.len() < 2 {
            return;
        }
        let Self { compass, shares, goals, .. } = self;
        goals.fill(0.0);
        if !compass.shares(velocity, |clip, share| goals[clip] += share) {
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

    fn duration(&self) -> f32 {
        self.mean(|clip| clip.duration)
    }

    fn mean(&self, of: impl Fn(&ClipFacts) -> f32) -> f32 {
        self.clips.iter().zip(&self.shares).map(|(clip, share)| of(clip) * share.value).sum()
    }

    /// Ground that its feet cover in a cycle, metres: opposite ways cancel out.
    fn stride(&self) -> f32 {
        let along = self.mean(|clip| clip.stride * ops::cos(clip.heading));
        let across = self.mean(|clip| clip.stride * ops::sin(clip.heading));
        Vec2::new(along, across).length()
    }

    fn is_finished(&self) -> bool {
        self.clips.first().is_some_and(|clip| !clip.looping && self.clock >= clip.duration)
    }
}

#[cfg(test)]
mod tests;
