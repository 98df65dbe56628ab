//! Inverse kinematics: where joints must turn so that an end reaches a place. Pure; any one space in, the same space out.
//!
//! [`two_bone`] works on three points. The others work on a [`chain`] of joints, each in its parent's space, so that
//! whatever carries the chain may be moved, turned, scaled or mirrored: [`limb`] bends a chain in one place, [`ccd`] and
//! [`fabrik`] in all of them, [`aim`] points its end, [`swivel`] turns it toward a pole. [`limits`] say how far joints turn.

pub mod aim;
pub mod ccd;
pub mod chain;
pub mod fabrik;
mod least_squares;
pub mod limb;
pub mod limits;
mod search;
pub mod swivel;
pub mod two_bone;

#[cfg(test)]
mod tests;
