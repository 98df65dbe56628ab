//! Vertical acceleration of the pelvis; jumps and falls apart. Pure.

use super::frame::Frame;

/// Seconds in the air from which it is a jump or a fall, and not a hop over a step.
const FLIGHT: f32 = 0.1;
/// Seconds after touching ground that count as the landing.
const LANDING: f32 = 0.3;

/// Seconds between the three heights that an acceleration is found from, where frames are shorter.
const STEP: f32 = 1.0 / 60.0;
/// Seconds by which rounding may shorten a frame.
const SLACK: f32 = 1e-4;

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
    for (index, frame) in frames.iter().enumerate() {
        let (Some(before), Some(after)) = (neighbour(frames, index, -1.0), neighbour(frames, index, 1.0)) else {
            continue;
        };
        let (first, second) = (frame.time - before.time, after.time - frame.time);
        let change = (after.pelvis - frame.pelvis) / second - (frame.pelvis - before.pelvis) / first;
        let acceleration = (change / (0.5 * (first + second))).abs();
        let airborne = |flight: &Flight| (flight.start..flight.end).contains(&after.index);
        let lands = |flight: &Flight| {
            let touch = frames.get(flight.end).map(|touch| touch.time);
            after.index >= flight.end && touch.is_some_and(|touch| frame.time <= touch + LANDING)
        };
        if flights.iter().any(airborne) {
            continue;
        }
        if flights.iter().any(lands) { &mut found.landing } else { &mut found.on_ground }.push(acceleration);
    }
    found
}

/// The pelvis a moment before or after a frame.
struct Moment {
    time: f32,
    pelvis: f32,
    /// The frame at or after it.
    index: usize,
}

/// The pelvis 1/60 s from frame `index`, or a frame where frames are longer: so that all frame rates tell the same.
fn neighbour(frames: &[Frame], index: usize, direction: f32) -> Option<Moment> {
    let step = if direction > 0.0 { 1 } else { usize::MAX };
    let (here, mut at) = (&frames[index], index);
    loop {
        let last = at;
        at = at.wrapping_add(step);
        let frame = frames.get(at)?;
        let away = (frame.time - here.time).abs();
        if away >= STEP - SLACK {
            let before = &frames[last];
            let way = if last == index {
                1.0
            } else {
                (STEP - (before.time - here.time).abs()) / (frame.time - before.time).abs()
            };
            let time = before.time + (frame.time - before.time) * way;
            return Some(Moment {
                time,
                pelvis: before.pelvis + (frame.pelvis - before.pelvis) * way,
                index: at.max(last),
            });
        }
    }
}

/// First frame in the air, and first on the ground again.
struct Flight {
    start: usize,
    end: usize,
}

/// Every flight.
fn flights(frames: &[Frame]) -> Vec<Flight> {
    let mut flights = Vec::new();
    let mut start = None;
    for (index, frame) in frames.iter().enumerate() {
        match (frame.grounded, start) {
            (false, None) => start = Some(index),
            (true, Some(first)) => {
                flights.push(Flight { start: first, end: index });
                start = None;
            }
            _ => {}
        }
    }
    flights.extend(start.map(|first| Flight { start: first, end: frames.len() }));
    let seconds = |flight: &Flight| frames[flight.end.min(frames.len() - 1)].time - frames[flight.start].time;
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
    fn all_frame_rates_see_the_same_acceleration() {
        for hertz in [60.0, 144.0, 240.0] {
            let frame = |index: usize| {
                let time = index as f32 / hertz;
                Frame { time, pelvis: 4.0 * time * time, grounded: true, ..Frame::default() }
            };
            let found = accelerations(&(0..100).map(frame).collect::<Vec<_>>()).on_ground;
            let off = found.iter().map(|a| (a - 8.0).abs()).fold(0.0, f32::max);
            assert!(found.len() > 90 && off < 1.0, "off by {off} m/s² at {hertz} Hz");
        }
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
