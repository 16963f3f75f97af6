//! Moments of lobes in position and normal, and the one Gaussian that has them.

use glintbake_format::view::LobeNormal;

/// Weight, mean and covariance of a set of lobes, without the kernel's variance, which all of them have alike.
///
/// Positions are in texels. A merged lobe is the moment match of its members in 4D \[TZX22\] §5.1.2: as every member's normals are
/// Gaussian about a plane over position, `cov(u, u) = A`, `cov(s, u) = J A` and `cov(s, s) = J A Jᵀ + σr² I`, means and
/// covariances of the mixture are sums of positive parts, and σr² passes through.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Moments {
    pub weight: f64,
    /// Position, then normal.
    pub mean: [f64; 4],
    /// Upper triangle of the covariance times the weight, row by row.
    pub scatter: [f64; 10],
}

/// Row and column of each element of an upper triangle.
const TRIANGLE: [(usize, usize); 10] = [
    (0, 0),
    (0, 1),
    (0, 2),
    (0, 3),
    (1, 1),
    (1, 2),
    (1, 3),
    (2, 2),
    (2, 3),
    (3, 3),
];

impl Moments {
    /// A lobe of weight 1 at `position` with the position variance `variance`; its slope is per texel.
    pub fn of_lobe(position: [f64; 2], variance: f64, lobe: &LobeNormal) -> Self {
        let [s_x, s_y, t_x, t_y] = lobe.slope;
        let [s, t] = lobe.normal;
        Self {
            weight: 1.0,
            mean: [position[0], position[1], s, t],
            scatter: [
                variance,
                0.0,
                variance * s_x,
                variance * t_x,
                variance,
                variance * s_y,
                variance * t_y,
                variance * (s_x * s_x + s_y * s_y),
                variance * (s_x * t_x + s_y * t_y),
                variance * (t_x * t_x + t_y * t_y),
            ],
        }
    }

    /// Adds `other`; by the pairwise form, in which nothing cancels.
    pub fn add(&mut self, other: &Self) {
        let weight = self.weight + other.weight;
        if weight <= 0.0 {
            return;
        }
        let part = other.weight / weight;
        let apart: [f64; 4] = core::array::from_fn(|k| other.mean[k] - self.mean[k]);
        for (sum, ((i, j), own)) in self
            .scatter
            .iter_mut()
            .zip(TRIANGLE.iter().zip(other.scatter))
        {
            *sum += own + self.weight * part * apart[*i] * apart[*j];
        }
        for (mean, apart) in self.mean.iter_mut().zip(apart) {
            *mean += part * apart;
        }
        self.weight = weight;
    }

    /// The same, `x` texels farther right and `y` farther down.
    pub fn moved(mut self, [x, y]: [f64; 2]) -> Self {
        self.mean[0] += x;
        self.mean[1] += y;
        self
    }

    /// The Gaussian that has these moments, in regression form.
    ///
    /// `J = cov(s, u) A⁻¹` and `R = cov(s, s) - J A Jᵀ`, which is the covariance of what J leaves of normals: positive but for
    /// rounding. Every A is at least a lobe's own variance, so it has an inverse.
    pub fn lobe(&self) -> ClusteredLobe {
        let c = self.scatter.map(|sum| sum / self.weight);
        let [xx, xy, xs, xt, yy, ys, yt, ss, st, tt] = c;
        let l_11 = xx.sqrt();
        let l_21 = xy / l_11;
        let l_22 = (yy - l_21 * l_21).max(0.0).sqrt();
        // B = J L: cov(s, u) = J L Lᵀ = B Lᵀ.
        let column = |x: f64, y: f64| {
            let first = x / l_11;
            let second = if l_22 > 0.0 {
                (y - l_21 * first) / l_22
            } else {
                0.0
            };
            [first, second]
        };
        let (b_s, b_t) = (column(xs, ys), column(xt, yt));
        // J = B L⁻¹.
        let slope = |[first, second]: [f64; 2]| {
            let down = if l_22 > 0.0 { second / l_22 } else { 0.0 };
            [(first - down * l_21) / l_11, down]
        };
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let r_ss = (ss - dot(b_s, b_s)).max(0.0);
        let r_st = st - dot(b_s, b_t);
        let r_tt = (tt - dot(b_t, b_t)).max(0.0);
        let m_11 = r_ss.sqrt();
        let m_21 = if m_11 > 0.0 {
            (r_st / m_11).clamp(-r_tt.sqrt(), r_tt.sqrt())
        } else {
            0.0
        };
        ClusteredLobe {
            weight: self.weight,
            position: [self.mean[0], self.mean[1]],
            factor: [l_11, l_21, l_22],
            normal: [self.mean[2], self.mean[3]],
            slope: {
                let ([s_x, s_y], [t_x, t_y]) = (slope(b_s), slope(b_t));
                [s_x, s_y, t_x, t_y]
            },
            residual: [m_11, m_21, (r_tt - m_21 * m_21).max(0.0).sqrt()],
        }
    }

    /// The greatest standard deviation of normals in any direction, and of none of them more.
    pub fn spread(&self) -> f64 {
        let [.., ss, _, tt] = self.scatter;
        ((ss + tt) / self.weight).max(0.0).sqrt()
    }
}

/// A Gaussian of position, and about a plane over it of normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ClusteredLobe {
    pub weight: f64,
    pub position: [f64; 2],
    /// L of A = L Lᵀ: first column, below it, second column.
    pub factor: [f64; 3],
    pub normal: [f64; 2],
    /// ∂s/∂x, ∂s/∂y, ∂t/∂x, ∂t/∂y per texel.
    pub slope: [f64; 4],
    /// M of R = M Mᵀ, as L.
    pub residual: [f64; 3],
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some() -> Vec<Moments> {
        (0..9)
            .map(|k| {
                let k = f64::from(k);
                let lobe = LobeNormal {
                    normal: [0.1 * (k * 1.3).sin(), 0.2 * (k * 0.7).cos()],
                    slope: [0.01 * k, -0.02, 0.03, 0.005 * k],
                };
                Moments::of_lobe([k % 3.0, (k / 3.0).floor()], 0.2, &lobe)
            })
            .collect()
    }

    fn sum(all: &[Moments]) -> Moments {
        let mut sum = Moments::default();
        for one in all {
            sum.add(one);
        }
        sum
    }

    #[test]
    fn moments_of_parts_are_those_of_the_whole_in_any_order() {
        let all = some();
        let whole = sum(&all);
        let mut parts = sum(all.get(5..).unwrap());
        parts.add(&sum(all.get(..5).unwrap()));
        let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(whole.mean.iter().zip(parts.mean).all(|(&a, b)| close(a, b)));
        let scatters = whole.scatter.iter().zip(parts.scatter);
        assert!(scatters.into_iter().all(|(&a, b)| close(a, b)));
    }

    #[test]
    fn the_gaussian_has_the_covariance_of_normals_and_of_position_with_normal() {
        let whole = sum(&some());
        let lobe = whole.lobe();
        let [a, b, c] = lobe.factor;
        let cov = [a * a, a * b, b * b + c * c];
        let [s_x, s_y, t_x, t_y] = lobe.slope;
        let [m, n, o] = lobe.residual;
        let product = |x: f64, y: f64| [x * cov[0] + y * cov[1], x * cov[1] + y * cov[2]];
        let (s, t) = (product(s_x, s_y), product(t_x, t_y));
        let found = [
            cov[0],
            cov[1],
            s[0],
            t[0],
            cov[2],
            s[1],
            t[1],
            s[0] * s_x + s[1] * s_y + m * m,
            s[0] * t_x + s[1] * t_y + m * n,
            t[0] * t_x + t[1] * t_y + n * n + o * o,
        ];
        for (found, sum) in found.iter().zip(whole.scatter) {
            let expected = sum / whole.weight;
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }

    #[test]
    fn a_lobe_by_itself_stays_what_it_is() {
        let lobe = LobeNormal {
            normal: [0.3, -0.1],
            slope: [0.02, -0.03, 0.05, 0.07],
        };
        let found = Moments::of_lobe([3.0, 4.0], 0.25, &lobe).lobe();
        assert_eq!(found.factor, [0.5, 0.0, 0.5]);
        let slopes = found.slope.iter().zip(lobe.slope);
        assert!(slopes.into_iter().all(|(a, b)| (a - b).abs() < 1e-15));
        assert!(found.residual.iter().all(|x| x.abs() < 1e-8), "{found:?}");
    }
}
