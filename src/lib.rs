//! Characters whose feet stay where they land.
//!
//! Layers, bottom to top; a file imports lower layers, or earlier stages of its own:
//! [`math`] → [`anim`] → [`rig`] → [`character`] → `skinning`, [`measure`], `debug` → [`testing`] → `terrain`, `camera` → `game`.
//!
//! A model of your own: [Bring your own character](rig::guide).
//!
//! Model space everywhere: metres, +Y up, the character faces -Z.
//!
//! # Layers and actions
//!
//! Locomotion moves the whole body; what is laid over it leaves the legs alone, so feet stay planted. An *action* plays a clip
//! on a part of the body, by name, with a fade at both ends: [`Actions`](character::animator::Actions), which every character
//! has. Several play at once, later ones over earlier ones.
//!
//! ```
//! use bevy::prelude::*;
//! use surefoot::character::animator::Actions;
//!
//! fn greet(mut characters: Query<&mut Actions>) {
//!     for mut actions in &mut characters {
//!         actions.play("wave");
//!     }
//! }
//! # bevy::ecs::system::assert_is_system(greet);
//! ```
//!
//! Every clip is an action of the upper body; the character's file says where one differs: on which joints it plays
//! ([masks](anim::mask)), how it fades, whether it is added to what plays.
//!
//! ```
//! # use surefoot::rig::character_file::CharacterFile;
//! let file = CharacterFile::parse(
//!     r#"(actions: {
//!         "wave": (root: Role(rightShoulder), feather: 1),
//!         "breathe": (clip: "idle", additive: true, looping: true, weight: 0.5),
//!     })"#,
//! )?;
//! # assert_eq!(file.actions.map(|actions| actions.len()), Some(2));
//! # Ok::<(), surefoot::rig::character_file::CharacterFileError>(())
//! ```
//!
//! [`MoveIntent::aim`](character::intent::MoveIntent::aim) raises an arm and turns the head to point along a direction, up and
//! down too, while the legs walk, strafe or back off; `facing` beside it keeps the body turned that way.
//!
//! ```
//! use bevy::prelude::*;
//! use surefoot::character::intent::MoveIntent;
//!
//! let view = Vec3::new(0.0, 0.3, -1.0);
//! let intent = MoveIntent { velocity: Vec3::X, facing: Some(view), aim: Some(view), ..default() };
//! # assert!(intent.is_sound());
//! ```
//!
//! # Crowds
//!
//! A [`Detail`](character::detail::Detail) says how often and how thoroughly a character is posed, and how seldom its controller
//! looks where it goes. What lies between poses is blended, feet and gaze fade, and who is hidden keeps its place and its phase.
//! Who is far enough is posed by its clips alone (`clips_only`), together with all others of its kind, ten times as cheap; put a
//! [`PoseRead`](character::crowd::PoseRead) on those whose [`CharacterPose`](character::animator::CharacterPose) you read in any case.
//! With the feature `render` a `ScreenDetail` sets it by the character's size on the screen, as the resource
//! [`DetailLevels`](character::levels::DetailLevels) says, and draws who is small with fewer triangles, where that is off by less than
//! a pixel: simplified meshes of any model are made in the background. The player's own character has neither. Frames that a crowd fills are
//! posed once each by [`PoseClock::at_most(1)`](character::schedule::PoseClock::at_most); on few cores Bevy keeps one thread
//! for all of this unless `TaskPoolOptions::compute` says more.
//!
//! ```
//! use bevy::prelude::*;
//! use surefoot::character::{Character, detail::Detail};
//!
//! fn spawn_passer_by(mut commands: Commands, assets: Res<AssetServer>) {
//!     let far = Detail { clips_only: true, small_joints: false, glide: 0.1, ..default() };
//!     commands.spawn((Character(assets.load("mannequin.character.ron")), far));
//! }
//! # bevy::ecs::system::assert_is_system(spawn_passer_by);
//! ```

pub mod anim;
pub mod character;
pub mod math;
pub mod measure;
pub mod rig;
pub mod testing;

#[cfg(feature = "game")]
pub mod camera;
#[cfg(feature = "render")]
pub mod debug;
#[cfg(feature = "game")]
pub mod game;
#[cfg(feature = "render")]
pub mod skinning;
#[cfg(feature = "game")]
pub mod terrain;

mod plugins;

pub use plugins::SurefootPlugins;

/// The code of the README compiles.
#[cfg(all(doctest, feature = "game"))]
#[doc = include_str!("../README.md")]
struct Readme;
