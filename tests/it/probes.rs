//! What feet ask of the ground: the colliders gathered about a character answer as the whole world does.

use avian3d::prelude::SpatialQuery;
use bevy::{ecs::system::SystemState, prelude::*};
use surefoot::{
    character::foot_ik::{GroundFilter, Grounds, NoGround, PhysicsProbe, Probe, Reach},
    testing::{Stage, World},
};

/// Metres about the root that the feet ask about, and a bit further.
const ASKED: f32 = 2.2;

fn assert_same_ground(world: &World) {
    let mut stage = Stage::on(world);
    let walker = stage.spawn_walker().expect("the mannequin loads");
    stage.run_for(0.3);
    let root = stage.root(walker);
    let filter = stage.get::<GroundFilter>(walker).cloned().expect("a walker's feet know what is ground");
    let reach = Reach { root, up: 0.5, down: 0.7, upright: 0.6 };
    let app = stage.app();
    let mut state = SystemState::<(Grounds, SpatialQuery, Query<(), NoGround>)>::new(app.world_mut());
    let (grounds, spatial, no_ground) = state.get(app.world()).expect("the world has colliders");
    let mut near = grounds.probe(&filter);
    grounds.gather(&filter, reach, 1.75, &mut near);
    let everywhere = PhysicsProbe::new(&spatial, &no_ground, &filter);
    let (mut met, mut highest) = (0, f32::MIN);
    for column in 0..60u8 {
        for row in 0..60u8 {
            // Off the edges of boxes and triangles, where either side is right.
            let share = |index: u8| 2.0 * (f32::from(index) + 0.317) / 60.0 - 1.0;
            let place = root + Vec3::new(share(column), 0.0, share(row)) * ASKED;
            let (here, there) = (reach.at(&near, place), reach.at(&everywhere, place));
            let case = format!("{}: at {place}", world.name);
            assert_eq!(here.map(|hit| hit.entity), there.map(|hit| hit.entity), "{case}");
            let (Some(here), Some(there)) = (here, there) else { continue };
            let (off, tilt) = ((here.point.y - there.point.y).abs(), here.normal.angle_between(there.normal));
            assert!(off < 1e-4, "{case}: ground {:.5} m off", off);
            assert!(tilt < 1e-2, "{case}: ground tilted by {tilt} rad");
            met += 1;
            highest = highest.max(here.point.y);
        }
    }
    assert!(met > 1_000, "{}: only {met} places have ground", world.name);
    assert!(near.down(root + Vec3::Y * 50.0, 0.1).is_none(), "{}: ground in the sky", world.name);
    println!("{}: {met} places, the highest {highest:.3} m", world.name);
}

#[test]
fn the_ground_near_a_character_is_the_ground_of_the_world() {
    for world in [World::flat(), World::rubble(), World::hills(), World::stepping_stones(), World::slope(30.0)] {
        assert_same_ground(&world);
    }
}

#[test]
fn characters_are_no_ground_for_each_other() {
    let mut stage = Stage::on(&World::flat());
    let walkers = [0, 1].map(|_| stage.spawn_walker().expect("the mannequin loads"));
    stage.run_for(0.3);
    let other = stage.root(walkers[1]);
    let filter = stage.get::<GroundFilter>(walkers[0]).cloned().expect("a walker's feet know what is ground");
    let app = stage.app();
    let mut state = SystemState::<Grounds>::new(app.world_mut());
    let grounds = state.get(app.world()).expect("the world has colliders");
    let reach = Reach { root: other, up: 3.0, down: 3.0, upright: 0.6 };
    let mut near = grounds.probe(&filter);
    grounds.gather(&filter, reach, 1.0, &mut near);
    let hit = reach.at(&near, other).expect("a floor");
    assert!(hit.point.y.abs() < 0.01, "the ground is {} m high where another character stands", hit.point.y);
}
