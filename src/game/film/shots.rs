//! Plans from where a walk is filmed: at each moment the view of least cost, all of them one smooth move. Pure; radians.

use core::f32::consts::TAU;

use crate::math::rotation::wrap_angle;

/// Yaws that are tried.
const YAWS: usize = 36;
/// Pitches that are tried: from eye level over handrails to over boulders.
const PITCHES: [f32; 5] = [0.24, 0.38, 0.52, 0.66, 0.8];
/// Steps of yaw that the camera may turn from one moment to the next.
const MOST_TURN: i32 = 2;
/// Cost of turning by one step of yaw, and of one step of pitch, both by the square.
const TURN_COST: f32 = 0.12;
const TILT_COST: f32 = 0.5;
/// Times that neighbouring moments are blended, so that steps become a move.
const BLENDS: usize = 4;
/// Moments before and after for which a view must be good too, since blending leads past it.
const MARGIN: usize = BLENDS;

/// From where the camera looks: as an orbit's yaw and pitch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct View {
    /// Radians about +Y; 0 looks along -Z.
    pub yaw: f32,
    /// Radians that the camera looks down.
    pub pitch: f32,
}

impl View {
    /// The view between this one and `other`, yaws taken as they are.
    #[must_use]
    pub fn lerp(self, other: Self, share: f32) -> Self {
        Self { yaw: self.yaw + (other.yaw - self.yaw) * share, pitch: self.pitch + (other.pitch - self.pitch) * share }
    }
}

/// A view for each of `count` moments: the row of least cost, where `cost` says what a view is worth at a moment (0 is best)
/// and turning costs too. Yaws run on past ±π, so that views between two moments can be blended.
#[must_use]
pub fn plan(count: usize, cost: impl Fn(usize, View) -> f32) -> Vec<View> {
    // Viterbi: the cheapest way to each view, moment by moment; then back from the cheapest end.
    let views: Vec<View> =
        (0..YAWS).flat_map(|step| PITCHES.map(|pitch| View { yaw: step as f32 * TAU / YAWS as f32, pitch })).collect();
    let costs: Vec<Vec<f32>> =
        (0..count).map(|moment| views.iter().map(|view| cost(moment, *view)).collect()).collect();
    let worst = |moment: usize, view: usize| {
        let around = moment.saturating_sub(MARGIN)..(moment + MARGIN + 1).min(count);
        costs[around].iter().map(|row| row[view]).fold(0.0, f32::max)
    };
    let mut total = vec![0.0; views.len()];
    let mut ways: Vec<Vec<usize>> = Vec::with_capacity(count);
    for moment in 0..count {
        let arrivals: Vec<(f32, usize)> = (0..views.len()).map(|view| cheapest(&total, view, moment > 0)).collect();
        for (view, (before, _)) in arrivals.iter().enumerate() {
            total[view] = before + worst(moment, view);
        }
        ways.push(arrivals.into_iter().map(|(_, from)| from).collect());
    }
    let mut view = (0..views.len()).min_by(|a, b| total[*a].total_cmp(&total[*b])).unwrap_or(0);
    let mut row = Vec::with_capacity(count);
    for way in ways.iter().rev() {
        row.push(views[view]);
        view = way[view];
    }
    row.reverse();
    smoothed(unwrapped(row))
}

/// What the cheapest way to `view` costs by the totals of the moment before, and the view it comes from.
fn cheapest(total: &[f32], view: usize, moved: bool) -> (f32, usize) {
    if !moved {
        return (total[view], view);
    }
    let (yaw, pitch) = (view / PITCHES.len(), view % PITCHES.len());
    let mut best = (f32::INFINITY, view);
    for turn in -MOST_TURN..=MOST_TURN {
        let from_yaw = (yaw as i32 + turn).rem_euclid(YAWS as i32) as usize;
        for from_pitch in 0..PITCHES.len() {
            let from = from_yaw * PITCHES.len() + from_pitch;
            let tilt = pitch.abs_diff(from_pitch);
            let cost = total[from] + TURN_COST * (turn * turn) as f32 + TILT_COST * (tilt * tilt) as f32;
            if cost < best.0 {
                best = (cost, from);
            }
        }
    }
    best
}

/// The same views with yaws that never jump by a whole turn.
fn unwrapped(mut row: Vec<View>) -> Vec<View> {
    for moment in 1..row.len() {
        let before = row[moment - 1].yaw;
        row[moment].yaw = before + wrap_angle(row[moment].yaw - before);
    }
    row
}

fn smoothed(mut row: Vec<View>) -> Vec<View> {
    for _ in 0..BLENDS {
        let sharp = row.clone();
        for moment in 1..row.len().saturating_sub(1) {
            row[moment] = sharp[moment - 1].lerp(sharp[moment + 1], 0.5).lerp(sharp[moment], 0.5);
        }
    }
    row
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How far a view is from looking along `yaw`, by the square.
    fn off(view: View, yaw: f32) -> f32 {
        wrap_angle(view.yaw - yaw) * wrap_angle(view.yaw - yaw)
    }

    #[test]
    fn nothing_in_the_way_keeps_the_camera_still() {
        let row = plan(40, |_, view| off(view, 1.0));
        let [least, most] = [f32::min, f32::max].map(|pick| row.iter().map(|view| view.yaw).reduce(pick).unwrap());
        assert!(most - least < 1e-4 && (least - 1.0).abs() < 0.1, "yaws from {least} to {most}");
    }

    #[test]
    fn the_camera_is_round_a_wall_before_the_wall_comes() {
        // From moment 20 to 30 nothing is seen from the left.
        let hidden = |moment: usize, view: View| (20..=30).contains(&moment) && wrap_angle(view.yaw) > 0.0;
        let row = plan(60, |moment, view| off(view, 1.2) + if hidden(moment, view) { 100.0 } else { 0.0 });
        let blind = row.iter().enumerate().filter(|(moment, view)| hidden(*moment, **view)).count();
        assert_eq!(blind, 0, "moments without a sight of the hero in {row:?}");
        let fastest = row.windows(2).map(|pair| (pair[1].yaw - pair[0].yaw).abs()).fold(0.0, f32::max);
        assert!(fastest < 0.3, "turns {fastest} radians at once");
    }

    #[test]
    fn yaws_run_on_past_half_a_turn() {
        let row = plan(80, |moment, view| off(view, moment as f32 * 0.1));
        let turned = row[79].yaw - row[0].yaw;
        assert!((turned - 7.9).abs() < 0.6, "turned by {turned} radians of 7.9");
    }
}
