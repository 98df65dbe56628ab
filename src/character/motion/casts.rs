//! Shape casts made exact: sweeps of a body, and a ball lowered onto the ground. World space, metres.
//!
//! The physics engine's casts iterate and stop early beside large shapes; what they find is sharpened by the contact at
//! that place. Heightfields are met without iteration.

use avian3d::{
    collision::collider::contact_query::contact_manifolds,
    prelude::{Collider, ContactManifold, SimpleCollider},
};
use bevy::prelude::*;

use super::{
    around::Solid,
    heightfield::{Rest, Span, Sweep, rest_on_field},
    space::{Hit, SKIN, View},
};

/// Most in metres by which a cast is taken to stop early.
const CAST_ERROR: f32 = 0.04;

/// A way that leads into a surface by less than this sine leads along it.
const GRAZING: f32 = 1e-3;

/// Surfaces grazed in one sweep before it is taken to be free.
const GRAZES: usize = 3;

/// Where a shape is nearest to a part of a collider.
#[derive(Clone, Copy, Debug)]
struct Contact {
    /// Unit normal toward the character.
    normal: Vec3,
    /// Metres between them; negative where they overlap.
    gap: f32,
    point: Vec3,
}

impl View<'_> {
    /// The first thing that `shape`, upright at `from`, meets on its `way`.
    pub(super) fn sweep(&self, shape: &Collider, from: Vec3, way: Vec3) -> Option<Hit> {
        self.sweep_without(shape, from, way, self.me)
    }

    /// [`sweep`](Self::sweep) that doesn't meet the body `without`.
    pub(super) fn sweep_without(&self, shape: &Collider, from: Vec3, way: Vec3, without: Entity) -> Option<Hit> {
        let (direction, length) = Dir3::new_and_length(way).ok()?;
        // Numbers that overflow find nothing; the tick then puts the body back.
        if !from.is_finite() || !length.is_finite() {
            return None;
        }
        let end = way + *direction * SKIN;
        let start = shape.aabb(from, Quat::IDENTITY);
        let slack = Vec3::splat(1e-3);
        let span =
            Span { least: start.min + end.min(Vec3::ZERO) - slack, most: start.max + end.max(Vec3::ZERO) + slack };
        let sweep = Sweep { shape, from, way: end, span };
        let solids = self.solids_in(span);
        let mut grazed = None;
        for _ in 0..GRAZES {
            let met =
                |solid: &&Solid| solid.body != without && Some(solid.entity) != grazed && solid.may_be_met(&sweep);
            let hit = first(solids.iter().filter(met), shape, from, direction, length + SKIN)?;
            let Some(hit) = self.sharpen_sweep(shape, from, direction, hit) else {
                grazed = Some(hit.collider);
                continue;
            };
            // Grazing hits would ask for an endless pull back.
            let toward = (-hit.normal.dot(*direction)).max(0.005);
            let safe = (hit.distance - SKIN / toward).clamp(0.0, length);
            return Some(Hit { safe, ..hit });
        }
        None
    }

    /// The first thing that a ball lowered from `centre` touches within `reach` metres.
    ///
    /// Exact for heightfields; for the rest see [`sharpen_lowering`](Self::sharpen_lowering).
    pub(super) fn lower(&self, ball: &Collider, radius: f32, centre: Vec3, reach: f32) -> Option<Hit> {
        if !centre.is_finite() || !reach.is_finite() {
            return None;
        }
        let span = Span { least: centre - Vec3::splat(radius) - Vec3::Y * reach, most: centre + Vec3::splat(radius) };
        let solids = self.solids_in(span);
        let met = || solids.iter().filter(|solid| solid.reaches_into(span));
        let rest = met()
            .filter_map(|solid| Some((solid, rest_on_field(solid.field?, solid.frame, radius, centre, span)?)))
            .max_by(|a, b| a.1.height.total_cmp(&b.1.height));
        let hit = first(met().filter(|solid| solid.field.is_none()), ball, centre, Dir3::NEG_Y, reach);
        let rest = rest.and_then(|(solid, Rest { height, normal, point })| {
            let distance = (centre.y - height).max(0.0);
            (distance <= reach).then_some(Hit {
                distance,
                safe: distance,
                normal,
                point,
                collider: solid.entity,
                exact: true,
            })
        });
        match (rest, hit) {
            (Some(rest), Some(hit)) if rest.distance >= hit.distance - CAST_ERROR => {
                let hit = Hit { exact: true, ..self.sharpen_lowering(ball, centre, hit) };
                Some(if rest.distance < hit.distance { rest } else { hit })
            }
            (rest, hit) => rest.or(hit),
        }
    }

    /// The hit with its exact distance and normal; `None` where the shape only grazes what was hit.
    ///
    /// Casts iterate: beside a box of a hundred metres they stop centimetres early. The contact at that place is exact.
    fn sharpen_sweep(&self, shape: &Collider, from: Vec3, direction: Dir3, hit: Hit) -> Option<Hit> {
        if hit.exact {
            return Some(hit).filter(|hit| hit.normal.dot(*direction) < -GRAZING);
        }
        let at = from + direction * hit.distance;
        let contacts = self.contacts(shape, at, hit.collider, CAST_ERROR);
        let alike = |contact: &&Contact| contact.normal.dot(hit.normal) > 0.8;
        if contacts.is_empty() {
            return Some(hit);
        }
        // A cast that starts at what it meets may make up a normal; what contacts there are know better.
        let any_alike = contacts.iter().any(|contact| alike(&contact));
        let near = contacts.iter().filter(|contact| !any_alike || alike(contact));
        near.filter(|contact| contact.normal.dot(*direction) < -GRAZING)
            .map(|contact| {
                let further = contact.gap / -contact.normal.dot(*direction);
                let distance = (hit.distance + further.clamp(-CAST_ERROR, CAST_ERROR)).max(0.0);
                Hit { distance, normal: contact.normal, point: contact.point, ..hit }
            })
            .min_by(|a, b| a.distance.total_cmp(&b.distance))
    }

    /// A lowered ball's hit with its exact distance and normal.
    pub(super) fn sharpen_lowering(&self, ball: &Collider, centre: Vec3, hit: Hit) -> Hit {
        let mut sharp = hit;
        // Twice, since an edge is straight for the first millimetres only.
        for _ in 0..2 {
            let at = centre - Vec3::Y * sharp.distance;
            let contacts = self.contacts(ball, at, hit.collider, CAST_ERROR);
            let first = contacts
                .iter()
                .filter(|contact| contact.normal.y > 0.05)
                .min_by(|a, b| (a.gap / a.normal.y).total_cmp(&(b.gap / b.normal.y)));
            let Some(first) = first else { break };
            let further = (first.gap / first.normal.y).clamp(-CAST_ERROR, CAST_ERROR);
            let distance = (sharp.distance + further).max(0.0);
            sharp = Hit { distance, safe: distance, normal: first.normal, point: first.point, ..hit };
            if further.abs() < 1e-3 {
                break;
            }
        }
        sharp
    }

    /// Where a shape is nearest to a collider, for each part of it that is within `reach` metres.
    fn contacts(&self, shape: &Collider, at: Vec3, collider: Entity, reach: f32) -> Vec<Contact> {
        let Ok((other, &position, &rotation, _)) = self.space.casts.colliders.get(collider) else {
            return Vec::new();
        };
        let mut manifolds = Vec::new();
        contact_manifolds(shape, at, Quat::IDENTITY, other, position, rotation, reach, &mut manifolds);
        let nearest = |manifold: &ContactManifold| {
            let deepest = manifold.find_deepest_contact()?;
            let contact = Contact { normal: -manifold.normal, gap: -deepest.penetration, point: deepest.point };
            (contact.normal.is_finite() && contact.gap.is_finite() && contact.point.is_finite()).then_some(contact)
        };
        manifolds.iter().filter_map(nearest).collect()
    }
}

/// The first of the solids that `shape`, upright at `from`, touches within `reach` metres.
fn first<'a>(
    solids: impl Iterator<Item = &'a Solid<'a>>,
    shape: &Collider,
    from: Vec3,
    direction: Dir3,
    reach: f32,
) -> Option<Hit> {
    let mut first: Option<Hit> = None;
    for solid in solids {
        let reach = first.map_or(reach, |hit| hit.distance);
        first = solid.cast_shape(shape, from, direction, reach).or(first);
    }
    first
}
