//! Sixteen lobes under a footprint, side by side.
#![expect(
    clippy::indexing_slicing,
    clippy::needless_range_loop,
    reason = "arrays of 16 by numbers below 16, which compilers see and checked indexing would hide from them"
)]

use crate::lanes::{LANES, Lanes, exponential, inverse_root, sum};
use crate::ndf::lobes::term::Term;
use glintbake_format::records::MipBlock;

/// Standard deviations, of position and normal together, beyond which lobes of a block are not looked at: 4e-6 of a peak.
const REACH: f64 = 5.0;

/// What a footprint and a half vector are to all lobes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asked {
    /// The columns of E, Σp = E Eᵀ, in texels.
    pub half_edges: [[f32; 2]; 2],
    /// The half vector.
    pub normal: [f64; 2],
    /// 1 / σr.
    pub scale: f64,
}

/// Sixteen lobes' positions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Positions {
    /// Texels² each stands for.
    pub weight: Lanes,
    /// `u_p` - `u_i`, in texels.
    pub x: Lanes,
    pub y: Lanes,
    /// L of A = L Lᵀ, in texels.
    pub l_11: Lanes,
    pub l_21: Lanes,
    pub l_22: Lanes,
}

/// Their normals, and slopes, in deviations σr of the kernel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Normals {
    /// The half vector less the normal at the middle.
    pub s: Lanes,
    pub t: Lanes,
    /// J, per texel.
    pub s_x: Lanes,
    pub s_y: Lanes,
    pub t_x: Lanes,
    pub t_y: Lanes,
    /// M: R = I + M Mᵀ.
    pub m_11: Lanes,
    pub m_21: Lanes,
    pub m_22: Lanes,
}

impl Positions {
    /// Lobes that weigh nothing.
    pub const NONE: Self = {
        let (zero, one) = ([0.0; LANES], [1.0; LANES]);
        Self {
            weight: zero,
            x: zero,
            y: zero,
            l_11: one,
            l_21: zero,
            l_22: one,
        }
    };

    /// Those of `block`, of a cell of `side` texels and `area` texels², whose corner lies `offset` before the footprint's centre.
    #[inline(always)]
    pub fn of_block(block: &MipBlock, side: f32, area: f32, offset: [f32; 2]) -> Self {
        let mut lobes = Self::NONE;
        let whole = 1.0 / 65535.0;
        let place = side * whole;
        let (width, lean) = (0.5 * place, 0.5 * side / 32767.0);
        let weight = area * whole;
        for lane in 0..LANES {
            lobes.weight[lane] = weight * f32::from(block.weight[lane].get());
            lobes.x[lane] = offset[0] - place * f32::from(block.x[lane].get());
            lobes.y[lane] = offset[1] - place * f32::from(block.y[lane].get());
            // Lanes without a lobe have no width; nothing is divided by it.
            lobes.l_11[lane] = width * f32::from(block.l_11[lane].get().max(1));
            lobes.l_21[lane] = lean * f32::from(block.l_21[lane].get());
            lobes.l_22[lane] = width * f32::from(block.l_22[lane].get().max(1));
        }
        lobes
    }
}

/// Where normals come from, if they are wanted.
pub(super) trait Source {
    /// Whether any of them may be within reach of the half vector.
    fn is_near(&self, asked: &Asked) -> bool;
    /// The normals.
    fn normals(&self, asked: &Asked) -> Normals;
}

impl Source for Normals {
    #[inline(always)]
    fn is_near(&self, _: &Asked) -> bool {
        true
    }

    #[inline(always)]
    fn normals(&self, _: &Asked) -> Normals {
        *self
    }
}

impl Source for MipBlock {
    /// Whether a lobe of the block may be within reach of the half vector.
    ///
    /// At q deviations of position the mean of a lobe that spreads by b lies up to b q off its middle, and its variance is 1 + b² at
    /// most. So at a gap g of normals, `q² + (g - b q)² / (1 + b²)` is the squared distance at least, whose least over q is
    /// `g² / (1 + 2 b²)`.
    #[inline(always)]
    fn is_near(&self, asked: &Asked) -> bool {
        let gap = |axis: usize| {
            let low = f64::from(self.low[axis].get());
            let high = low + 65535.0 * f64::from(self.step[axis].get());
            let h = asked.normal[axis];
            (low - h).max(h - high).max(0.0) * asked.scale
        };
        let spread = f64::from(self.spread.get()) * asked.scale;
        let (s, t) = (gap(0), gap(1));
        s * s + t * t <= REACH * REACH * (1.0 + 2.0 * spread * spread)
    }

    #[inline(always)]
    fn normals(&self, asked: &Asked) -> Normals {
        let mut lobes = Normals::NONE;
        let scale = asked.scale;
        let relative = |axis: usize| {
            let low = f64::from(self.low[axis].get());
            ((asked.normal[axis] - low) * scale) as f32
        };
        let normal = [relative(0), relative(1)];
        let step = self.step.map(|step| (f64::from(step.get()) * scale) as f32);
        let slope = (f64::from(self.slope_step.get()) * scale) as f32;
        let residual = (f64::from(self.residual_step.get()) * scale) as f32;
        for lane in 0..LANES {
            lobes.s[lane] = normal[0] - step[0] * f32::from(self.s[lane].get());
            lobes.t[lane] = normal[1] - step[1] * f32::from(self.t[lane].get());
            lobes.s_x[lane] = slope * f32::from(self.s_x[lane].get());
            lobes.s_y[lane] = slope * f32::from(self.s_y[lane].get());
            lobes.t_x[lane] = slope * f32::from(self.t_x[lane].get());
            lobes.t_y[lane] = slope * f32::from(self.t_y[lane].get());
            lobes.m_11[lane] = residual * f32::from(self.m_11[lane].get());
            lobes.m_21[lane] = residual * f32::from(self.m_21[lane].get());
            lobes.m_22[lane] = residual * f32::from(self.m_22[lane].get());
        }
        lobes
    }
}

impl Normals {
    /// Flat ones at the half vector.
    pub const NONE: Self = {
        let zero = [0.0; LANES];
        Self {
            s: zero,
            t: zero,
            s_x: zero,
            s_y: zero,
            t_x: zero,
            t_y: zero,
            m_11: zero,
            m_21: zero,
            m_22: zero,
        }
    };
}

/// Positions under the footprint, whitened by each lobe's own L.
struct Whitened {
    /// `w N(u_p; u_i, S)` but for 2π.
    weight: Lanes,
    /// a⁻¹ y, for y = L⁻¹ (`u_p` - `u_i`).
    v_0: Lanes,
    v_1: Lanes,
    /// The columns of E' N^(-1/2).
    g_0: Lanes,
    g_1: Lanes,
    h_0: Lanes,
    h_1: Lanes,
}

impl Positions {
    /// The sum of all `w N(u_p; u_i, S)`, and of those times the density at the half vector, 0 where `source` says that none is near; both
    /// but for the factors `1 / 2π` and `1 / 2π σr²`.
    ///
    /// With y = L⁻¹ (`u_p` - `u_i`) and E' = L⁻¹ E, `L⁻¹ S L⁻ᵀ = a` = I + E' E'ᵀ, and the shift of the mean is B a⁻¹ y with B = J L. As
    /// det a = 1 + |e1|² + |e2|² + (e1 × e2)² and adj a = I + Σ e⊥ e⊥ᵀ, everything is a sum of positive parts:
    /// yᵀ a⁻¹ y = (|y|² + Σ (e × y)²) / det a. Likewise the covariance of normals is I + Σ f fᵀ over the two columns of M and those
    /// of B E' N^(-1/2), N = I + E'ᵀ E', whose determinant is that of a.
    #[inline(always)]
    pub fn sums(&self, source: &impl Source, asked: &Asked) -> (f32, f32) {
        let whitened = self.whitened(asked);
        let weight = sum(&whitened.weight);
        if !source.is_near(asked) {
            return (weight, 0.0);
        }
        (weight, self.density(&whitened, &source.normals(asked)))
    }

    /// All `w N(u_p; u_i, S)` but for the factor `1 / 2π`, as in [`sums`](Self::sums).
    #[inline(always)]
    pub fn weights(&self, asked: &Asked) -> Lanes {
        self.whitened(asked).weight
    }

    #[inline(always)]
    fn whitened(&self, asked: &Asked) -> Whitened {
        let [[e1_x, e1_y], [e2_x, e2_y]] = asked.half_edges;
        let zero = [0.0; LANES];
        let mut found = Whitened {
            weight: zero,
            v_0: zero,
            v_1: zero,
            g_0: zero,
            g_1: zero,
            h_0: zero,
            h_1: zero,
        };
        for lane in 0..LANES {
            let (l_11, l_21, l_22) = (self.l_11[lane], self.l_21[lane], self.l_22[lane]);
            let (i_11, i_22) = (1.0 / l_11, 1.0 / l_22);
            let y_0 = self.x[lane] * i_11;
            let y_1 = (self.y[lane] - l_21 * y_0) * i_22;
            let a_0 = e1_x * i_11;
            let a_1 = (e1_y - l_21 * a_0) * i_22;
            let b_0 = e2_x * i_11;
            let b_1 = (e2_y - l_21 * b_0) * i_22;
            let cross = a_0 * b_1 - a_1 * b_0;
            let (aa, bb) = (a_0 * a_0 + a_1 * a_1, b_0 * b_0 + b_1 * b_1);
            let root = inverse_root(1.0 + aa + bb + cross * cross);
            let inverse = root * root;
            let (a_y, b_y) = (a_0 * y_1 - a_1 * y_0, b_0 * y_1 - b_1 * y_0);
            let squared = (y_0 * y_0 + y_1 * y_1 + a_y * a_y + b_y * b_y) * inverse;
            found.weight[lane] =
                self.weight[lane] * exponential(-0.5 * squared) * root * (i_11 * i_22);
            found.v_0[lane] = (y_0 - a_1 * a_y - b_1 * b_y) * inverse;
            found.v_1[lane] = (y_1 + a_0 * a_y + b_0 * b_y) * inverse;
            // By the triangular root of N.
            let n_11 = 1.0 + aa;
            let r_11 = inverse_root(n_11);
            let ratio = (a_0 * b_0 + a_1 * b_1) * r_11 * r_11;
            let r_22 = n_11 * r_11 * root;
            found.g_0[lane] = a_0 * r_11;
            found.g_1[lane] = a_1 * r_11;
            found.h_0[lane] = (b_0 - ratio * a_0) * r_22;
            found.h_1[lane] = (b_1 - ratio * a_1) * r_22;
        }
        found
    }

    #[inline(always)]
    fn density(&self, whitened: &Whitened, normals: &Normals) -> f32 {
        let mut values = [0.0; LANES];
        for lane in 0..LANES {
            let (l_11, l_21, l_22) = (self.l_11[lane], self.l_21[lane], self.l_22[lane]);
            // B = J L.
            let (s_x, s_y) = (normals.s_x[lane], normals.s_y[lane]);
            let (t_x, t_y) = (normals.t_x[lane], normals.t_y[lane]);
            let (s_0, s_1) = (s_x * l_11 + s_y * l_21, s_y * l_22);
            let (t_0, t_1) = (t_x * l_11 + t_y * l_21, t_y * l_22);
            let (v_0, v_1) = (whitened.v_0[lane], whitened.v_1[lane]);
            let s = normals.s[lane] - (s_0 * v_0 + s_1 * v_1);
            let t = normals.t[lane] - (t_0 * v_0 + t_1 * v_1);
            let (g_0, g_1) = (whitened.g_0[lane], whitened.g_1[lane]);
            let (h_0, h_1) = (whitened.h_0[lane], whitened.h_1[lane]);
            let (f_s, f_t) = (s_0 * g_0 + s_1 * g_1, t_0 * g_0 + t_1 * g_1);
            let (g_s, g_t) = (s_0 * h_0 + s_1 * h_1, t_0 * h_0 + t_1 * h_1);
            let (m_11, m_21, m_22) = (normals.m_11[lane], normals.m_21[lane], normals.m_22[lane]);
            let squares = f_s * f_s
                + f_t * f_t
                + g_s * g_s
                + g_t * g_t
                + m_11 * m_11
                + m_21 * m_21
                + m_22 * m_22;
            let f_g = f_s * g_t - f_t * g_s;
            let f_m = f_s * m_21 - f_t * m_11;
            let g_m = g_s * m_21 - g_t * m_11;
            let (f_n, g_n, m_n) = (f_s * m_22, g_s * m_22, m_11 * m_22);
            let crosses = f_g * f_g + f_m * f_m + g_m * g_m + f_n * f_n + g_n * g_n + m_n * m_n;
            let root = inverse_root(1.0 + squares + crosses);
            let (f_d, g_d) = (f_s * t - f_t * s, g_s * t - g_t * s);
            let (m_d, n_d) = (m_11 * t - m_21 * s, -m_22 * s);
            let distance = s * s + t * t + f_d * f_d + g_d * g_d + m_d * m_d + n_d * n_d;
            values[lane] =
                whitened.weight[lane] * exponential(-0.5 * distance * (root * root)) * root;
        }
        sum(&values)
    }

    /// The weight of lane `lane` as in [`sums`](Self::sums), and its Gaussian of normals: `mean` and covariance in the disk's own units.
    /// In f64, by way of the same positive sums.
    pub fn term(&self, normals: &Normals, lane: usize, asked: &Asked) -> (f64, Term) {
        let at = |lanes: &Lanes| f64::from(lanes[lane & (LANES - 1)]);
        let (l_11, l_21, l_22) = (at(&self.l_11), at(&self.l_21), at(&self.l_22));
        let whiten = |[x, y]: [f64; 2]| {
            let first = x / l_11;
            [first, (y - l_21 * first) / l_22]
        };
        let [a, b] = asked.half_edges.map(|edge| whiten(edge.map(f64::from)));
        let y = whiten([at(&self.x), at(&self.y)]);
        let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let area = cross(a, b);
        let determinant = 1.0 + dot(a, a) + dot(b, b) + area * area;
        let (a_y, b_y) = (cross(a, y), cross(b, y));
        let squared = (dot(y, y) + a_y * a_y + b_y * b_y) / determinant;
        let weight =
            at(&self.weight) * libm::exp(-0.5 * squared) / (libm::sqrt(determinant) * l_11 * l_22);
        let v = [
            (y[0] - a[1] * a_y - b[1] * b_y) / determinant,
            (y[1] + a[0] * a_y + b[0] * b_y) / determinant,
        ];
        // Back from deviations of the kernel.
        let sigma = 1.0 / asked.scale;
        let s = [
            sigma * (at(&normals.s_x) * l_11 + at(&normals.s_y) * l_21),
            sigma * at(&normals.s_y) * l_22,
        ];
        let t = [
            sigma * (at(&normals.t_x) * l_11 + at(&normals.t_y) * l_21),
            sigma * at(&normals.t_y) * l_22,
        ];
        let n_11 = 1.0 + dot(a, a);
        let ratio = dot(a, b) / n_11;
        let (first, second) = (libm::sqrt(n_11), libm::sqrt(determinant / n_11));
        let g = a.map(|x| x / first);
        let h = [
            (b[0] - ratio * a[0]) / second,
            (b[1] - ratio * a[1]) / second,
        ];
        let [m_11, m_21, m_22] =
            [&normals.m_11, &normals.m_21, &normals.m_22].map(|m| sigma * at(m));
        let variance = sigma * sigma;
        let term = Term {
            mean: [
                asked.normal[0] - sigma * at(&normals.s) + dot(s, v),
                asked.normal[1] - sigma * at(&normals.t) + dot(t, v),
            ],
            residual: [
                variance + m_11 * m_11,
                m_11 * m_21,
                variance + m_21 * m_21 + m_22 * m_22,
            ],
            fan: [[dot(s, g), dot(t, g)], [dot(s, h), dot(t, h)]],
            position_squared: 0.0,
        };
        (weight, term)
    }
}
