//! What is shown between two ticks is the same, whoever keeps the poses of the ticks.

use bevy::prelude::*;
use surefoot::{
    character::{animator::CharacterPose, detail::Detail, show::ShowLocals},
    measure::record::Recorder,
    testing::{Stage, World},
};

/// Frames a second: more than ticks.
const RATE: f32 = 144.0;
/// Frames that are looked at.
const FRAMES: usize = 150;

/// Places of all joints of a walker in every frame; `change` may do something to it before each.
fn shown(change: impl Fn(EntityWorldMut, usize)) -> Vec<Vec<Vec3>> {
    let mut stage = Stage::on(&World::rubble());
    let walker = stage.spawn_walker().expect("the mannequin loads");
    // Who is recorded shows locals.
    stage.app().world_mut().entity_mut(walker).remove::<(Recorder, ShowLocals)>();
    stage.walk(walker, Vec3::NEG_Z * 1.4).run_for(0.5);
    stage.set_frame_rate(RATE);
    let frame = |frame: usize| {
        change(stage.app().world_mut().entity_mut(walker), frame);
        stage.run_for(1.0 / RATE);
        let pose = &stage.get::<CharacterPose>(walker).expect("it is bound").pose;
        let places: Vec<Vec3> = pose.positions().collect();
        let model = |joint| Vec3::from(pose.model(joint).translation);
        let asset = stage.asset(walker).expect("it is loaded");
        assert!(asset.skeleton.joints().zip(&places).all(|(joint, place)| model(joint) == *place), "in frame {frame}");
        places
    };
    (0..FRAMES).map(frame).collect()
}

/// Metres between the joints that are farthest apart, and the frame of it.
fn farthest(a: &[Vec<Vec3>], b: &[Vec<Vec3>]) -> (f32, usize) {
    let apart = |(a, b): (&Vec<Vec3>, &Vec<Vec3>)| a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    let frames = a.iter().zip(b).map(apart).enumerate().map(|(frame, apart)| (apart, frame));
    frames.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default()
}

#[test]
fn who_shows_locals_too_is_shown_as_others_from_the_first_frame_on_and_after_the_last() {
    let plain = shown(|_, _| ());
    let moved = plain.windows(2).filter(|pair| farthest(&pair[..1], &pair[1..]).0 > 1e-5).count();
    assert!(moved > FRAMES - 3, "{moved} of {FRAMES} frames show something new");
    let always = shown(|mut walker, _| {
        walker.insert(ShowLocals);
    });
    let (off, frame) = farthest(&plain, &always);
    assert!(off < 1e-5, "{off} m off in frame {frame}");
    let now_and_then = shown(|mut walker, frame| match frame {
        20 | 61 | 95 => _ = walker.insert(ShowLocals),
        41 | 62 | 120 => _ = walker.remove::<ShowLocals>(),
        _ => {}
    });
    let (off, frame) = farthest(&plain, &now_and_then);
    assert!(off < 1e-5, "{off} m off in frame {frame}");
}

#[test]
fn a_detail_that_is_given_later_changes_nothing_that_is_shown() {
    let plain = shown(|_, _| ());
    let later = shown(|mut walker, frame| {
        if frame == 50 {
            walker.insert(Detail::default());
        }
    });
    let (off, frame) = farthest(&plain, &later);
    assert!(off < 1e-5, "{off} m off in frame {frame}");
}

#[test]
fn a_pose_that_nobody_sees_is_not_taken_for_changed() {
    for plain_before in [false, true] {
        let mut stage = Stage::on(&World::flat());
        let walker = stage.spawn_walker().expect("the mannequin loads");
        let unseen = Detail { posed: false, ..Detail::default() };
        if plain_before {
            stage.app().world_mut().entity_mut(walker).remove::<(Recorder, ShowLocals)>();
            stage.walk(walker, Vec3::NEG_Z * 1.4).run_for(0.5);
        }
        stage.app().world_mut().entity_mut(walker).insert(unseen);
        stage.walk(walker, Vec3::NEG_Z * 1.4).run_for(0.5);
        let mut changed = || {
            let entity = stage.app().world().entity(walker);
            let ticks = entity.get_change_ticks::<CharacterPose>().expect("it is bound");
            stage.run_for(0.1);
            ticks.changed.get()
        };
        let (before, after) = (changed(), changed());
        assert_eq!(before, after, "written while nobody sees it; without a detail before: {plain_before}");
    }
}
