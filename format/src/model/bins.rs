//! Bins: how the hemisphere of normals is cut, and which bins a half vector looks at.

use super::HalfVector;
use core::f64::consts::PI;

/// How the hemisphere is cut into bins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum Binning {
    /// A uniform grid over the square [-1, 1]² around the projected disk, \[AWKK21\] §5.2.
    DiskGrid = 0,
    /// A uniform grid over the unit square, mapped to the hemisphere by a concentric equal-area map, so that
    /// every bin spans the solid angle 2π/B, \[ABKK20\] §2.
    EqualSolidAngle = 1,
}

impl Binning {
    /// The binning stored as `code`, if there is one.
    pub const fn from_code(code: u16) -> Option<Self> {
        match code {
            0 => Some(Self::DiskGrid),
            1 => Some(Self::EqualSolidAngle),
            _ => None,
        }
    }

    /// The word used in metadata.
    pub const fn name(self) -> &'static str {
        match self {
            Self::DiskGrid => "disk-grid",
            Self::EqualSolidAngle => "equal-solid-angle",
        }
    }
}

/// A grid of `resolution` × `resolution` bins; bin (x, y) has the number `x + resolution · y`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BinGrid {
    binning: Binning,
    resolution: u32,
}

/// Bins per side for Beckmann roughness `alpha`: `ceil(5 / sin(atan(3 α / √2)))`, \[AWKK21\] eq. 16.
///
/// Five bins then span the cone that holds three standard deviations of the flake's normals.
pub fn disk_grid_resolution(alpha: f64) -> u32 {
    let three_sigma = 3.0 * alpha / core::f64::consts::SQRT_2;
    // sin(atan x) = x / sqrt(1 + x²), written so that a tiny x loses nothing.
    let sine = three_sigma / libm::sqrt(1.0 + three_sigma * three_sigma);
    libm::ceil(5.0 / sine) as u32
}

impl BinGrid {
    /// The largest resolution whose bin numbers fit an unsigned 32-bit integer.
    pub const MAX_RESOLUTION: u32 = 65_535;

    /// A grid of `resolution` bins a side, or `None` if `resolution` is zero or above [`Self::MAX_RESOLUTION`].
    pub const fn new(binning: Binning, resolution: u32) -> Option<Self> {
        if resolution == 0 || resolution > Self::MAX_RESOLUTION {
            return None;
        }
        Some(Self {
            binning,
            resolution,
        })
    }

    /// How the grid is laid over the hemisphere.
    pub const fn binning(self) -> Binning {
        self.binning
    }

    /// Bins per side.
    pub const fn resolution(self) -> u32 {
        self.resolution
    }

    /// All bins of the grid, also those that no direction falls into; at most 65 535² < 2³².
    pub const fn count(self) -> u32 {
        self.resolution.wrapping_mul(self.resolution)
    }

    /// The number of bin (`x`, `y`), both below the resolution.
    pub const fn number(self, x: u32, y: u32) -> u32 {
        y.wrapping_mul(self.resolution).wrapping_add(x)
    }

    /// Column and row of bin `number`.
    pub const fn column_row(self, number: u32) -> (u32, u32) {
        (number % self.resolution, number / self.resolution)
    }

    /// Column and row of the bin that holds `normal`: β of \[AWKK21\] §5.2.
    ///
    /// A coordinate of exactly 1 belongs to the last bin (the paper's floor alone would name one beyond it).
    pub fn bin_of(self, normal: HalfVector) -> (u32, u32) {
        let [x, y] = match self.binning {
            Binning::DiskGrid => [normal.s * 0.5 + 0.5, normal.t * 0.5 + 0.5],
            Binning::EqualSolidAngle => square_from_hemisphere(normal),
        };
        (self.cell(x), self.cell(y))
    }

    /// The normal at fraction (`x`, `y`) in [0, 1]² of bin (`column`, `row`): β⁻¹ of \[AWKK21\] §5.2.
    ///
    /// On the disk grid this may lie beyond the disk; [`HalfVector::direction`] then projects it to the horizon.
    pub fn normal_in_bin(self, column: u32, row: u32, x: f64, y: f64) -> HalfVector {
        let scale = 1.0 / f64::from(self.resolution);
        let square = [
            (f64::from(column) + x) * scale,
            (f64::from(row) + y) * scale,
        ];
        match self.binning {
            Binning::DiskGrid => HalfVector {
                s: 2.0 * square[0] - 1.0,
                t: 2.0 * square[1] - 1.0,
            },
            Binning::EqualSolidAngle => hemisphere_from_square(square),
        }
    }

    /// The unit normal at the centre of bin (`column`, `row`), projected to the horizon where the centre of a
    /// border bin lies beyond the disk.
    pub fn centre(self, column: u32, row: u32) -> [f64; 3] {
        self.normal_in_bin(column, row, 0.5, 0.5).direction()
    }

    /// Solid angle of one bin of an equal-solid-angle grid: 2π / B.
    pub fn solid_angle(self) -> f64 {
        let side = f64::from(self.resolution);
        2.0 * PI / (side * side)
    }

    fn cell(self, fraction: f64) -> u32 {
        // A float-to-integer cast saturates, so a coordinate below 0 (rounding at the rim) lands in bin 0.
        let cell = libm::floor(fraction * f64::from(self.resolution)) as u32;
        cell.min(self.resolution.wrapping_sub(1))
    }
}

/// The bins around a half vector's bin whose flakes are summed, \[AWKK21\] eq. 15.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[repr(u16)]
pub enum Neighbourhood {
    /// 7×7 without the corners: 45 bins, loses at most 8.5e-5 of a flake's energy (6.1e-5 at α = 0.01, worst at 0.07)
    /// for α up to 0.2, away from the rim.
    #[default]
    Bins45 = 45,
    /// 5×5 without the corners: the paper's 21 bins, loses 1 % of the energy and more for rough flakes (2 % at 0.3).
    Bins21 = 21,
}

impl Neighbourhood {
    /// Bins to each side of the centre, 3 or 2.
    pub const fn reach(self) -> i32 {
        match self {
            Self::Bins45 => 3,
            Self::Bins21 => 2,
        }
    }

    /// Whether the bin `dx` columns and `dy` rows away belongs: within reach, and not a corner.
    pub const fn holds(self, dx: i32, dy: i32) -> bool {
        let reach = self.reach();
        let (dx, dy) = (dx.unsigned_abs() as i64, dy.unsigned_abs() as i64);
        let reach = reach as i64;
        dx <= reach && dy <= reach && !(dx == reach && dy == reach)
    }

    /// The word used in metadata and in the header of query results.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bins45 => "bins-45",
            Self::Bins21 => "bins-21",
        }
    }
}

/// Disk radius below which the concentric map's angle is taken as zero, to avoid 0/0 at the pole.
const POLE: f64 = 1e-300;

/// Concentric map of the square to the disk (Shirley and Chiu 1997), then Lambert's equal-area lift.
///
/// With ρ in [0, 1] the disk radius of the concentric map, Lambert's azimuthal projection of the hemisphere has
/// 1 - z = ρ²: then dω = dφ dz = 2ρ dρ dφ, so equal areas of disk (and square) are equal solid angles.
/// sin θ = sqrt(1 - z²) = ρ sqrt(2 - ρ²).
fn hemisphere_from_square(square: [f64; 2]) -> HalfVector {
    let a = 2.0 * square[0] - 1.0;
    let b = 2.0 * square[1] - 1.0;
    let (radius, angle) = if a == 0.0 && b == 0.0 {
        (0.0, 0.0)
    } else if a.abs() > b.abs() {
        (a, PI / 4.0 * (b / a))
    } else {
        (b, PI / 2.0 - PI / 4.0 * (a / b))
    };
    let sine = radius * libm::sqrt((2.0 - radius * radius).max(0.0));
    HalfVector {
        s: sine * libm::cos(angle),
        t: sine * libm::sin(angle),
    }
}

/// Inverse of [`hemisphere_from_square`].
fn square_from_hemisphere(normal: HalfVector) -> [f64; 2] {
    let HalfVector { s, t } = normal;
    let squared = (s * s + t * t).min(1.0);
    let sine = libm::sqrt(squared);
    if sine < POLE {
        return [0.5, 0.5];
    }
    // ρ² = 1 - z = sin² / (1 + z): the second form loses nothing near the pole.
    let radius = libm::sqrt(squared / (1.0 + libm::sqrt(1.0 - squared)));
    let (a, b) = if s.abs() > t.abs() {
        let a = radius * s.signum();
        (a, a * 4.0 / PI * libm::atan(t / s))
    } else {
        let b = radius * t.signum();
        (b * 4.0 / PI * libm::atan(s / t), b)
    };
    [a * 0.5 + 0.5, b * 0.5 + 0.5]
}
