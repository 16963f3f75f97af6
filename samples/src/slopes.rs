//! From slopes of a height field to points of the projected disk.

use rayon::prelude::*;

/// Largest `s² + t²`: leaves z = √(2·10⁻⁶) = 0.0014, which rounds to a positive code at 8 and at 16 bits.
const MAX_SQUARED_LENGTH: f64 = 1.0 - 2e-6;

/// The normal of a surface with height derivatives (∂h/∂column, ∂h/∂row), dimensionless.
///
/// `(−∂h/∂column, +∂h/∂row)/√(1 + …)`: rows run down and t up, so the second sign flips twice. Slopes above 707 are
/// held at that.
pub fn normal(slope: [f64; 2]) -> [f32; 2] {
    let squared = slope[0] * slope[0] + slope[1] * slope[1];
    disk_point([-slope[0], slope[1]], (1.0 + squared).sqrt(), squared)
}

/// `vector / divisor`, whose squared length is `squared / divisor²`, moved inside the disk and rounded.
fn disk_point(vector: [f64; 2], divisor: f64, squared: f64) -> [f32; 2] {
    // f32 rounding adds at most 2⁻²³ to the squared length, which stays well below 1.
    let divisor = divisor.max((squared / MAX_SQUARED_LENGTH).sqrt());
    vector.map(|x| (x / divisor) as f32)
}

/// The point of the disk in direction `azimuth` (radians from +s towards +t) at polar angle θ with `sin² θ` given.
pub fn normal_at(sin_squared: f64, azimuth: f64) -> [f32; 2] {
    let radius = sin_squared.clamp(0.0, MAX_SQUARED_LENGTH).sqrt();
    let (sin, cos) = libm::sincos(azimuth);
    [(radius * cos) as f32, (radius * sin) as f32]
}

/// Turns `slopes` (∂h/∂column, ∂h/∂row) of a map `width` wide into normals, after scaling them to RMS length `target`.
///
/// Slopes that are all zero stay zero: a relief that a tile of this size cannot hold.
pub fn normalise(slopes: &mut [[f32; 2]], width: usize, target: f64) {
    // One sum per row, added in row order: the same rounding for any number of threads.
    let row_sums: Vec<f64> = slopes
        .par_chunks(width)
        .map(|row| row.iter().map(|&[a, b]| square(a) + square(b)).sum())
        .collect();
    let mean = row_sums.iter().sum::<f64>() / slopes.len() as f64;
    if mean == 0.0 {
        return;
    }
    let factor = target / mean.sqrt();
    slopes.par_chunks_mut(width).for_each(|row| {
        for texel in row {
            *texel = normal(texel.map(|x| f64::from(x) * factor));
        }
    });
}

fn square(x: f32) -> f64 {
    f64::from(x) * f64::from(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rise_to_the_right_leans_left_and_a_rise_downwards_leans_up() {
        assert_eq!(normal([0.75, 0.0]), [-0.6, 0.0]);
        assert_eq!(normal([0.0, 0.75]), [0.0, 0.6]);
    }

    #[test]
    fn the_steepest_slope_stays_inside_the_disk() {
        for slope in [[100.0, 0.0], [1e6, -1e6], [0.0, 1e100]] {
            let [s, t] = normal(slope).map(f64::from);
            let squared = s * s + t * t;
            assert!(
                squared < 1.0 - 1e-6 && squared > 0.9998,
                "{slope:?}: {squared}"
            );
        }
        let [s, t] = normal_at(1.0, 0.7).map(f64::from);
        assert!(s * s + t * t < 1.0 - 1e-6);
    }

    #[test]
    fn normalise_reaches_the_target_and_keeps_zero() {
        let mut slopes = vec![[1.0, 0.0], [0.0, 3.0], [0.0, 0.0], [-1.0, 1.0]];
        normalise(&mut slopes, 2, 0.5);
        let mean: f64 = slopes
            .iter()
            .map(|&[s, t]| {
                let sin_squared = square(s) + square(t);
                sin_squared / (1.0 - sin_squared)
            })
            .sum::<f64>()
            / 4.0;
        assert!((mean.sqrt() - 0.5).abs() < 1e-6, "{mean}");
        let mut flat = vec![[0.0; 2]; 4];
        normalise(&mut flat, 2, 0.5);
        assert_eq!(flat, [[0.0; 2]; 4]);
    }
}
