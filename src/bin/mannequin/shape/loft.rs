//! A limb as cross-sections along an axis, and the field around it.

use glam::{Vec2, Vec3};

/// One cross-section: where along the axis, its centre, and how far it reaches to each of four sides (metres).
#[derive(Clone, Copy, Debug)]
pub struct Section {
    /// Coordinate along the axis.
    pub at: f32,
    /// Centre in the plane of the section: along the first side direction, along the second.
    pub center: Vec2,
    /// Reach along +first, -first, +second, -second.
    pub reach: [f32; 4],
}

/// A section in short: `at`, centre x and y, and the four reaches.
#[must_use]
pub const fn section(at: f32, center: [f32; 2], reach: [f32; 4]) -> Section {
    Section { at, center: Vec2::from_array(center), reach }
}

/// Cross-sections, sorted by `at`, in a frame of axes.
pub struct Loft {
    /// Unit axes: along the limb, first side, second side.
    pub axes: [Vec3; 3],
    /// At least two, `at` rising.
    pub sections: &'static [Section],
    /// 0: ellipses; 1: rounded squares.
    pub square: f32,
}

impl Loft {
    /// The section at `at`, smoothly between its neighbours; beyond the ends the last one.
    #[must_use]
    pub fn section(&self, at: f32) -> Section {
        let rows = self.sections;
        let last = rows.len() - 1;
        let at = at.clamp(rows[0].at, rows[last].at);
        let i = rows[1..last].iter().take_while(|row| row.at < at).count();
        let (a, b) = (&rows[i], &rows[i + 1]);
        let (before, after) = (&rows[i.saturating_sub(1)], &rows[(i + 2).min(last)]);
        let span = b.at - a.at;
        let t = (at - a.at) / span;
        let curve = |value: &dyn Fn(&Section) -> f32| {
            let slope_a = (value(b) - value(before)) / (b.at - before.at) * span;
            let slope_b = (value(after) - value(a)) / (after.at - a.at) * span;
            let (t2, t3) = (t * t, t * t * t);
            (2.0 * t3 - 3.0 * t2 + 1.0) * value(a)
                + (t3 - 2.0 * t2 + t) * slope_a
                + (3.0 * t2 - 2.0 * t3) * value(b)
                + (t3 - t2) * slope_b
        };
        Section {
            at,
            center: Vec2::new(curve(&|s| s.center.x), curve(&|s| s.center.y)),
            reach: std::array::from_fn(|side| curve(&|s| s.reach[side])),
        }
    }

    /// Metres from `p` to the limb's surface, measured across the axis; negative inside.
    #[must_use]
    pub fn field(&self, p: Vec3) -> f32 {
        let [along, first, second] = self.axes;
        let at = p.dot(along);
        let section = self.section(at);
        let flat = Vec2::new(p.dot(first), p.dot(second)) - section.center;
        let across = flat.length() - section.radius(flat.normalize_or(Vec2::X), self.square);
        let beyond = (at - section.at).abs();
        if beyond > 0.0 { Vec2::new(across.max(0.0), beyond).length() } else { across }
    }
}

impl Section {
    /// Reach from the centre in the unit direction `toward`.
    #[must_use]
    pub fn radius(&self, toward: Vec2, square: f32) -> f32 {
        let x = toward.x / if toward.x > 0.0 { self.reach[0] } else { self.reach[1] };
        let y = toward.y / if toward.y > 0.0 { self.reach[2] } else { self.reach[3] };
        let (x2, y2) = (x * x, y * y);
        let round = 1.0 / (x2 + y2).sqrt();
        let boxy = 1.0 / (x2 * x2 + y2 * y2).sqrt().sqrt();
        round + (boxy - round) * square
    }
}
