//! Synthetic bodies under every naming scheme, and under none.

mod tools;

use bevy::math::{Affine3A, Quat};
use proptest::prelude::*;

use self::tools::{TOOLS, named_by};
use super::*;
use crate::{
    anim::{matrix::JointMatrix, skeleton::JointTransform},
    math::rotation::from_scaled_axis,
};

/// A joint by its VRM name, what it hangs on, and where it is: metres, +Y up, facing +Z, left is +X.
type Joint = (&'static str, &'static str, [f32; 3]);

const TRUNK: &[Joint] = &[
    ("root", "", [0.0, 0.0, 0.0]),
    ("hips", "root", [0.0, 0.97, 0.0]),
    ("spine", "hips", [0.0, 1.06, 0.0]),
    ("chest", "spine", [0.0, 1.2, -0.01]),
    ("neck", "chest", [0.0, 1.46, -0.01]),
    ("head", "neck", [0.0, 1.56, 0.01]),
];
const LIMBS: &[Joint] = &[
    ("Shoulder", "chest", [0.03, 1.42, 0.0]),
    ("UpperArm", "Shoulder", [0.18, 1.42, -0.01]),
    ("LowerArm", "UpperArm", [0.46, 1.42, -0.02]),
    ("Hand", "LowerArm", [0.72, 1.42, -0.01]),
    ("Thumb", "Hand", [0.76, 1.41, 0.03]),
    ("Index", "Hand", [0.81, 1.42, 0.02]),
    ("Middle", "Hand", [0.82, 1.42, -0.01]),
    ("UpperLeg", "hips", [0.09, 0.93, 0.0]),
    ("LowerLeg", "UpperLeg", [0.09, 0.5, 0.01]),
    ("Foot", "LowerLeg", [0.09, 0.08, -0.02]),
    ("Toes", "Foot", [0.09, 0.02, 0.12]),
];

/// A body in parts that tests may bend, rename and hang up anew.
#[derive(Clone)]
struct Sample {
    joints: Vec<(String, Option<usize>, Vec3)>,
    /// Turn of each joint's own axes.
    axes: Quat,
    /// What the scene puts above the body.
    above: Vec<JointTransform>,
}

impl Sample {
    fn body() -> Self {
        let mut joints: Vec<(String, Option<usize>, Vec3)> = Vec::new();
        let mut add = |name: String, parent: String, at: Vec3| {
            let parent = joints.iter().position(|joint| joint.0 == parent);
            joints.push((name, parent, at));
        };
        for &(name, parent, at) in TRUNK {
            add(name.to_owned(), parent.to_owned(), Vec3::from(at));
        }
        for (side, mirror) in [("left", 1.0), ("right", -1.0)] {
            for &(name, parent, [x, y, z]) in LIMBS {
                let sided = TRUNK.iter().all(|joint| joint.0 != parent);
                let parent = if sided { format!("{side}{parent}") } else { parent.to_owned() };
                add(format!("{side}{name}"), parent, Vec3::new(mirror * x, y, z));
            }
        }
        Self { joints, axes: Quat::IDENTITY, above: Vec::new() }
    }

    fn renamed(mut self, name: impl Fn(&str, usize) -> String) -> Self {
        for (index, joint) in self.joints.iter_mut().enumerate() {
            joint.0 = name(&joint.0, index);
        }
        self
    }

    /// Without joints that `goes` picks by their place; their children hang on what they hung on.
    fn without(mut self, goes: &[&str]) -> Self {
        for name in goes {
            let Some(place) = self.joints.iter().position(|joint| joint.0 == *name) else { continue };
            let above = self.joints.remove(place).1;
            for joint in &mut self.joints {
                joint.1 = match joint.1 {
                    Some(parent) if parent == place => above,
                    Some(parent) if parent > place => Some(parent - 1),
                    other => other,
                };
            }
        }
        self
    }

    fn rig(&self) -> Rig {
        let mut list: Vec<(String, Option<JointIndex>, JointTransform)> = Vec::new();
        for (place, &transform) in self.above.iter().enumerate() {
            let parent = place.checked_sub(1).and_then(|parent| u16::try_from(parent).ok()).map(JointIndex);
            list.push((format!("node{place}"), parent, transform));
        }
        let first = list.len();
        let joint = |index: usize| JointIndex(u16::try_from(first + index).expect("few joints"));
        for (name, parent, at) in &self.joints {
            let parent_at = parent.map_or(Affine3A::IDENTITY, |parent| self.place(self.joints[parent].2));
            let local = parent_at.inverse() * self.place(*at);
            let (scale, rotation, translation) = local.to_scale_rotation_translation();
            let parent = parent.map(joint).or_else(|| first.checked_sub(1).map(|last| JointIndex(last as u16)));
            list.push((name.clone(), parent, JointTransform { translation, rotation, scale }));
        }
        let skin = crate::anim::skin::Skin {
            joints: (0..self.joints.len()).map(joint).collect(),
            inverse_bind: vec![JointMatrix::IDENTITY; self.joints.len()],
        };
        let skeleton = Skeleton::new(list, frame::gltf_default()).expect("parents come first");
        Rig { skeleton, skins: vec![skin], ..Rig::default() }
    }

    fn place(&self, at: Vec3) -> Affine3A {
        Affine3A::from_rotation_translation(self.axes, at)
    }

    /// The joints that were called after roles, by what plays the role now.
    fn check(&self, original: &Self, skip: &[Role]) {
        let rig = self.rig();
        let report = BindingReport::new(&rig, &Roles::Auto);
        for RoleReport { role, joint } in &report.roles {
            let Some(place) = original.joints.iter().position(|joint| joint.0 == role.spelling()) else { continue };
            if skip.contains(role) {
                continue;
            }
            let found = joint.as_ref().map(|joint| joint.0.as_str());
            assert_eq!(found, Some(self.joints[place].0.as_str()), "{}\n{report}", role.spelling());
        }
        let body = report.body.unwrap_or_else(|| panic!("{:?}", report.problem));
        let leg = body.leg_length;
        assert!((leg - 0.85).abs() < 0.03, "leg of {leg} m");
    }
}

#[test]
fn the_names_of_every_tool_bind() {
    let original = Sample::body();
    for tool in TOOLS {
        let sample = original.clone().renamed(|name, _| named_by(tool, name));
        sample.check(&original, &[]);
        let report = BindingReport::new(&sample.rig(), &Roles::Auto);
        let means = |role: Role| report.roles.iter().find(|part| part.role == role).and_then(|part| part.joint.clone());
        for role in [Role::LeftUpperLeg, Role::RightFoot, Role::LeftToes, Role::RightUpperArm, Role::LeftHand] {
            let (joint, means) = means(role).expect("it was just checked");
            assert_eq!(means, Means::Name, "{tool}: {} is `{joint}`", role.spelling());
        }
    }
}

#[test]
fn numbered_joints_bind_by_their_shape() {
    let original = Sample::body();
    let sample = original.clone().renamed(|_, index| format!("Bone_{:02}", index + 1));
    sample.check(&original, &[]);
    let report = BindingReport::new(&sample.rig(), &Roles::Auto).to_string();
    assert!(report.contains("leftUpperLeg   `Bone_14`, from the shape at rest"), "{report}");
    assert!(report.contains("forward is +Z, told by toes"), "{report}");
}

#[test]
fn parts_without_a_name_are_found_between_and_below_named_ones() {
    let original = Sample::body();
    let sample = original.clone().renamed(|name, _| match name {
        "leftFoot" => "hoof".to_owned(),
        "rightLowerLeg" => "stilt".to_owned(),
        "rightToes" => "claw".to_owned(),
        _ => name.to_owned(),
    });
    sample.check(&original, &[]);
    let report = BindingReport::new(&sample.rig(), &Roles::Auto).to_string();
    assert!(report.contains("leftFoot       `hoof`, from what hangs where"), "{report}");
}

#[test]
fn a_body_without_toes_shoulders_neck_and_fingers_binds_too() {
    let gone = ["Toes", "Shoulder", "Thumb", "Index", "Middle"];
    let gone: Vec<String> = gone.iter().flat_map(|part| [format!("left{part}"), format!("right{part}")]).collect();
    let mut gone: Vec<&str> = gone.iter().map(String::as_str).collect();
    gone.push("neck");
    let original = Sample::body().without(&gone);
    original.check(&original, &[]);
    original.clone().renamed(|_, index| format!("Bone{index}")).check(&original, &[]);
}

#[test]
fn a_body_that_lies_in_a_z_up_file_stands_up() {
    let original = Sample::body();
    // Z up, facing -Y, as modelling tools have it.
    let up = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
    for named in [true, false] {
        let mut sample = original.clone();
        sample.joints.iter_mut().for_each(|joint| joint.2 = up * joint.2);
        let sample = if named { sample } else { sample.renamed(|_, index| format!("b{index}")) };
        sample.check(&original, &[]);
        let body = BindingReport::new(&sample.rig(), &Roles::Auto).body.expect("it binds");
        assert_eq!((body.up, body.forward), (Vec3::Z, Vec3::NEG_Y), "named: {named}");
    }
}

#[test]
fn centimetres_and_scaled_ancestors_come_out_in_metres() {
    let original = Sample::body();
    let mut bare = original.clone();
    bare.joints.iter_mut().for_each(|joint| joint.2 *= 100.0);
    bare.check(&original, &[]);
    let mut scaled = bare.clone();
    scaled.above = vec![JointTransform { scale: Vec3::splat(0.01), ..JointTransform::IDENTITY }];
    scaled.check(&original, &[]);
    let mut twice = original.clone();
    twice.above = vec![JointTransform { scale: Vec3::splat(0.01), ..JointTransform::IDENTITY }];
    twice.check(&original, &[]);
}

#[test]
fn mirrored_ancestors_change_sides_and_the_report_says_so() {
    let original = Sample::body();
    let mut sample = original.clone();
    sample.above = vec![JointTransform { scale: Vec3::new(-1.0, 1.0, 1.0), ..JointTransform::IDENTITY }];
    let report = BindingReport::new(&sample.rig(), &Roles::Auto);
    let left = report.roles.iter().find(|part| part.role == Role::LeftFoot).and_then(|part| part.joint.clone());
    assert_eq!(left.map(|joint| joint.0).as_deref(), Some("rightFoot"), "what is called right is on the left");
    assert!(report.notes.iter().any(|note| note.contains("swapped")), "{report}");
    let body = report.body.expect("it binds");
    let sides = body.legs.map(|leg| leg.sole[0].x);
    assert!(sides[0] < -0.05 && sides[1] > 0.05, "left heel at {}, right at {} m", sides[0], sides[1]);
}

#[test]
fn a_quadruped_is_refused_and_told_what_to_write() {
    let mut dog = Sample { joints: Vec::new(), axes: Quat::IDENTITY, above: Vec::new() };
    let mut add = |name: &str, parent: Option<usize>, at: [f32; 3]| {
        dog.joints.push((name.to_owned(), parent, Vec3::from(at)));
        Some(dog.joints.len() - 1)
    };
    let hips = add("hips", None, [0.0, 0.6, -0.4]);
    let chest = add("chest", hips, [0.0, 0.62, 0.3]);
    let head = add("head", chest, [0.0, 0.8, 0.6]);
    add("nose", head, [0.0, 0.78, 0.75]);
    let tail = add("tail", hips, [0.0, 0.6, -0.6]);
    add("tail_end", tail, [0.0, 0.5, -0.9]);
    for (names, above, z) in
        [(["UpperLeg", "LowerLeg", "Foot"], hips, -0.4), (["UpperArm", "LowerArm", "Hand"], chest, 0.3)]
    {
        for (side, x) in [("left", 0.12), ("right", -0.12)] {
            let upper = add(&format!("{side}{}", names[0]), above, [x, 0.55, z]);
            let lower = add(&format!("{side}{}", names[1]), upper, [x, 0.3, z + 0.03]);
            add(&format!("{side}{}", names[2]), lower, [x, 0.05, z]);
        }
    }
    for dog in [dog.clone(), dog.clone().renamed(|_, index| format!("Bone_{index}"))] {
        let report = BindingReport::new(&dog.rig(), &Roles::Auto);
        assert!(matches!(report.problem, Some(HumanoidError::FourLegs { .. })), "{report}");
        assert!(report.to_string().contains("roles: Explicit({"), "{report}");
        // The lines to write are there in full, hind legs or front ones.
        assert!(!report.ron().contains('…'), "{report}");
    }
    // Who insists, walks on the two that are named.
    let legs = ["Hips", "UpperLeg", "LowerLeg", "Foot"];
    let told = Role::ALL.into_iter().filter(|role| legs.iter().any(|part| format!("{role:?}").ends_with(part)));
    let told = Roles::Explicit(told.map(|role| (role, role.spelling())).collect());
    let report = BindingReport::new(&dog.rig(), &told);
    assert!(report.is_bound(), "{report}");
    assert!(report.notes.iter().any(|note| note.contains("it walks on those that are named")), "{report}");
}

#[test]
fn a_leg_with_a_joint_of_another_limb_is_refused() {
    let told = [(Role::LeftFoot, "rightHand"), (Role::LeftUpperLeg, "leftUpperLeg")];
    let told = Roles::Explicit(told.map(|(role, joint)| (role, joint.to_owned())).into());
    let report = BindingReport::new(&Sample::body().without(&["leftToes", "rightToes"]).rig(), &told);
    let problem = report.problem.as_ref().expect("a hand is no foot").to_string();
    assert!(problem.contains("the left leg (`leftUpperLeg`, `leftLowerLeg`, `rightHand`) is"), "{problem}");
    assert!(problem.contains("one of their joints is another part's"), "{problem}");
}

#[test]
fn a_rig_without_legs_is_refused_with_what_is_missing() {
    let legs = ["UpperLeg", "LowerLeg", "Foot", "Toes"];
    let gone: Vec<String> = legs.iter().flat_map(|part| [format!("left{part}"), format!("right{part}")]).collect();
    let gone: Vec<&str> = gone.iter().map(String::as_str).collect();
    let report = BindingReport::new(&Sample::body().without(&gone).rig(), &Roles::Auto);
    let problem = report.problem.as_ref().expect("nothing to walk on").to_string();
    assert!(
        problem.contains("no joint found for") && problem.contains("leftUpperLeg, leftLowerLeg, leftFoot"),
        "{problem}"
    );
    let text = report.to_string();
    assert!(text.contains("leftFoot       missing, and needed") && text.contains("    leftFoot: \"…\",\n"), "{text}");
    assert!(text.contains("head           `head`, by name"), "{text}");
}

#[test]
fn a_map_of_the_model_weighs_more_than_names() {
    let original = Sample::body();
    let sample = original.clone().renamed(|_, index| format!("骨{index}"));
    let mut rig = sample.rig();
    let place = |name: &str| original.joints.iter().position(|joint| joint.0 == name).expect("it is there");
    rig.told_roles = vec![(Role::Chest, JointIndex(place("spine") as u16))];
    let report = BindingReport::new(&rig, &Roles::Auto);
    let chest = report.roles.iter().find(|part| part.role == Role::Chest).and_then(|part| part.joint.clone());
    assert_eq!(chest, Some((format!("骨{}", place("spine")), Means::Vrm)), "{report}");
}

proptest! {
    /// Bodies of any proportion, posture, size and joint axes, none of whose joints has a telling name.
    #[test]
    fn any_body_binds_by_its_shape(
        stretch in (0.7f32..1.4, 0.7f32..1.4),
        wide in 0.8f32..2.0,
        arms_down in 0.0f32..1.1,
        lean in -0.1f32..0.1,
        axis in (-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0),
        yaw in 0usize..4,
    ) {
        let original = Sample::body();
        let mut sample = original.clone();
        for (name, _, at) in &mut sample.joints {
            // Legs, trunk and width each in their own measure.
            let hip = 0.97;
            at.y = if at.y < hip { at.y } else { hip + (at.y - hip) * stretch.0 };
            at.x *= if at.y < hip { wide } else { stretch.1 };
            let shoulder = Vec3::new(0.18 * stretch.1 * at.x.signum(), hip + (1.42 - hip) * stretch.0, at.z);
            if ["LowerArm", "Hand", "Thumb", "Index", "Middle"].iter().any(|part| name.ends_with(part)) {
                let turn = from_scaled_axis(Vec3::Z * (-arms_down * at.x.signum()));
                *at = shoulder + turn * (*at - shoulder);
            }
            *at = from_scaled_axis(Vec3::X * lean) * *at;
            *at = Quat::from_rotation_y(yaw as f32 * core::f32::consts::FRAC_PI_2) * *at;
        }
        sample.axes = from_scaled_axis(Vec3::new(axis.0, axis.1, axis.2));
        let sample = sample.renamed(|_, index| format!("Bone_{index:02}"));
        sample.check(&original, &[]);
    }
}
