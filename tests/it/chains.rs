//! IK chains and sockets on the mannequin: hands that reach, heads that look, things that ride on joints.

use bevy::prelude::*;
use surefoot::{
    anim::{
        ik::chain::ChainJoint,
        leg::{LEFT, RIGHT},
        pose::Pose,
    },
    character::{
        Character,
        animator::CharacterPose,
        attach::Attach,
        chains::{ChainJointSetup, ChainOf, IkChain, IkResult, IkState, IkTarget, Pole, RestLimit, TipFacing},
    },
    math::rotation::angle_between,
    rig::{
        humanoid::HumanoidRole::{Head, LeftHand, RightHand, RightUpperArm},
        joint_ref::JointRef,
    },
    testing::{Stage, World},
};

/// In front of the right shoulder, within reach, world space: the mannequin stands at the origin and faces -Z.
const NEAR: Vec3 = Vec3::new(0.25, 1.25, -0.4);
/// Limits of floating point, radians.
const EXACT: f32 = 3e-3;

fn stage() -> (Stage, Entity) {
    let mut stage = Stage::on(&World::flat());
    let walker = stage.spawn_walker().unwrap();
    stage.run_for(0.5);
    (stage, walker)
}

fn add(stage: &mut Stage, walker: Entity, chain: IkChain) -> Entity {
    stage.app().world_mut().spawn((chain, ChainOf(walker))).id()
}

fn change(stage: &mut Stage, chain: Entity, change: impl FnOnce(&mut IkChain)) {
    change(&mut stage.app().world_mut().get_mut::<IkChain>(chain).unwrap());
}

fn result(stage: &Stage, chain: Entity) -> IkResult {
    *stage.get::<IkResult>(chain).unwrap()
}

/// The joint's place in the world, from the pose.
fn place(stage: &Stage, walker: Entity, joint: &str) -> Vec3 {
    let joint = stage.asset(walker).unwrap().skeleton.find(joint).unwrap();
    let root = stage.get::<Transform>(walker).unwrap();
    root.transform_point(stage.get::<CharacterPose>(walker).unwrap().pose.position(joint))
}

fn rotations(stage: &Stage, walker: Entity) -> Vec<Quat> {
    stage.get::<CharacterPose>(walker).unwrap().pose.locals().iter().map(|local| local.rotation).collect()
}

/// Greatest turn of any joint between two poses, degrees.
fn turned(before: &[Quat], now: &[Quat]) -> f32 {
    before.iter().zip(now).map(|(before, now)| angle_between(*before, *now).to_degrees()).fold(0.0, f32::max)
}

/// Greatest turn of any joint from one frame to the next, degrees, in so many frames.
fn greatest_step(stage: &mut Stage, walker: Entity, frames: usize) -> f32 {
    let mut worst = 0.0f32;
    for _ in 0..frames {
        let before = rotations(stage, walker);
        stage.run_for(1.0 / 60.0);
        worst = worst.max(turned(&before, &rotations(stage, walker)));
    }
    worst
}

/// Greatest turn of a joint beyond its limit, radians.
fn excess(stage: &Stage, chain: Entity) -> f32 {
    stage.get::<IkState>(chain).unwrap().joints().iter().map(ChainJoint::excess).fold(0.0, f32::max)
}

#[test]
fn every_solver_brings_the_hand_to_what_is_near() {
    for chain in [
        IkChain::arm(RIGHT),
        IkChain::fabrik("rightShoulder", "rightHand")
            .with_joint(ChainJointSetup::new("rightShoulder", RestLimit::cone(0.4)).giving(0.2))
            .with_joint(ChainJointSetup::new("rightUpperArm", RestLimit::cone(2.0)))
            .with_joint(ChainJointSetup::new("rightLowerArm", RestLimit::cone(2.5))),
        IkChain::two_bone(RightUpperArm, RightHand).with_pole(Pole::Direction(Vec3::new(0.3, -1.0, 0.2))),
    ] {
        let (mut stage, walker) = stage();
        let name = format!("{:?}", chain.solver);
        let hand = add(&mut stage, walker, chain.toward(IkTarget::Point(NEAR)));
        stage.run_for(2.0);
        let missed = place(&stage, walker, "rightHand").distance(NEAR);
        assert!(missed < 1e-3, "{name}: the hand is {:.2} mm away", missed * 1000.0);
        let result = result(&stage, hand);
        assert!(result.reached && result.weight > 0.999, "{name}: {result:?}");
        assert!(excess(&stage, hand) < EXACT, "{name}: {} rad beyond a limit", excess(&stage, hand));
    }
}

#[test]
fn a_hand_that_reaches_while_walking_stays_with_its_target() {
    let (mut stage, walker) = stage();
    let ball = stage.app().world_mut().spawn((Transform::from_translation(NEAR), ChildOf(walker))).id();
    let hand = add(&mut stage, walker, IkChain::arm(RIGHT).toward(IkTarget::Entity(ball, Vec3::ZERO)));
    stage.walk(walker, Vec3::NEG_Z * 1.4).run_for(2.0);
    let mut worst = 0.0f32;
    for _ in 0..120 {
        stage.run_for(1.0 / 60.0);
        let target = stage.get::<GlobalTransform>(ball).unwrap().translation();
        worst = worst.max(place(&stage, walker, "rightHand").distance(target));
        assert!(excess(&stage, hand) < EXACT, "{} rad beyond a limit", excess(&stage, hand));
    }
    assert!(worst < 1e-3, "the hand is {:.2} mm away", worst * 1000.0);
}

#[test]
fn a_hand_fades_in_and_out_without_a_jump() {
    let (mut stage, walker) = stage();
    let still = greatest_step(&mut stage, walker, 60);
    let hand = add(&mut stage, walker, IkChain::arm(RIGHT).toward(IkTarget::Point(NEAR)));
    let coming = greatest_step(&mut stage, walker, 60);
    assert!(result(&stage, hand).weight > 0.99, "{:?}", result(&stage, hand));
    change(&mut stage, hand, |chain| chain.weight = 0.0);
    let going = greatest_step(&mut stage, walker, 120);
    // A hand that goes by half in 0.1 s turns an elbow of some 90° by 6° in a frame at most.
    assert!(coming < still + 7.0 && going < still + 7.0, "{coming}° coming, {going}° going, {still}° without");
    assert_eq!(result(&stage, hand), IkResult::default());
}

#[test]
fn a_faded_chain_leaves_the_pose_as_it_was_animated() {
    let (mut stage, walker) = stage();
    let (mut plain, other) = self::stage();
    let hand = add(&mut stage, walker, IkChain::arm(RIGHT).toward(IkTarget::Point(NEAR)));
    stage.run_for(1.0);
    change(&mut stage, hand, |chain| chain.weight = 0.0);
    stage.run_for(2.0);
    plain.run_for(3.0);
    let off = turned(&rotations(&plain, other), &rotations(&stage, walker));
    assert!(off < 0.05, "{off}° off the clip");
}

#[test]
fn a_hand_that_takes_another_target_glides_there() {
    let (mut stage, walker) = stage();
    let balls = [NEAR, NEAR + Vec3::new(-0.15, 0.2, 0.05)]
        .map(|at| stage.app().world_mut().spawn(Transform::from_translation(at)).id());
    let hand = add(&mut stage, walker, IkChain::arm(RIGHT).toward(IkTarget::Entity(balls[0], Vec3::ZERO)));
    stage.run_for(1.5);
    change(&mut stage, hand, |chain| chain.target = IkTarget::Entity(balls[1], Vec3::ZERO));
    let step = greatest_step(&mut stage, walker, 90);
    assert!(step < 6.0, "a joint turned by {step}° in a frame");
    let missed = place(&stage, walker, "rightHand").distance(NEAR + Vec3::new(-0.15, 0.2, 0.05));
    assert!(missed < 1e-3, "the hand is {:.2} mm away from its new target", missed * 1000.0);
}

#[test]
fn a_target_that_vanishes_lets_the_hand_go_gently() {
    let (mut stage, walker) = stage();
    let ball = stage.app().world_mut().spawn(Transform::from_translation(NEAR)).id();
    let hand = add(&mut stage, walker, IkChain::arm(RIGHT).toward(IkTarget::Entity(ball, Vec3::ZERO)));
    stage.run_for(1.5);
    stage.app().world_mut().despawn(ball);
    let step = greatest_step(&mut stage, walker, 90);
    assert!(step < 7.0, "a joint turned by {step}° in a frame");
    assert_eq!(result(&stage, hand), IkResult::default());
}

#[test]
fn a_hand_on_a_still_target_is_still() {
    let (mut stage, walker) = stage();
    add(&mut stage, walker, IkChain::arm(RIGHT).toward(IkTarget::Point(NEAR)));
    stage.run_for(1.5);
    let mut elbows = Vec::new();
    for _ in 0..120 {
        stage.run_for(1.0 / 60.0);
        let missed = place(&stage, walker, "rightHand").distance(NEAR);
        assert!(missed < 1e-3, "the hand is {:.2} mm away", missed * 1000.0);
        elbows.push(place(&stage, walker, "rightLowerArm"));
    }
    let step = elbows.windows(2).map(|pair| pair[0].distance(pair[1])).fold(0.0, f32::max);
    // Breathing moves the shoulder by some 0.2 mm a frame.
    assert!(step < 1e-3, "the elbow moves by {:.2} mm in a frame", step * 1000.0);
    let turns = elbows.windows(3).filter(|p| (p[1] - p[0]).dot(p[2] - p[1]) < -1e-9).count();
    assert!(turns < 12, "the elbow turned round {turns} times in 2 s");
}

#[test]
fn what_is_out_of_reach_is_pointed_at() {
    let (mut stage, walker) = stage();
    let far = Vec3::new(3.0, 1.6, -3.0);
    let hand = add(&mut stage, walker, IkChain::arm(RIGHT).toward(IkTarget::Point(far)));
    stage.run_for(1.5);
    let [shoulder, elbow, wrist] = ["rightUpperArm", "rightLowerArm", "rightHand"].map(|j| place(&stage, walker, j));
    let aside = (wrist - shoulder).angle_between(far - shoulder).to_degrees();
    let bend = (wrist - elbow).angle_between(elbow - shoulder).to_degrees();
    // The elbow is bent by 2.4° at rest, and goes no further back.
    assert!(aside < 0.2 && bend < 2.5, "the arm points {aside}° aside, bent by {bend}°");
    let result = result(&stage, hand);
    let missed = wrist.distance(far);
    assert!(!result.reached && (result.missed - missed).abs() < 1e-3, "it says {} m of {missed} m", result.missed);
}

#[test]
fn neck_and_chest_turn_the_eyes_to_what_is_near() {
    let (mut stage, walker) = stage();
    let thing = Vec3::new(-1.0, 1.3, -1.5);
    let eyes = Vec3::new(0.0, 0.085, -0.072);
    let head = IkChain::aim("chest", Head, Vec3::NEG_Z)
        .with_effector(eyes)
        .with_joint(ChainJointSetup::new("chest", RestLimit::cone(0.3)).giving(0.3))
        .with_joint(ChainJointSetup::new("upperChest", RestLimit::Fixed))
        .with_joint(ChainJointSetup::new("neck", RestLimit::cone(0.8)).giving(0.5))
        .with_joint(ChainJointSetup::new("head", RestLimit::cone(1.2)))
        .toward(IkTarget::Point(thing));
    let head = add(&mut stage, walker, head);
    stage.run_for(1.5);
    let result = result(&stage, head);
    assert!(result.reached, "{result:?}");
    let asset = stage.asset(walker).unwrap();
    let joint = asset.skeleton.find("head").unwrap();
    let rest = Pose::rest(&asset.skeleton).model(joint);
    let now = stage.get::<CharacterPose>(walker).unwrap().pose.model(joint);
    let turn = now * rest.inverse();
    let eye = now.transform_point3(rest.inverse().transform_vector3(eyes));
    let aside = turn.transform_vector3(Vec3::NEG_Z).angle_between(thing - eye).to_degrees();
    assert!(aside < 0.2, "the eyes look {aside}° aside");
}

#[test]
fn a_chain_with_a_misspelt_joint_leaves_the_pose_alone() {
    let (mut stage, walker) = stage();
    let hand = add(&mut stage, walker, IkChain::ccd("rightUperArm", "rightHand").toward(IkTarget::Point(NEAR)));
    stage.run_for(0.5);
    assert_eq!(result(&stage, hand), IkResult::default());
    assert!(stage.get::<IkState>(hand).unwrap().path().is_empty());
    let error = JointRef::from("rightUperArm").find(stage.asset(walker).unwrap());
    let text = error.unwrap_err().to_string();
    assert!(text.contains("did you mean `rightUpperArm`?"), "{text}");
    change(&mut stage, hand, |chain| chain.root = RightUpperArm.into());
    stage.run_for(1.5);
    assert!(result(&stage, hand).reached, "mended, it reaches");
}

#[test]
fn a_chain_goes_with_its_character() {
    let (mut stage, walker) = stage();
    let hand = add(&mut stage, walker, IkChain::arm(LEFT).toward(IkTarget::Point(NEAR)));
    stage.run_for(0.2);
    stage.app().world_mut().despawn(walker);
    stage.run_for(0.2);
    assert!(stage.get::<IkChain>(hand).is_none(), "the chain is still there");
}

#[test]
fn what_rides_on_a_joint_is_where_the_pose_of_the_same_frame_has_it() {
    let (mut stage, walker) = stage();
    let offset = Transform::from_xyz(0.0, -0.1, 0.02).with_rotation(Quat::from_rotation_x(0.4));
    let lantern = stage.app().world_mut().spawn((Attach::to(LeftHand).at(offset), ChildOf(walker))).id();
    stage.walk(walker, Vec3::new(0.8, 0.0, -1.2));
    let mut travelled = 0.0;
    let mut last = Vec3::ZERO;
    for _ in 0..120 {
        stage.run_for(1.0 / 60.0);
        let joint = stage.asset(walker).unwrap().skeleton.find("leftHand").unwrap();
        let root = stage.get::<Transform>(walker).unwrap().compute_affine();
        let model = stage.get::<CharacterPose>(walker).unwrap().pose.model(joint);
        let wanted = root * model * offset.compute_affine();
        let is = stage.get::<GlobalTransform>(lantern).unwrap().affine();
        // Between two ticks a joint's axes aren't quite square, those of what rides on it are.
        let (axes, place) =
            (is.matrix3.abs_diff_eq(wanted.matrix3, 2e-3), is.translation.abs_diff_eq(wanted.translation, 1e-5));
        assert!(axes && place, "at {is:?} instead of {wanted:?}");
        travelled += Vec3::from(is.translation).distance(last);
        last = is.translation.into();
    }
    assert!(travelled > 2.5, "it only moved {travelled} m");
}

#[test]
fn what_rides_on_a_joint_goes_with_the_character_or_stays_when_let_go() {
    let (mut stage, walker) = stage();
    let world = stage.app().world_mut();
    let [pack, dropped, lost] =
        ["upperChest", "leftHand", "leftHandd"].map(|joint| world.spawn((Attach::to(joint), ChildOf(walker))).id());
    stage.run_for(0.2);
    assert_eq!(stage.get::<Transform>(lost), Some(&Transform::IDENTITY), "a joint that isn't there moves nothing");
    stage.app().world_mut().commands().entity(dropped).remove_parent_in_place();
    stage.app().world_mut().flush();
    let at = stage.get::<Transform>(dropped).unwrap().translation;
    assert!(at.y > 0.5, "it was let go at {at}");
    stage.walk(walker, Vec3::NEG_Z).run_for(0.5);
    assert_eq!(stage.get::<Transform>(dropped).unwrap().translation, at, "it stays where it was let go");
    stage.app().world_mut().despawn(walker);
    stage.run_for(0.1);
    assert!(stage.get::<Character>(walker).is_none() && stage.get::<Attach>(pack).is_none(), "the pack is still there");
    assert!(stage.get::<Attach>(dropped).is_some(), "what was let go is gone");
}

#[test]
fn what_rides_on_a_joint_of_a_rig_in_centimetres_keeps_its_size() {
    let mut stage = Stage::on(&World::flat());
    let mut asset = stage.load_character("mannequin.character.ron").unwrap();
    let mut skeleton = (*asset.skeleton).clone();
    skeleton.model_from_root *= bevy::math::Affine3A::from_scale(Vec3::splat(0.5));
    asset.skeleton = skeleton.into();
    let walker = stage.spawn_loaded(asset, &[Transform::IDENTITY])[0];
    let hat = stage.app().world_mut().spawn((Attach::to(Head), ChildOf(walker))).id();
    stage.run_for(0.2);
    let scale = stage.get::<Transform>(hat).unwrap().scale;
    assert!(scale.abs_diff_eq(Vec3::ONE, 1e-4), "scaled by {scale}");
}

#[test]
fn limits_hold_wherever_the_target_is() {
    let (mut stage, walker) = stage();
    let chain = IkChain::arm(RIGHT).toward(IkTarget::Point(NEAR));
    let hand = add(&mut stage, walker, IkChain { half_life: 0.0, ..chain });
    for step in 0..200u16 {
        let angle = f32::from(step) * 0.31;
        let way = Quat::from_rotation_y(angle) * Quat::from_rotation_x(f32::from(step % 17) * 0.37);
        let at = Vec3::new(0.185, 1.4, 0.0) + way * Vec3::NEG_Z * (0.1 + 0.05 * f32::from(step % 13));
        change(&mut stage, hand, |chain| chain.target = IkTarget::Point(at));
        stage.run_for(1.0 / 60.0);
        let (excess, result) = (excess(&stage, hand), result(&stage, hand));
        assert!(excess < EXACT, "{excess} rad beyond a limit, with the target at {at}");
        let missed = place(&stage, walker, "rightHand").distance(at);
        assert!((missed - result.missed).abs() < 1e-3, "it says {} m of {missed} m", result.missed);
    }
}

#[test]
fn a_hand_that_reaches_lays_its_palm_on_the_target() {
    let (mut stage, walker) = stage();
    // Held out at rest, the palm looks down.
    let facing = |toward: Vec3, most: f32| Some(TipFacing { side: Vec3::NEG_Y, toward, most });
    let reaching = IkChain { facing: facing(Vec3::NEG_Y, 1.5), ..IkChain::arm(RIGHT) };
    let palm = Vec3::new(0.085, -0.03, 0.0);
    let chain = add(&mut stage, walker, reaching.with_effector(palm).toward(IkTarget::Point(NEAR)));
    let off = |stage: &Stage, toward: Vec3| {
        let asset = stage.asset(walker).unwrap();
        let hand = asset.humanoid.get(RightHand).unwrap();
        let rest = Pose::rest(&asset.skeleton).rotation(hand);
        let turn = stage.get::<CharacterPose>(walker).unwrap().pose.rotation(hand) * rest.inverse();
        (turn * Vec3::NEG_Y).angle_between(toward).to_degrees()
    };
    for toward in [Vec3::NEG_Y, Vec3::new(-0.7, -0.7, 0.0), Vec3::NEG_Z] {
        change(&mut stage, chain, |chain| chain.facing = facing(toward, 2.0));
        stage.run_for(1.0);
        let (off, result) = (off(&stage, toward), result(&stage, chain));
        assert!(off < 2.0, "toward {toward} the palm is {off:.1}° off");
        assert!(result.missed < 1e-3, "toward {toward} it misses by {} mm", result.missed * 1000.0);
        let step = greatest_step(&mut stage, walker, 20);
        assert!(step < 1.0, "toward {toward} a joint turns by {step}° in a frame though nothing moves");
    }
    change(&mut stage, chain, |chain| chain.facing = facing(Vec3::Y, 0.3));
    stage.run_for(1.0);
    let off = off(&stage, Vec3::Y);
    assert!(off > 60.0, "a wrist that turns by 17° at most has the palm only {off:.0}° from straight up");
}
