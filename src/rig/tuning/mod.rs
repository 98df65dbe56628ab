//! What a developer tunes, one file per stage. Radians in code, degrees in RON.

pub mod actions;
pub mod aim;
pub mod balance;
pub mod blink;
pub mod degrees;
pub mod foot_ik;
pub mod locomotion;
pub mod look;
pub mod motion;
pub mod ranges;
pub mod retarget;
pub mod standard;
