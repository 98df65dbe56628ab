//! The state machine: facts about the body in, clip weights and times out. Pure; a system feeds it.

use super::fade::Fades;
use crate::rig::tuning::locomotion::{Condition, LocomotionConfig, Pace, TransitionBlend};

/// What the machine must know of a state's clip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipFacts {
    /// Seconds.
    pub duration: f32,
    /// Whether it starts over at its end.
    pub looping: bool,
    /// Ground that one cycle covers, metres; 0 for a clip that stays in place.
    pub stride: f32,
}

/// The body, as motion has it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Facts<'a> {
    /// Horizontal speed over the ground, m/s.
    pub speed: f32,
    /// Rise over run of the way it goes.
    pub grade: f32,
    /// Whether it stands on ground.
    pub grounded: bool,
    /// Seconds in the air.
    pub air_time: f32,
    /// Downward speed, m/s.
    pub fall_speed: f32,
    /// Whether it crouches.
    pub crouched: bool,
    /// Trigger names pulled since the last frame.
    pub triggers: &'a [String],
}

/// A transition taken in this frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taken {
    /// The state entered.
    pub to: usize,
    /// Seconds that it takes.
    pub fade: f32,
    /// How it looks.
    pub blend: TransitionBlend,
}

/// Grade from which on steps get no quicker: stairs are about 0.6.
const STEEPEST: f32 = 0.7;

#[derive(Clone, Debug)]
struct State {
    name: String,
    pace: Pace,
    clip: ClipFacts,
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
    current: usize,
    fades: Fades,
    time_in_state: f32,
    /// Clock of every state, seconds.
    clocks: Vec<f32>,
    phase: f32,
    rate: f32,
    stride_scale: f32,
}

impl Machine {
    /// A machine at its first state. `clips` gives the facts of each state's clip, in the order of `config.states`.
    ///
    /// Transitions that name no existing state are left out; the loader of character files refuses them before.
    #[must_use]
    pub fn new(config: &LocomotionConfig, clips: &[ClipFacts]) -> Self {
        let find = |name: &String| config.states.iter().position(|state| &state.name == name);
        let states: Vec<State> = config
            .states
            .iter()
            .zip(clips)
            .map(|(state, clip)| State { name: state.name.clone(), pace: state.pace, clip: *clip })
            .collect();
        let transitions = config
            .transitions
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
            clocks: vec![0.0; states.len()],
            states,
            transitions,
            rate_range: config.rate_range,
            stride_range: config.stride_range,
            climb_cadence: config.climb_cadence,
            current: 0,
            time_in_state: 0.0,
            phase: 0.0,
            rate: 1.0,
            stride_scale: 1.0,
        }
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

    /// Where a state's clip is, in fractions of it: the shared phase for gaits, its own clock otherwise.
    #[must_use]
    pub fn clip_phase(&self, state: usize) -> f32 {
        let State { pace, clip, .. } = &self.states[state];
        match pace {
            Pace::Gait { .. } => self.phase,
            Pace::Clock if clip.duration <= 0.0 => 0.0,
            Pace::Clock if clip.looping => (self.clocks[state] / clip.duration).fract(),
            Pace::Clock => (self.clocks[state] / clip.duration).min(1.0),
        }
    }

    /// Whether a state's clip runs by the feet.
    #[must_use]
    pub fn is_gait(&self, state: usize) -> bool {
        matches!(self.states[state].pace, Pace::Gait { .. })
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
            self.enter(taken);
        }
        self.fades.advance(dt);
        self.pace(facts, dt);
        taken
    }

    fn choose(&self, facts: &Facts<'_>) -> Option<Taken> {
        let open = |t: &&Transition| {
            t.to != self.current && (t.from.is_empty() || t.from.contains(&self.current)) && self.holds(&t.when, facts)
        };
        self.transitions.iter().find(open).map(|t| Taken { to: t.to, fade: t.fade, blend: t.blend })
    }

    fn holds(&self, condition: &Condition, facts: &Facts<'_>) -> bool {
        match condition {
            Condition::SpeedAbove(speed) => facts.speed > *speed,
            Condition::SpeedBelow(speed) => facts.speed < *speed,
            Condition::Grounded => facts.grounded,
            Condition::AirborneFor(seconds) => !facts.grounded && facts.air_time > *seconds,
            Condition::FallingFaster(speed) => facts.fall_speed > *speed,
            Condition::InStateFor(seconds) => self.time_in_state > *seconds,
            Condition::Finished => {
                let clip = self.states[self.current].clip;
                !clip.looping && self.clocks[self.current] >= clip.duration
            }
            Condition::Crouched => facts.crouched,
            Condition::Upright => !facts.crouched,
            Condition::Trigger(name) => facts.triggers.contains(name),
            Condition::All(all) => all.iter().all(|condition| self.holds(condition, facts)),
        }
    }

    fn enter(&mut self, taken: Taken) {
        let gait_weight: f32 = (0..self.len()).filter(|i| self.is_gait(*i)).map(|i| self.weight(i)).sum();
        match self.states[taken.to].pace {
            // A gait that is still to be seen goes on where it is.
            Pace::Gait { start_phase } if gait_weight < 0.05 => self.phase = start_phase.rem_euclid(1.0),
            Pace::Clock if self.weight(taken.to) < 0.05 => self.clocks[taken.to] = 0.0,
            _ => {}
        }
        self.current = taken.to;
        self.time_in_state = 0.0;
        self.fades.send_to(taken.to, if taken.blend == TransitionBlend::Inertialize { 0.0 } else { taken.fade });
    }

    fn pace(&mut self, facts: &Facts<'_>, dt: f32) {
        let (mut weights, mut duration, mut stride) = (0.0, 0.0, 0.0);
        for index in 0..self.len() {
            let weight = self.weight(index);
            if self.is_gait(index) {
                weights += weight;
                duration += weight * self.states[index].clip.duration;
                stride += weight * self.states[index].clip.stride;
            } else if weight > 0.0 {
                self.clocks[index] += dt;
            }
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
        self.stride_scale = (speed / (natural * playback)).clamp(self.stride_range.0, self.stride_range.1);
        self.phase = (self.phase + self.rate * dt).rem_euclid(1.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const IDLE: ClipFacts = ClipFacts { duration: 6.0, looping: true, stride: 0.0 };
    const WALK: ClipFacts = ClipFacts { duration: 1.08, looping: true, stride: 1.512 };
    const RUN: ClipFacts = ClipFacts { duration: 0.72, looping: true, stride: 2.52 };

    fn machine() -> Machine {
        Machine::new(&LocomotionConfig::default(), &[IDLE, WALK, RUN])
    }

    fn run_for(machine: &mut Machine, speed: f32, seconds: f32) {
        let facts = Facts { speed, grounded: true, ..Facts::default() };
        for _ in 0..(seconds * 60.0) as usize {
            machine.advance(&facts, 1.0 / 60.0);
        }
    }

    #[test]
    fn speed_leads_from_idle_over_walk_to_run_and_back() {
        let mut machine = machine();
        for (speed, name) in [(0.0, "idle"), (1.4, "walk"), (3.5, "run"), (1.4, "walk"), (0.0, "idle")] {
            run_for(&mut machine, speed, 0.5);
            assert_eq!(machine.name(machine.current()), name, "at {speed} m/s");
            assert!(machine.weight(machine.current()) > 0.999, "{name} weighs {}", machine.weight(machine.current()));
        }
    }

    #[test]
    fn a_speed_between_the_bounds_keeps_the_gait() {
        let mut machine = machine();
        run_for(&mut machine, 1.4, 0.5);
        run_for(&mut machine, 2.2, 1.0);
        assert_eq!(machine.name(machine.current()), "walk");
        run_for(&mut machine, 3.0, 0.5);
        run_for(&mut machine, 2.2, 1.0);
        assert_eq!(machine.name(machine.current()), "run");
    }

    #[test]
    fn a_change_of_gait_keeps_the_phase() {
        let mut machine = machine();
        run_for(&mut machine, 1.4, 1.0);
        let before = machine.phase();
        machine.advance(&Facts { speed: 3.5, grounded: true, ..Facts::default() }, 1.0 / 60.0);
        let moved = (machine.phase() - before).rem_euclid(1.0);
        assert!(moved < 0.04, "the phase jumped by {moved}");
        assert_eq!(machine.name(machine.current()), "run");
    }

    #[test]
    fn one_stride_of_ground_is_one_cycle() {
        let mut machine = machine();
        run_for(&mut machine, 1.4, 1.0);
        assert!((machine.phase_rate() * 1.512 * machine.stride_scale() - 1.4).abs() < 1e-3, "feet skate");
        run_for(&mut machine, 0.5, 1.0);
        let covered = machine.phase_rate() * 1.512 * machine.stride_scale();
        assert!((covered - 0.5).abs() < 1e-3, "feet cover {covered} m/s at 0.5 m/s");
    }

    #[test]
    fn two_half_frames_are_one_whole() {
        let (mut once, mut twice) = (machine(), machine());
        let facts = Facts { speed: 1.4, grounded: true, ..Facts::default() };
        for _ in 0..30 {
            once.advance(&facts, 1.0 / 30.0);
            twice.advance(&facts, 1.0 / 60.0);
            twice.advance(&facts, 1.0 / 60.0);
        }
        let off = (once.phase() - twice.phase()).abs();
        assert!(off < 0.02, "phases {off} apart after a second at 30 and 60 Hz");
    }

    #[test]
    fn a_clip_without_length_is_no_danger() {
        let still = ClipFacts { duration: 0.0, looping: true, stride: 0.0 };
        let mut machine = Machine::new(&LocomotionConfig::default(), &[still, still, still]);
        run_for(&mut machine, 1.4, 0.5);
        assert!(machine.clip_phase(0).is_finite() && machine.phase().is_finite());
    }

    #[test]
    fn triggers_and_finished_clips_lead_on() {
        use crate::rig::tuning::locomotion::{StateConfig, TransitionConfig};
        let mut config = LocomotionConfig::default();
        config.states.push(StateConfig { name: "wave".into(), clip: "wave".into(), pace: Pace::Clock });
        let to = |from: &str, to: &str, when| TransitionConfig {
            from: vec![from.into()],
            to: to.into(),
            when,
            fade: 0.1,
            blend: TransitionBlend::CrossFade,
        };
        config.transitions.push(to("idle", "wave", Condition::Trigger("wave".into())));
        config.transitions.push(to("wave", "idle", Condition::Finished));
        let wave = ClipFacts { duration: 0.5, looping: false, stride: 0.0 };
        let mut machine = Machine::new(&config, &[IDLE, WALK, RUN, wave]);
        let pulled = ["wave".to_owned()];
        machine.advance(&Facts { grounded: true, triggers: &pulled, ..Facts::default() }, 1.0 / 60.0);
        assert_eq!(machine.name(machine.current()), "wave");
        run_for(&mut machine, 0.0, 0.7);
        assert_eq!(machine.name(machine.current()), "idle");
    }
}
