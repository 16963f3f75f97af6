//! Integrals of the query's Gaussian over affine pieces of the surface, \[YHJ*14\] eq. 8, in an accurate form and in the paper's.

mod exponential;
mod paper;
mod small;
mod wedge;
mod whiten;

#[cfg(test)]
mod tests;

pub(super) use whiten::Point;

use core::f64::consts::TAU;
use exponential::exp_negative;
use small::Sizes;

/// How the integral over a triangle is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum TriangleForm {
    /// By the edges, with Gauss and Legendre's nodes or error functions; a few nodes for small triangles.
    #[default]
    Accurate,
    /// As in the paper: `experf`, with the error function as six quadratics, \[YHJ*14\] eq. 9 to 12.
    Paper,
}

impl TriangleForm {
    /// The word used in headers of results.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Accurate => "default",
            Self::Paper => "paper",
        }
    }
}

/// The outline of a piece with two edges from a corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::ndf) enum Shape {
    Triangle,
    Parallelogram,
}

/// The mean of `e^{-|x|²/2}` over the piece at `corner` with `edges`, in standard deviations of position and normal: in [0, 1].
///
/// 0 if no point of the piece is within the root of `reach` of the origin, whatever the form. Accurate within 1e-8 of itself for
/// pieces that are no slivers beyond it, by 16 nodes at most for small ones (20 to 60 ns), else after [`whiten::whiten`] by
/// [`wedge::share`].
#[inline]
pub(in crate::ndf) fn mean(
    corner: Point,
    edges: [Point; 2],
    shape: Shape,
    form: TriangleForm,
    reach: f64,
) -> f64 {
    let sizes = Sizes::new(corner, edges, shape);
    if sizes.is_beyond(reach) {
        return 0.0;
    }
    if form == TriangleForm::Accurate
        && let Some(mean) = sizes.mean(shape)
    {
        return mean;
    }
    let Some(piece) = whiten::whiten(corner, edges) else {
        return 0.0;
    };
    if piece.residual.is_nan() || piece.residual >= reach {
        return 0.0;
    }
    let is_parallelogram = shape == Shape::Parallelogram;
    let share = match form {
        TriangleForm::Accurate => wedge::share(&piece, is_parallelogram),
        TriangleForm::Paper => paper::share(&piece, is_parallelogram),
    };
    let area = piece.length * piece.height * if is_parallelogram { 1.0 } else { 0.5 };
    let mean = exp_negative(0.5 * piece.residual) * share * (TAU / area);
    // An accurate mean exceeds 1 by no more than rounding; the paper's does over small pieces.
    if mean.is_finite() { mean } else { 0.0 }
}
