//! Inverse kinematics: where joints must turn so that an end reaches a place. Pure; any one space in, the same space out.

pub mod two_bone;
