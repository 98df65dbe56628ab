//! The controller: `MoveIntent` → a moved root and `MotionState`, on the fixed clock.
//!
//! Reads [`MoveIntent`], [`MotionConfig`] and avian's colliders; writes `Transform`, avian's `Position`, `Rotation` and
//! `LinearVelocity`, and [`MotionState`]. World space; the root is the point on the ground between the feet.
//!
//! On the ground a capsule *above step height* slides along walls and a ball is lowered from it to find what bears the
//! body; in the air the whole capsule flies. The root follows the ground under its middle, and steps of it smoothly.

mod ahead;
mod around;
mod body;
mod capsule;
mod capsules;
mod casts;
mod contacts;
mod descent;
mod field;
mod fly;
mod footing;
mod frame;
mod glide;
mod heightfield;
mod jump;
mod movers;
mod place;
mod planes;
mod report;
mod slide;
mod slope;
mod space;
mod speed;
mod tick;
mod turn;
mod walk;

use avian3d::{
    interpolation::TransformEasingSystems,
    prelude::{
        Collider, CollisionLayers, CustomPositionIntegration, NarrowPhaseSystems, PhysicsSchedule, RigidBody,
        RotationInterpolation, SleepingDisabled, SpatialQueryFilter, TranslationInterpolation,
    },
};
use bevy::{prelude::*, utils::Parallel};

use super::{
    intent::MoveIntent,
    schedule::{MotionSystems, SchedulePlugin, stagger},
};
use crate::rig::tuning::motion::MotionConfig;
use ahead::region;
use around::{Around, Solid, recycled};
use body::MotionBody;
use capsule::MotionShapes;
pub(in crate::character) use field::{FieldGround, UprightField};
pub use glide::Glide;
use heightfield::Span;
pub(in crate::character) use movers::Movers;
use space::{Space, View};
use speed::limit_strafe;
use tick::Tick;

/// A body that walks, jumps and stands: spawn this with a `Transform` for a controller without any animation.
///
/// Must be a root entity: its `Transform` is in world space. Steer it through [`MoveIntent`], tune it through
/// [`MotionConfig`], read [`MotionState`]. Its `CollisionLayers`, if any, decide what it collides with; move its
/// `Transform` to teleport it.
///
/// The physics engine finds its contacts with dynamic bodies and sensors; with all else only where either collider has
/// `CollisionEventsEnabled` or `CollidingEntities`.
#[derive(Component, Reflect, Clone, Copy, Debug, Default)]
#[reflect(Component)]
#[require(
    Transform,
    MoveIntent,
    MotionConfig,
    MotionState,
    MotionBody,
    MotionShapes,
    RigidBody::Kinematic,
    Collider = MotionShapes::default().standing.whole.clone(),
    CustomPositionIntegration,
    SleepingDisabled,
    TranslationInterpolation,
    RotationInterpolation
)]
pub struct CharacterMotion;

/// What the controller did. World space; written once per fixed tick.
#[derive(Component, Reflect, Clone, Debug, Default)]
#[reflect(Component)]
pub struct MotionState {
    /// Velocity of the root in world space, m/s, after collisions. Includes the platform's.
    pub velocity: Vec3,
    /// Velocity relative to the ground the character stands on, m/s.
    pub ground_velocity: Vec3,
    /// The ground under the capsule; `None` in the air and on ground too steep to stand on.
    pub ground: Option<Ground>,
    /// Turn rate of the root about +Y in rad/s.
    pub yaw_rate: f32,
    /// The same over the ground it stands on: without the platform's turn.
    pub ground_yaw_rate: f32,
    /// Angle about +Y by which it still has to turn to face what it shall, radians, left positive.
    pub turn_ahead: f32,
    /// Whether it faces a given direction, whatever way it goes.
    pub facing_locked: bool,
    /// Rise over run to where the next stride may land; 0 where the ground there is out of reach.
    pub grade_ahead: f32,
    /// Seconds since the character last stood on ground; 0 when grounded.
    pub air_time: f32,
    /// World height of the ground that a fall is about to end on, while the legs slow it; `None` otherwise.
    pub lands_on: Option<f32>,
    /// Speed of the last landing, downward, m/s.
    pub landing_speed: f32,
    /// Counts jumps; a change tells later stages that one has begun.
    pub jumps: u32,
    /// Whether the capsule is crouched; stays so under a ceiling too low to stand up.
    pub crouched: bool,
    /// Sum of all vertical ways of the root by step-up, step-down and snapping, metres.
    ///
    /// A frame's difference tells the pelvis what to take out, so that the body doesn't pop.
    pub stepped: f32,
    /// Counts teleports (respawn, recovery); a change tells later stages to forget the ground.
    pub teleports: u32,
}

/// The ground under the capsule.
#[derive(Reflect, Clone, Copy, Debug)]
pub struct Ground {
    /// The collider's entity.
    pub entity: Entity,
    /// World normal.
    pub normal: Vec3,
    /// World velocity of the ground at the contact, m/s.
    pub velocity: Vec3,
}

/// Moves every [`CharacterMotion`] in [`MotionSystems::Move`]. Needs avian's `PhysicsPlugins`.
pub struct MotionPlugin;

impl Plugin for MotionPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<SchedulePlugin>() {
            app.add_plugins(SchedulePlugin);
        }
        app.init_resource::<Movers>()
            .add_systems(
                FixedUpdate,
                (place::build_shapes, movers::find_movers, move_characters, place::place_roots, place::push_bodies)
                    .chain()
                    .in_set(MotionSystems::Move),
            )
            .add_systems(PhysicsSchedule, contacts::leave_out_idle_contacts.in_set(NarrowPhaseSystems::First))
            .add_systems(
                RunFixedMainLoop,
                (
                    place::heed_moved_roots.in_set(RunFixedMainLoopSystems::BeforeFixedMainLoop),
                    place::remember_shown_roots
                        .in_set(RunFixedMainLoopSystems::AfterFixedMainLoop)
                        .after(TransformEasingSystems::UpdateEasingTick),
                ),
            );
    }
}

/// Every character moves in the world as the last physics step left it, so their order doesn't matter.
fn move_characters(
    space: Space,
    time: Res<Time>,
    memory: Local<Parallel<Vec<Solid<'static>>>>,
    mut characters: Query<(
        Entity,
        &MoveIntent,
        &MotionShapes,
        &Transform,
        Option<&CollisionLayers>,
        Option<&Glide>,
        &mut MotionBody,
        &mut MotionState,
    )>,
) {
    let (space, dt) = (&space, time.delta_secs());
    if dt <= 0.0 {
        return;
    }
    let characters = characters.par_iter_mut();
    characters.for_each_init(
        || memory.borrow_local_mut(),
        |memory, (me, intent, shapes, transform, layers, glide, mut body, mut state)| {
            if !intent.is_sound() {
                warn_once!("the MoveIntent of character {me} is not finite: {intent:?}; it counts as zero");
            }
            let filter =
                layers.map_or_else(SpatialQueryFilter::default, |layers| SpatialQueryFilter::from_mask(layers.filters));
            let config = &shapes.config;
            let top_speed = if body.crouched { config.crouch_speed } else { config.sprint_speed };
            let mut intent = intent.sanitised(top_speed);
            if let Some(facing) = intent.facing {
                intent.velocity = limit_strafe(intent.velocity, facing, config.sprint_speed, config.strafe_speed);
            }
            let around = Around::new(Span::default(), recycled(core::mem::take(&mut **memory)));
            let caught_up;
            let mut tick = Tick { view: View { space, me, filter, around }, config, shapes, intent, transform, dt };
            let Glide { seconds, hops } = glide.copied().unwrap_or_default();
            if seconds > 0.0 && tick.may_glide(&body) {
                tick.glide(&mut body, &mut state, hops);
            } else {
                if let Some(root) = tick.catch_up(&mut body, &mut state) {
                    caught_up = root;
                    tick.transform = &caught_up;
                }
                let span = region(&body, shapes, &tick.intent, dt).with(tick.span_ahead(&body, seconds));
                tick.view.look_around(span);
                let before = body.velocity;
                tick.run(&mut body, &mut state);
                // Neighbours look at different times.
                let share = 0.75 + 0.25 * stagger(me);
                body.line = tick.line_ahead(&body, before, (seconds * share, hops));
            }
            **memory = tick.view.around.into_memory();
        },
    );
}
