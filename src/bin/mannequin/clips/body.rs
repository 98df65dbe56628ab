//! From a figure (pelvis, trunk, head, arms, feet) to the local rotation of every joint.
//!
//! Model space of the file: metres, +Y up, facing +Z, left +X. Angles of [`Arm`] and [`turn`] are degrees.

use super::super::skeleton::{JOINTS, index};
use super::leg::{Foot, mirror_point, mirror_turn, rest, solve};
use glam::{DQuat, DVec3};

/// A turn from anatomical angles in degrees: `left_forward` brings the left side to the front, `lean` tips forward,
/// `left_up` raises the left side.
#[must_use]
pub fn turn(left_forward: f64, lean: f64, left_up: f64) -> DQuat {
    DQuat::from_rotation_y(-left_forward.to_radians())
        * DQuat::from_rotation_x(lean.to_radians())
        * DQuat::from_rotation_z(left_up.to_radians())
}

/// One arm in degrees; all zero = hanging straight down, palm to the thigh.
#[derive(Clone, Copy, Debug, Default)]
pub struct Arm {
    /// Shoulder: forward +.
    pub flex: f64,
    /// Shoulder: away from the body +; 90 = T-pose.
    pub abduct: f64,
    /// Upper arm about its own axis: elbow outward, forearm to the midline +.
    pub inward: f64,
    /// Elbow: 0 straight, forward +.
    pub elbow: f64,
    /// Forearm about its own axis: palm to the back +.
    pub pronate: f64,
    /// Wrist: palm-ward +.
    pub wrist: f64,
    /// Fingers: 0 straight, 1 a fist.
    pub curl: f64,
    /// Clavicle: up +.
    pub shrug: f64,
    /// Clavicle: forward +.
    pub protract: f64,
}

/// A whole body at one moment.
#[derive(Clone, Copy, Debug)]
pub struct Figure {
    /// The `hips` joint, metres.
    pub hips: DVec3,
    /// Turn of pelvis, thorax and head in model space; the spine and neck between them share the difference.
    pub pelvis: DQuat,
    pub thorax: DQuat,
    pub head: DQuat,
    /// Left, right.
    pub arms: [Arm; 2],
    pub feet: [Foot; 2],
    /// How far each knee points outward of straight ahead, degrees.
    pub knees_out: [f64; 2],
}

/// Local rotations by joint index, and the local translation of `hips`.
#[derive(Clone, Debug)]
pub struct Joints {
    pub rotations: Vec<DQuat>,
    pub hips: DVec3,
}

/// Position of the left or right hip joint in model space with the pelvis so placed.
#[must_use]
pub fn hip_joint(hips: DVec3, pelvis: DQuat, side: usize) -> DVec3 {
    let offset = rest("leftUpperLeg") - rest("hips");
    hips + pelvis * if side == 0 { offset } else { mirror_point(offset) }
}

impl Figure {
    /// The mirror image: left and right change places.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        let swap = |feet: [Foot; 2]| [feet[1].mirrored(), feet[0].mirrored()];
        Self {
            hips: mirror_point(self.hips),
            pelvis: mirror_turn(self.pelvis),
            thorax: mirror_turn(self.thorax),
            head: mirror_turn(self.head),
            arms: [self.arms[1], self.arms[0]],
            feet: swap(self.feet),
            knees_out: [self.knees_out[1], self.knees_out[0]],
        }
    }

    /// The pose of all joints.
    #[must_use]
    pub fn joints(&self) -> Joints {
        let mut pose = Joints { rotations: vec![DQuat::IDENTITY; JOINTS.len()], hips: self.hips };
        pose.trunk(self);
        for side in 0..2 {
            pose.arm(side, &self.arms[side]);
            pose.leg(side, self);
        }
        pose
    }
}

impl Joints {
    fn set(&mut self, side: usize, name: &str, left: DQuat) {
        let (prefix, rotation) = if side == 0 { ("left", left) } else { ("right", mirror_turn(left)) };
        self.rotations[index(&format!("{prefix}{name}"))] = rotation;
    }

    fn trunk(&mut self, figure: &Figure) {
        let (pelvis, thorax, head) = (figure.pelvis, figure.thorax, figure.head);
        let levels = [
            ("hips", pelvis),
            ("spine", pelvis.slerp(thorax, 0.3)),
            ("chest", pelvis.slerp(thorax, 0.65)),
            ("upperChest", thorax),
            ("neck", thorax.slerp(head, 0.45)),
            ("head", head),
        ];
        let mut parent = DQuat::IDENTITY;
        for (name, model) in levels {
            self.rotations[index(name)] = parent.inverse() * model;
            parent = model;
        }
    }

    fn arm(&mut self, side: usize, arm: &Arm) {
        let (x, y, z) = (DQuat::from_rotation_x, DQuat::from_rotation_y, DQuat::from_rotation_z);
        let rad = f64::to_radians;
        self.set(side, "Shoulder", y(rad(-arm.protract)) * z(rad(arm.shrug)));
        let hang = x(rad(-arm.flex)) * z(rad(arm.abduct - 90.0)) * x(rad(arm.inward));
        self.set(side, "UpperArm", hang);
        self.set(side, "LowerArm", y(rad(-arm.elbow)) * x(rad(0.6 * arm.pronate)));
        self.set(side, "Hand", x(rad(0.4 * arm.pronate)) * z(rad(-arm.wrist)));
        let fingers = [("Index", 0.82, 2.5), ("Middle", 1.0, 0.0), ("Ring", 1.1, -2.0), ("Little", 1.18, -4.0)];
        for (finger, share, spread) in fingers {
            let bend = |most: f64| z(rad(-most * share * arm.curl));
            self.set(side, &format!("{finger}Proximal"), y(rad(-spread * (1.0 - arm.curl))) * bend(68.0));
            self.set(side, &format!("{finger}Intermediate"), bend(92.0));
            self.set(side, &format!("{finger}Distal"), bend(58.0));
        }
        let curl = arm.curl;
        self.set(side, "ThumbMetacarpal", y(rad(8.0 + 22.0 * curl)) * z(rad(-10.0 - 22.0 * curl)));
        self.set(side, "ThumbProximal", y(rad(6.0 + 30.0 * curl)));
        self.set(side, "ThumbDistal", y(rad(6.0 + 40.0 * curl)));
    }

    fn leg(&mut self, side: usize, figure: &Figure) {
        let seen = |p: DVec3| if side == 0 { p } else { mirror_point(p) };
        let seen_turn = |q: DQuat| if side == 0 { q } else { mirror_turn(q) };
        let hip = seen(hip_joint(figure.hips, figure.pelvis, side));
        let pelvis = seen_turn(figure.pelvis);
        let foot = if side == 0 { figure.feet[0] } else { figure.feet[1].mirrored() };
        let out = figure.knees_out[side].to_radians();
        let leg = solve(hip, foot.ankle, DVec3::new(out.sin(), 0.0, out.cos()));
        self.set(side, "UpperLeg", pelvis.inverse() * leg.thigh);
        self.set(side, "LowerLeg", leg.thigh.inverse() * leg.shank);
        self.set(side, "Foot", leg.shank.inverse() * foot.turn);
        self.set(side, "Toes", foot.turn.inverse() * foot.toes);
    }
}
