//! Level of detail: who is seen small is posed less, and nobody sees it change.

use bevy::prelude::*;
use surefoot::{
    character::{animator::CharacterPose, detail::Detail, foot_ik::FootIk, locomotion::Locomotion, look::Look},
    measure::summary::Measures,
    testing::{Stage, World},
};

const WALK: Vec3 = Vec3::new(0.0, 0.0, -1.4);

fn walker_on(world: &World) -> (Stage, Entity) {
    let mut stage = Stage::on(world);
    let walker = stage.spawn_walker().expect("the mannequin loads");
    stage.walk(walker, WALK).run_for(1.0);
    (stage, walker)
}

fn set(stage: &mut Stage, walker: Entity, detail: Detail) {
    stage.app().world_mut().entity_mut(walker).insert(detail);
}

/// What is recorded while these details take turns, each for 0.7 s.
fn turns(world: &World, details: &[Detail]) -> Measures {
    let (mut stage, walker) = walker_on(world);
    set(&mut stage, walker, details[0]);
    stage.run_for(0.7).start_recording(walker);
    for detail in details.iter().cycle().take(6) {
        set(&mut stage, walker, *detail);
        stage.run_for(0.7);
    }
    stage.measures(walker)
}

#[test]
fn nothing_pops_when_the_step_changes() {
    let every = Detail::default();
    let stepped = |step: f32| Detail { step, feet: false, look: false, ..every };
    let calm = turns(&World::flat(), &[every]).pop_jump;
    for step in [1.0 / 32.0, 1.0 / 30.0, 1.0 / 15.0] {
        let steady = turns(&World::flat(), &[stepped(step)]).pop_jump;
        println!("steps of {step:.3} s: jumps {steady:.2}, {calm:.2} in every frame");
        assert!(steady <= 2.0, "with steps of {step} s it jumps by {steady:.2} of its clips");
    }
    for step in [1.0 / 32.0, 1.0 / 30.0] {
        let changing = turns(&World::flat(), &[every, stepped(step)]).pop_jump;
        println!("jumps {changing:.2} while changing");
        assert!(changing <= 2.0, "a change to steps of {step} s jumps by {changing:.2} of its clips");
    }
}

#[test]
fn feet_leave_the_ground_and_find_it_again_without_a_pop() {
    let every = Detail::default();
    let without = Detail { feet: false, ..every };
    for world in [World::flat(), World::hills()] {
        let calm = turns(&world, &[every]).pop_jump;
        let changing = turns(&world, &[every, without]).pop_jump;
        println!("{}: jumps {changing:.2} while changing, {calm:.2} in every frame", world.name);
        assert!(
            changing <= 2.0_f32.max(1.1 * calm),
            "{}: jumps by {changing:.2}, without a change {calm:.2}",
            world.name
        );
    }
}

#[test]
fn far_away_feet_and_gaze_are_off_and_come_back() {
    let (mut stage, walker) = walker_on(&World::hills());
    set(&mut stage, walker, Detail { feet: false, look: false, ..default() });
    stage.run_for(1.5);
    let (ik, look) = (stage.get::<FootIk>(walker).unwrap(), stage.get::<Look>(walker).unwrap());
    assert!(ik.weight < 0.01 && ik.placed == [None; 2], "feet are still placed by {}", ik.weight);
    assert!(look.off > 0.99, "the look is still on by {}", 1.0 - look.off);
    set(&mut stage, walker, Detail::default());
    stage.run_for(1.0);
    let (ik, look) = (stage.get::<FootIk>(walker).unwrap(), stage.get::<Look>(walker).unwrap());
    assert!(ik.weight > 0.99 && ik.placed[0].is_some(), "feet are placed by {} only", ik.weight);
    assert!(look.off < 0.01, "the look is off by {}", look.off);
}

#[test]
fn who_is_hidden_keeps_its_phase_and_place_and_stands_still() {
    let (mut seen, twin) = walker_on(&World::hills());
    let (mut unseen, hidden) = walker_on(&World::hills());
    set(&mut unseen, hidden, Detail { posed: false, ..default() });
    unseen.run_for(1.0 / 60.0);
    seen.run_for(1.0 / 60.0);
    let locals = |stage: &Stage| stage.get::<CharacterPose>(hidden).unwrap().pose.locals().to_vec();
    let before = locals(&unseen);
    unseen.run_for(2.0);
    seen.run_for(2.0);
    assert_eq!(locals(&unseen), before, "nobody sees it move");
    let phase = |stage: &Stage, who: Entity| {
        let machine = &stage.get::<Locomotion>(who).unwrap().machine;
        machine.clip_phase(machine.current())
    };
    let off = (phase(&seen, twin) - phase(&unseen, hidden)).abs();
    assert!(off < 1e-5, "its phase is {off} off that of its twin");
    assert_eq!(seen.root(twin), unseen.root(hidden), "it went another way than its twin");
    set(&mut unseen, hidden, Detail::default());
    unseen.run_for(1.0);
    seen.run_for(1.0);
    let knee = |stage: &Stage, who: Entity| {
        let asset = stage.asset(who).unwrap();
        stage.get::<CharacterPose>(who).unwrap().pose.position(asset.legs[0].foot)
    };
    let off = knee(&seen, twin).distance(knee(&unseen, hidden));
    assert!(off < 0.01, "seen again for a second its foot is {off} m off that of its twin");
}
