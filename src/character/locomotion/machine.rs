//! The state machine: facts about the body in, clip weights and times out. Pure; a system feeds it.

use std::sync::Arc;

use super::{
    facts::{ClipFacts, Facts, Stay, Taken},
    fade::Fades,
    plan::{Plan, State},
};
use crate::{
    math::spring::Spring,
    rig::tuning::locomotion::{LocomotionConfig, Pace, TransitionBlend},
};

/// Grade from which on steps get no quicker: stairs are about 0.6.
const STEEPEST: f32 = 0.7;

/// Weight below which a state is not seen.
const UNSEEN: f32 = 0.05;

/// The machine of one character, and where it is.
#[derive(Clone, Debug)]
pub struct Machine {
    plan: Arc<Plan>,
    /// By state and clip: how much of the state each clip is, those of a state sum to one; and where that is going.
    shares: Vec<Spring<f32>>,
    goals: Vec<f32>,
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
        let plan = Plan::new(config, facts);
        let mut shares = vec![Spring::at(0.0); plan.clip_count()];
        for state in &plan.states {
            if let Some(first) = state.own_mut(&mut shares).first_mut() {
                first.value = 1.0;
            }
        }
        Self {
            fades: Fades::new(plan.states.len(), 0),
            goals: vec![0.0; shares.len()],
            shares,
            plan: Arc::new(plan),
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
        let Some(old) = other.plan.states.get(other.current) else { return };
        let Some(current) = self.plan.states.iter().position(|state| state.name == old.name) else { return };
        self.fades.send_to(current, 0.0);
        self.fades.advance(0.0);
        self.current = current;
        self.fades.set_clock(current, other.fades.clock(other.current));
        let (shares, old) = (self.plan.states[current].own_mut(&mut self.shares), old.own(&other.shares));
        if shares.len() == old.len() {
            shares.copy_from_slice(old);
        }
        self.time_in_state = other.time_in_state;
        self.phase = other.phase;
    }

    /// How many states there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.plan.states.len()
    }

    /// Whether there is no state.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.plan.states.is_empty()
    }

    /// Index of the state that the machine is in.
    #[must_use]
    pub fn current(&self) -> usize {
        self.current
    }

    /// Name of a state.
    #[must_use]
    pub fn name(&self, state: usize) -> &str {
        &self.plan.states[state].name
    }

    /// Weight of a state's clip, 0..=1; all sum to one.
    #[must_use]
    pub fn weight(&self, state: usize) -> f32 {
        self.fades.weight(state)
    }

    /// States that weigh something, in ascending order, and how much.
    pub fn heard(&self) -> impl Iterator<Item = (usize, f32)> {
        self.fades.heard()
    }

    /// How much of a state its clip number `clip` is, 0..=1; those of a state sum to one.
    #[must_use]
    pub fn share(&self, state: usize, clip: usize) -> f32 {
        let state = &self.plan.states[state];
        if state.clips.len() < 2 { 1.0 } else { state.own(&self.shares)[clip].value }
    }

    /// Where a state's clips are, in fractions of them: the shared phase for gaits, its own clock otherwise.
    #[must_use]
    pub fn clip_phase(&self, state: usize) -> f32 {
        let State { pace, clips, .. } = &self.plan.states[state];
        let clock = self.fades.clock(state);
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
        matches!(self.plan.states[state].pace, Pace::Gait { .. })
    }

    /// Whether the feet of a state's clips step over the ground: gaits, and turns on the spot.
    #[must_use]
    pub fn steps(&self, state: usize) -> bool {
        !matches!(self.plan.states[state].pace, Pace::Clock)
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
        if self.is_empty() {
            return None;
        }
        let dt = dt.max(0.0);
        self.time_in_state += dt;
        let finished = self.plan.states[self.current].is_finished(self.fades.clock(self.current));
        let taken = self.plan.exit(self.current, facts, Stay { seconds: self.time_in_state, finished });
        if let Some(taken) = taken {
            self.enter(taken, facts);
        }
        self.fades.advance(dt);
        let Self { plan, shares, goals, fades, .. } = self;
        for (state, _) in fades.heard() {
            plan.states[state].steer(shares, goals, facts.velocity, plan.blend_half_life, dt);
        }
        self.run_clocks(facts, dt);
        self.pace(facts, dt);
        taken
    }

    fn enter(&mut self, taken: Taken, facts: &Facts<'_>) {
        let gait_weight: f32 = self.heard().filter(|(state, _)| self.is_gait(*state)).map(|(_, weight)| weight).sum();
        if self.weight(taken.to) < UNSEEN {
            self.fades.set_clock(taken.to, 0.0);
            self.plan.states[taken.to].steer(&mut self.shares, &mut self.goals, facts.velocity, 0.0, 1.0);
        }
        // A gait that is still to be seen goes on where it is.
        if let Pace::Gait { start_phase } = self.plan.states[taken.to].pace
            && gait_weight < UNSEEN
        {
            // The foot of the side that it goes to steps first.
            let side = if facts.velocity.x < -0.5 * facts.speed { 0.5 } else { 0.0 };
            self.phase = (start_phase + side).rem_euclid(1.0);
        }
        self.current = taken.to;
        self.time_in_state = 0.0;
        self.fades.send_to(taken.to, if taken.blend == TransitionBlend::CrossFade { taken.fade } else { 0.0 });
    }

    fn run_clocks(&mut self, facts: &Facts<'_>, dt: f32) {
        let Self { plan, shares, fades, turn_rate, .. } = self;
        *turn_rate = 0.0;
        fades.run_clocks(|index| {
            let state = &plan.states[index];
            match state.pace {
                Pace::Gait { .. } => 0.0,
                Pace::Clock => dt,
                Pace::Turn { angle } => {
                    let runs = facts.turned / angle;
                    *turn_rate = if dt > 0.0 { runs.abs() / dt } else { 0.0 };
                    runs * state.duration(shares)
                }
            }
        });
    }

    fn pace(&mut self, facts: &Facts<'_>, dt: f32) {
        let (mut weights, mut duration, mut stride) = (0.0, 0.0, 0.0);
        for (index, weight) in self.heard().filter(|(index, _)| self.is_gait(*index)) {
            let state = &self.plan.states[index];
            weights += weight;
            duration += weight * state.duration(&self.shares);
            stride += weight * state.stride(&self.shares);
        }
        if weights <= 0.0 || duration <= 0.0 || stride <= 0.0 {
            self.stride_scale = 1.0;
            return;
        }
        // The weighted means over the gaits that are heard.
        let natural = stride / duration;
        let speed = facts.speed;
        let cadence = 1.0 + self.plan.climb_cadence * facts.grade.abs().min(STEEPEST);
        let playback = (speed / natural).clamp(self.plan.rate_range.0, self.plan.rate_range.1) * cadence;
        self.rate = playback * weights / duration;
        let scale = (speed / (natural * playback)).clamp(self.plan.stride_range.0, self.plan.stride_range.1);
        // As much of it as there is of gaits: what doesn't step has no stride.
        self.stride_scale = 1.0 + (scale - 1.0) * weights.min(1.0);
        self.phase = (self.phase + self.rate * dt).rem_euclid(1.0);
    }
}

#[cfg(test)]
mod tests;
