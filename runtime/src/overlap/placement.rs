//! A footprint laid on a map: validated, reduced to the first tile, in texels.

use crate::error::QueryError;
use glintbake_format::model::{Footprint, MAX_EDGE_TILES, Wrap};

/// Standard deviation, in tiles, from which a repeating Gaussian weighs an axis evenly: the sum of its copies is a Fourier
/// series whose first wave has the amplitude `2 exp(-2π² 0.75²)`, 3e-5.
pub(crate) const EVEN_TILES: f64 = 0.75;

/// Centre and edges of a footprint in texels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement {
    /// Whole part of the centre. Apart from the rest, so that the rest keeps all its digits.
    pub cell: [f64; 2],
    /// The centre relative to `cell`, in [0, 1] but for rounding.
    pub centre: [f64; 2],
    pub edge_1: [f64; 2],
    pub edge_2: [f64; 2],
}

impl Placement {
    /// `footprint` on a map of `width` × `height` texels, its centre reduced to the first tile where the map repeats.
    ///
    /// # Errors
    /// [`QueryError::NotFinite`], [`QueryError::FootprintTooLarge`].
    pub fn new(
        footprint: &Footprint,
        width: u32,
        height: u32,
        wrap: Wrap,
    ) -> Result<Self, QueryError> {
        let Footprint {
            centre,
            edge_1,
            edge_2,
        } = *footprint;
        if ![centre, edge_1, edge_2]
            .iter()
            .flatten()
            .all(|coordinate| coordinate.is_finite())
        {
            return Err(QueryError::NotFinite);
        }
        if [edge_1, edge_2]
            .iter()
            .flatten()
            .any(|coordinate| coordinate.abs() > MAX_EDGE_TILES)
        {
            return Err(QueryError::FootprintTooLarge);
        }
        // Exact: a tile number is subtracted from a coordinate of the same magnitude, before anything is scaled.
        let reduce = |coordinate: f64| match wrap {
            Wrap::Repeat => coordinate - floor(coordinate),
            // Beyond this no footprint reaches the map, and border texels extend without end.
            Wrap::Clamp => coordinate.clamp(-4.0 * MAX_EDGE_TILES, 4.0 * MAX_EDGE_TILES),
        };
        let size = [f64::from(width), f64::from(height)];
        let scale = |[x, y]: [f64; 2]| [x * size[0], y * size[1]];
        // The product of centre and size is rounded to the nearest f64, and can land on a texel's border though the
        // centre lies before it; the exact remainder brings back what rounding took.
        let centre = centre.map(reduce);
        let product = scale(centre);
        let rest = [
            product_error(centre[0], size[0], product[0]),
            product_error(centre[1], size[1], product[1]),
        ];
        let cell = product.map(floor);
        Ok(Self {
            cell,
            centre: [
                (product[0] - cell[0]) + rest[0],
                (product[1] - cell[1]) + rest[1],
            ],
            edge_1: scale(edge_1),
            edge_2: scale(edge_2),
        })
    }
}

/// The greatest whole number not above `value`. Every query waits for it: without vector instructions of SSE4.1, which a
/// portable build cannot count on, libm's takes several times as long.
#[inline(always)]
fn floor(value: f64) -> f64 {
    /// 2⁵², from which on there are only whole numbers.
    const WHOLE: f64 = 4_503_599_627_370_496.0;
    if value.abs() < WHOLE {
        let truncated = value as i64 as f64;
        if value < truncated {
            truncated - 1.0
        } else {
            truncated
        }
    } else {
        value
    }
}

/// `factor size - product` without rounding, where `product` is their rounded product and `size` a whole number of at most
/// 26 bits: that of a fused multiplication, in the time of a few (Dekker 1971, after Veltkamp).
#[inline(always)]
fn product_error(factor: f64, size: f64, product: f64) -> f64 {
    /// 2²⁷ + 1 splits a number into two of 26 bits.
    const SPLITTER: f64 = 134_217_729.0;
    let scaled = factor * SPLITTER;
    let high = scaled - (scaled - factor);
    let low = factor - high;
    (high * size - product) + low * size
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floors_and_errors_of_products_are_those_of_libm() {
        let mut state = 7_u64;
        for number in 0..200_000_u64 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let unit = (state >> 11) as f64 / (1_u64 << 53) as f64;
            let wide = (unit - 0.5) * libm::exp2((number % 60) as f64);
            assert_eq!(floor(wide), libm::floor(wide));
            let size = (state % 65_536) as f64;
            for factor in [unit, 4e5 * (unit - 0.5)] {
                let product = factor * size;
                let exact = libm::fma(factor, size, -product);
                assert_eq!(
                    product_error(factor, size, product),
                    exact,
                    "{factor} {size}"
                );
            }
        }
        for value in [0.0, -1.0, 7.0, 1e300, -1e300, -0.25] {
            assert_eq!(floor(value), libm::floor(value));
        }
    }
}
