//! A periodic Gaussian random height field with its exact derivatives.
//!
//! Independent standard normal numbers on a lattice, convolved with a Gaussian kernel: the power spectrum is the
//! kernel's squared, hence Gaussian, `S(k) ∝ exp(−σx² kx² − σy² ky²)`, and heights (dx, dy) apart correlate as
//! `exp(−dx²/(4σx²) − dy²/(4σy²))`. It is the field that a sum of all periodic Fourier modes with those amplitudes
//! gives, at 60 multiplications a texel whatever the size of the tile, where the sum costs one per mode.
//!
//! Legend: σ kernel width, δ lattice spacing, a lattice value, g kernel, g′ its derivative; lengths in texels.

use crate::random::{Random, key};

pub use crate::random::Stream;

/// Lattice points a texel draws from along each axis: 6 σ to both sides, where the kernel is 1.5e-8 of its peak.
const TAPS: usize = 20;

/// Lattice spacing as a share of σ. The variance ripples over the lattice by 2 exp(−π² σ²/δ²), 5e-8 here; that of the
/// slopes by 40 times as much (Poisson summation of g² and g′²).
const SPACING: f64 = 0.75;

/// Smallest σ, in texels: a kernel narrower than that is white at the pitch of texels.
const MIN_SIGMA: f64 = 0.5;

/// Widest kernel as a share of the tile: the longest wave that fits then has 0.58 of a wide tile's amplitude.
const MAX_SIGMA_PER_TILE: f64 = 1.0 / 6.0;

/// The kernel along one axis of a tile.
#[derive(Clone, Copy, Debug)]
struct Axis {
    /// σ, or `None` for an axis too short to hold a wave: the field is constant along it.
    sigma: Option<f64>,
    lattice_count: usize,
    /// δ.
    spacing: f64,
}

/// Kernel values and derivatives at the taps of one texel row or column.
#[derive(Clone, Copy)]
struct Taps {
    /// First tap, in the sequence of [`Axis::wrapped`].
    first: usize,
    value: [f64; TAPS],
    derivative: [f64; TAPS],
}

impl Axis {
    fn new(extent: u32, sigma: f64) -> Self {
        let extent = f64::from(extent);
        let sigma = sigma.max(MIN_SIGMA).min(extent * MAX_SIGMA_PER_TILE);
        if sigma < MIN_SIGMA {
            return Self {
                sigma: None,
                lattice_count: 1,
                spacing: extent,
            };
        }
        let count = (extent / (SPACING * sigma)).ceil();
        Self {
            sigma: Some(sigma),
            lattice_count: count as usize,
            spacing: extent / count,
        }
    }

    /// The taps of the texel row or column `index`.
    fn taps(&self, index: usize) -> Taps {
        let mut taps = Taps {
            first: 0,
            value: [0.0; TAPS],
            derivative: [0.0; TAPS],
        };
        let Some(sigma) = self.sigma else {
            taps.value[0] = 1.0;
            return taps;
        };
        let x = index as f64 + 0.5;
        taps.first = (x / self.spacing) as usize;
        let values = taps.value.iter_mut().zip(&mut taps.derivative);
        for (k, (value, derivative)) in values.enumerate() {
            let point = (taps.first + k) as f64 - Self::LEAD as f64;
            let distance = (x - point * self.spacing) / sigma;
            *value = libm::exp(-0.5 * distance * distance);
            *derivative = -distance / sigma * *value;
        }
        taps
    }

    /// Lattice points before a texel's own that it draws from.
    const LEAD: usize = TAPS / 2 - 1;

    /// The lattice index of point `k` in the sequence that taps index: the lattice, repeated, from [`Self::LEAD`]
    /// points before its start.
    fn wrapped(&self, k: usize) -> usize {
        (k as i64 - Self::LEAD as i64).rem_euclid(self.lattice_count as i64) as usize
    }

    /// Expected ∑ g² over the lattice: ∫ g²/δ = √π σ/δ.
    fn value_energy(&self) -> f64 {
        self.sigma.map_or(1.0, |sigma| {
            core::f64::consts::PI.sqrt() * sigma / self.spacing
        })
    }

    /// Expected ∑ g′² over the lattice: ∫ g′²/δ = √π/(2σδ).
    fn derivative_energy(&self) -> f64 {
        self.sigma.map_or(0.0, |sigma| {
            core::f64::consts::PI.sqrt() / (2.0 * sigma * self.spacing)
        })
    }
}

/// Height and slopes of a field at a texel.
#[derive(Clone, Copy, Debug, Default)]
pub struct Jet {
    pub height: f64,
    /// (∂/∂column, ∂/∂row).
    pub slope: [f64; 2],
}

/// A field over a tile; [`GaussianField::band`] gives its values.
pub struct GaussianField {
    key: u64,
    columns: Axis,
    rows: Axis,
    column_taps: Vec<Taps>,
}

impl GaussianField {
    /// The field `part` of `stream` on a `width` × `height` tile with kernel widths `sigma` along (columns, rows).
    ///
    /// Kernels are kept between half a texel and a sixth of the tile; where no width is both, the field does not vary
    /// along that axis. Takes about 330 bytes a column.
    pub fn new(
        seed: u64,
        stream: Stream,
        part: u64,
        [width, height]: [u32; 2],
        sigma: [f64; 2],
    ) -> Self {
        let columns = Axis::new(width, sigma[0]);
        Self {
            key: key(seed, stream, part),
            columns,
            rows: Axis::new(height, sigma[1]),
            column_taps: (0..width as usize)
                .map(|column| columns.taps(column))
                .collect(),
        }
    }

    /// The field's expected RMS height, over all seeds.
    pub fn expected_height(&self) -> f64 {
        (self.columns.value_energy() * self.rows.value_energy()).sqrt()
    }

    /// The field's expected RMS slope, over all seeds.
    pub fn expected_slope(&self) -> f64 {
        let along_columns = self.columns.derivative_energy() * self.rows.value_energy();
        let along_rows = self.columns.value_energy() * self.rows.derivative_energy();
        (along_columns + along_rows).sqrt()
    }

    /// The lattice values that the texel rows `rows` (not empty) need.
    pub fn band(&self, rows: core::ops::Range<usize>) -> FieldBand<'_> {
        let first = self.rows.taps(rows.start).first;
        let last = self.rows.taps(rows.end - 1).first + TAPS - 1;
        let count = self.columns.lattice_count;
        let mut lattice = Vec::with_capacity((last + 1 - first) * count);
        for k in first..=last {
            let row = self.rows.wrapped(k) as u64;
            // Pairs of columns share a draw; an odd last column leaves its second number unused.
            let pairs = (0..count.div_ceil(2) as u64)
                .flat_map(|pair| Random::at(self.key, pair, row).gaussian_pair());
            lattice.extend(pairs.take(count));
        }
        FieldBand {
            field: self,
            first,
            lattice,
        }
    }
}

/// A field in the neighbourhood of some texel rows.
pub struct FieldBand<'f> {
    field: &'f GaussianField,
    /// First lattice row held, in the sequence that taps index.
    first: usize,
    lattice: Vec<f64>,
}

impl FieldBand<'_> {
    /// Calls `visit(column, jet)` for every texel of `row`, which must be one of the band's.
    pub fn visit_row(&self, row: usize, mut visit: impl FnMut(usize, Jet)) {
        let (columns, count) = (&self.field.columns, self.field.columns.lattice_count);
        let taps = self.field.rows.taps(row);
        let start = (taps.first - self.first) * count;
        let lattice_rows = &self.lattice[start..];
        let mut summed = vec![[0.0; 2]; count];
        let row_taps = taps.value.iter().zip(&taps.derivative);
        for ((&g, &dg), values) in row_taps.zip(lattice_rows.chunks_exact(count)) {
            for (sum, &a) in summed.iter_mut().zip(values) {
                sum[0] += a * g;
                sum[1] += a * dg;
            }
        }
        // Repeated beyond the tile, so that every texel's taps are one slice.
        let repeated: Vec<[f64; 2]> = (0..count + TAPS)
            .map(|k| summed[columns.wrapped(k)])
            .collect();
        for (column, taps) in self.field.column_taps.iter().enumerate() {
            visit(column, contract(taps, &repeated[taps.first..]));
        }
    }
}

/// The sums over one texel's column taps of lattice columns already summed along rows with (g, g′).
fn contract(taps: &Taps, columns: &[[f64; 2]]) -> Jet {
    // Four partial sums: a single one would wait for each addition in turn.
    const LANES: usize = 4;
    let mut sums = [[0.0; LANES]; 3];
    let weights = taps
        .value
        .chunks_exact(LANES)
        .zip(taps.derivative.chunks_exact(LANES));
    for ((g, dg), column) in weights.zip(columns.chunks_exact(LANES)) {
        for lane in 0..LANES {
            sums[0][lane] += column[lane][0] * g[lane];
            sums[1][lane] += column[lane][0] * dg[lane];
            sums[2][lane] += column[lane][1] * g[lane];
        }
    }
    let [height, across, down] = sums.map(|[a, b, c, d]| (a + b) + (c + d));
    Jet {
        height,
        slope: [across, down],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn jets(size: [u32; 2], sigma: [f64; 2]) -> (GaussianField, Vec<Jet>) {
        let field = GaussianField::new(5, Stream::Wave, 0, size, sigma);
        let mut jets = Vec::new();
        let band = field.band(0..size[1] as usize);
        for row in 0..size[1] as usize {
            band.visit_row(row, |_, jet| jets.push(jet));
        }
        drop(band);
        (field, jets)
    }

    #[test]
    fn slopes_are_the_derivatives_of_the_heights_also_across_the_seam() {
        let [width, height] = [96usize, 80];
        let (field, jets) = jets([96, 80], [6.0, 9.0]);
        let scale = field.expected_slope();
        for row in 0..height {
            for column in 0..width {
                let at = |dx: usize, dy: usize| {
                    jets[(row + dy) % height * width + (column + dx) % width].height
                };
                // Fourth-order central difference; its error is h⁽⁵⁾/30, about σ⁻⁴/2 of the slope.
                let difference = |[a, b, c, d]: [f64; 4]| (a - 8.0 * b + 8.0 * c - d) / 12.0;
                let across = difference([at(width - 2, 0), at(width - 1, 0), at(1, 0), at(2, 0)]);
                let down = difference([at(0, height - 2), at(0, height - 1), at(0, 1), at(0, 2)]);
                let slope = jets[row * width + column].slope;
                assert!(
                    (across - slope[0]).abs() < 4e-3 * scale,
                    "({column}, {row})"
                );
                assert!((down - slope[1]).abs() < 4e-3 * scale, "({column}, {row})");
            }
        }
    }

    #[test]
    fn heights_correlate_as_the_kernel_says() {
        let sigma = 3.0;
        let (field, jets) = jets([512, 512], [sigma; 2]);
        let at =
            |x: usize, y: usize| jets[y % 512 * 512 + x % 512].height / field.expected_height();
        for [dx, dy] in [[0, 0], [4, 0], [0, 4], [6, 3], [40, 0]] {
            let mut mean = 0.0;
            for y in 0..512 {
                for x in 0..512 {
                    mean += at(x, y) * at(x + dx, y + dy) / (512.0 * 512.0);
                }
            }
            let squared = (dx * dx + dy * dy) as f64;
            let expected = libm::exp(-squared / (4.0 * sigma * sigma));
            // The tile holds 512²/(2πσ²·2) = 2300 independent patches: standard error at most √(2/2300) = 0.03.
            assert!(
                (mean - expected).abs() < 0.08,
                "({dx}, {dy}): {mean} for {expected}"
            );
        }
    }

    #[test]
    fn slopes_are_as_steep_as_expected() {
        for sigma in [[3.0, 3.0], [0.7, 12.0], [40.0, 1.0]] {
            let (field, jets) = jets([512, 512], sigma);
            let sum: f64 = jets
                .iter()
                .map(|jet| jet.slope[0] * jet.slope[0] + jet.slope[1] * jet.slope[1])
                .sum();
            let found = (sum / (512.0 * 512.0)).sqrt();
            // At least 512²/(2π·40) = 1000 independent patches: the root's standard error is at most √(1/2000) = 2 %.
            assert!(
                (found / field.expected_slope() - 1.0).abs() < 0.08,
                "{sigma:?}: {found} for {}",
                field.expected_slope()
            );
        }
    }

    #[test]
    fn bands_agree_with_the_whole() {
        let (field, jets) = jets([37, 53], [2.0, 5.0]);
        for rows in [0..1, 17..29, 52..53] {
            let band = field.band(rows.clone());
            for row in rows {
                band.visit_row(row, |column, jet| {
                    assert_eq!(jet.slope, jets[row * 37 + column].slope);
                });
            }
        }
    }

    #[test]
    fn short_axes_do_not_vary() {
        let (field, jets) = jets([1, 64], [4.0; 2]);
        assert!(
            jets.iter()
                .all(|jet| jet.slope[0] == 0.0 && jet.slope[1] != 0.0)
        );
        assert!(field.expected_slope() > 0.0);
        let (field, _) = self::jets([2, 1], [4.0; 2]);
        assert_eq!(field.expected_slope(), 0.0);
    }
}
