//! What the pieces of the course are made of: each shape gives a mesh and a collider on the same surface.
//!
//! Model space, metres, the foot at y = 0 in the middle of the plan. Where a shape climbs, it climbs toward -Z.

use avian3d::prelude::Collider;
use bevy::math::{Quat, Vec2, Vec3};

use super::boulder;

mod look;

/// Thickness of a rail's bar and posts, metres.
const BAR: f32 = 0.06;
/// Metres by which boxes stand out sideways as colliders: a ray between two that touch must hit one of them.
const SEAM: f32 = 0.001;

/// A solid of the course.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A box with softened edges.
    Block {
        /// Full size in metres.
        size: Vec3,
    },
    /// A box with planks on top, laid along X.
    Deck {
        /// Full size in metres.
        size: Vec3,
    },
    /// A planked wedge that climbs from 0 at +Z to its full height at -Z.
    Ramp {
        /// Full size in metres.
        size: Vec3,
    },
    /// A roof with its ridge along X.
    Ridge {
        /// Full size in metres.
        size: Vec3,
    },
    /// A flight of stairs that climbs toward -Z.
    Stairs {
        /// Count of steps.
        steps: u32,
        /// Height of a step in metres.
        rise: f32,
        /// Depth of a step in metres.
        run: f32,
        /// Width in metres.
        width: f32,
        /// Height in metres at which the flight begins; solid below.
        base: f32,
    },
    /// An upright round slab with painted spokes, so that its turning shows.
    Disc {
        /// Radius in metres.
        radius: f32,
        /// Height in metres.
        height: f32,
    },
    /// A handrail along X.
    Rail {
        /// Length in metres.
        length: f32,
        /// Height of the bar's top in metres.
        height: f32,
    },
    /// A tapered square mast, banded every metre.
    Mast {
        /// Height in metres.
        height: f32,
        /// Width at the foot in metres; half of it at the top.
        width: f32,
    },
    /// A convex rock, its foot a little below y = 0.
    Boulder {
        /// About half its width in metres.
        radius: f32,
        /// Which rock.
        seed: u32,
    },
    /// A pine: a trunk one can bump into, below boughs one can't.
    Pine {
        /// Height in metres.
        height: f32,
    },
}

impl Shape {
    /// Radius in metres around the middle of the plan that holds the whole collider.
    #[must_use]
    pub fn reach(&self) -> f32 {
        match self {
            Self::Block { size } | Self::Deck { size } | Self::Ramp { size } | Self::Ridge { size } => {
                size.with_y(0.0).length() * 0.5
            }
            Self::Stairs { steps, run, width, .. } => Vec3::new(*width, 0.0, *run * *steps as f32).length() * 0.5,
            Self::Disc { radius, .. } => *radius,
            Self::Rail { length, .. } => *length * 0.5 + BAR,
            Self::Mast { width, .. } => *width,
            Self::Boulder { radius, .. } => *radius * 1.3,
            Self::Pine { height } => trunk_radius(*height),
        }
    }

    /// Height of the top in metres.
    #[must_use]
    pub fn height(&self) -> f32 {
        match self {
            Self::Block { size } | Self::Deck { size } | Self::Ramp { size } | Self::Ridge { size } => size.y,
            Self::Stairs { steps, rise, base, .. } => base + rise * *steps as f32,
            Self::Boulder { radius, .. } => *radius,
            Self::Disc { height, .. }
            | Self::Rail { height, .. }
            | Self::Mast { height, .. }
            | Self::Pine { height } => *height,
        }
    }

    /// Metres from a place on the plan, in model space, to the foot; below 0 inside it.
    #[must_use]
    pub fn outside(&self, at: Vec2) -> f32 {
        let half = match self {
            Self::Block { size } | Self::Deck { size } | Self::Ramp { size } | Self::Ridge { size } => {
                Vec2::new(size.x, size.z) * 0.5
            }
            Self::Stairs { steps, run, width, .. } => Vec2::new(*width, *run * *steps as f32) * 0.5,
            Self::Mast { width, .. } => Vec2::splat(*width * 0.5),
            // Thin posts hide no sky.
            Self::Rail { .. } => return f32::INFINITY,
            Self::Disc { radius, .. } => return at.length() - radius,
            Self::Boulder { radius, .. } => return at.length() - radius * 0.85,
            Self::Pine { height } => return at.length() - trunk_radius(*height),
        };
        let beyond = at.abs() - half;
        beyond.max(Vec2::ZERO).length() + beyond.max_element().min(0.0)
    }

    /// The collider, on the mesh's surface.
    #[must_use]
    pub fn collider(&self) -> Collider {
        match *self {
            Self::Block { size } | Self::Deck { size } => raised_box(Vec3::Y * size.y * 0.5, size),
            Self::Ramp { size } => {
                let half = size * 0.5;
                let corner = |x: f32, y: f32, z: f32| Vec3::new(x * half.x, y * size.y, z * half.z);
                hull_or_box(
                    vec![
                        corner(-1.0, 0.0, 1.0),
                        corner(1.0, 0.0, 1.0),
                        corner(-1.0, 0.0, -1.0),
                        corner(1.0, 0.0, -1.0),
                        corner(-1.0, 1.0, -1.0),
                        corner(1.0, 1.0, -1.0),
                    ],
                    size,
                )
            }
            Self::Ridge { size } => {
                let [a, b, c, d, e, f] = ridge_corners(size);
                hull_or_box(vec![a, b, c, d, e, f], size)
            }
            Self::Stairs { steps, rise, run, width, base } => {
                let flight = Flight { steps, rise, run, width, base };
                Collider::compound(
                    (0..steps.max(1))
                        .map(|step| {
                            let (top, front) = (flight.top(step), flight.front(step));
                            let centre = Vec3::new(0.0, top * 0.5, front - run * 0.5);
                            (centre, Quat::IDENTITY, Collider::cuboid(width, top, run + 2.0 * SEAM))
                        })
                        .collect(),
                )
            }
            Self::Disc { radius, height } => {
                Collider::compound(vec![(Vec3::Y * height * 0.5, Quat::IDENTITY, Collider::cylinder(radius, height))])
            }
            Self::Rail { length, height } => Collider::compound(
                rail_bars(length, height)
                    .map(|(centre, size)| (centre, Quat::IDENTITY, Collider::cuboid(size.x, size.y, size.z)))
                    .collect(),
            ),
            Self::Mast { height, width } => {
                let corners = [0.0, 1.0].into_iter().flat_map(|up| mast_ring(height, width, up * height)).collect();
                hull_or_box(corners, Vec3::new(width, height, width))
            }
            Self::Boulder { radius, seed } => hull_or_box(boulder::hull(radius, seed).0, Vec3::splat(radius)),
            Self::Pine { height } => {
                let trunk = height * 0.5;
                Collider::compound(vec![(
                    Vec3::Y * trunk * 0.5,
                    Quat::IDENTITY,
                    Collider::cylinder(trunk_radius(height), trunk),
                )])
            }
        }
    }
}

struct Flight {
    steps: u32,
    rise: f32,
    run: f32,
    width: f32,
    base: f32,
}

impl Flight {
    /// Height of a step's tread.
    fn top(&self, step: u32) -> f32 {
        self.base + self.rise * (step + 1) as f32
    }

    /// Z of a step's riser.
    fn front(&self, step: u32) -> f32 {
        self.run * (self.steps as f32 * 0.5 - step as f32)
    }
}

fn raised_box(centre: Vec3, size: Vec3) -> Collider {
    let size = size + Vec3::new(2.0 * SEAM, 0.0, 2.0 * SEAM);
    Collider::compound(vec![(centre, Quat::IDENTITY, Collider::cuboid(size.x, size.y, size.z))])
}

/// The hull of `points`, or a box of `size` where they have none.
fn hull_or_box(points: Vec<Vec3>, size: Vec3) -> Collider {
    Collider::convex_hull(points).unwrap_or_else(|| raised_box(Vec3::Y * size.y * 0.5, size))
}

fn ridge_corners(size: Vec3) -> [Vec3; 6] {
    let half = size * 0.5;
    [
        Vec3::new(half.x, 0.0, half.z),
        Vec3::new(half.x, 0.0, -half.z),
        Vec3::new(half.x, size.y, 0.0),
        Vec3::new(-half.x, 0.0, half.z),
        Vec3::new(-half.x, 0.0, -half.z),
        Vec3::new(-half.x, size.y, 0.0),
    ]
}

/// Middle and size of a rail's bars.
fn rail_bars(length: f32, height: f32) -> impl Iterator<Item = (Vec3, Vec3)> {
    let posts = (length / 1.2).ceil().max(1.0) as u32;
    let step = (length - BAR) / posts as f32;
    let post = move |index: u32| {
        let x = step * index as f32 - (length - BAR) * 0.5;
        // Into the bar, and thinner, so that no face of it shows.
        let up = height - BAR * 0.5;
        (Vec3::new(x, up * 0.5, 0.0), Vec3::new(BAR * 0.8, up, BAR * 0.8))
    };
    let bar = |y: f32, thick: f32| (Vec3::new(0.0, y, 0.0), Vec3::new(length, thick, thick));
    (0..=posts).map(post).chain([bar(height - BAR * 0.5, BAR), bar(height * 0.5, BAR * 0.6)])
}

/// The corners of a mast at `up` metres, counter-clockwise seen from above.
fn mast_ring(height: f32, width: f32, up: f32) -> [Vec3; 4] {
    let half = width * 0.5 * (1.0 - 0.5 * up / height.max(0.01));
    [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)].map(|(x, z)| Vec3::new(x * half, up, z * half))
}

fn trunk_radius(height: f32) -> f32 {
    0.035 * height
}
