//! Which joints carry a point of the soft parts, left half, model space of the file.
//!
//! Every chain hands over along its own coordinate, so a weight never jumps across a gap between limbs.

use glam::Vec3;

use crate::{
    mesh::Influences,
    shape::{field::bone, hand::Finger},
    skeleton::{index, opposite},
};

/// 0 below `center - half`, 1 above `center + half`, smooth between.
fn ramp(value: f32, center: f32, half: f32) -> f32 {
    let t = ((value - center) / (2.0 * half) + 0.5).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Shares that are being handed down a tree of joints.
#[derive(Default)]
struct Shares(Vec<(usize, f32)>);

impl Shares {
    fn of(joint: &str) -> Self {
        Self(vec![(index(joint), 1.0)])
    }

    /// `from` gives this part of its share to `to`.
    fn hand_over(&mut self, from: &str, to: &str, part: f32) -> &mut Self {
        self.give(index(from), index(to), part)
    }

    fn give(&mut self, from: usize, to: usize, part: f32) -> &mut Self {
        let given: f32 = self
            .0
            .iter_mut()
            .filter(|(joint, _)| *joint == from)
            .map(|(_, share)| {
                let given = *share * part;
                *share -= given;
                given
            })
            .sum();
        self.0.push((to, given));
        self
    }

    /// The four largest, scaled to sum 1.
    fn finish(&mut self) -> Influences {
        let mut list: Vec<(usize, f32)> = Vec::new();
        for &(joint, share) in &self.0 {
            match list.iter_mut().find(|(other, _)| *other == joint) {
                Some((_, sum)) => *sum += share,
                None => list.push((joint, share)),
            }
        }
        list.retain(|(_, share)| *share > 0.004);
        list.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        list.truncate(4);
        let sum: f32 = list.iter().map(|(_, share)| share).sum();
        std::array::from_fn(|i| list.get(i).map_or((0, 0.0), |(joint, share)| (*joint, share / sum)))
    }
}

/// Joints of a point of the undersuit, x ≥ 0.
#[must_use]
pub fn undersuit(p: Vec3) -> Influences {
    let mut shares = Shares::of("hips");
    shares.hand_over("hips", "spine", ramp(p.y, 1.035, 0.060));
    shares.hand_over("spine", "chest", ramp(p.y, 1.160, 0.050));
    shares.hand_over("chest", "upperChest", ramp(p.y, 1.275, 0.050));
    shares.hand_over("upperChest", "neck", ramp(p.y, 1.478, 0.032));
    shares.hand_over("neck", "head", ramp(p.y, 1.560, 0.025));
    clavicle_and_arm(&mut shares, p);
    leg(&mut shares, p);
    shares.finish()
}

fn clavicle_and_arm(shares: &mut Shares, p: Vec3) {
    // The hand-over leans outward below the shoulder, so that the flank stays with the chest.
    let outward = p.x + 0.35 * (p.y - 1.415).min(0.0);
    let arm = ramp(outward, 0.176, 0.052) * ramp(p.y, 1.290, 0.050);
    let clavicle = ramp(p.x, 0.095, 0.060) * ramp(p.y, 1.385, 0.055);
    let lower = ramp(p.x, 0.480, 0.046);
    let hand = ramp(p.x, 0.752, 0.036);
    for from in ["chest", "upperChest", "neck"] {
        shares.hand_over(from, "leftShoulder", clavicle.max(arm));
    }
    shares.hand_over("leftShoulder", "leftUpperArm", arm / clavicle.max(arm).max(1e-6));
    shares.hand_over("leftUpperArm", "leftLowerArm", lower);
    shares.hand_over("leftLowerArm", "leftHand", hand);
}

fn leg(shares: &mut Shares, p: Vec3) {
    // The groin's fold: from the crotch up to the hip bone, a little lower behind.
    let fold = 0.925 + 0.50 * (p.x - 0.088) + 0.25 * p.z;
    let thigh = 1.0 - ramp(p.y, fold, 0.068);
    // Left and right share the crotch, and nothing below it.
    let reach = 0.002 + 0.030 * ramp(p.y, 0.865, 0.020);
    let left = ramp(p.x, 0.0, reach);
    let hips = index("hips");
    let thigh_joint = index("leftUpperLeg");
    shares.give(hips, thigh_joint, thigh);
    shares.give(thigh_joint, opposite(thigh_joint), 1.0 - left);
    shares.hand_over("leftUpperLeg", "leftLowerLeg", 1.0 - ramp(p.y, 0.508, 0.056));
    shares.hand_over("leftLowerLeg", "leftFoot", 1.0 - ramp(p.y, 0.082, 0.034));
}

/// Joints of a point of the left boot or its sole.
#[must_use]
pub fn boot(p: Vec3) -> Influences {
    let mut shares = Shares::of("leftLowerLeg");
    // Instep and heel belong to the foot even where they rise as high as the ankle's fold.
    let ahead = ((p.z + 0.012).abs() - 0.030).max(0.0);
    shares.hand_over("leftLowerLeg", "leftFoot", 1.0 - ramp(p.y - 0.7 * ahead, 0.096, 0.030));
    // Ends under the rim of the toe cap, which is rigid.
    shares.hand_over("leftFoot", "leftToes", ramp(p.z, 0.114, 0.017));
    shares.finish()
}

/// Joints of a point of the left glove.
#[must_use]
pub fn glove(p: Vec3, fingers: &[Finger; 5]) -> Influences {
    let mut shares = Shares::of("leftLowerArm");
    shares.hand_over("leftLowerArm", "leftHand", ramp(p.x, 0.752, 0.036));
    let distance = |finger: &Finger| {
        (0..3)
            .map(|k| bone(p, finger.points[k], finger.points[k + 1], finger.radii[k], finger.radii[k + 1]))
            .fold(f32::MAX, f32::min)
    };
    let away: [f32; 5] = std::array::from_fn(|i| distance(&fingers[i]));
    let mut order = [0, 1, 2, 3, 4];
    order.sort_by(|a, b| away[*a].total_cmp(&away[*b]));
    let [first, second, ..] = order;
    // In the web between two fingers both pull; further out the near one alone.
    let web = 1.0 - ramp(p.x, 0.862, 0.014);
    let share = 1.0 - web * (1.0 - ramp(away[second] - away[first], 0.0, 0.007));
    let hand = index("leftHand");
    let mut left = 1.0;
    for (i, part) in [(first, share), (second, 1.0 - share)] {
        let passed = part * past(&fingers[i], 0, p);
        shares.give(hand, fingers[i].joints[0], (passed / left).min(1.0));
        left = (left - passed).max(1e-6);
        for k in 1..3 {
            shares.give(fingers[i].joints[k - 1], fingers[i].joints[k], past(&fingers[i], k, p));
        }
    }
    shares.finish()
}

/// How far `p` has passed joint `k` of a finger, 0..1.
fn past(finger: &Finger, k: usize, p: Vec3) -> f32 {
    let before = if k == 0 { finger.points[1] - finger.points[0] } else { finger.points[k] - finger.points[k - 1] };
    let along = (before.normalize() + (finger.points[k + 1] - finger.points[k]).normalize()).normalize();
    ramp((p - finger.points[k]).dot(along), 0.0, 0.8 * finger.radii[k])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::hand::fingers;

    fn share(influences: &Influences, joint: &str) -> f32 {
        influences.iter().filter(|(i, _)| *i == index(joint)).map(|(_, share)| share).sum()
    }

    /// Largest change of any joint's share over a millimetre, along a line.
    fn steepest(carry: impl Fn(Vec3) -> Influences, from: Vec3, to: Vec3) -> f32 {
        let steps = (from.distance(to) / 0.001) as u16;
        let at = |k: u16| carry(from.lerp(to, f32::from(k) / f32::from(steps)));
        let change = |a: Influences, b: Influences| {
            let of = |list: &Influences, joint| list.iter().filter(|(i, _)| *i == joint).map(|(_, w)| w).sum::<f32>();
            a.iter().chain(&b).map(|(joint, _)| (of(&a, *joint) - of(&b, *joint)).abs()).fold(0.0, f32::max)
        };
        (0..steps).map(|k| change(at(k), at(k + 1))).fold(0.0, f32::max)
    }

    #[test]
    fn a_thigh_knows_nothing_of_the_other_one() {
        let inner_thigh = undersuit(Vec3::new(0.012, 0.80, 0.0));
        assert!(share(&inner_thigh, "rightUpperLeg") < 1e-6, "{inner_thigh:?}");
        assert!(share(&inner_thigh, "leftUpperLeg") > 0.9, "{inner_thigh:?}");
    }

    #[test]
    fn left_and_right_share_the_crotch_equally() {
        let crotch = undersuit(Vec3::new(0.0, 0.870, 0.0));
        let (left, right) = (share(&crotch, "leftUpperLeg"), share(&crotch, "rightUpperLeg"));
        assert!((left - right).abs() < 1e-6 && left > 0.05, "left {left}, right {right}");
    }

    #[test]
    fn the_flank_does_not_follow_the_arm() {
        let flank = undersuit(Vec3::new(0.150, 1.250, 0.0));
        assert!(share(&flank, "leftUpperArm") < 0.02, "{flank:?}");
    }

    #[test]
    fn weights_change_gradually_along_leg_arm_and_spine() {
        let lines = [
            ("leg", Vec3::new(0.10, 1.00, 0.05), Vec3::new(0.10, 0.09, 0.02)),
            ("arm", Vec3::new(0.02, 1.45, 0.0), Vec3::new(0.77, 1.43, 0.0)),
            ("spine", Vec3::new(0.0, 0.90, 0.09), Vec3::new(0.0, 1.70, 0.05)),
        ];
        for (name, from, to) in lines {
            let step = steepest(undersuit, from, to);
            assert!(step < 0.035, "{name}: a share jumps by {step} within a millimetre");
        }
    }

    #[test]
    fn a_fingertip_belongs_to_its_own_finger() {
        let fingers = fingers();
        for finger in &fingers {
            let tip = glove(finger.points[3], &fingers);
            assert_eq!(tip[0], (finger.joints[2], 1.0), "{tip:?}");
        }
    }

    #[test]
    fn the_sole_bends_under_the_ball_and_nowhere_else() {
        let at = |z| share(&boot(Vec3::new(0.09, 0.0, z)), "leftToes");
        assert!(at(0.06) < 1e-6 && at(0.15) > 0.999, "toes carry {} at the arch, {} at the toes", at(0.06), at(0.15));
        assert!((0.2..0.8).contains(&at(0.114)), "toes carry {} at the ball", at(0.114));
    }
}
