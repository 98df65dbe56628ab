//! An app without window or GPU, stepped frame by frame.

use core::time::Duration;
use std::path::Path;

use avian3d::prelude::*;
use bevy::{
    asset::{AssetPlugin, LoadState},
    prelude::*,
    time::TimeUpdateStrategy,
};

use super::{tape::Tape, world::World as Ground};
use crate::{
    SurefootPlugins,
    character::{Character, intent::MoveIntent, motion::MotionState, schedule::MotionSystems},
    measure::{
        frame::Frame,
        record::{MeasurePlugin, Recorder},
        summary::{Measures, summarize},
    },
    rig::{character::CharacterAsset, character_file::CharacterFile},
};

/// Why a stage could not be set.
#[derive(thiserror::Error, Debug)]
pub enum StageError {
    /// The character's file or something that it names could not be loaded.
    #[error("{path}: {reason}")]
    Load {
        /// The file asked for.
        path: String,
        /// What the loader says.
        reason: String,
    },
}

/// A headless app with a ground and characters on it.
pub struct Stage {
    app: App,
    dt: f32,
}

/// A tape, who hears it, and when it began.
#[derive(Resource)]
struct Playing {
    tape: Tape,
    characters: Vec<Entity>,
    began: Duration,
}

fn hear(time: Res<Time<Fixed>>, playing: Option<Res<Playing>>, mut intents: Query<&mut MoveIntent>) {
    let Some(playing) = playing else { return };
    // In the middle of the tick: where its ends fall, a rounding would decide which tick is the first to hear of a change.
    let now = time.elapsed().saturating_sub(playing.began).as_secs_f32() - 0.5 * time.timestep().as_secs_f32();
    let wanted = playing.tape.intent_at(now.max(0.0));
    for character in &playing.characters {
        if let Ok(mut intent) = intents.get_mut(*character) {
            *intent = wanted.clone();
        }
    }
}

/// Frames per second that measures are meant for.
const FRAME_RATE: f32 = 60.0;
/// Longest wait for a character's files, in updates of about a millisecond.
const LOAD_UPDATES: usize = 20_000;

impl Stage {
    /// A stage with this ground; asset paths are relative to the folder `assets`.
    #[must_use]
    pub fn new(ground: &Ground, assets: &Path) -> Self {
        Self::with(ground, assets, |_| ())
    }

    /// A stage with this ground and whatever `build` adds to its app.
    #[must_use]
    pub fn with(ground: &Ground, assets: &Path, build: impl FnOnce(&mut App)) -> Self {
        let mut app = App::new();
        app.add_plugins((
            MinimalPlugins,
            TransformPlugin,
            AssetPlugin { file_path: assets.to_string_lossy().into_owned(), ..default() },
            PhysicsPlugins::default(),
            SurefootPlugins,
            MeasurePlugin,
        ))
        .add_systems(FixedUpdate, hear.in_set(MotionSystems::Decide));
        build(&mut app);
        let mut stage = Self { app, dt: 1.0 / FRAME_RATE };
        stage.set_frame_rate(FRAME_RATE);
        for piece in &ground.pieces {
            stage.spawn_piece(piece);
        }
        stage.app.finish();
        stage.app.cleanup();
        stage.app.update();
        stage
    }

    /// A stage with this ground and the assets of this crate's source folder.
    #[must_use]
    pub fn on(ground: &Ground) -> Self {
        Self::new(ground, Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/assets")))
    }

    /// Frames per second from now on; the fixed clock stays as it is.
    pub fn set_frame_rate(&mut self, hertz: f32) {
        self.dt = 1.0 / hertz;
        let step = Duration::from_secs_f32(self.dt);
        self.app.insert_resource(TimeUpdateStrategy::ManualDuration(step));
    }

    /// The app itself.
    pub fn app(&mut self) -> &mut App {
        &mut self.app
    }

    /// Puts a character on the stage, its feet at `place`, and waits until it is loaded and bound.
    ///
    /// # Errors
    /// When its files can't be loaded.
    pub fn spawn_character(&mut self, path: &str, place: Transform) -> Result<Entity, StageError> {
        let handle = self.load(path)?;
        Ok(self.put(&handle, &[place])[0])
    }

    /// Puts characters of a loaded file on the stage, their feet at `places`.
    pub fn spawn_loaded(&mut self, asset: CharacterAsset, places: &[Transform]) -> Vec<Entity> {
        let handle = self.app.world_mut().resource_mut::<Assets<CharacterAsset>>().add(asset);
        self.put(&handle, places)
    }

    /// A character's file and all that it names.
    ///
    /// # Errors
    /// When it can't be loaded.
    pub fn load_character(&mut self, path: &str) -> Result<CharacterAsset, StageError> {
        let handle = self.load(path)?;
        let asset = self.app.world().resource::<Assets<CharacterAsset>>().get(&handle).cloned();
        asset.ok_or_else(|| StageError::Load { path: path.to_owned(), reason: "it vanished".to_owned() })
    }

    fn put(&mut self, handle: &Handle<CharacterAsset>, places: &[Transform]) -> Vec<Entity> {
        let bundles: Vec<_> =
            places.iter().map(|place| (Character(handle.clone()), *place, Recorder::default())).collect();
        let entities = self.app.world_mut().spawn_batch(bundles).collect();
        // One frame to bind, one to stand.
        self.app.update();
        self.app.update();
        entities
    }

    fn load(&mut self, path: &str) -> Result<Handle<CharacterAsset>, StageError> {
        let handle = self.app.world().resource::<AssetServer>().load(path.to_owned());
        self.wait_for(&handle, path)?;
        Ok(handle)
    }

    /// Waits until an asset is loaded, with time standing still. `path` is for the error's text.
    ///
    /// # Errors
    /// When it can't be loaded.
    pub fn wait_for<A: Asset>(&mut self, handle: &Handle<A>, path: &str) -> Result<(), StageError> {
        let error = |reason: String| StageError::Load { path: path.to_owned(), reason };
        self.app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::ZERO));
        let mut outcome = Err(error("still not loaded after 20 s".to_owned()));
        for _ in 0..LOAD_UPDATES {
            self.app.update();
            match self.app.world().resource::<AssetServer>().get_load_state(handle) {
                Some(LoadState::Loaded) => {
                    outcome = Ok(());
                    break;
                }
                Some(LoadState::Failed(reason)) => {
                    outcome = Err(error(reason.to_string()));
                    break;
                }
                _ => std::thread::sleep(Duration::from_millis(1)),
            }
        }
        self.set_frame_rate(1.0 / self.dt);
        outcome
    }

    /// Puts this crate's mannequin at the origin.
    ///
    /// # Errors
    /// When its files can't be loaded.
    pub fn spawn_walker(&mut self) -> Result<Entity, StageError> {
        self.spawn_character("mannequin.character.ron", Transform::IDENTITY)
    }

    /// Puts a solid on the stage.
    pub fn spawn_piece(&mut self, piece: &super::world::Piece) -> Entity {
        let body = if piece.motion.is_some() { RigidBody::Kinematic } else { RigidBody::Static };
        let mut entity = self.app.world_mut().spawn((body, piece.collider(), piece.transform));
        if let Some((velocity, turn)) = piece.motion {
            entity.insert((LinearVelocity(velocity), AngularVelocity(Vec3::Y * turn), TransformInterpolation));
        }
        entity.id()
    }

    /// What the character wants from now on.
    pub fn intend(&mut self, character: Entity, intent: MoveIntent) -> &mut Self {
        if let Some(mut wanted) = self.app.world_mut().get_mut::<MoveIntent>(character) {
            *wanted = intent;
        }
        self
    }

    /// Wanted velocity in m/s from now on.
    pub fn walk(&mut self, character: Entity, velocity: Vec3) -> &mut Self {
        self.intend(character, MoveIntent { velocity, ..default() })
    }

    /// Lets `seconds` pass.
    pub fn run_for(&mut self, seconds: f32) -> &mut Self {
        for _ in 0..(seconds / self.dt).round().max(0.0) as usize {
            self.app.update();
        }
        self
    }

    /// Plays a whole tape.
    pub fn play(&mut self, character: Entity, tape: &Tape) -> &mut Self {
        self.play_all(&[character], tape)
    }

    /// Plays a whole tape to all of them, tick by tick of the controller: the frame rate doesn't delay it.
    pub fn play_all(&mut self, characters: &[Entity], tape: &Tape) -> &mut Self {
        let began = self.app.world().resource::<Time<Virtual>>().elapsed();
        self.app.insert_resource(Playing { tape: tape.clone(), characters: characters.to_vec(), began });
        self.run_for(tape.seconds);
        self.app.world_mut().remove_resource::<Playing>();
        self
    }

    /// Turns foot IK of this character's file on or off.
    pub fn set_foot_ik(&mut self, character: Entity, enabled: bool) {
        self.tune(character, |file| file.foot_ik.enabled = enabled);
    }

    /// Changes what the stages read from this character's file every frame: everything but motion and locomotion.
    pub fn tune(&mut self, character: Entity, change: impl FnOnce(&mut CharacterFile)) {
        let world = self.app.world_mut();
        let Some(handle) = world.get::<Character>(character).map(|character| character.0.clone()) else { return };
        if let Some(asset) = world.resource_mut::<Assets<CharacterAsset>>().get_mut_untracked(&handle) {
            change(&mut asset.file);
        }
    }

    /// Forgets what was recorded.
    pub fn start_recording(&mut self, character: Entity) -> &mut Self {
        if let Some(mut recorder) = self.app.world_mut().get_mut::<Recorder>(character) {
            recorder.restart();
        }
        self
    }

    /// From now on records this character at moments `seconds` apart whatever the frame rate: see [`Recorder::every`].
    pub fn record_every(&mut self, character: Entity, seconds: f32) -> &mut Self {
        if let Some(mut recorder) = self.app.world_mut().get_mut::<Recorder>(character) {
            recorder.every = seconds;
        }
        self
    }

    /// Figures of what was recorded.
    #[must_use]
    pub fn measures(&self, character: Entity) -> Measures {
        summarize(self.frames(character))
    }

    /// What was recorded.
    #[must_use]
    pub fn frames(&self, character: Entity) -> &[Frame] {
        self.get::<Recorder>(character).map_or(&[], |recorder| &recorder.frames)
    }

    /// A component of the character.
    #[must_use]
    pub fn get<C: Component>(&self, character: Entity) -> Option<&C> {
        self.app.world().get::<C>(character)
    }

    /// The character's file, as loaded.
    #[must_use]
    pub fn asset(&self, character: Entity) -> Option<&CharacterAsset> {
        self.app.world().get_resource::<Assets<CharacterAsset>>()?.get(&self.get::<Character>(character)?.0)
    }

    /// Where the character stands, world.
    #[must_use]
    pub fn root(&self, character: Entity) -> Vec3 {
        self.get::<Transform>(character).map_or(Vec3::NAN, |transform| transform.translation)
    }

    /// Whether the character stands on ground.
    #[must_use]
    pub fn is_grounded(&self, character: Entity) -> bool {
        self.get::<MotionState>(character).is_some_and(|motion| motion.ground.is_some())
    }
}
