//! The density of lobes of an example whose copies make up a surface, line by line over a box \[XTXW24\] §6 and §7.2.
//!
//! Of a footprint `c + a e1 + b e2` the lines of constant b are cut where copies begin, end, or come to be nearer than another; each
//! piece has one owner. In the owner's texels the piece is straight, and along it a lobe
//! `N(u; u_i, σh²) N(s; s_i + J_i (u - u_i), σr²)` is a Gaussian of a, whose integral is a difference of error functions. Lines are
//! summed by Gauss and Legendre's rule over strips narrower than what changes across them. Neither polygons nor tiles nor images
//! are used, which is what the fast way is made of.
//!
//! Lobes of one texel's spacing ripple: their weights add up to 0.89 to 1.12. Densities are divided by the mean of that sum over the
//! footprint.

mod pieces;

use super::gauss_legendre::GaussLegendre;
use super::lobes::lattice::{Seed, seed};
use crate::normals::NormalMap;
use core::f64::consts::{FRAC_1_SQRT_2, TAU};
use glintbake_format::model::{Footprint, HalfVector, LobeLattice, Wrap};
use glintbake_format::view::Copied;
use pieces::strips;

/// Nodes of a strip of lines.
const NODES: usize = 3;

/// Texels beyond which a lobe counts as nothing: 4.9 standard deviations.
const REACH: f64 = 2.1;

/// A surface made of copies of an example.
#[derive(Clone, Debug)]
pub struct Surface {
    /// The example, and how it continues beyond its sides.
    pub example: NormalMap,
    /// Texels along a side of a tile of texture space.
    pub size: u32,
    /// The copies; one, if they are tiled.
    pub copies: Vec<Copied>,
    /// Whether copies have places of their own.
    pub is_scattered: bool,
    /// Whether scale and shear of a copy change the slopes of its normals.
    pub scales_slopes: bool,
    /// Normal of what no copy covers.
    pub ground: [f64; 2],
    /// Standard deviation of its kernel.
    pub ground_deviation: f64,
}

/// A straight piece of a line, in texels of the example of its owner.
#[derive(Clone, Copy, Debug)]
struct Piece {
    copy: usize,
    /// Where a = 0 would be.
    origin: [f64; 2],
    /// How far a takes it.
    step: [f64; 2],
    /// From which a to which.
    range: [f64; 2],
    /// Share of its line among all.
    weight: f64,
}

/// What is seen in one footprint, for many half vectors and roughnesses.
#[derive(Clone, Debug)]
pub struct Prepared {
    surface: Surface,

    pieces: Vec<Piece>,
    bare: f64,
    total: f64,
    /// The rule for what hardly changes.
    gentle: GaussLegendre,
    /// The lobes of the example and of two texels beyond it on each side, row by row.
    seeds: Vec<Seed>,
    /// What each piece weighs.
    masses: Vec<f64>,
}

fn inverse([[xx, xy], [yx, yy]]: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let determinant = xx * yy - xy * yx;
    [
        [yy / determinant, -xy / determinant],
        [-yx / determinant, xx / determinant],
    ]
}

fn times([x, y]: [[f64; 2]; 2], v: [f64; 2]) -> [f64; 2] {
    [x[0] * v[0] + x[1] * v[1], y[0] * v[0] + y[1] * v[1]]
}

impl Prepared {
    /// What `footprint`, a box, shows of `surface`, for kernels no narrower than `sigma`.
    ///
    /// # Accuracy
    /// About 1e-4 of what it is, where copies begin and end; better within one.
    ///
    /// # Cost
    /// Proportional to the texels under the footprint, times the lines across each: six, or more where normals change by more
    /// than `sigma` between them. Tiled copies are folded into one example where the footprint is wider than it.
    ///
    /// # Panics
    /// If a number of the footprint is not finite.
    pub fn new(surface: Surface, footprint: &Footprint, sigma: f64) -> Self {
        let size = f64::from(surface.size);
        // Tiled copies need not repeat as texture space does, and only scattered ones are folded into a tile.
        let centre = footprint.centre.map(|along| {
            let whole = if surface.is_scattered {
                along.floor()
            } else {
                0.0
            };
            (along - whole) * size
        });
        let mut edges =
            [footprint.edge_1, footprint.edge_2].map(|edge| edge.map(|along| along * size));
        let length = |[x, y]: [f64; 2]| (x * x + y * y).sqrt();
        assert!(
            centre
                .iter()
                .chain(edges.iter().flatten())
                .all(|x| x.is_finite()),
            "a footprint must be finite"
        );
        if length(edges[0]) < length(edges[1]) {
            edges.swap(0, 1);
        }
        let [along, across] = edges;
        let near = surface.near(centre, 0.5 * (length(along) + length(across)));
        let width = surface.width_of_strips(sigma);
        let seeds = surface.seeds();
        let mut prepared = Self {
            surface,
            pieces: Vec::new(),
            bare: 0.0,
            total: 0.0,
            gentle: GaussLegendre::new(8),
            seeds,
            masses: Vec::new(),
        };
        let rule = GaussLegendre::new(NODES);
        // In texels of the example, where the finest copy has the most.
        let finest = near
            .iter()
            .map(|near| length(times(near.inverse, across)))
            .fold(f64::MIN_POSITIVE, f64::max);
        if !prepared.surface.is_scattered && finest > f64::from(prepared.surface.example.width()) {
            prepared.fold(&near[0], centre, [along, across], width, &rule);
        } else {
            for (b, share) in strips(&rule, -0.5, 0.5, width / finest) {
                let middle = across.map(|edge| b * edge);
                prepared.line(&near, centre, middle, along, share);
            }
        }
        let masses: Vec<f64> = prepared
            .pieces
            .iter()
            .map(|piece| prepared.sum_over(piece, None))
            .collect();
        prepared.total = masses.iter().sum::<f64>() + prepared.bare;
        prepared.masses = masses;
        prepared
    }

    /// The share of the footprint that no copy covers.
    pub fn bare(&self) -> f64 {
        self.bare
    }

    /// What the positions of lobes add up to on average before densities are divided by it, bare ground counted as 1: 0.89 to 1.12.
    pub fn total(&self) -> f64 {
        self.total
    }

    /// Density `D(h)` for the kernel deviation `sigma`, per solid angle of h, which is that per area of the disk; 0 outside the unit
    /// disk.
    pub fn ndf(&self, h: HalfVector, sigma: f64) -> f64 {
        let normal = [h.s, h.t];
        if h.s * h.s + h.t * h.t >= 1.0 {
            return 0.0;
        }
        let mut copy = usize::MAX;
        let mut pulled = (normal, 1.0);
        let mut sum = 0.0;
        for piece in &self.pieces {
            if piece.copy != copy {
                copy = piece.copy;
                pulled = pulled_back(
                    self.surface.copies[copy].matrix,
                    self.surface.scales_slopes,
                    normal,
                );
            }
            let (normal, area) = pulled;
            sum += area * self.sum_over(piece, Some((normal, sigma)));
        }
        let [s, t] = [0, 1].map(|axis| normal[axis] - self.surface.ground[axis]);
        let deviation = self.surface.ground_deviation;
        let ground = libm::exp(-0.5 * (s * s + t * t) / (deviation * deviation))
            / (TAU * deviation * deviation);
        (sum + self.bare * ground) / self.total
    }

    /// A half vector drawn with density `D (h·n)` by four numbers in [0, 1), or `None` with the probability that it leaves over.
    ///
    /// The first number draws a piece of a line and a place on it, as dense as lobes lie there, the second one of these lobes, the last
    /// two a normal of it.
    pub fn draw(&self, sigma: f64, [first, second, third, fourth]: [f64; 4]) -> Option<HalfVector> {
        let radius = |deviation: f64| deviation * (-2.0 * libm::log1p(-third)).sqrt();
        let (sine, cosine) = libm::sincos(TAU * fourth);
        let about = |[s, t]: [f64; 2], deviation: f64| {
            let at = [s + radius(deviation) * cosine, t + radius(deviation) * sine];
            (at[0] * at[0] + at[1] * at[1] < 1.0).then_some(at)
        };
        let mut left = first * self.total;
        let mut chosen = None;
        for (piece, &mass) in self.pieces.iter().zip(&self.masses) {
            if left < mass {
                chosen = Some((piece, left / mass));
                break;
            }
            left -= mass;
        }
        let Some((piece, share)) = chosen else {
            return about(self.surface.ground, self.surface.ground_deviation)
                .map(|[s, t]| HalfVector { s, t });
        };
        // Halving, as mass grows along the piece.
        let whole = self.sum_over(piece, None);
        let (mut low, mut high) = (piece.range[0], piece.range[1]);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            let part = Piece {
                range: [piece.range[0], middle],
                ..*piece
            };
            if self.sum_over(&part, None) < share * whole {
                low = middle;
            } else {
                high = middle;
            }
        }
        let place = [0, 1].map(|axis| piece.origin[axis] + low * piece.step[axis]);
        let fall = |column: i64, row: i64| {
            let [x, y] = [place[0] - column as f64 - 0.5, place[1] - row as f64 - 0.5];
            let deviation = LobeLattice::DEVIATION;
            libm::exp(-0.5 * (x * x + y * y) / (deviation * deviation))
        };
        let [column, row] = place.map(|at| at.floor() as i64);
        let near = || (-2..=2).flat_map(|y| (-2..=2).map(move |x| (column + x, row + y)));
        let mut left = second * near().map(|(x, y)| fall(x, y)).sum::<f64>();
        let (x, y) = near()
            .find(|&(x, y)| {
                left -= fall(x, y);
                left < 0.0
            })
            .unwrap_or((column, row));
        let lobe = self.seed(x, y);
        let offset = [place[0] - x as f64 - 0.5, place[1] - y as f64 - 0.5];
        let mean = [0, 1].map(|axis| {
            lobe.normal[axis] + lobe.slope[0][axis] * offset[0] + lobe.slope[1][axis] * offset[1]
        });
        let own = about(mean, sigma)?;
        let [s, t] = self.surface.shown(piece.copy, own);
        Some(HalfVector { s, t })
    }

    /// The integral over a of all lobes at `query`'s normal and roughness, or of their positions alone.
    fn sum_over(&self, piece: &Piece, query: Option<([f64; 2], f64)>) -> f64 {
        let Piece {
            origin,
            step,
            range: [from, to],
            weight,
            ..
        } = *piece;
        let length = (step[0] * step[0] + step[1] * step[1]).sqrt() * (to - from);
        // Longer parts pass by fewer lobes twice, shorter ones by fewer that are far.
        let parts = (0.5 * length).ceil().max(1.0);
        let mut sum = 0.0;
        for part in 0..parts as usize {
            let at = |part: f64| from + (to - from) * part / parts;
            let range = [at(part as f64), at(part as f64 + 1.0)];
            let ends = range.map(|a| [origin[0] + a * step[0], origin[1] + a * step[1]]);
            let texels = |axis: usize| {
                let [x, y] = ends.map(|end| end[axis]);
                let low = (x.min(y) - REACH - 0.5).ceil() as i64;
                low..=(x.max(y) + REACH - 0.5).floor() as i64
            };
            for row in texels(1) {
                for column in texels(0) {
                    sum += self.lobe(column, row, origin, step, range, query);
                }
            }
        }
        weight * sum
    }

    /// The lobe of texel (`column`, `row`) of the endless example.
    fn seed(&self, column: i64, row: i64) -> Seed {
        let side = i64::from(self.surface.example.width());
        // Beyond a border that does not repeat nothing changes.
        let place = |index: i64| match self.surface.example.wrap() {
            Wrap::Repeat => index.rem_euclid(side) + 2,
            Wrap::Clamp => index.clamp(-2, side + 1) + 2,
        };
        self.seeds[(place(row) * (side + 4) + place(column)) as usize]
    }

    fn lobe(
        &self,
        column: i64,
        row: i64,
        origin: [f64; 2],
        step: [f64; 2],
        range: [f64; 2],
        query: Option<([f64; 2], f64)>,
    ) -> f64 {
        let sigma_h = LobeLattice::DEVIATION;
        let middle = [column, row].map(|at| at as f64 + 0.5);
        // A point of four dimensions that moves straight as a does, in standard deviations.
        let mut at = [0.0; 4];
        let mut moves = [0.0; 4];
        for axis in 0..2 {
            at[axis] = (origin[axis] - middle[axis]) / sigma_h;
            moves[axis] = step[axis] / sigma_h;
        }
        let mut peak = 1.0 / (TAU * sigma_h * sigma_h);
        if let Some((normal, sigma)) = query {
            let Seed {
                normal: mean,
                slope: [across, down],
            } = self.seed(column, row);
            let offset = [0, 1].map(|axis| origin[axis] - middle[axis]);
            for axis in 0..2 {
                let rises = |u: [f64; 2]| across[axis] * u[0] + down[axis] * u[1];
                at[2 + axis] = (mean[axis] + rises(offset) - normal[axis]) / sigma;
                moves[2 + axis] = rises(step) / sigma;
            }
            peak /= TAU * sigma * sigma;
        }
        let dot = |x: [f64; 4], y: [f64; 4]| x[0] * y[0] + x[1] * y[1] + x[2] * y[2] + x[3] * y[3];
        let along = |a: f64| [0, 1, 2, 3].map(|axis| at[axis] + a * moves[axis]);
        let bend = dot(moves, moves);
        let value = |a: f64| libm::exp(-0.5 * dot(along(a), along(a)));
        let [from, to] = range;
        if bend * (to - from) * (to - from) < 0.25 {
            // Hardly a change: a rule of few nodes is exact.
            let sum: f64 = self
                .gentle
                .nodes(from, to)
                .map(|(a, share)| share * value(a))
                .sum();
            return peak * sum;
        }
        let foot = -dot(at, moves) / bend;
        let distance = dot(along(foot), along(foot));
        if distance > 80.0 {
            return 0.0;
        }
        let root = bend.sqrt();
        let [from, to] = [from, to].map(|a| (a - foot) * root * FRAC_1_SQRT_2);
        // On the side where both tails are small.
        let between = if from > 0.0 {
            libm::erfc(from) - libm::erfc(to)
        } else if to < 0.0 {
            libm::erfc(-to) - libm::erfc(-from)
        } else {
            libm::erf(to) - libm::erf(from)
        };
        peak * libm::exp(-0.5 * distance) * 0.5 * between * TAU.sqrt() / root
    }
}

impl Surface {
    /// The lobes of the example and of two texels beyond it on each side, row by row.
    fn seeds(&self) -> Vec<Seed> {
        let lattice = LobeLattice {
            curved: true,
            per_side: 1,
        };
        let side = i64::from(self.example.width());
        (-2..side + 2)
            .flat_map(|row| (-2..side + 2).map(move |column| (column, row)))
            .map(|(column, row)| seed(&self.example, lattice, column, row))
            .collect()
    }

    /// Texels of the example between strips of lines: half of one, or less where normals change by more than `sigma`.
    fn width_of_strips(&self, sigma: f64) -> f64 {
        let mut steepest: f64 = 0.0;
        for Seed { slope, .. } in self.seeds() {
            for [s, t] in slope {
                steepest = steepest.max((s * s + t * t).sqrt());
            }
        }
        (2.0 * sigma / steepest.max(1e-9)).clamp(0.01, 0.5)
    }

    /// The normal that copy `number` shows for `normal` of the example: a copy under the inverse would pull it back so.
    pub fn shown(&self, number: usize, normal: [f64; 2]) -> [f64; 2] {
        let matrix = inverse(self.copies[number].matrix);
        pulled_back(matrix, self.scales_slopes, normal).0
    }
}

/// The normal of the example that a copy under `matrix` shows as `normal`, and how much larger areas of the disk are there.
///
/// With t up where rows go down, M is `F M F`, F = diag(1, -1). Unless slopes are scaled, its orthogonal polar factor turns normals.
/// Else slopes `q = n / n_z` of the copy are `M⁻ᵀ` times those of the example, and as `dq = ds / n_z⁴` in area, areas grow
/// by `|det M|` and by the ratio of the fourth powers of `n_z`.
fn pulled_back(
    [[xx, xy], [yx, yy]]: [[f64; 2]; 2],
    scales_slopes: bool,
    normal: [f64; 2],
) -> ([f64; 2], f64) {
    let matrix = [[xx, -xy], [-yx, yy]];
    if scales_slopes {
        let z = (1.0 - normal[0] * normal[0] - normal[1] * normal[1]).sqrt();
        let slope = normal.map(|x| x / z);
        let [x, y] = [0, 1].map(|axis| matrix[0][axis] * slope[0] + matrix[1][axis] * slope[1]);
        let own = 1.0 / (1.0 + x * x + y * y).sqrt();
        let determinant = (xx * yy - xy * yx).abs();
        return ([x * own, y * own], determinant * (own / z).powi(4));
    }
    // Newton's iteration for the polar factor (Higham 1986): the mean with the inverse transposed.
    let mut turn = matrix;
    for _ in 0..60 {
        let [[a, b], [c, d]] = inverse(turn);
        let next = [
            [0.5 * (turn[0][0] + a), 0.5 * (turn[0][1] + c)],
            [0.5 * (turn[1][0] + b), 0.5 * (turn[1][1] + d)],
        ];
        if next == turn {
            break;
        }
        turn = next;
    }
    let pulled = [0, 1].map(|axis| turn[0][axis] * normal[0] + turn[1][axis] * normal[1]);
    (pulled, 1.0)
}
