//! Which level of the pyramid a footprint looks at, and where: trilinear filtering with anisotropic probes.
//!
//! A footprint's widths are those of a box of the same covariance, along its principal axes: the singular values of
//! `[e1 e2]` for a box, √3 times these for a Gaussian. Probes are as wide as the short one, but at least so wide that
//! [`PROBES`] of them span the long one, and at least a cell of the finest level.
//!
//! Nothing pops as the footprint changes: probes appear at the ends with weight 0.

use glintbake_format::model::{Filter, PyramidLayout};

/// The most probes, an odd number.
const PROBES: u32 = 15;
/// Probes to one side of the middle.
const HALF: f64 = 7.0;
/// How many times as long as its probes a Gaussian may be: the last probes then stand at 3.5 standard deviations.
const GAUSSIAN_LENGTH: f64 = 7.9;
/// Where the Gaussian along the long axis ends, in standard deviations; weights fall to 0 there.
const RADIUS: f64 = 3.5;
/// Share by which a footprint must be longer than its probes before there is more than one: the axes of squares differ by
/// the root of rounding.
const ROUND: f64 = 1e-6;

/// Components of edges shorter than this many texels count as zero, which keeps every product within the range of f64.
const SHORTEST: f64 = 1e-100;

/// Probes along a line through the footprint's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Probes {
    /// Level of every probe, between the finest stored and the top.
    pub level: f64,
    /// Unit vector of the long axis.
    axis: [f64; 2],
    /// Width of a probe in texels, and as a rule the distance of two.
    width: f64,
    along: Along,
}

/// How probes lie and weigh.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Along {
    /// Evenly over this length: the last two stand for what is left at the ends.
    Even(f64),
    /// By a Gaussian of this standard deviation.
    Gaussian(f64),
}

impl Probes {
    /// The probes of a footprint with `edges` in texels, by `filter`.
    pub fn new(edges: [[f64; 2]; 2], filter: Filter, layout: PyramidLayout) -> Self {
        let edges = edges.map(|edge| edge.map(|x| if x.abs() < SHORTEST { 0.0 } else { x }));
        let (axis, [long, short]) = principal(edges);
        let (stretch, most) = match filter {
            Filter::Box => (1.0, f64::from(PROBES)),
            Filter::Gaussian => (libm::sqrt(3.0), GAUSSIAN_LENGTH),
        };
        let (long, short) = (long * stretch, short * stretch);
        let finest = f64::from(layout.finest());
        let cell = f64::from(1_u32.wrapping_shl(layout.finest()));
        let width = short.max(long / most).max(cell);
        Self {
            level: libm::log2(width).clamp(finest, f64::from(layout.top())),
            axis,
            width,
            along: match filter {
                Filter::Box => Along::Even(long * (1.0 - ROUND)),
                // What probes are wide themselves is not theirs to spread.
                Filter::Gaussian => {
                    let rest = ((long - (1.0 + ROUND) * width) * (long + width)).max(0.0);
                    Along::Gaussian(libm::sqrt(rest / 12.0))
                }
            },
        }
    }

    /// The two levels that [`level`](Self::level) lies between, and their shares.
    pub fn levels(&self) -> [(u32, f64); 2] {
        let lower = libm::floor(self.level);
        let share = self.level - lower;
        // Casts saturate, and the level is within the pyramid's.
        [(lower as u32, 1.0 - share), (lower as u32 + 1, share)]
    }

    /// Calls `visit(offset, weight)` for each probe: where it is relative to the centre, in texels, and its share. Shares
    /// add up to 1 within rounding.
    ///
    /// # Errors
    /// What `visit` returns.
    pub fn for_each<E>(
        &self,
        visit: &mut impl FnMut([f64; 2], f64) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut at = |place: f64, weight: f64| {
            if weight > 0.0 {
                visit([place * self.axis[0], place * self.axis[1]], weight)
            } else {
                Ok(())
            }
        };
        match self.along {
            Along::Even(length) if length > self.width => {
                let whole = libm::floor((length / self.width - 1.0) * 0.5).min(HALF - 1.0);
                let rest = 0.5 * length - (whole + 0.5) * self.width;
                at(0.0, self.width / length)?;
                for number in 1..=whole as u32 {
                    let place = f64::from(number) * self.width;
                    at(place, self.width / length)?;
                    at(-place, self.width / length)?;
                }
                // Where both give the whole its second moment: probes that stand for less are as wide as the rest. With the
                // n pairs between, Σ k² = n (n + 1) (2n + 1) / 6.
                let pairs = whole * (whole + 1.0) * (2.0 * whole + 1.0) / 6.0;
                let square = self.width * self.width;
                let moment = length * (length * length - square) / 24.0;
                let left = (moment - self.width * square * pairs).max(0.0);
                let place = libm::sqrt(left / rest).min(0.5 * length);
                at(place, rest / length)?;
                at(-place, rest / length)
            }
            Along::Gaussian(deviation) if deviation > 0.0 => {
                // As far apart as they are wide, but near enough for three to spread as the Gaussian does.
                let step = self.width.min(0.5 * RADIUS * deviation);
                let count = libm::floor(RADIUS * deviation / step).min(HALF) as u32;
                let floor = libm::exp(-0.5 * RADIUS * RADIUS);
                let weight = |number: u32| {
                    let x = f64::from(number) * step / deviation;
                    (libm::exp(-0.5 * x * x) - floor).max(0.0)
                };
                let sum = weight(0) + 2.0 * (1..=count).map(weight).sum::<f64>();
                at(0.0, weight(0) / sum)?;
                for number in 1..=count {
                    let place = f64::from(number) * step;
                    at(place, weight(number) / sum)?;
                    at(-place, weight(number) / sum)?;
                }
                Ok(())
            }
            Along::Even(_) | Along::Gaussian(_) => at(0.0, 1.0),
        }
    }
}

/// Unit vector along the longer principal axis of `edges[0] edges[0]ᵀ + edges[1] edges[1]ᵀ`, and the square roots of its
/// eigenvalues, the greater first. Any axis if both are the same.
fn principal([[x_1, y_1], [x_2, y_2]]: [[f64; 2]; 2]) -> ([f64; 2], [f64; 2]) {
    let (xx, xy, yy) = (
        x_1 * x_1 + x_2 * x_2,
        x_1 * y_1 + x_2 * y_2,
        y_1 * y_1 + y_2 * y_2,
    );
    // The product of both roots; a difference of eigenvalues would lose the smaller one of a needle.
    let area = (x_1 * y_2 - y_1 * x_2).abs();
    let sum = xx + yy;
    let greater = 0.5 * (sum + libm::sqrt(((sum - 2.0 * area) * (sum + 2.0 * area)).max(0.0)));
    let long = libm::sqrt(greater);
    if long == 0.0 {
        return ([1.0, 0.0], [0.0, 0.0]);
    }
    let short = (area / long).min(long);
    // Either row of the matrix less the smaller eigenvalue, the one that cancels less.
    let axis = if xx >= yy {
        [xx - short * short, xy]
    } else {
        [xy, yy - short * short]
    };
    let length = libm::sqrt(axis[0] * axis[0] + axis[1] * axis[1]);
    let axis = if length > 0.0 {
        [axis[0] / length, axis[1] / length]
    } else {
        [1.0, 0.0]
    };
    (axis, [long, short])
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    fn probes(edges: [[f64; 2]; 2], filter: Filter) -> (f64, Vec<([f64; 2], f64)>) {
        let layout = PyramidLayout::new(4096, 4096, 0).unwrap();
        let probes = Probes::new(edges, filter, layout);
        let mut all = Vec::new();
        probes
            .for_each(&mut |offset, weight| {
                all.push((offset, weight));
                Ok::<(), ()>(())
            })
            .unwrap();
        (probes.level, all)
    }

    #[test]
    fn squares_take_one_probe_of_their_own_size() {
        for turn in [0.0, 0.3, 1.1] {
            let (cos, sin) = (8.0 * libm::cos(turn), 8.0 * libm::sin(turn));
            let (level, all) = probes([[cos, sin], [-sin, cos]], Filter::Box);
            assert!((level - 3.0).abs() < 1e-7, "{level}");
            assert_eq!(all, [([0.0, 0.0], 1.0)]);
            let (_, all) = probes([[cos, sin], [-sin, cos]], Filter::Gaussian);
            assert_eq!(all, [([0.0, 0.0], 1.0)]);
        }
    }

    #[test]
    fn shares_add_up_and_spread_as_the_footprint_does() {
        for filter in [Filter::Box, Filter::Gaussian] {
            for step in 0..2000 {
                let ratio = libm::pow(10.0, f64::from(step) * 0.003);
                let short = 4.0;
                let (long, other) = ([0.6 * short * ratio, 0.8 * short * ratio], [-3.2, 2.4]);
                let (level, all) = probes([long, other], filter);
                assert!(all.len() <= PROBES as usize, "{ratio}: {}", all.len());
                let sum: f64 = all.iter().map(|probe| probe.1).sum();
                assert!((sum - 1.0).abs() < 1e-14, "{ratio}: {sum}");
                let spread: f64 = all
                    .iter()
                    .map(|([x, y], weight)| weight * (x * x + y * y))
                    .sum();
                let width = libm::exp2(level);
                let kappa = if filter == Filter::Box { 12.0 } else { 4.0 };
                let wanted = short * short * ratio * ratio / kappa;
                let got = spread + width * width / 12.0;
                // The top ends the pyramid before the longest of these do.
                if level < 12.0 {
                    assert!(
                        (got / wanted - 1.0).abs()
                            < if filter == Filter::Box { 1e-5 } else { 0.12 },
                        "{filter:?} {ratio}: {got} {wanted}"
                    );
                }
            }
        }
    }

    #[test]
    fn degenerate_edges_have_a_level_and_finite_probes() {
        for filter in [Filter::Box, Filter::Gaussian] {
            for edges in [
                [[0.0; 2]; 2],
                [[1e-300, 0.0], [0.0, 1e-300]],
                [[5.0, 3.0], [-10.0, -6.0]],
                [[1e7, 1e7], [-1.0, 1.0]],
                [[0.0, 1e7], [0.0, -1e7]],
                [[3.0, 0.0], [0.0, 3.0]],
            ] {
                let (level, all) = probes(edges, filter);
                assert!((0.0..=12.0).contains(&level), "{edges:?}: {level}");
                assert!(!all.is_empty() && all.len() <= PROBES as usize);
                for ([x, y], weight) in all {
                    assert!(x.is_finite() && y.is_finite() && weight > 0.0);
                }
            }
        }
    }
}
