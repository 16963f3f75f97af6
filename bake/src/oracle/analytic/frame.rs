//! Coordinates in which a Gaussian footprint is a unit Gaussian, and what repetition leaves of it.

use super::super::double_double::DoubleDouble;
use super::super::gaussian::least_deviation;
use super::super::texel_axis::TexelAxis;
use crate::normals::NormalMap;
use core::f64::consts::PI;
use glintbake_format::model::{Footprint, Wrap};

/// Variance added to the footprint along every direction, in texels²: a millionth of a texel is less than anyone can
/// see, and points and lines have a density.
pub(in crate::oracle) const FLOOR: f64 = 1e-12;

/// Which axes of the frame the footprint's weight depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reach {
    /// Both.
    Place,
    /// The outer one: along the inner one, whole tiles weigh alike.
    Line,
    /// None: all of a tile weighs alike.
    Tile,
}

/// A Gaussian as `y ~ N(0, deviation²)` along the outer axis and `x ~ N(slope y, spread²)` along the inner, in texels;
/// an axis on which nothing depends has a deviation of one texel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) reach: Reach,
    /// Number of the outer axis: 0 for columns, 1 for rows.
    pub(super) outer: usize,
    pub(super) deviation: f64,
    pub(super) slope: DoubleDouble,
    pub(super) spread: f64,
    /// What the integral over (y / deviation, (x - slope y) / spread) of the bells is to be multiplied by.
    pub(super) factor: f64,
}

impl Frame {
    /// The frame of `footprint`, whose axes over the map are `axes`; from a deviation of `even_tiles` tiles on the
    /// copies of the map along a direction are integrated.
    pub(super) fn new(
        map: &NormalMap,
        footprint: &Footprint,
        axes: &[TexelAxis; 2],
        even_tiles: f64,
    ) -> Self {
        let quarter = |x: DoubleDouble| x.half().half();
        let floor = DoubleDouble::from(FLOOR);
        let [[x_1, x_2], [y_1, y_2]] = [axes[0].edges(), axes[1].edges()];
        let bare = [
            quarter(x_1 * x_1 + x_2 * x_2),
            quarter(y_1 * y_1 + y_2 * y_2),
        ];
        let variances = bare.map(|variance| variance + floor);
        let covariance = quarter(x_1 * y_1 + x_2 * y_2);
        let cross = quarter(x_1 * y_2 - y_1 * x_2);
        let determinant = (cross * cross + floor * (bare[0] + bare[1] + floor)).value();
        let tile = [map.width(), map.height()].map(f64::from);
        let conditional = |given: usize| libm::sqrt(determinant / variances[given].value());
        let repeats = map.wrap() == Wrap::Repeat;
        let wide = |axis: usize| repeats && conditional(1 - axis) >= even_tiles * tile[axis];
        // The longer axis is the outer one, which keeps the slope in [-1, 1], or is the one integrated.
        let longer = usize::from(variances[1] >= variances[0]);
        let line = |outer: usize| {
            let deviation = libm::sqrt(variances[outer].value());
            Self {
                reach: Reach::Line,
                outer,
                deviation,
                slope: DoubleDouble::ZERO,
                spread: 1.0,
                factor: 1.0 / (libm::sqrt(2.0 * PI) * tile[1 - outer]),
            }
        };
        if repeats && least_deviation(footprint.edge_1, footprint.edge_2) >= even_tiles {
            Self {
                reach: Reach::Tile,
                outer: 1,
                deviation: 1.0,
                slope: DoubleDouble::ZERO,
                spread: 1.0,
                factor: 1.0 / (tile[0] * tile[1]),
            }
        } else if wide(longer) {
            line(1 - longer)
        } else if wide(1 - longer) {
            line(longer)
        } else {
            Self {
                reach: Reach::Place,
                outer: longer,
                deviation: libm::sqrt(variances[longer].value()),
                slope: covariance / variances[longer],
                spread: conditional(longer),
                factor: 1.0 / (2.0 * PI),
            }
        }
    }
}
