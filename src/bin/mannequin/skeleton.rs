//! The mannequin's skeleton: joint names, parents and rest positions.
//!
//! Model space of the file: metres, +Y up, the character faces +Z (glTF and VRM 1.0), its left is +X.
//! T-pose; every rest rotation is the identity, so a joint's local translation is the difference of two positions.
//! Lengths: stature 1.80 m, segment fractions after Winter / Drillis & Contini and de Leva 1996 (joint centres).

use glam::Vec3;

/// One joint: name (VRM 1.0 humanoid), parent's name, rest position in model space.
#[derive(Clone, Copy, Debug)]
pub struct Joint {
    pub name: &'static str,
    pub parent: Option<&'static str>,
    pub position: Vec3,
}

/// Stature in metres.
pub const STATURE: f32 = 1.80;

const fn joint(name: &'static str, parent: &'static str, x: f32, y: f32, z: f32) -> Joint {
    Joint { name, parent: Some(parent), position: Vec3::new(x, y, z) }
}

/// All joints, parents first. Index in this table = index in the skin.
pub const JOINTS: &[Joint] = &[
    Joint { name: "root", parent: None, position: Vec3::ZERO },
    joint("hips", "root", 0.0, 0.970, 0.0),
    joint("spine", "hips", 0.0, 1.060, -0.006),
    joint("chest", "spine", 0.0, 1.170, -0.012),
    joint("upperChest", "chest", 0.0, 1.290, -0.012),
    joint("neck", "upperChest", 0.0, 1.460, -0.012),
    joint("head", "neck", 0.0, 1.555, 0.008),
    joint("leftEye", "head", 0.033, 1.640, 0.080),
    joint("rightEye", "head", -0.033, 1.640, 0.080),
    joint("leftShoulder", "upperChest", 0.022, 1.415, -0.008),
    joint("leftUpperArm", "leftShoulder", 0.185, 1.415, -0.014),
    joint("leftLowerArm", "leftUpperArm", 0.480, 1.415, -0.020),
    joint("leftHand", "leftLowerArm", 0.755, 1.415, -0.014),
    joint("leftThumbMetacarpal", "leftHand", 0.782, 1.405, 0.022),
    joint("leftThumbProximal", "leftThumbMetacarpal", 0.812, 1.398, 0.046),
    joint("leftThumbDistal", "leftThumbProximal", 0.840, 1.394, 0.062),
    joint("leftIndexProximal", "leftHand", 0.845, 1.415, 0.018),
    joint("leftIndexIntermediate", "leftIndexProximal", 0.886, 1.415, 0.021),
    joint("leftIndexDistal", "leftIndexIntermediate", 0.911, 1.415, 0.022),
    joint("leftMiddleProximal", "leftHand", 0.847, 1.417, -0.006),
    joint("leftMiddleIntermediate", "leftMiddleProximal", 0.891, 1.417, -0.006),
    joint("leftMiddleDistal", "leftMiddleIntermediate", 0.919, 1.417, -0.006),
    joint("leftRingProximal", "leftHand", 0.843, 1.414, -0.029),
    joint("leftRingIntermediate", "leftRingProximal", 0.883, 1.414, -0.031),
    joint("leftRingDistal", "leftRingIntermediate", 0.909, 1.414, -0.032),
    joint("leftLittleProximal", "leftHand", 0.836, 1.409, -0.050),
    joint("leftLittleIntermediate", "leftLittleProximal", 0.868, 1.409, -0.054),
    joint("leftLittleDistal", "leftLittleIntermediate", 0.888, 1.409, -0.056),
    joint("rightShoulder", "upperChest", -0.022, 1.415, -0.008),
    joint("rightUpperArm", "rightShoulder", -0.185, 1.415, -0.014),
    joint("rightLowerArm", "rightUpperArm", -0.480, 1.415, -0.020),
    joint("rightHand", "rightLowerArm", -0.755, 1.415, -0.014),
    joint("rightThumbMetacarpal", "rightHand", -0.782, 1.405, 0.022),
    joint("rightThumbProximal", "rightThumbMetacarpal", -0.812, 1.398, 0.046),
    joint("rightThumbDistal", "rightThumbProximal", -0.840, 1.394, 0.062),
    joint("rightIndexProximal", "rightHand", -0.845, 1.415, 0.018),
    joint("rightIndexIntermediate", "rightIndexProximal", -0.886, 1.415, 0.021),
    joint("rightIndexDistal", "rightIndexIntermediate", -0.911, 1.415, 0.022),
    joint("rightMiddleProximal", "rightHand", -0.847, 1.417, -0.006),
    joint("rightMiddleIntermediate", "rightMiddleProximal", -0.891, 1.417, -0.006),
    joint("rightMiddleDistal", "rightMiddleIntermediate", -0.919, 1.417, -0.006),
    joint("rightRingProximal", "rightHand", -0.843, 1.414, -0.029),
    joint("rightRingIntermediate", "rightRingProximal", -0.883, 1.414, -0.031),
    joint("rightRingDistal", "rightRingIntermediate", -0.909, 1.414, -0.032),
    joint("rightLittleProximal", "rightHand", -0.836, 1.409, -0.050),
    joint("rightLittleIntermediate", "rightLittleProximal", -0.868, 1.409, -0.054),
    joint("rightLittleDistal", "rightLittleIntermediate", -0.888, 1.409, -0.056),
    joint("leftUpperLeg", "hips", 0.088, 0.945, 0.0),
    joint("leftLowerLeg", "leftUpperLeg", 0.088, 0.508, 0.008),
    joint("leftFoot", "leftLowerLeg", 0.088, 0.070, -0.012),
    joint("leftToes", "leftFoot", 0.092, 0.022, 0.123),
    joint("rightUpperLeg", "hips", -0.088, 0.945, 0.0),
    joint("rightLowerLeg", "rightUpperLeg", -0.088, 0.508, 0.008),
    joint("rightFoot", "rightLowerLeg", -0.088, 0.070, -0.012),
    joint("rightToes", "rightFoot", -0.092, 0.022, 0.123),
];

/// Sole points of the left foot in model space at rest; the right foot mirrors them in X.
///
/// Heel: 0.055 m behind the ankle; ball: under the toe joint; tip: 0.075 m beyond the ball.
pub const HEEL: Vec3 = Vec3::new(0.088, 0.0, -0.067);
/// See [`HEEL`].
pub const BALL: Vec3 = Vec3::new(0.092, 0.0, 0.123);
/// See [`HEEL`].
pub const TIP: Vec3 = Vec3::new(0.092, 0.0, 0.198);

/// Index of the joint named `name`.
#[must_use]
pub fn index(name: &str) -> usize {
    JOINTS.iter().position(|j| j.name == name).expect("joint is in the table")
}

/// Index of the joint on the other side; a joint of the middle is its own.
#[must_use]
pub fn opposite(joint: usize) -> usize {
    let name = JOINTS[joint].name;
    let other = match (name.strip_prefix("left"), name.strip_prefix("right")) {
        (Some(rest), _) => format!("right{rest}"),
        (_, Some(rest)) => format!("left{rest}"),
        _ => return joint,
    };
    index(&other)
}
