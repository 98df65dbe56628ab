//! What the physics engine finds of a character's contacts.

use avian3d::prelude::*;
use bevy::prelude::*;

use crate::support::*;

const HZ: f64 = 64.0;

/// Whether the physics engine knows of any contact between two colliders.
fn meet(app: &App, one: Entity, other: Entity) -> bool {
    app.world().resource::<ContactGraph>().get(one, other).is_some()
}

#[test]
fn contacts_with_what_stands_still_are_found_only_if_asked_for() {
    let mut app = world(HZ);
    let ground = flat(&mut app);
    let heard = block(&mut app, Vec3::new(1.0, 0.5, 0.0), Vec3::ONE, Quat::IDENTITY);
    app.world_mut().entity_mut(heard).insert(CollisionEventsEnabled);
    let walker = walker(&mut app, Vec3::new(0.2, 0.0, 0.0));
    let zone = app.world_mut().spawn((Sensor, Collider::sphere(0.5), Transform::default())).id();
    let ball = app.world_mut().spawn((RigidBody::Dynamic, Collider::sphere(0.3), Transform::from_xyz(-0.3, 0.3, 0.0)));
    let ball = ball.id();
    updates(&mut app, 10);
    assert!(!meet(&app, walker, ground), "nobody asked for the ground under a character");
    for (what, entity) in [("a wall with events", heard), ("a sensor", zone), ("a ball", ball)] {
        assert!(meet(&app, walker, entity), "{what} doesn't meet the character");
    }

    app.world_mut().entity_mut(walker).insert(CollidingEntities::default());
    go(&mut app, walker, Vec3::Z);
    updates(&mut app, 10);
    let met = app.world().get::<CollidingEntities>(walker).unwrap();
    assert!(met.contains(&ground), "asked for, the ground doesn't collide");
}
