//! From linear light to a photograph: bloom, tone curve, bytes.

use super::vector::{Vector, add, dot, scale};
use crate::picture::colour::srgb_byte;
use libm::{exp, sqrt};
use rayon::prelude::*;

/// Linear light of a pixel: f32 keeps the largest picture within memory.
pub(super) type Light = [f32; 3];

/// Light above this spreads in the lens.
const BLOOM_THRESHOLD: f64 = 1.0;

/// The most one pixel gives to the bloom, so that a lamp's mirror image does not veil the ball.
const BLOOM_LIMIT: f64 = 12.0;

/// Standard deviation of the bloom as a share of the picture's side, and its strength: a tight glow and a wide veil.
const BLOOM: [[f64; 2]; 2] = [[0.0022, 0.10], [0.012, 0.05]];

/// Brings the studio's light to where the tone curve is made for.
const EXPOSURE: f64 = 0.8;

/// 8-bit sRGB of the square picture `light`, `side` pixels a side, row-major from the top.
pub(super) fn develop(side: usize, light: &[Light]) -> Vec<u8> {
    let bright: Vec<Light> = light.iter().copied().map(excess).collect();
    let glow = BLOOM.map(|[share, strength]| {
        let kernel = gaussian(share * side as f64, strength);
        let across = blurred(side, &bright, &kernel, Along::Rows);
        blurred(side, &across, &kernel, Along::Columns)
    });
    let mut bytes = vec![0; 3 * light.len()];
    bytes
        .par_chunks_mut(3)
        .with_min_len(side.max(1))
        .enumerate()
        .for_each(|(index, rgb)| {
            let sum = glow.iter().fold(widened(light[index]), |sum, glow| {
                add(sum, widened(glow[index]))
            });
            rgb.copy_from_slice(&tone(sum).map(srgb_byte));
        });
    bytes
}

/// Direction of a convolution.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Along {
    Rows,
    Columns,
}

/// `light` convolved with `kernel` along rows or columns; it is dark beyond the border.
fn blurred(side: usize, light: &[Light], kernel: &[f32], along: Along) -> Vec<Light> {
    let reach = kernel.len() / 2;
    let mut result = vec![[0.0; 3]; light.len()];
    result
        .par_chunks_mut(side.max(1))
        .enumerate()
        .for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                let (place, start, stride) = match along {
                    Along::Rows => (x, y * side, 1),
                    Along::Columns => (y, x, side),
                };
                let last = (place + reach).min(side - 1);
                for source in place.saturating_sub(reach)..=last {
                    let weight = kernel[source + reach - place];
                    for (sum, source) in pixel.iter_mut().zip(light[start + source * stride]) {
                        *sum += weight * source;
                    }
                }
            }
        });
    result
}

fn widened(light: Light) -> Vector {
    light.map(f64::from)
}

/// What of `light` the lens spreads.
fn excess(light: Light) -> Light {
    let light = widened(light);
    let luminance = dot(light, [0.2126, 0.7152, 0.0722]);
    if luminance <= BLOOM_THRESHOLD {
        return [0.0; 3];
    }
    let kept = luminance.min(BLOOM_LIMIT) - BLOOM_THRESHOLD;
    scale(light, kept / luminance).map(|component| component as f32)
}

/// An odd number of weights, normally distributed with `sigma` pixels, that sum to √`strength`: rows and columns
/// each take the root.
fn gaussian(sigma: f64, strength: f64) -> Vec<f32> {
    let reach = (3.0 * sigma) as i32;
    let weights: Vec<f64> = (-reach..=reach)
        .map(|place| {
            // Below a third of a pixel there is only the middle, whatever sigma is.
            let x = f64::from(place) / sigma.max(0.1);
            exp(-0.5 * x * x)
        })
        .collect();
    let factor = sqrt(strength) / weights.iter().sum::<f64>();
    weights
        .iter()
        .map(|weight| (weight * factor) as f32)
        .collect()
}

/// Linear light as the photograph shows it, in [0, 1]: Narkowicz's fit (2015) of the ACES film curve.
///
/// Each colour saturates by itself, so what is very bright turns white, as on film.
fn tone(light: Vector) -> Vector {
    light.map(|x| {
        let x = EXPOSURE * x;
        (x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)).clamp(0.0, 1.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tone_curve_rises_from_black_to_white() {
        assert_eq!(tone([0.0; 3]), [0.0; 3]);
        assert_eq!(tone([1e6; 3]), [1.0; 3]);
        let mut last = 0.0;
        for step in 1..=50 {
            let [value, ..] = tone([f64::from(step) * 0.1; 3]);
            assert!(value >= last, "the curve falls at step {step}");
            last = value;
        }
    }

    #[test]
    fn bloom_spreads_a_glint_evenly_and_by_its_strength() {
        let side = 33;
        let mut light = vec![[0.0; 3]; side * side];
        let middle = side / 2;
        light[middle * side + middle] = [2.0, 4.0, 8.0];
        let kernel = gaussian(2.0, 0.25);
        let across = blurred(side, &light, &kernel, Along::Rows);
        let glow = blurred(side, &across, &kernel, Along::Columns);
        for (channel, given) in [2.0, 4.0, 8.0].into_iter().enumerate() {
            let sum: f32 = glow.iter().map(|pixel| pixel[channel]).sum();
            assert!((sum - 0.25 * given).abs() < 1e-4, "{sum} of {given}");
        }
        let at = |x: usize, y: usize| glow[y * side + x];
        assert_eq!(at(middle + 3, middle + 1), at(middle - 3, middle + 1));
        assert_eq!(at(middle + 3, middle + 1), at(middle + 1, middle + 3));
        assert!(at(middle + 1, middle)[0] < at(middle, middle)[0]);
        assert!(at(middle + 1, middle)[0] > 0.0);
    }

    #[test]
    fn dim_light_does_not_bloom_and_glare_is_limited() {
        assert_eq!(excess([0.9; 3]), [0.0; 3]);
        let [glare, ..] = excess([1e4; 3]);
        assert!((f64::from(glare) - (BLOOM_LIMIT - BLOOM_THRESHOLD)).abs() < 1e-4);
    }
}
