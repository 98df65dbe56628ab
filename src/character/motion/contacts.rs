//! Spares the physics engine the contacts of characters with what doesn't give way, since nothing comes of them.
//!
//! Reads the pairs that avian's broad phase has found; takes some out before its narrow phase looks where they touch.

use avian3d::{collision::contact_types::ContactId, data_structures::pair_key::PairKey, prelude::*};
use bevy::prelude::*;

use super::CharacterMotion;

/// Colliders whose contacts someone asks for.
type Asked = Or<(With<Sensor>, With<CollisionEventsEnabled>, With<CollidingEntities>, With<ActiveCollisionHooks>)>;

/// Takes out pairs of a character and a body that isn't dynamic, unless either collider is asked for its contacts.
///
/// The controller has found its way among them already, and neither moves by a contact.
pub(super) fn leave_out_idle_contacts(
    mut contacts: ResMut<ContactGraph>,
    characters: Query<(), With<CharacterMotion>>,
    kinds: Query<&RigidBody>,
    asked: Query<(), Asked>,
    mut idle: Local<Vec<(PairKey, ContactId)>>,
) {
    idle.extend(contacts.iter_active().filter_map(|pair| {
        let (body, other) = (pair.body1?, pair.body2?);
        let gives_way = |body| kinds.get(body).is_ok_and(RigidBody::is_dynamic);
        let comes_to_nothing = !pair.is_touching()
            && (characters.contains(body) || characters.contains(other))
            && !(gives_way(body) || gives_way(other))
            && !(asked.contains(pair.collider1) || asked.contains(pair.collider2));
        let key = || PairKey::new(pair.collider1.index_u32(), pair.collider2.index_u32());
        comes_to_nothing.then(|| (key(), pair.contact_id))
    }));
    // The last first, so that others needn't move up.
    for (key, contact) in idle.drain(..).rev() {
        contacts.remove_edge_by_id(&key, contact);
    }
}
