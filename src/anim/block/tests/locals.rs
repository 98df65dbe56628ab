//! Clips of a set against the scalar functions, joint by joint.

use proptest::prelude::*;

use super::{all_instructions, plays, reference::body};
use crate::anim::{
    blend::Accumulator,
    block::{ClipSet, LocalWorkspace},
    skeleton::JointTransform,
};

/// Largest difference of two poses' numbers; rotations whatever their sign.
fn difference(got: &[JointTransform], wanted: &[JointTransform]) -> f32 {
    let off = got.iter().zip(wanted).map(|(a, b)| {
        let side = if a.rotation.dot(b.rotation) < 0.0 { -b.rotation } else { b.rotation };
        let turned = (a.rotation - side).length();
        turned.max(a.translation.distance(b.translation)).max(a.scale.distance(b.scale))
    });
    off.fold(0.0, f32::max)
}

proptest! {
    #[test]
    fn a_set_gives_the_poses_of_the_scalar_functions(body in body(1..24, 0.4), plays in plays()) {
        let skeleton = &body.skeleton;
        let set = ClipSet::new(skeleton, &body.clips[..3], skeleton.joints());
        let (mut sampled, mut wanted) = (skeleton.rest().to_vec(), skeleton.rest().to_vec());
        let mut blend = Accumulator::new(&mut wanted);
        for play in &plays {
            body.clips[play.clip].sample(skeleton, play.time, &mut sampled);
            blend.add(&sampled, play.weight);
        }
        let heard = blend.finish();
        for instructions in all_instructions() {
            let mut got = skeleton.rest().to_vec();
            prop_assert_eq!(set.sample(&plays, &mut LocalWorkspace::with(instructions), &mut got), heard);
            let off = difference(&got, &wanted);
            prop_assert!(off < 1e-5, "{off:e} off");
        }
        for play in &plays {
            body.clips[play.clip].sample(skeleton, play.time, &mut wanted);
            prop_assert!(set.sample_watched(play.clip, play.time, &mut sampled));
            let off = difference(&sampled, &wanted);
            prop_assert!(off < 1e-5, "{off:e} off where joints are watched");
        }
    }
}

#[test]
fn what_a_set_does_not_hold_is_left_to_others() {
    let body = super::Dice(7).body(5, 0.3);
    let set = ClipSet::new(&body.skeleton, [], []);
    let mut out = body.skeleton.rest().to_vec();
    let plays = [super::Play { clip: 0, time: 0.0, weight: 1.0 }];
    assert!(!set.sample(&plays, &mut LocalWorkspace::default(), &mut out));
    assert!(!set.sample_watched(0, 0.0, &mut out));
    assert_eq!(out, body.skeleton.rest());
}
