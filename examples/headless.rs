//! A walk up a ramp without window or GPU: how a test or a server uses the crate. Prints where the walker gets to, and how well.

use std::error::Error;

use bevy::prelude::*;
use surefoot::{
    character::{foot_ik::FootIk, locomotion::Locomotion},
    testing::{Stage, World},
};

/// Slope of the ramp in degrees, and the walking speed in m/s.
const SLOPE: f32 = 15.0;
const SPEED: f32 = 1.4;

fn main() -> Result<(), Box<dyn Error>> {
    let mut stage = Stage::on(&World::ramp(SLOPE));
    let walker = stage.spawn_walker()?;

    println!("second   height m   state   planted feet");
    for second in 1..=5 {
        stage.walk(walker, Vec3::NEG_Z * SPEED).run_for(1.0);
        let state = stage.get::<Locomotion>(walker).map_or("", Locomotion::state);
        let planted =
            stage.get::<FootIk>(walker).map_or(0, |ik| ik.feet.iter().filter(|foot| foot.plant().is_some()).count());
        println!("{second:>6}   {:>8.2}   {state:>5}   {planted}", stage.root(walker).y);
    }

    let measures = stage.measures(walker);
    println!("a planted foot slid {:.1} mm at most, and sank {:.1} mm", measures.drift_max, measures.penetration_max);
    Ok(())
}
