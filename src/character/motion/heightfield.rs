//! Heightfields without iteration: which of their triangles are near, and where a ball comes to rest on one.
//!
//! A cast by the physics engine tries every triangle of the grid cells below a shape, however far below; for a crowd on
//! terrain that is most of the time. World space, metres.

use core::cell::Cell;

use avian3d::{
    parry::{bounding_volume::Aabb, math::Vector, shape::HeightField},
    prelude::Collider,
};
use bevy::math::{Mat3, Vec3};

use super::{field::UprightField, frame::Frame};

/// Slack in metres around an edge, so that no seam lies between two triangles.
const SEAM: f32 = 1e-5;

/// Metres over the plane that a ball rests on up to which nothing else is looked at: rounding, some way from the origin.
const FLUSH: f32 = 1e-5;

/// Metres by which a shape has to miss a triangle's plane.
const SLACK: f32 = 1e-3;

/// A box along the world's axes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Span {
    pub(super) least: Vec3,
    pub(super) most: Vec3,
}

impl Span {
    /// The span between two corners, whichever they are.
    #[must_use]
    pub(super) fn between(a: Vec3, b: Vec3) -> Self {
        Self { least: a.min(b), most: a.max(b) }
    }

    /// The span that holds both.
    #[must_use]
    pub(super) fn with(self, other: Self) -> Self {
        Self { least: self.least.min(other.least), most: self.most.max(other.most) }
    }

    /// Whether all of `other` lies within.
    #[must_use]
    pub(super) fn contains(self, other: Self) -> bool {
        self.least.cmple(other.least).all() && self.most.cmpge(other.most).all()
    }

    /// Whether the two have anything in common.
    #[must_use]
    pub(super) fn meets(self, other: Self) -> bool {
        self.least.cmple(other.most).all() && self.most.cmpge(other.least).all()
    }
}

/// An upright shape on a straight way.
pub(super) struct Sweep<'a> {
    pub(super) shape: &'a Collider,
    pub(super) from: Vec3,
    pub(super) way: Vec3,
    /// All that it passes through.
    pub(super) span: Span,
}

impl Sweep<'_> {
    /// Whether all of it stays on the side of the triangle's plane where it is: then it can't touch the triangle.
    fn stays_beside(&self, [a, b, c]: [Vec3; 3]) -> bool {
        let Some(shape) = self.shape.shape_scaled().as_support_map() else { return false };
        let normal = (b - a).cross(c - a);
        let normal = if normal.dot(self.from - a) < 0.0 { -normal } else { normal };
        let Vec3 { x, y, z } = -normal;
        let nearest = shape.local_support_point(Vector::new(x, y, z));
        let nearest = self.from + Vec3::new(nearest.x, nearest.y, nearest.z) - a;
        nearest.dot(normal) + self.way.dot(normal).min(0.0) > SLACK * normal.length()
    }
}

/// Where a ball rests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rest {
    /// Height of the ball's centre.
    pub(super) height: f32,
    /// Unit normal from what it touches to its centre.
    pub(super) normal: Vec3,
    /// Where it touches.
    pub(super) point: Vec3,
}

/// Calls `found` with every triangle of the field, in the world, whose cell reaches into the span; where corners of cells are at hand, of
/// those alone that have one that is `worth` it.
fn triangles_in(
    field: &HeightField,
    frame: Frame,
    span: Span,
    worth: impl Fn(Vec3) -> bool,
    mut found: impl FnMut([Vec3; 3]),
) {
    if UprightField::new(field, frame.position, frame.rotation)
        .is_some_and(|field| field.triangles_in(span, worth, &mut found))
    {
        return;
    }
    let into_field = Mat3::from_quat(frame.rotation).transpose();
    let middle = into_field * ((span.least + span.most) * 0.5 - frame.position);
    let half = into_field.abs() * ((span.most - span.least) * 0.5);
    let vector = |v: Vec3| Vector::new(v.x, v.y, v.z);
    let near = Aabb::new(vector(middle - half), vector(middle + half));
    let corner = |v: Vector| frame.world(Vec3::new(v.x, v.y, v.z));
    field.map_elements_in_local_aabb(&near, &mut |_, triangle| {
        found([corner(triangle.a), corner(triangle.b), corner(triangle.c)]);
    });
}

/// Whether a shape on its way may touch any triangle of the field.
pub(super) fn reaches_into(field: &HeightField, frame: Frame, sweep: &Sweep) -> bool {
    let mut reaches = false;
    let any = |_: Vec3| true;
    triangles_in(field, frame, sweep.span, any, |triangle| {
        let [a, b, c] = triangle;
        let bounds = Span { least: a.min(b).min(c), most: a.max(b).max(c) };
        reaches = reaches || (bounds.meets(sweep.span) && !sweep.stays_beside(triangle));
    });
    reaches
}

/// Where a ball lowered from `centre` through `span` first touches the field.
#[must_use]
pub(super) fn rest_on_field(field: &HeightField, frame: Frame, radius: f32, centre: Vec3, span: Span) -> Option<Rest> {
    let rest: Cell<Option<Rest>> = Cell::new(None);
    let under = Span { least: centre.with_y(span.least.y), most: centre };
    // What is straight below is mostly what it rests on. Then nothing holds it higher that lies below the plane it rests on.
    let worth = |corner: Vec3| rest.get().is_none_or(|rest| (corner - rest.point).dot(rest.normal) > FLUSH);
    for span in [under, span] {
        triangles_in(field, frame, span, worth, |triangle| {
            let above = rest.get().map_or(f32::NEG_INFINITY, |rest| rest.height);
            rest.set(rest_on_triangle(centre, radius, triangle, above).or(rest.get()));
        });
    }
    rest.get()
}

/// Where a ball lowered from above at the horizontal place of `over` first touches the triangle, if that is higher than `above`.
#[must_use]
pub(super) fn rest_on_triangle(over: Vec3, radius: f32, [a, b, c]: [Vec3; 3], above: f32) -> Option<Rest> {
    let (least, most) = (a.min(b).min(c), a.max(b).max(c));
    if over.x < least.x - radius || over.x > most.x + radius || over.z < least.z - radius || over.z > most.z + radius {
        return None;
    }
    if most.y + radius <= above {
        return None;
    }
    let cross = (b - a).cross(c - a);
    let (upward, length) = (if cross.y < 0.0 { -1.0 } else { 1.0 }, cross.length());
    let cross = cross * upward;
    let edges = [(a, b), (b, c), (c, a)];
    let mut outside = [true; 3];
    if cross.y > 1e-3 * length {
        let height = a.y + (radius * length - (over.x - a.x) * cross.x - (over.z - a.z) * cross.z) / cross.y;
        // On the whole plane it would rest no lower than on any part of it.
        if height <= above {
            return None;
        }
        let normal = cross / length;
        let point = over.with_y(height) - normal * radius;
        // How far on the inner side of every edge, seen from above; whichever way the corners go round.
        let side = |(from, to): (Vec3, Vec3)| {
            upward * ((to.z - from.z) * (point.x - from.x) - (to.x - from.x) * (point.z - from.z))
        };
        let sides = edges.map(side);
        if sides.iter().all(|s| *s >= -SEAM) {
            return Some(Rest { height, normal, point });
        }
        // The nearer to that point the higher it rests: on an edge that the point is outside of.
        outside = sides.map(|s| s < 0.0);
    }
    let on_edges = edges.into_iter().zip(outside).filter(|(_, outside)| *outside);
    let rests = on_edges.filter_map(|((from, to), _)| rest_on_edge(over, radius, from, to));
    rests.max_by(|a, b| a.height.total_cmp(&b.height)).filter(|rest| rest.height > above)
}

/// Where the ball rests on an edge or on its ends.
fn rest_on_edge(over: Vec3, radius: f32, from: Vec3, to: Vec3) -> Option<Rest> {
    let (along, way) = (to - from, Vec3::new(over.x - from.x, 0.0, over.z - from.z));
    let length_squared = along.length_squared();
    if length_squared > 1e-12 {
        // |w|² - (w·u)²/|u|² = r², solved for the height in w.
        let flat = way.dot(along);
        let a = 1.0 - along.y * along.y / length_squared;
        let b = -2.0 * along.y * flat / length_squared;
        let c = way.length_squared() - flat * flat / length_squared - radius * radius;
        let root = b * b - 4.0 * a * c;
        if a > 1e-6 && root >= 0.0 {
            let above = (root.sqrt() - b) / (2.0 * a);
            let share = (flat + above * along.y) / length_squared;
            if (0.0..=1.0).contains(&share) {
                return rest_at(over, from.y + above, from + along * share);
            }
        }
    }
    let on_end = |end: Vec3| {
        let aside = Vec3::new(over.x - end.x, 0.0, over.z - end.z).length_squared();
        let above = radius * radius - aside;
        if above < 0.0 { None } else { rest_at(over, end.y + above.sqrt(), end) }
    };
    [on_end(from), on_end(to)].into_iter().flatten().max_by(|a, b| a.height.total_cmp(&b.height))
}

fn rest_at(over: Vec3, height: f32, point: Vec3) -> Option<Rest> {
    let normal = (over.with_y(height) - point).normalize_or_zero();
    (normal != Vec3::ZERO).then_some(Rest { height, normal, point })
}

#[cfg(test)]
mod tests {
    use super::*;
    use avian3d::parry::utils::Array2;
    use bevy::math::{Quat, primitives::Triangle3d};
    use proptest::prelude::*;

    fn corner() -> impl Strategy<Value = Vec3> {
        (-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0).prop_map(|(x, y, z)| Vec3::new(x, y, z))
    }

    /// Distance from a point to the triangle, by trying many points of it.
    fn distance(point: Vec3, [a, b, c]: [Vec3; 3]) -> f32 {
        let mut nearest = f32::MAX;
        for i in 0..=40u8 {
            for j in 0..=(40 - i) {
                let (u, v) = (f32::from(i) / 40.0, f32::from(j) / 40.0);
                nearest = nearest.min(point.distance(a + (b - a) * u + (c - a) * v));
            }
        }
        nearest
    }

    proptest! {
        #[test]
        fn a_resting_ball_touches_and_a_higher_one_does_not(a in corner(), b in corner(), c in corner(), x in -1.2f32..1.2, z in -1.2f32..1.2, radius in 0.1f32..0.5) {
            prop_assume!(Triangle3d::new(a, b, c).vertices.len() == 3 && (b - a).cross(c - a).length() > 0.05);
            let over = Vec3::new(x, 0.0, z);
            match rest_on_triangle(over, radius, [a, b, c], f32::NEG_INFINITY) {
                Some(rest) => {
                    let gap = distance(over.with_y(rest.height), [a, b, c]) - radius;
                    // The tried points lie up to some centimetres beside the nearest one.
                    prop_assert!((-2e-3..0.03).contains(&gap), "rests {gap} m off the triangle");
                    let touch = over.with_y(rest.height).distance(rest.point) - radius;
                    prop_assert!(touch.abs() < 1e-3, "touches {touch} m off");
                    for higher in [0.05f32, 0.2, 0.8] {
                        let gap = distance(over.with_y(rest.height + higher), [a, b, c]) - radius;
                        prop_assert!(gap > -2e-3, "a ball {higher} m higher is {gap} m in it");
                    }
                }
                None => {
                    for step in 0..40u8 {
                        let height = f32::from(step) * 0.08 - 1.6;
                        let gap = distance(over.with_y(height), [a, b, c]) - radius;
                        prop_assert!(gap > -2e-3, "missed a triangle {gap} m from the ball at {height}");
                    }
                }
            }
        }
    }

    proptest! {
        #[test]
        fn a_ball_rests_on_a_field_as_on_the_highest_of_its_triangles(heights in prop::collection::vec(0.0f32..0.6, 25), x in -1.5f32..1.5, z in -1.5f32..1.5, radius in 0.2f32..0.6) {
            let field = HeightField::new(Array2::new(5, 5, heights), Vector::new(4.0, 1.0, 4.0));
            let frame = Frame { position: Vec3::new(0.0, 2.0, 0.0), rotation: Quat::IDENTITY };
            let (centre, flat) = (Vec3::new(x, 5.0, z), Vec3::new(radius, 0.0, radius));
            let span = Span { least: centre - flat - Vec3::Y * 5.0, most: centre + flat };
            let got = rest_on_field(&field, frame, radius, centre, span).expect("there is ground everywhere").height;
            let mut wanted = f32::NEG_INFINITY;
            for triangle in field.triangles() {
                let corners = [triangle.a, triangle.b, triangle.c].map(|v| frame.world(Vec3::new(v.x, v.y, v.z)));
                let rest = rest_on_triangle(centre, radius, corners, f32::NEG_INFINITY);
                wanted = wanted.max(rest.map_or(f32::NEG_INFINITY, |rest| rest.height));
            }
            prop_assert!((got - wanted).abs() < 5e-5, "rests at {got} instead of {wanted}");
        }
    }

    #[test]
    fn a_ball_rests_on_a_slope_as_on_its_plane() {
        let [a, b, c] = [Vec3::new(-5.0, -5.0, -5.0), Vec3::new(5.0, 5.0, -5.0), Vec3::new(0.0, 0.0, 9.0)];
        let rest = rest_on_triangle(Vec3::ZERO, 0.5, [a, b, c], f32::NEG_INFINITY).map_or(f32::NAN, |rest| rest.height);
        assert!((rest - 0.5 * 2f32.sqrt()).abs() < 1e-4, "rests at {rest}");
    }
}
