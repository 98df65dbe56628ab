//! # Bring your own character
//!
//! A model of a body on two legs walks without any set-up: its file is the character.
//!
//! ```
//! use bevy::prelude::*;
//! use surefoot::character::Character;
//!
//! fn spawn(mut commands: Commands, assets: Res<AssetServer>) {
//!     commands.spawn((Character::from(assets.load("knight.glb")), Transform::from_xyz(0.0, 1.0, 0.0)));
//! }
//! ```
//!
//! What happens on loading: the joints that make a body are [found](super::binding), the file is turned to stand upright and
//! look along -Z in metres, its soles are laid on the ground, its own clips play in the
//! [standard states](super::tuning::standard) that [their names tell](super::own_clips), `Walking_A` or `Armature|Idle`, and
//! every clip that is still wanted is taken from this crate's mannequin and made to fit. The controller's figures are brought to
//! the body's size: one with legs half as long walks 0.7 times as fast. `.glb`, `.gltf` and `.vrm` files will do.
//!
//! As soon as something is to differ, a `.character.ron` beside the model says what; all it needs is the model's name:
//!
//! ```
//! # use surefoot::rig::character_file::CharacterFile;
//! let file = CharacterFile::parse(r#"(model: "knight.glb")"#)?;
//! assert!(file.standard_clips);
//! # Ok::<(), surefoot::rig::character_file::CharacterFileError>(())
//! ```
//!
//! # See what was found
//!
//! [`BindingReport`](super::binding::BindingReport) tells in words which joint plays which part and how that was found, where
//! up and forward are, how long the legs are, about which axis knees turn, where the soles lie, and which lines to write in
//! the RON to change it. `surefoot view knight.glb --check` prints it, `surefoot view knight.glb` shows the model in its clips and
//! walks it over the course, and with `--film` that becomes a sheet of pictures. In code:
//!
//! ```no_run
//! use surefoot::rig::{Rig, binding::BindingReport, character_file::Roles};
//!
//! let bytes = std::fs::read("knight.glb")?;
//! let rig = Rig::from_slice(&bytes, |uri| std::fs::read(uri).map_err(|error| error.to_string()))?;
//! let report = BindingReport::new(&rig, &Roles::Auto);
//! println!("{report}");
//! assert!(report.is_bound());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # A Mixamo-like model
//!
//! Bodies with names such as `mixamorig:LeftUpLeg` bind by name. They come in centimetres below a node scaled by 0.01, which is
//! of no matter, and mostly with one clip a file. Clips of other files join by name:
//!
//! ```
//! # use surefoot::rig::character_file::CharacterFile;
//! let file = CharacterFile::parse(
//!     r#"(
//!         model: "vanguard.glb",
//!         clips: {
//!             "walk": (file: "Walking.glb", clip: "mixamo.com", looping: true),
//!             "wave": (file: "Waving.glb", clip: "mixamo.com"),
//!         },
//!     )"#,
//! )?;
//! assert_eq!(file.clips.len(), 2);
//! # Ok::<(), surefoot::rig::character_file::CharacterFileError>(())
//! ```
//!
//! `walk` is a name that a standard state plays and `wave` that of a standard action, so that nothing else is to be said; the
//! other states keep the mannequin's clips. Download clips "in place": root motion left in a clip counts for how fast its feet go, but the
//! controller moves the body.
//!
//! # A VRM-like model
//!
//! VRM files bring a map of the body, which is taken before any name is looked at; joints may be called as they like. Without
//! the map, VRM's names (`leftUpperLeg`, `J_Bip_L_UpperLeg`) bind by themselves. Arms of such models are held out at rest, those
//! of others hang: retargeting makes up for it, and takes more or less of a motion where a body asks for it.
//!
//! ```
//! # use surefoot::rig::character_file::CharacterFile;
//! let file = CharacterFile::parse(
//!     r#"(
//!         model: "alicia.vrm",
//!         // A slim body in a wide skirt: arms swing less, and a little farther out.
//!         retarget: (arms: 0.8, arm_spread: 8.0),
//!     )"#,
//! )?;
//! assert!((file.retarget.arm_spread.to_degrees() - 8.0).abs() < 1e-3);
//! # Ok::<(), surefoot::rig::character_file::CharacterFileError>(())
//! ```
//!
//! # A rig made by hand
//!
//! Where joints are called `Bone_01`, `Bone_02` and so on, the body is told from its shape: the longest pair of mirrored limbs
//! that reach the ground are the legs, what carries both is the pelvis. Z-up files, files in centimetres and mirrored ones are
//! stood upright. What the shape doesn't tell, the file does; parts that it leaves out are still found:
//!
//! ```
//! # use surefoot::rig::{character_file::{CharacterFile, Roles}, humanoid::HumanoidRole};
//! let file = CharacterFile::parse(
//!     r#"(
//!         model: "golem.glb",
//!         roles: Explicit({leftFoot: "Bone_17", rightFoot: "Bone_23", head: "Lantern"}),
//!         // Stone feet of its own: where the left sole meets the ground, (left, up, forward) in metres.
//!         soles: (heel: (0.3, 0.0, -0.2), ball: (0.3, 0.0, 0.15), tip: (0.3, 0.0, 0.4)),
//!         clips: {"idle": (clip: "Golem|Breathe"), "walk": (clip: "Golem|Stomp", ground_speed: 0.9)},
//!     )"#,
//! )?;
//! let Roles::Explicit(roles) = &file.roles else { unreachable!() };
//! assert_eq!(roles[&HumanoidRole::LeftFoot], "Bone_17");
//! # Ok::<(), surefoot::rig::character_file::CharacterFileError>(())
//! ```
//!
//! # From another body's clip to this one's
//!
//! Clips of a file whose skeleton has the same joints at rest are taken as they are. Others are retargeted by the parts that
//! joints play, whatever their axes: each turns, in model space, as its partner does against the partner's own rest pose;
//! arms and legs point where the source's point, even if one body rests with its arms out and the other with its arms down;
//! feet that are flat stay flat, and long ones turn less;
//! spines of different numbers of joints share the turn out. The pelvis goes as far as the legs are longer or shorter. At last
//! the legs are put by IK so that each ball goes the source's way, scaled, and each sole is exactly as high: contacts stay
//! contacts. Where shorter feet would have the legs stretch farther than the source's, the pelvis is a little lower. Bodies of another size step in times that go with the root of their legs' length, as pendulums do, when they walk
//! with the mannequin's clips. Every field of [`RetargetConfig`](super::tuning::retarget::RetargetConfig) may be set in the file.
//!
//! # Its own clips
//!
//! A clip whose name says no more than what it is, `Robot_Walking`, `Jog_Fwd`, `Strafe Left`, `Rig|Jump_Idle`, plays in the state
//! of that name, if it ends as it begins and its feet do what the state does; `surefoot view` tells which are taken and why
//! others aren't. Jumps, landings and turns have to fit the controller to a tenth of a second, so they are taken only under the
//! state's own name. What plays is decided by the file, first of all:
//!
//! ```
//! # use surefoot::rig::character_file::CharacterFile;
//! let file = CharacterFile::parse(
//!     r#"(
//!         model: "robot.glb",
//!         clips: {
//!             // Another one than the name tells, and one that no name tells.
//!             "walk": (clip: "Robot_March", ground_speed: 1.1),
//!             "jump": (clip: "Robot_Leap"),
//!         },
//!         // Or none by name at all: own_clips: false,
//!         // Figures as they stand, whatever the body's size.
//!         fit_motion: false,
//!         motion: (walk_speed: 1.1, height: 1.3, crouch_height: 1.0),
//!     )"#,
//! )?;
//! assert!(file.own_clips && !file.fit_motion);
//! # Ok::<(), surefoot::rig::character_file::CharacterFileError>(())
//! ```
//!
//! Every clip can be played over what the body does, too: `actions.play("Robot_ThumbsUp")`, by
//! [`Actions`](crate::character::animator::Actions).
//!
//! # Its face
//!
//! Morph targets go with the clips that move them, and by name where the game wants them: `morphs.set("smile", 0.8)` on the
//! component [`Morphs`](../../skinning/struct.Morphs.html), until `morphs.release("smile")`. Expressions of VRM models, sets of
//! targets with a name, go by `morphs.express("happy", 0.8)` and end at 0; those of VRM 0.x have the names of 1.0 (`joy` is
//! `happy`, `a` is `aa`). Eyes blink by themselves where the model has an expression or a target for it; `blink` in the file
//! says how often, and by which one if names don't tell.
//!
//! # Hold it to the measures
//!
//! The harness that tests the mannequin takes any character:
//!
//! ```no_run
//! use std::path::Path;
//! use bevy::math::Vec3;
//! use surefoot::testing::{Stage, World};
//!
//! let mut stage = Stage::new(&World::hills(), Path::new("assets"));
//! let knight = stage.spawn_character("knight.glb", Default::default())?;
//! stage.walk(knight, Vec3::NEG_Z * 1.2).run_for(5.0);
//! let measures = stage.measures(knight);
//! assert!(measures.float_p95 < 10.0, "feet float {} mm over the ground", measures.float_p95);
//! # Ok::<(), surefoot::testing::StageError>(())
//! ```
//!
//! # Errors you may meet
//!
//! | it says | and means |
//! |---|---|
//! | `no joint found for leftFoot; found: …` | Neither names nor shape tell the part. Name it in `roles: Explicit({leftFoot: "…"})`. |
//! | `this is a body on four legs` | Two pairs of limbs reach the ground and the trunk lies. If it walks on two nevertheless, name hips and legs; a warning stays. |
//! | `the left leg … and the right one …: one of their joints is another part's` | Legs of a pair are about as long as each other: a joint of another limb was named. |
//! | `leftLowerLeg … does not hang below leftUpperLeg` | The limb can't carry it. Name the joints that hang together; feet alone may hang elsewhere. |
//! | `… that bone has no length` | Two joints of a leg in one place: another one is meant. |
//! | `left and right are swapped in the joint names` | A note: toes point the other way than the names say, as after mirroring. Sides were changed. |
//! | `` `Run` is called like `run` but … `` | A remark of `surefoot view`: the mannequin's clip plays instead. Make the clip a loop, or name it in `clips`. |
//! | `… which the model doesn't have (did you mean …?)` | A joint, clip or state is misspelt; all that exist are listed. |
//! | `no joint that … moves has a partner` | The clip's file moves another kind of body, and no names agree. |
//! | `glTF element …`, `accessor …`, `clip …`, `skin …`, `mesh …, vertex …` | The file itself is broken; the message names the element. Export it again. |
//! | `the file requires the extension …` | Its data are compressed in a way this importer doesn't read. Export without. |
