//! `wave`: the right hand goes up and waves, while the body stands as in `idle`.

use super::super::clip::Clip;
use super::body::{Arm, Figure, turn};
use super::curves::{ease, wave};
use super::idle;
use super::record::{Moment, Timing, record};

const SECONDS: f64 = 2.6;

fn figure(time: f64) -> Figure {
    let stand = idle::figure(time);
    let raised = ease(0.0, 0.55, time) * (1.0 - ease(1.95, SECONDS, time));
    // The elbow leads on the way up and on the way down.
    let bent = ease(0.0, 0.42, time) * (1.0 - ease(2.1, SECONDS, time));
    let waving = ease(0.4, 0.7, time) * (1.0 - ease(1.75, 2.05, time));
    let beat = |late: f64| waving * wave(time - late, 2.1, 0.62, 1.0);
    let low = stand.arms[1];
    let mix = |from: f64, to: f64, share: f64| from + (to - from) * share;
    let arm = Arm {
        flex: mix(low.flex, 10.0, raised),
        abduct: mix(low.abduct, 62.0, raised) + 2.0 * beat(0.0),
        inward: mix(low.inward, -78.0, raised) - 4.0 * beat(0.03),
        elbow: mix(low.elbow, 98.0, bent) + 19.0 * beat(0.04),
        pronate: mix(low.pronate, 4.0, raised),
        wrist: mix(low.wrist, -6.0, raised) + 5.0 * beat(0.12),
        curl: mix(low.curl, 0.10, raised),
        shrug: mix(low.shrug, 9.0, raised),
        protract: mix(low.protract, 4.0, raised),
    };
    Figure {
        thorax: turn(2.5 * raised, -raised, -2.2 * raised - 0.5 * beat(0.0)) * stand.thorax,
        head: turn(1.5 * raised, -raised, 3.0 * raised) * stand.head,
        arms: [stand.arms[0], arm],
        ..stand
    }
}

/// One greeting.
#[must_use]
pub fn clip() -> Clip {
    let timing = Timing { seconds: SECONDS, rate: 60.0, ground_speed: None };
    record("wave", timing, |time| Moment { breath: idle::breath(time), ..Moment::from(figure(time)) })
}
