//! Vertical acceleration of the pelvis; jumps and falls apart. Pure.

use super::frame::Frame;

/// Seconds in the air from which it is a jump or a fall, and not a hop over a step.
const FLIGHT: f32 = 0.1;
/// Seconds after touching ground that count as the landing.
const LANDING: f32 = 0.3;

/// Sizes of accelerations, m/s², in order of time.
#[derive(Clone, Debug, Default)]
pub(super) struct Accelerations {
    /// With ground under the feet.
    pub(super) on_ground: Vec<f32>,
    /// In landings from a jump or fall.
    pub(super) landing: Vec<f32>,
}

/// Accelerations of the pelvis. Take-off and flight are left out: they are the jump's own.
pub(super) fn accelerations(frames: &[Frame]) -> Accelerations {
    let mut found = Accelerations::default();
    let flights = flights(frames);
    for (middle, window) in (1..).zip(frames.windows(3)) {
        let [a, b, c] = window else { continue };
        let (first, second) = ((b.time - a.time).max(1e-4), (c.time - b.time).max(1e-4));
        let change = (c.pelvis - b.pelvis) / second - (b.pelvis - a.pelvis) / first;
        let acceleration = (change / (0.5 * (first + second))).abs();
        let flies = |&(start, end): &(usize, usize)| start <= middle + 1 && middle + 1 < end;
        let lands = |&(_, end): &(usize, usize)| {
            middle + 1 >= end && frames.get(end).is_some_and(|touch| b.time <= touch.time + LANDING)
        };
        if flights.iter().any(flies) {
            continue;
        }
        if flights.iter().any(lands) { &mut found.landing } else { &mut found.on_ground }.push(acceleration);
    }
    found
}

/// First frame in the air and first frame on the ground again of every flight.
fn flights(frames: &[Frame]) -> Vec<(usize, usize)> {
    let mut flights = Vec::new();
    let mut start = None;
    for (index, frame) in frames.iter().enumerate() {
        match (frame.grounded, start) {
            (false, None) => start = Some(index),
            (true, Some(first)) => {
                flights.push((first, index));
                start = None;
            }
            _ => {}
        }
    }
    flights.extend(start.map(|first| (first, frames.len())));
    let seconds = |&(first, end): &(usize, usize)| frames[end.min(frames.len() - 1)].time - frames[first].time;
    flights.retain(|flight| seconds(flight) > FLIGHT);
    flights
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fall of 0.5 s from height 1.25 m that ends at once, then a second of standing.
    fn fall() -> Vec<Frame> {
        let frame = |index: usize| {
            let time = index as f32 / 60.0;
            let since = (time - 0.5).max(0.0);
            let pelvis = if since < 0.5 { 1.25 - 5.0 * since * since } else { 0.0 };
            Frame { time, pelvis, grounded: !(0.5..1.0).contains(&time), ..Frame::default() }
        };
        (0..120).map(frame).collect()
    }

    #[test]
    fn a_hard_landing_counts_as_a_landing_and_not_as_walking() {
        let found = accelerations(&fall());
        let [walking, landing] = [&found.on_ground, &found.landing].map(|a| a.iter().copied().fold(0.0, f32::max));
        assert!(walking < 0.1, "{walking} m/s² on the ground");
        assert!(landing > 200.0, "{landing} m/s² in the landing");
    }

    #[test]
    fn a_hop_of_a_few_frames_is_no_flight() {
        let mut frames = fall();
        for (index, frame) in frames.iter_mut().enumerate() {
            frame.grounded = !(30..34).contains(&index);
        }
        assert!(accelerations(&frames).landing.is_empty());
    }
}
