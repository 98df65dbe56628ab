//! How good the walk is, world by world, held to the bars of `measure::bars`.

use std::{collections::BTreeSet, sync::OnceLock};

use surefoot::{
    measure::{bars::listed, table::Table},
    testing::gauntlet::{Feet, Runner, courses, jobs, run},
};

/// The mannequin, loaded once.
fn mannequin() -> &'static Runner {
    static MANNEQUIN: OnceLock<Runner> = OnceLock::new();
    MANNEQUIN.get_or_init(|| Runner::mannequin().unwrap())
}

fn assert_bars_hold_on(world: &str) {
    let courses: Vec<_> = courses().into_iter().filter(|course| course.world.name == world).collect();
    assert!(!courses.is_empty(), "no course is on {world}");
    let rows = run(&jobs(&courses, &[Feet::Placed]), mannequin(), || ()).unwrap();
    let mut over = Vec::new();
    for row in rows {
        let name = format!("{} / {}", row.world, row.tape);
        println!("{name}\n{}", Table(&row.bars.rows(&row.measures)));
        over.extend((!row.breaches.is_empty()).then(|| format!("\n{name}: {}", listed(&row.breaches))));
    }
    assert!(over.is_empty(), "over their bars:{}", over.concat());
}

/// One test a world, and a list of all their worlds.
macro_rules! tests {
    ($($test:ident: $world:literal,)*) => {
        const WORLDS: &[&str] = &[$($world),*];
        $(
            #[test]
            fn $test() {
                assert_bars_hold_on($world);
            }
        )*
    };
}

tests! {
    on_the_flat: "flat",
    on_a_ramp_of_10_degrees: "ramp 10°",
    on_a_ramp_of_20_degrees: "ramp 20°",
    on_a_ramp_of_30_degrees: "ramp 30°",
    on_a_slope_of_10_degrees: "slope 10°",
    on_a_slope_of_20_degrees: "slope 20°",
    on_a_slope_of_30_degrees: "slope 30°",
    on_stairs_up: "stairs up",
    on_stairs_down: "stairs down",
    on_rubble: "rubble",
    on_a_ridge: "ridge",
    on_stepping_stones: "stepping stones",
    on_hills: "hills",
    over_curbs: "curb",
    on_a_moving_platform: "moving platform",
    on_a_rotating_platform: "rotating platform",
    along_a_cliff: "cliff edge",
}

#[test]
fn every_world_of_the_gauntlet_has_its_test() {
    let worlds: BTreeSet<String> = courses().into_iter().map(|course| course.world.name).collect();
    let tested: BTreeSet<String> = WORLDS.iter().map(ToString::to_string).collect();
    assert_eq!(worlds, tested);
}
