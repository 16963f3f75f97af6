//! Cells of the surface: squares of two triangles, and what lies beyond the border.

use super::integral::{Point, Shape, TriangleForm, mean};
use super::placed::{Frame, Placed};

/// A query, in deviations.
#[derive(Clone, Copy, Debug)]
pub(super) struct Query {
    pub placed: Placed,
    pub frame: Frame,
    /// The half vector.
    pub normal: [f64; 2],
    /// One over σr.
    pub scale: f64,
    pub reach_squared: f64,
    pub form: TriangleForm,
}

impl Query {
    /// A normal in deviations of the kernel from the half vector.
    #[inline(always)]
    pub fn whiten(&self, [s, t]: [f64; 2]) -> [f64; 2] {
        [
            (s - self.normal[0]) * self.scale,
            (t - self.normal[1]) * self.scale,
        ]
    }

    /// Whether the footprint reaches no point of the cell at `corner`, in deviations.
    #[inline(always)]
    pub fn is_beyond(&self, corner: [f64; 2]) -> bool {
        far_from(corner, self.frame.edges) >= self.reach_squared
    }

    /// Whether the query reaches no point of the cell at `corner` in the middle of 4 × 4 whitened normals that cubics go through.
    ///
    /// Weights of either axis take an eighth from some texels, at most, to give to others: cubics leave the box of their texels by
    /// `1/8 + 5/4 · 1/8` of its sides.
    #[inline(always)]
    pub fn is_cubic_beyond(&self, corner: [f64; 2], texels: &[[[f64; 2]; 4]; 4]) -> bool {
        const OVERSHOOT: f64 = 0.281_25;
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for [s, t] in texels.as_flattened() {
            low = [low[0].min(*s), low[1].min(*t)];
            high = [high[0].max(*s), high[1].max(*t)];
        }
        let axis = |low: f64, high: f64| {
            let room = OVERSHOOT * (high - low);
            (low - room).max(-(high + room)).max(0.0)
        };
        let (s, t) = (axis(low[0], high[0]), axis(low[1], high[1]));
        far_from(corner, self.frame.edges) + s * s + t * t >= self.reach_squared
    }

    /// The integral over a square of two triangles, in units of the kernel's peak: at `corner`, with edges `across` and
    /// `down`, in deviations, of `area` texel², and the whitened normals of its corners row by row.
    #[inline(always)]
    pub fn square(
        &self,
        corner: [f64; 2],
        [across, down]: [[f64; 2]; 2],
        area: f64,
        [a, b, c, d]: [[f64; 2]; 4],
    ) -> f64 {
        let reach = self.reach_squared;
        let far = far_from(corner, [across, down]) + far_of([a, b, c, d]);
        if far >= reach {
            return 0.0;
        }
        let join = |[x, y]: [f64; 2], [s, t]: [f64; 2]| -> Point { [x, y, s, t] };
        let less = |[s, t]: [f64; 2], [u, v]: [f64; 2]| [s - u, t - v];
        let minus = |[x, y]: [f64; 2]| [-x, -y];
        let opposite = [
            corner[0] + across[0] + down[0],
            corner[1] + across[1] + down[1],
        ];
        let upper = mean(
            join(corner, a),
            [join(across, less(b, a)), join(down, less(c, a))],
            Shape::Triangle,
            self.form,
            reach,
        );
        let lower = mean(
            join(opposite, d),
            [
                join(minus(across), less(c, d)),
                join(minus(down), less(b, d)),
            ],
            Shape::Triangle,
            self.form,
            reach,
        );
        0.5 * area * self.frame.weight * (upper + lower)
    }

    /// The integral over a parallelogram whose normals are those of `corner_normal`, and change to that of `other` along the second
    /// edge.
    #[inline(always)]
    pub fn strip(
        &self,
        corner: [f64; 2],
        [along, across]: [[f64; 2]; 2],
        area: f64,
        [near, other]: [[f64; 2]; 2],
    ) -> f64 {
        let far = far_from(corner, [along, across]) + far_of([near, near, other, other]);
        if far >= self.reach_squared {
            return 0.0;
        }
        let value = mean(
            [corner[0], corner[1], near[0], near[1]],
            [
                [along[0], along[1], 0.0, 0.0],
                [across[0], across[1], other[0] - near[0], other[1] - near[1]],
            ],
            Shape::Parallelogram,
            self.form,
            self.reach_squared,
        );
        area * self.frame.weight * value
    }

    /// The share of the footprint, whatever the normals, on the parallelogram at `corner`; in [0, 1].
    pub fn share(&self, corner: [f64; 2], edges: [[f64; 2]; 2], area: f64) -> f64 {
        let Self { frame, .. } = self;
        let flat = |[x, y]: [f64; 2]| -> Point { [x, y, 0.0, 0.0] };
        let value = mean(
            flat(corner),
            edges.map(flat),
            Shape::Parallelogram,
            TriangleForm::Accurate,
            f64::INFINITY,
        );
        area * frame.weight * value
    }
}

/// A bound of the squared distance of a parallelogram from the origin.
#[inline(always)]
fn far_from(corner: [f64; 2], [across, down]: [[f64; 2]; 2]) -> f64 {
    let axis = |corner: f64, across: f64, down: f64| {
        let middle = corner + 0.5 * (across + down);
        (middle.abs() - 0.5 * (across.abs() + down.abs())).max(0.0)
    };
    let x = axis(corner[0], across[0], down[0]);
    let y = axis(corner[1], across[1], down[1]);
    x * x + y * y
}

/// A bound of the squared distance of all points between four from the origin.
#[inline(always)]
fn far_of([a, b, c, d]: [[f64; 2]; 4]) -> f64 {
    let axis = |a: f64, b: f64, c: f64, d: f64| {
        let low = a.min(b).min(c.min(d));
        let high = a.max(b).max(c.max(d));
        low.max(-high).max(0.0)
    };
    let s = axis(a[0], b[0], c[0], d[0]);
    let t = axis(a[1], b[1], c[1], d[1]);
    s * s + t * t
}
