//! Limbs in blocks against [`two_bone`](crate::anim::ik::two_bone).

use super::{super::Goal, reference::posed, *};
use crate::math::rotation::from_scaled_axis;

/// The last joint with at least two above it, and a limb of those; one joint is between its bones' where there are three.
fn limb_of(body: &Body) -> Option<LimbJoints> {
    let parent = |joint: JointIndex| body.skeleton.parent(joint);
    let limb = |end: JointIndex| {
        let lower = parent(end)?;
        let above = parent(lower)?;
        Some(LimbJoints { upper: parent(above).unwrap_or(above), lower, end, extension: Extension::default() })
    };
    body.skeleton.joints().filter_map(limb).last()
}

/// How much a palette changes when the target moves by a thousandth of a millimetre, or time by a millionth of a second:
/// nearly straight or folded limbs, and those that swing round to the opposite side, make much of little.
fn sway(body: &Body, limbs: &[LimbJoints], actor: &Actor, palette_there: &[JointMatrix]) -> f32 {
    let beside = |offset: Vec3, later: f32| {
        let goals: Vec<_> =
            actor.goals.iter().map(|goal| goal.map(|goal| Goal { target: goal.target + offset, ..goal })).collect();
        let clips: Vec<_> =
            actor.layers[0].clips.iter().map(|play| Play { time: play.time + later, ..*play }).collect();
        let layers = [Layer { clips: &clips, ..actor.layers[0] }];
        difference(&palette(body, limbs, &Actor { goals: &goals, layers: &layers, ..*actor }), palette_there)
    };
    let moved = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| beside(axis * 1e-6, 0.0)).into_iter().fold(0.0, f32::max);
    moved.max(beside(Vec3::ZERO, 1e-6))
}

/// Whether rounding alone may turn the limb's bones: it is straight, it can't fold as far as its goal is near, or it swings
/// round to the opposite side.
fn is_delicate(body: &Body, limb: LimbJoints, actor: &Actor) -> bool {
    let Some(goal) = actor.goals[0] else { return false };
    let pose = posed(body, actor);
    let [root, middle, end] = [limb.upper, limb.lower, limb.end].map(|joint| pose.position(joint));
    let (upper, wanted) = (middle - root, goal.target - root);
    let shortest = (upper.length() - middle.distance(end)).abs();
    let (old, new) = ((end - root).normalize_or_zero(), wanted.normalize_or_zero());
    let bend = upper.normalize_or_zero().cross(old).length();
    wanted.length() < 1.05 * shortest + 0.01 || bend < 0.05 || old.dot(new) < -0.95
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn limbs_reach_in_blocks_as_they_do_alone(body in body(8..24, 0.0), seed in any::<u64>()) {
        let Some(limb) = limb_of(&body) else { return Ok(()) };
        let size = body.skeleton.model_from_root.x_axis.length();
        // Bones of millimetres a metre from the origin are turned by the rounding of positions alone.
        prop_assume!(size > 0.5);
        let limbs = [limb];
        let Body { skeleton, skin, clips, .. } = &body;
        let sources: Vec<_> = clips.iter().map(|clip| RowSource::new(clip, Precision::Float)).collect();
        let parts = SpeciesParts { skeleton, skin, limbs: &limbs, clips: &sources, masks: &[] };
        let species = Species::new(&parts).unwrap();
        let mut dice = Dice(seed);
        let goals: Vec<_> = (0..9).map(|_| [dice.chance(0.8).then(|| Goal {
            target: skeleton.model_from_root.translation.to_vec3() + dice.vector(2.0 * size),
            pole: dice.vector(1.0),
            end_turn: from_scaled_axis(dice.vector(1.0)),
        })]).collect();
        let clips: Vec<_> = (0..9).map(|_| [Play { clip: 0, time: dice.between(0.0, 1.0), weight: 1.0 }]).collect();
        let layers: Vec<_> = clips.iter().map(|clips| [Layer { weight: 1.0, clips, ..Layer::default() }]).collect();
        let actors: Vec<_> = layers.iter().zip(&goals)
            .map(|(layers, goals)| Actor { layers, goals, ..Actor::default() }).collect();
        for matrices in palettes(&species, &actors) {
            for (index, actor) in actors.iter().enumerate() {
                let got = &matrices[index * species.slot_count()..][..species.slot_count()];
                let wanted = palette(&body, &limbs, actor);
                let (off, sway) = (difference(got, &wanted), sway(&body, &limbs, actor, &wanted));
                let bar = if is_delicate(&body, limb, actor) { 1e-3 } else { 1e-5 };
                prop_assert!(off < bar + 10.0 * sway, "character {index}: {off:e} off, where it sways by {sway:e}");
            }
        }
    }
}
