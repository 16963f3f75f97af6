//! From light and from numbers to pixels.

use libm::pow;

/// The sRGB byte of a linear component; below 0 is 0, above 1 is 255.
pub fn srgb_byte(linear: f64) -> u8 {
    quantised(srgb(linear))
}

/// The byte nearest to `value`, of which 0 is 0 and 1 is 255.
pub fn quantised(value: f64) -> u8 {
    // A cast from float saturates, so what is out of range lands on the nearest end.
    (value * 255.0 + 0.5) as u8
}

/// The sRGB signal, in [0, 1], of a linear component (IEC 61966-2-1); the component is clamped to [0, 1].
pub fn srgb(linear: f64) -> f64 {
    let linear = linear.clamp(0.0, 1.0);
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * pow(linear, 1.0 / 2.4) - 0.055
    }
}

/// Lightness of the darkest colour of [`heat`], and of the lightest.
const HEAT_LIGHTNESS: [f64; 2] = [0.13, 0.97];

/// Oklab (a, b) of [`heat`] at equal steps: night blue, violet, crimson, orange, straw, nearly white.
const HEAT_HUES: [[f64; 2]; 6] = [
    [0.00, -0.06],
    [0.10, -0.14],
    [0.19, 0.02],
    [0.14, 0.13],
    [0.00, 0.15],
    [-0.01, 0.04],
];

/// The colour, as sRGB bytes, of `value` in [0, 1] on a scale from night blue over crimson and orange to white.
///
/// Ordered by construction: Oklab lightness is a straight line of `value`, only hue and chroma bend, so the scale
/// also reads in grey. Values outside are clamped.
pub fn heat(value: f64) -> [u8; 3] {
    let value = if value > 0.0 { value.min(1.0) } else { 0.0 };
    let [dark, light] = HEAT_LIGHTNESS;
    let last = HEAT_HUES.len() - 1;
    let place = value * last as f64;
    let segment = (place as usize).min(last - 1);
    let x = place - segment as f64;
    let [a, b] = [0, 1].map(|axis| {
        let at = |index: usize| HEAT_HUES[index.min(last)][axis];
        catmull_rom(
            [
                at(segment.saturating_sub(1)),
                at(segment),
                at(segment + 1),
                at(segment + 2),
            ],
            x,
        )
    });
    linear_from_oklab([dark + (light - dark) * value, a, b]).map(srgb_byte)
}

/// The Catmull-Rom spline through `points[1]` at 0 and `points[2]` at 1.
fn catmull_rom(points: [f64; 4], x: f64) -> f64 {
    let [p0, p1, p2, p3] = points;
    let linear = p2 - p0;
    let square = 2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3;
    let cube = 3.0 * (p1 - p2) + p3 - p0;
    p1 + 0.5 * x * (linear + x * (square + x * cube))
}

/// Linear sRGB of an Oklab colour (Ottosson 2020, "A perceptual color space for image processing").
fn linear_from_oklab([lightness, a, b]: [f64; 3]) -> [f64; 3] {
    let cube = |x: f64| x * x * x;
    let l = cube(lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b);
    let m = cube(lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b);
    let s = cube(lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b);
    [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use libm::cbrt;

    fn linear(byte: u8) -> f64 {
        let signal = f64::from(byte) / 255.0;
        if signal <= 0.040_45 {
            signal / 12.92
        } else {
            pow((signal + 0.055) / 1.055, 2.4)
        }
    }

    /// Oklab lightness of an sRGB colour (Ottosson 2020).
    fn lightness(bytes: [u8; 3]) -> f64 {
        let [r, g, b] = bytes.map(linear);
        let l = cbrt(0.412_221_470_8 * r + 0.536_332_536_3 * g + 0.051_445_992_9 * b);
        let m = cbrt(0.211_903_498_2 * r + 0.680_699_545_1 * g + 0.107_396_956_6 * b);
        let s = cbrt(0.088_302_461_9 * r + 0.281_718_837_6 * g + 0.629_978_700_5 * b);
        0.210_454_255_3 * l + 0.793_617_785_0 * m - 0.004_072_046_8 * s
    }

    #[test]
    fn every_byte_survives_the_way_to_linear_and_back() {
        for byte in 0..=255 {
            assert_eq!(srgb_byte(linear(byte)), byte);
        }
        assert_eq!(srgb_byte(-1.0), 0);
        assert_eq!(srgb_byte(7.0), 255);
    }

    #[test]
    fn heat_rises_in_lightness_as_a_straight_line() {
        let [dark, light] = HEAT_LIGHTNESS;
        let mut last = -1.0;
        for step in 0..=100 {
            let value = f64::from(step) / 100.0;
            let seen = lightness(heat(value));
            assert!(seen > last, "the scale falls at {value}");
            // Colours clipped to the screen's gamut are off the line by a little.
            let line = dark + (light - dark) * value;
            assert!(
                (seen - line).abs() < 0.03,
                "{seen} instead of {line} at {value}"
            );
            last = seen;
        }
    }

    #[test]
    fn heat_clamps_what_is_outside_or_no_number() {
        assert_eq!(heat(-3.0), heat(0.0));
        assert_eq!(heat(f64::NAN), heat(0.0));
        assert_eq!(heat(2.0), heat(1.0));
    }
}
