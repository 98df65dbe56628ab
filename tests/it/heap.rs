//! Posing crowds takes nothing from the heap once its memory has grown, by blocks and by the stages of the app.

use std::{
    alloc::{GlobalAlloc, Layout as Memory, System},
    cell::Cell,
    env,
    process::Command,
};

use bevy::{
    ecs::schedule::SingleThreadedExecutor,
    math::Affine3A,
    prelude::*,
    tasks::{ComputeTaskPool, TaskPoolBuilder},
};
use surefoot::{
    anim::{
        bake::{ClipCurves, JointCurves},
        block::{Actor, Goal, Layer, LimbJoints, Play, Precision, RowSource, Species, SpeciesParts, Workspace, pose},
        clip::Clip,
        curve::{Curve, Interpolation},
        ik::two_bone::Extension,
        matrix::JointMatrix,
        pose::Pose,
        skeleton::{JointIndex, JointTransform, Skeleton},
        skin::Skin,
    },
    character::{animator::Actions, intent::MoveIntent, schedule::MotionSystems, show::ShowLocals},
    measure::record::Recorder,
    testing::{
        Stage, World as Ground,
        laps::{STAGES, lap_stages},
    },
};

thread_local! {
    /// Heap allocations of this thread: tests run beside each other.
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

/// The system's allocator, counted.
struct Counting;

#[expect(unsafe_code, reason = "an allocator can't be counted otherwise; it only passes on")]
// SAFETY: all is passed on to the system's allocator as it comes.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Memory) -> *mut u8 {
        // A thread that ends has no counter any more.
        let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's promises go on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Memory) {
        // SAFETY: the caller's promises go on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn a_crowd_is_posed_without_the_heap() {
    let step = JointTransform { translation: Vec3::NEG_Y * 0.4, ..JointTransform::IDENTITY };
    let joints = (0..4).map(|i: u16| (i.to_string(), i.checked_sub(1).map(JointIndex), step));
    let skeleton = Skeleton::new(joints, Affine3A::IDENTITY).unwrap();
    let rest = Pose::rest(&skeleton);
    let inverse_bind = rest.models().iter().map(JointMatrix::inverse).collect();
    let skin = Skin { joints: skeleton.joints().collect(), inverse_bind };
    let clips = [0.3, 0.8].map(|angle| swing(&skeleton, angle));
    let sources = [RowSource::new(&clips[0], Precision::Float), RowSource::new(&clips[1], Precision::Short)];
    let [upper, lower, end] = [0, 1, 2].map(JointIndex);
    let limbs = [LimbJoints { upper, lower, end, extension: Extension::default() }];
    let parts = SpeciesParts { skeleton: &skeleton, skin: &skin, limbs: &limbs, clips: &sources, masks: &[] };
    let species = Species::new(&parts).unwrap();

    let goals = [Some(Goal { target: Vec3::NEG_Y, pole: Vec3::NEG_Z, end_turn: Quat::IDENTITY })];
    let plays: Vec<_> =
        (0..100).map(|i| [0, 1].map(|clip| Play { clip, time: i as f32 * 0.01, weight: 1.0 + clip as f32 })).collect();
    let layers: Vec<_> = plays.iter().map(|clips| [Layer { weight: 1.0, clips, ..Layer::default() }]).collect();
    let actors: Vec<_> = layers
        .iter()
        .enumerate()
        .map(|(index, layers)| Actor { layers, goals: &goals, palette: index * species.slot_count() })
        .collect();
    let mut matrices = vec![JointMatrix::IDENTITY; actors.len() * species.slot_count()];
    let mut work = Workspace::default();
    pose(&species, &actors, &mut work, &mut matrices);

    let before = ALLOCATIONS.get();
    for _ in 0..3 {
        pose(&species, &actors, &mut work, &mut matrices);
    }
    let taken = ALLOCATIONS.get() - before;
    assert_eq!(taken, 0, "{taken} allocations in three frames of {} characters", actors.len());
    drop(std::hint::black_box(Box::new(taken)));
    assert!(ALLOCATIONS.get() > before, "the counter counts");
}

/// Heap allocations of each stage, and the count at its start.
#[derive(Resource, Default)]
struct Taken {
    before: usize,
    stages: [usize; STAGES.len()],
    controller: usize,
}

/// Counts the controller and the stages of a frame's poses, all of them on this thread.
fn watch(app: &mut App) {
    app.init_resource::<Taken>();
    let start = |mut taken: ResMut<Taken>| taken.before = ALLOCATIONS.get();
    let end = |mut taken: ResMut<Taken>| taken.controller += ALLOCATIONS.get() - taken.before;
    app.add_systems(
        FixedUpdate,
        (start.after(MotionSystems::Decide).before(MotionSystems::Move), end.after(MotionSystems::Move)),
    );
    lap_stages(app, start, |stage| {
        move |mut taken: ResMut<Taken>| {
            let now = ALLOCATIONS.get();
            let before = core::mem::replace(&mut taken.before, now);
            taken.stages[stage] += now - before;
        }
    });
    for (_, schedule) in app.world_mut().resource_mut::<Schedules>().iter_mut() {
        schedule.set_executor(SingleThreadedExecutor::new());
    }
}

/// What stands before the allocations in the output of the process below.
const MARK: &str = "allocations of the stages: ";

#[test]
#[ignore = "not a test by itself: the one below runs it in a process of its own, since a process has one pool of threads"]
fn prints_what_walkers_take_from_the_heap() {
    ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(1).build());
    let ground = Ground::hills();
    let mut stage = Stage::with(&ground, concat!(env!("CARGO_MANIFEST_DIR"), "/assets").as_ref(), watch);
    let places: Vec<_> = (0..16u8).map(|i| Transform::from_xyz(f32::from(i) * 2.0 - 16.0, 0.0, 0.0)).collect();
    let mannequin = stage.load_character("mannequin.character.ron").unwrap();
    let walkers = stage.spawn_loaded(mannequin, &ground.on_ground(&places));
    for (index, walker) in walkers.iter().enumerate() {
        // Two pairs press against each other.
        let way = match index {
            12 | 14 => Vec3::X,
            13 | 15 => Vec3::NEG_X,
            _ => Vec3::NEG_Z,
        };
        stage.intend(*walker, MoveIntent { velocity: way * 1.4, aim: Some(Vec3::NEG_Z), ..default() });
        // Records of every frame do take memory.
        let mut walker = stage.app().world_mut().entity_mut(*walker);
        walker.remove::<Recorder>();
        if index % 2 == 0 {
            walker.remove::<ShowLocals>();
        }
    }
    stage.run_for(3.5);
    for walker in &walkers {
        let mut actions = stage.app().world_mut().get_mut::<Actions>(*walker).unwrap();
        actions.play("wave");
        actions.play("crouch_idle");
    }
    stage.run_for(0.5);
    stage.app().insert_resource(Taken::default());
    stage.run_for(2.0);
    let Taken { stages, controller, .. } = stage.app().world().resource::<Taken>();
    println!("\n{MARK}{controller} {}", stages.map(|count| count.to_string()).join(" "));
}

#[test]
fn walkers_are_posed_without_the_heap() {
    let output = Command::new(env::current_exe().unwrap())
        .args(["--ignored", "--exact", "heap::prints_what_walkers_take_from_the_heap", "--nocapture"])
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let counts = text.lines().find_map(|line| line.strip_prefix(MARK)).unwrap_or_else(|| {
        panic!("no count: {text}{}", String::from_utf8_lossy(&output.stderr));
    });
    let names = ["Move".to_owned()].into_iter().chain(STAGES.map(|stage| format!("{stage:?}")));
    let taken: Vec<_> = names.zip(counts.split(' ')).filter(|(_, count)| *count != "0").collect();
    assert!(taken.is_empty(), "allocations in two seconds of 16 walkers: {taken:?}");
}

/// Every joint swings to `angle` radians and back within a second.
fn swing(skeleton: &Skeleton, angle: f32) -> Clip {
    let times = vec![0.0, 0.5, 1.0];
    let keys = vec![Quat::IDENTITY, Quat::from_rotation_x(angle), Quat::IDENTITY];
    let curves = |joint| JointCurves {
        rotation: Curve::rotation(times.clone(), keys.clone(), Interpolation::Linear).ok(),
        ..JointCurves::new(joint)
    };
    ClipCurves { joints: skeleton.joints().map(curves).collect(), ..ClipCurves::default() }.bake_at(skeleton, 30.0)
}
