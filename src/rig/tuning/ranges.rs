//! Range checks of tuning: each names the field, the value and what would be right.

use core::ops::RangeInclusive;

use bevy::reflect::{PartialReflect, ReflectRef};

use super::{
    balance::BalanceConfig,
    foot_ik::FootIkConfig,
    locomotion::{Condition, LocomotionConfig, Pace, StateConfig},
    look::LookConfig,
    motion::MotionConfig,
};
use crate::rig::names::{listed, suggestion};

/// A value out of its range.
///
/// The message names the field as a path in the file, its value and what would be valid.
#[derive(thiserror::Error, Clone, Debug, PartialEq, Eq)]
#[error("{0}")]
pub struct RangeError(String);

/// Checks fields of one part of a file.
pub struct Ranges {
    prefix: String,
}

impl Ranges {
    /// Checks whose messages put `prefix` before field names.
    #[must_use]
    pub fn new(prefix: &str) -> Self {
        Self { prefix: prefix.to_owned() }
    }

    /// Whether `value` is a number in `range`; `unit` goes into the message.
    ///
    /// # Errors
    /// When it isn't.
    pub fn within(&self, field: &str, value: f32, range: RangeInclusive<f32>, unit: &str) -> Result<(), RangeError> {
        if range.contains(&value) {
            return Ok(());
        }
        let valid = format!("{} to {}{unit}", range.start(), range.end());
        Err(self.fail(field, format!("{value}{unit}"), valid))
    }

    /// As [`Ranges::within`] for an angle kept in radians, with range and message in degrees.
    ///
    /// # Errors
    /// When it isn't within.
    pub fn degrees(&self, field: &str, radians: f32, range: RangeInclusive<f32>) -> Result<(), RangeError> {
        // Degrees that went to radians and back are off by rounding.
        let degrees = (radians.to_degrees() * 1000.0).round() / 1000.0;
        self.within(field, degrees, range, "°")
    }

    /// Whether `pair` is ordered and within `range`.
    ///
    /// # Errors
    /// When it isn't.
    pub fn ordered(&self, field: &str, pair: (f32, f32), range: RangeInclusive<f32>) -> Result<(), RangeError> {
        if range.contains(&pair.0) && range.contains(&pair.1) && pair.0 <= pair.1 {
            return Ok(());
        }
        let valid = format!("a smaller and a larger number from {} to {}", range.start(), range.end());
        Err(self.fail(field, format!("({}, {})", pair.0, pair.1), valid))
    }

    /// An error about `field`.
    #[must_use]
    pub fn fail(&self, field: &str, value: String, valid: String) -> RangeError {
        RangeError(format!("`{}{field}` is {value}; valid is {valid}", self.prefix))
    }

    /// Whether every number anywhere in `value` is finite.
    ///
    /// # Errors
    /// With the first that isn't.
    pub fn finite(&self, value: &dyn PartialReflect) -> Result<(), RangeError> {
        self.finite_below("", value)
    }

    fn finite_below(&self, path: &str, value: &dyn PartialReflect) -> Result<(), RangeError> {
        if let Some(number) = value.try_downcast_ref::<f32>() {
            let valid = || "a finite number".to_owned();
            return if number.is_finite() { Ok(()) } else { Err(self.fail(path, number.to_string(), valid())) };
        }
        let below = |name: &str| if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
        match value.reflect_ref() {
            ReflectRef::Struct(fields) => {
                (0..fields.field_len()).try_for_each(|index| match (fields.name_at(index), fields.field_at(index)) {
                    (Some(name), Some(field)) => self.finite_below(&below(name), field),
                    _ => Ok(()),
                })
            }
            ReflectRef::Tuple(fields) => (0..fields.field_len()).try_for_each(|index| match fields.field(index) {
                Some(field) => self.finite_below(&below(&index.to_string()), field),
                None => Ok(()),
            }),
            ReflectRef::List(items) => items
                .iter()
                .enumerate()
                .try_for_each(|(index, item)| self.finite_below(&format!("{path}[{index}]"), item)),
            ReflectRef::Enum(variant) => (0..variant.field_len()).try_for_each(|index| match variant.field_at(index) {
                Some(field) => self.finite_below(path, field),
                None => Ok(()),
            }),
            _ => Ok(()),
        }
    }
}

impl MotionConfig {
    /// Checks every range.
    ///
    /// # Errors
    /// With the first value out of range.
    pub fn check(&self, ranges: &Ranges) -> Result<(), RangeError> {
        match self.problem() {
            None => Ok(()),
            Some(problem) => Err(RangeError(format!("{}{problem}", ranges.prefix))),
        }
    }
}

impl LocomotionConfig {
    /// Checks every range and, where states are listed, that transitions lead to states that exist.
    ///
    /// # Errors
    /// With the first value out of range.
    pub fn check(&self, ranges: &Ranges) -> Result<(), RangeError> {
        ranges.finite(self)?;
        ranges.ordered("rate_range", self.rate_range, 0.05..=10.0)?;
        ranges.ordered("stride_range", self.stride_range, 0.05..=10.0)?;
        ranges.within("climb_cadence", self.climb_cadence, 0.0..=10.0, "")?;
        ranges.within("blend_half_life", self.blend_half_life, 0.0..=5.0, " s")?;
        if let Some(states) = &self.states {
            check_states(ranges, states)?;
            self.check_names(ranges)?;
        }
        for (index, transition) in self.transitions().iter().enumerate() {
            ranges.within(&format!("transitions[{index}].fade"), transition.fade, 0.0..=10.0, " s")?;
            check_condition(ranges, &format!("transitions[{index}].when"), &transition.when)?;
        }
        Ok(())
    }

    /// Checks that transitions lead from and to states that exist.
    ///
    /// # Errors
    /// With the first name of a state that doesn't.
    pub fn check_names(&self, ranges: &Ranges) -> Result<(), RangeError> {
        let names = || self.states().iter().map(|state| state.name.as_str());
        let known = |field: String, name: &str| {
            if names().any(|state| state == name) {
                return Ok(());
            }
            let valid = format!("one of {}{}", listed(names()), suggestion(name, names()));
            Err(ranges.fail(&field, format!("`{name}`"), valid))
        };
        for (index, transition) in self.transitions().iter().enumerate() {
            known(format!("transitions[{index}].to"), &transition.to)?;
            for from in &transition.from {
                known(format!("transitions[{index}].from"), from)?;
            }
        }
        Ok(())
    }
}

fn check_states(ranges: &Ranges, states: &[StateConfig]) -> Result<(), RangeError> {
    if states.is_empty() {
        return Err(ranges.fail("states", "empty".to_owned(), "at least one state".to_owned()));
    }
    for (index, state) in states.iter().enumerate() {
        let field = |name: &str| format!("states[{index}].{name}");
        if states[..index].iter().any(|earlier| earlier.name == state.name) {
            return Err(ranges.fail(&field("name"), format!("`{}`", state.name), "a name of its own".to_owned()));
        }
        if state.clip.is_empty() == state.blend.is_empty() {
            let value = if state.clip.is_empty() { "empty" } else { "there beside `blend`" };
            return Err(ranges.fail(&field("clip"), value.to_owned(), "either a clip or a blend".to_owned()));
        }
        match state.pace {
            Pace::Clock => {}
            Pace::Gait { start_phase } => ranges.within(&field("pace.start_phase"), start_phase, 0.0..=1.0, "")?,
            Pace::Turn { angle } if angle.abs() < 0.01 => {
                return Err(ranges.fail(
                    &field("pace.angle"),
                    "0°".to_owned(),
                    "a turn to the left or right".to_owned(),
                ));
            }
            Pace::Turn { angle } => ranges.degrees(&field("pace.angle"), angle, -720.0..=720.0)?,
        }
    }
    Ok(())
}

fn check_condition(ranges: &Ranges, field: &str, condition: &Condition) -> Result<(), RangeError> {
    match condition {
        Condition::SpeedAbove(speed)
        | Condition::SpeedBelow(speed)
        | Condition::FallingFaster(speed)
        | Condition::LandedFaster(speed) => ranges.within(field, *speed, 0.0..=100.0, " m/s"),
        Condition::TurnLeftAbove(angle) | Condition::TurnRightAbove(angle) | Condition::TurnBelow(angle) => {
            ranges.degrees(field, *angle, 0.0..=180.0)
        }
        Condition::AirborneFor(time) | Condition::InStateFor(time) => ranges.within(field, *time, 0.0..=3600.0, " s"),
        Condition::All(conditions) => {
            conditions.iter().try_for_each(|condition| check_condition(ranges, field, condition))
        }
        _ => Ok(()),
    }
}

impl FootIkConfig {
    /// Checks every range.
    ///
    /// # Errors
    /// With the first value out of range.
    pub fn check(&self, ranges: &Ranges) -> Result<(), RangeError> {
        ranges.finite(self)?;
        for (field, value) in [
            ("probe_up", self.probe_up),
            ("probe_down", self.probe_down),
            ("unplant_radius", self.unplant_radius),
            ("restep_distance", self.restep_distance),
            ("step_height", self.step_height),
            ("clearance", self.clearance),
            ("landing_shift", self.landing_shift),
            ("pelvis_drop", self.pelvis_drop),
        ] {
            ranges.within(field, value, 0.0..=5.0, " m")?;
        }
        for (field, value) in [
            ("pelvis_half_life", self.pelvis_half_life),
            ("align_half_life", self.align_half_life),
            ("air_half_life", self.air_half_life),
        ] {
            ranges.within(field, value, 0.0..=5.0, " s")?;
        }
        ranges.within("step_time", self.step_time, 0.02..=5.0, " s")?;
        ranges.degrees("walkable", self.walkable, 0.0..=90.0)?;
        ranges.degrees("unplant_yaw", self.unplant_yaw, 0.0..=180.0)?;
        ranges.degrees("pitch_limit", self.pitch_limit, 0.0..=90.0)?;
        ranges.degrees("roll_limit", self.roll_limit, 0.0..=90.0)?;
        ranges.within("pelvis_extension", self.pelvis_extension, 0.5..=1.0, "")?;
        ranges.ordered("extension", self.extension, 0.5..=1.0)
    }
}

impl BalanceConfig {
    /// Checks every range.
    ///
    /// # Errors
    /// With the first value out of range.
    pub fn check(&self, ranges: &Ranges) -> Result<(), RangeError> {
        for (field, value) in [
            ("forward", self.forward),
            ("side", self.side),
            ("uphill", self.uphill),
            ("downhill", self.downhill),
            ("from_ankles", self.from_ankles),
        ] {
            ranges.within(field, value, 0.0..=1.0, "")?;
        }
        ranges.within("half_life", self.half_life, 0.0..=5.0, " s")?;
        ranges.degrees("forward_limit", self.forward_limit, 0.0..=45.0)?;
        ranges.degrees("backward_limit", self.backward_limit, 0.0..=45.0)?;
        ranges.degrees("side_limit", self.side_limit, 0.0..=45.0)
    }
}

impl LookConfig {
    /// Checks every range.
    ///
    /// # Errors
    /// With the first value out of range.
    pub fn check(&self, ranges: &Ranges) -> Result<(), RangeError> {
        ranges.within("half_life", self.half_life, 0.0..=5.0, " s")?;
        ranges.degrees("fastest", self.fastest, 1.0..=3600.0)?;
        ranges.within("ahead", self.ahead, 0.0..=5.0, " s")?;
        for (field, value) in [("slope", self.slope), ("level", self.level), ("chest", self.chest), ("neck", self.neck)]
        {
            ranges.within(field, value, 0.0..=1.0, "")?;
        }
        ranges.within("chest and neck together", self.chest + self.neck, 0.0..=1.0, "")?;
        ranges.degrees("side_limit", self.side_limit, 0.0..=90.0)?;
        ranges.degrees("up_limit", self.up_limit, 0.0..=90.0)
    }
}
