//! One tick on the ground: the raised capsule slides along walls, then the ground under it is looked for.
//!
//! What lies below step height doesn't meet the raised capsule and is stepped on, so steps cost no extra sweeps
//! and the edges of triangles never catch the body. World space, metres.

use bevy::prelude::*;

use super::{
    body::MotionBody,
    capsule::{MotionShapes, Posture},
    footing::{Footing, Look, Support, footing},
    slide::Slider,
};

/// Most looks below in one stretch. The foot of a wall in a corner takes three.
const LOOKS: usize = 4;

/// Most stretches that a tick's way is cut into.
const STRETCHES: f32 = 16.0;

/// Where a walk ended.
#[derive(Clone, Copy, Debug)]
pub(super) struct Walked {
    pub(super) position: Vec3,
    /// `None`: the ground ended.
    pub(super) support: Option<Support>,
}

/// Walks the horizontal `way` from the body's position.
pub(super) fn walk(
    slider: &mut Slider,
    body: &mut MotionBody,
    shapes: &MotionShapes,
    posture: &Posture,
    way: Vec3,
) -> Walked {
    // Each stretch shorter than half the ball, so that nothing to stand on is jumped over.
    let stretches = (way.length() / (shapes.radius * 0.5)).ceil().clamp(1.0, STRETCHES);
    let mut walked = Walked { position: body.position, support: None };
    for _ in 0..stretches as u32 {
        let stretch = slider.planes.slide(way / stretches);
        walked = walk_stretch(slider, body, shapes, posture, walked.position, stretch);
        if walked.support.is_none() {
            break;
        }
    }
    walked
}

fn walk_stretch(
    slider: &mut Slider,
    body: &mut MotionBody,
    shapes: &MotionShapes,
    posture: &Posture,
    from: Vec3,
    way: Vec3,
) -> Walked {
    let look = Look {
        up: shapes.step_up,
        down: slider.config.step_down.max(0.0),
        highest: shapes.step_up + 1e-3,
        limit_cos: slider.limit_cos,
    };
    let raised = &posture.raised;
    let mut at = slider.walk(body, raised, from, way);
    let mut rerouted = false;
    for _ in 0..LOOKS {
        match footing(slider.view, shapes, at, look) {
            Footing::Support(support) if fits(slider, posture, at, support) => {
                body.wedged = 0.0;
                return stand(at, support);
            }
            Footing::Support(_) => {
                // No headroom up there: as good as a wall.
                let against = (at - from).normalize_or_zero();
                slider.planes.push(-against, 0.0);
                at = if rerouted { from } else { slider.walk(body, raised, from, slider.planes.slide(way)) };
                rerouted = true;
            }
            Footing::Wall { normal, back } => {
                slider.planes.push(normal, body.frame_velocity.dot(normal));
                if back <= way.length() + 0.05 {
                    // A hair further than needed, so that the next look finds it free.
                    at = slider.walk(body, raised, at, normal * (back + 5e-4));
                } else {
                    at = if rerouted { from } else { slider.walk(body, raised, from, slider.planes.slide(way)) };
                    rerouted = true;
                }
            }
            Footing::Slip(support) if body.wedged > 0.0 => return stand(at, support),
            Footing::Slip(_) | Footing::Air => return Walked { position: at, support: None },
        }
    }
    // Nowhere to go: stay, on whatever bears.
    match footing(slider.view, shapes, from, look) {
        Footing::Support(support) => stand(from, support),
        Footing::Slip(support) if body.wedged > 0.0 => stand(from, support),
        _ => Walked { position: from, support: None },
    }
}

fn stand(at: Vec3, support: Support) -> Walked {
    Walked { position: at.with_y(support.height), support: Some(support) }
}

/// Whether the body has the headroom to rise onto the support.
fn fits(slider: &Slider, posture: &Posture, at: Vec3, support: Support) -> bool {
    let rise = support.height - at.y;
    if rise < 1e-3 {
        return true;
    }
    slider.view.sweep(&posture.raised, at, Vec3::Y * rise).is_none_or(|hit| hit.normal.y > -0.1 || hit.safe >= rise)
}
