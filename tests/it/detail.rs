//! Level of detail: who is seen small is posed less, and nobody sees it change.

use avian3d::prelude::*;
use bevy::{ecs::system::RunSystemOnce, prelude::*};
use surefoot::{
    anim::matrix::JointMatrix,
    character::{
        Character,
        animator::{Actions, CharacterPose},
        bind::CharacterAssets,
        crowd::{Crowd, PaletteJob},
        detail::{ClipsOnly, Detail, Mode, Pacing},
        foot_ik::FootIk,
        intent::MoveIntent,
        locomotion::Locomotion,
        look::Look,
        motion::Glide,
        schedule::{PoseClock, PoseSystems},
    },
    measure::summary::Measures,
    rig::humanoid::HumanoidRole,
    testing::{Stage, World},
};

const WALK: Vec3 = Vec3::new(0.0, 0.0, -1.4);

fn walker_on(world: &World) -> (Stage, Entity) {
    walker_after(world, 0)
}

/// A walker who isn't the first that was spawned: its steps begin at another time than those of its neighbours.
fn walker_after(world: &World, others: usize) -> (Stage, Entity) {
    let mut stage = Stage::on(world);
    stage.app().add_systems(PostUpdate, see_clips.in_set(PoseSystems::Reach));
    for _ in 0..others {
        stage.app().world_mut().spawn_empty();
    }
    let walker = stage.spawn_walker().expect("the mannequin loads");
    stage.walk(walker, WALK).run_for(1.0);
    (stage, walker)
}

fn set(stage: &mut Stage, walker: Entity, detail: Detail) {
    stage.app().world_mut().entity_mut(walker).insert(detail);
}

/// Lets a recorder see who has no pose of its own.
fn see_clips(
    fixed: Res<Time<Fixed>>,
    clock: Res<PoseClock>,
    assets: CharacterAssets,
    mut crowd: Query<(&Character, &Pacing, &mut CharacterPose)>,
) {
    let share = clock.share(fixed.overstep_fraction());
    for (character, pacing, mut pose) in crowd.iter_mut().filter(|(_, pacing, _)| pacing.mode == ALONE) {
        let asset = assets.get(character).expect("it is loaded");
        assert!(pose.show_clips(asset, pacing.small_joints, share), "something plays");
    }
}

const ALONE: Mode = Mode::ClipsOnly(ClipsOnly::Alone);

fn crowded() -> Detail {
    Detail { clips_only: true, ..default() }
}

fn mode(stage: &Stage, walker: Entity) -> Mode {
    stage.get::<Pacing>(walker).expect("it has a detail").mode
}

#[test]
fn nothing_pops_when_clips_take_over_and_give_back() {
    let every = Detail::default();
    let near = Detail { step: 1.0 / 32.0, ..every };
    for world in [World::flat(), World::hills()] {
        let calm = turns(&world, &[every]).pop_jump;
        let far = Detail { small_joints: false, ..crowded() };
        let pairs =
            [("every tick", [every, crowded()]), ("steps", [near, crowded()]), ("without fingers", [near, far])];
        for (name, details) in pairs {
            let changing = turns_of(&world, &details, 1.1).pop_jump;
            println!("{}: jumps {changing:.2} between {name} and clips alone, {calm:.2} in every frame", world.name);
            assert!(changing <= 2.0_f32.max(1.1 * calm), "{}: {name}: jumps by {changing:.2}", world.name);
        }
    }
}

#[test]
fn clips_alone_go_through_every_change_of_state_without_a_pop() {
    let (mut stage, walker) = walker_on(&World::flat());
    set(&mut stage, walker, crowded());
    stage.run_for(1.5);
    assert_eq!(mode(&stage, walker), ALONE);
    stage.start_recording(walker);
    for speed in [0.0, 1.0, 2.5, 1.0, -1.0, 0.0] {
        stage.walk(walker, WALK * speed).run_for(0.9);
        assert_eq!(mode(&stage, walker), ALONE);
    }
    let jump = stage.measures(walker).pop_jump;
    assert!(jump <= 2.0, "it jumps by {jump:.2} of its clips");
}

/// The palette of the only character, as blocks write it.
fn block_palette(
    crowd: Crowd,
    assets: CharacterAssets,
    characters: Query<(Entity, &Character, &Pacing)>,
) -> Vec<JointMatrix> {
    let (entity, character, pacing) = characters.single().expect("there is one");
    let kind = Crowd::kind(character, Some(pacing));
    assert!(kind.is_some(), "clips alone pose it");
    let len = assets.get(character).expect("it is loaded").rig.skins[0].joints.len();
    let mut out = vec![JointMatrix::IDENTITY; len + 5];
    let job = PaletteJob { first: 5, len, character: entity, part: 0, kind };
    crowd.write(&mut [job], &mut out, |_, _| panic!("it has no pose"));
    out.split_off(5)
}

#[test]
fn blocks_show_what_the_reference_does() {
    for small_joints in [true, false] {
        blocks_show_the_reference(Detail { small_joints, ..crowded() });
    }
}

fn blocks_show_the_reference(detail: Detail) {
    let (mut stage, walker) = walker_on(&World::flat());
    set(&mut stage, walker, detail);
    stage.run_for(1.5);
    let asset = stage.asset(walker).expect("it is loaded").clone();
    let skin = asset.rig.skins[0].clone();
    for _ in 0..40 {
        stage.run_for(1.0 / 60.0);
        let got = stage.app().world_mut().run_system_cached(block_palette).expect("it runs");
        let mut wanted = vec![JointMatrix::IDENTITY; got.len()];
        skin.write_palette(&stage.get::<CharacterPose>(walker).expect("shown").pose, &mut wanted);
        for (slot, (got, wanted)) in got.iter().zip(&wanted).enumerate() {
            let off = got.0.as_flattened().iter().zip(wanted.0.as_flattened()).map(|(a, b)| (a - b).abs());
            let off = off.fold(0.0, f32::max);
            assert!(off < 1e-4, "slot {slot} is {off} off");
        }
    }
}

/// Whether the only character is shown anew in this frame.
fn shown_anew(crowd: Crowd, characters: Query<(Entity, &Pacing)>) -> bool {
    let (entity, pacing) = characters.single().expect("there is one");
    assert_eq!(pacing.mode, ALONE);
    crowd.is_due(entity, pacing)
}

#[test]
fn clips_alone_are_shown_as_often_as_the_step_says() {
    for (step, least, most) in [(0.0, 120, 120), (1.0 / 32.0, 62, 66), (0.1, 19, 21)] {
        let (mut stage, walker) = walker_on(&World::flat());
        set(&mut stage, walker, Detail { step, ..crowded() });
        stage.run_for(1.5);
        let shown = (0..120).filter(|_| {
            stage.run_for(1.0 / 60.0);
            stage.app().world_mut().run_system_cached(shown_anew).expect("it runs")
        });
        let shown = shown.count();
        assert!((least..=most).contains(&shown), "shown {shown} times in two seconds at steps of {step} s");
    }
}

#[test]
fn held_fingers_stay_as_they_are_while_hands_move() {
    let (mut stage, walker) = walker_on(&World::flat());
    set(&mut stage, walker, Detail { small_joints: false, ..crowded() });
    stage.run_for(1.5);
    let asset = stage.asset(walker).expect("it is loaded").clone();
    let fingers = asset.small_joints.joints();
    assert!(fingers.len() >= 20, "{} small joints", fingers.len());
    let pose = |stage: &Stage| stage.get::<CharacterPose>(walker).expect("shown").pose.clone();
    let before = pose(&stage);
    let hand = asset.humanoid.get(HumanoidRole::LeftHand).expect("it has hands");
    let mut moved: f32 = 0.0;
    for _ in 0..30 {
        stage.run_for(1.0 / 60.0);
        let now = pose(&stage);
        moved = moved.max(now.position(hand).distance(before.position(hand)));
        for finger in fingers {
            let off = now.turn(*finger).angle_between(before.turn(*finger));
            assert!(off < 1e-3, "`{}` turns by {off}", asset.skeleton.name(*finger));
        }
    }
    assert!(moved > 0.1, "the hand moves by {moved} m alone");
}

#[test]
fn who_acts_is_posed_by_itself_however_far_away() {
    let (mut stage, walker) = walker_on(&World::flat());
    set(&mut stage, walker, crowded());
    stage.run_for(1.5);
    stage.app().world_mut().get_mut::<Actions>(walker).expect("everyone has actions").play("wave");
    stage.run_for(0.3);
    assert_eq!(mode(&stage, walker), Mode::Every, "it waves");
    let aim = stage.app().world_mut().get_mut::<MoveIntent>(walker).map(|mut intent| intent.aim = Some(Vec3::X));
    stage.run_for(6.0);
    assert_eq!((aim, mode(&stage, walker)), (Some(()), Mode::Every), "it aims");
    stage.app().world_mut().get_mut::<MoveIntent>(walker).expect("it is steered").aim = None;
    stage.run_for(2.5);
    assert_eq!(mode(&stage, walker), ALONE);
}

/// What is recorded while these details take turns, each for 0.7 s.
fn turns(world: &World, details: &[Detail]) -> Measures {
    turns_of(world, details, 0.7)
}

/// The same with turns of so many seconds: the livelier of two walkers whose steps begin in different ticks.
fn turns_of(world: &World, details: &[Detail], seconds: f32) -> Measures {
    let mut both = [0, 1].map(|others| {
        let (mut stage, walker) = walker_after(world, others);
        set(&mut stage, walker, details[0]);
        stage.run_for(seconds).start_recording(walker);
        for detail in details.iter().cycle().take(6) {
            set(&mut stage, walker, *detail);
            stage.run_for(seconds);
        }
        stage.measures(walker)
    });
    both.sort_by(|a, b| b.pop_jump.total_cmp(&a.pop_jump));
    let [livelier, _] = both;
    livelier
}

#[test]
fn nothing_pops_when_the_step_changes() {
    let every = Detail::default();
    let stepped = |step: f32| Detail { step, feet: false, look: false, ..every };
    let calm = turns(&World::flat(), &[every]).pop_jump;
    for world in [World::flat(), World::hills()] {
        let steady = turns_of(&world, &[Detail { step: 1.0 / 32.0, ..every }], 1.1).pop_jump;
        println!("{}: steps of 1/32 s with feet: jumps {steady:.2}", world.name);
        assert!(steady <= 2.0, "{}: with feet at steps of 1/32 s it jumps by {steady:.2} of its clips", world.name);
    }
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

#[test]
fn what_is_not_solid_stops_nothing_and_is_hit_by_rays_all_the_same() {
    let reached = |detail: Detail| {
        let (mut stage, walker) = walker_on(&World::flat());
        stage.walk(walker, Vec3::ZERO).run_for(0.7);
        set(&mut stage, walker, detail);
        stage.run_for(0.2);
        let at = stage.get::<Transform>(walker).expect("it stands").translation + Vec3::Y;
        let ball = (
            RigidBody::Dynamic,
            Collider::sphere(0.1),
            Transform::from_translation(at + Vec3::X * 2.0),
            LinearVelocity(Vec3::NEG_X * 4.0),
            GravityScale(0.0),
        );
        let ball = stage.app().world_mut().spawn(ball).id();
        let ray = move |rays: SpatialQuery| {
            let hit = rays.cast_ray(at + Vec3::Z * 2.0, Dir3::NEG_Z, 4.0, true, &SpatialQueryFilter::default());
            hit.map(|hit| hit.entity)
        };
        let hit = stage.app().world_mut().run_system_once(ray).expect("it runs");
        assert_eq!(hit, Some(walker), "a ray at {detail:?}");
        stage.run_for(1.0);
        (at - stage.get::<Transform>(ball).expect("it flies").translation).x
    };
    let every = Detail::default();
    assert!(reached(every) < 0.0, "a ball flew {} m through a solid body", reached(every));
    let passed = reached(Detail { solid: false, ..every });
    assert!((1.5..2.5).contains(&passed), "a ball flew {passed} m beyond who isn't solid");
}

#[test]
fn who_has_no_detail_any_more_has_everything_again() {
    for hides in [false, true] {
        let (mut stage, walker) = walker_on(&World::flat());
        set(&mut stage, walker, Detail { posed: !hides, solid: false, glide: 0.5, ..crowded() });
        stage.run_for(1.0);
        stage.app().world_mut().entity_mut(walker).remove::<Detail>();
        stage.run_for(0.5);
        assert!(stage.get::<RigidBodyDisabled>(walker).is_none(), "nothing stops it");
        assert_eq!((mode(&stage, walker), stage.get::<Glide>(walker)), (Mode::Every, Some(&Glide::default())));
        stage.start_recording(walker);
        stage.run_for(2.0);
        let measures = stage.measures(walker);
        assert!(measures.skate < 2.0, "feet skate by {} cm/s", measures.skate);
    }
}

#[test]
fn who_is_solid_again_stops_what_comes() {
    let (mut stage, walker) = walker_on(&World::flat());
    for solid in [false, true, false, true] {
        set(&mut stage, walker, Detail { solid, ..default() });
        stage.run_for(0.1);
        let disabled = stage.get::<RigidBodyDisabled>(walker).is_some();
        assert_eq!(disabled, !solid, "the body is out of the simulation");
    }
    stage.app().world_mut().entity_mut(walker).insert(RigidBodyDisabled);
    set(&mut stage, walker, Detail { glide: 0.1, ..default() });
    stage.run_for(0.1);
    assert!(stage.get::<RigidBodyDisabled>(walker).is_some(), "someone else took it out");
}
