//! The mannequin's clips, drawn by code: feet on exact contact paths, legs by inverse kinematics, the rest by curves.
//!
//! All in the file's model space (metres, +Y up, facing +Z, left +X) and in place: the root stays, feet in stance run
//! backward at exactly the clip's speed.

mod air;
mod body;
mod crouch;
mod curves;
mod foot_path;
mod gait;
mod greet;
mod idle;
mod keyed;
mod leg;
mod record;
mod run;
mod sidle;
mod sprint;
mod turning;
mod walk;

use super::clip::Clip;

/// Every clip of the file.
#[must_use]
pub fn all() -> Vec<Clip> {
    vec![
        idle::clip(),
        walk::gait().clip(),
        run::gait().clip(),
        sprint::gait().clip(),
        crouch::idle(),
        crouch::gait().clip(),
        crouch::back().clip(),
        crouch::left().clip(),
        crouch::left().mirrored_clip("crouch_right"),
        sidle::back().clip(),
        sidle::left().clip(),
        sidle::left().mirrored_clip("strafe_right"),
        air::jump(),
        air::fall(),
        air::land_light(),
        air::land_hard(),
        turning::left(),
        turning::right(),
        greet::clip(),
    ]
}
