//! Logarithmic scales and their ticks.

/// A logarithmic scale between two pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogScale {
    /// Decimal logarithms at both ends.
    exponents: [f64; 2],
    /// Pixels of both ends.
    pixels: [f64; 2],
}

impl LogScale {
    /// The scale that takes `range`, both above 0, to `pixels`. A range of one point is widened to half a decade.
    pub fn new(range: [f64; 2], pixels: [f64; 2]) -> Self {
        let mut exponents = range.map(libm::log10);
        if exponents[1] - exponents[0] < 1e-9 {
            exponents = [exponents[0] - 0.25, exponents[1] + 0.25];
        }
        Self { exponents, pixels }
    }

    /// The pixel of `value`, which must be above 0.
    pub fn at(&self, value: f64) -> f64 {
        let [low, high] = self.exponents;
        let share = (libm::log10(value) - low) / (high - low);
        self.pixels[0] + share * (self.pixels[1] - self.pixels[0])
    }

    /// Round values within the scale that are named, at most about `most`, and those that have a line only.
    pub fn ticks(&self, most: usize) -> Ticks {
        let [low, high] = self.exponents;
        // A tick at the very end stays despite rounding.
        let within = |value: &f64| {
            let exponent = libm::log10(*value);
            exponent >= low - 1e-9 && exponent <= high + 1e-9
        };
        let (first, last) = (libm::floor(low) as i32, libm::ceil(high) as i32);
        let of = |digits: &[f64], step: i32| -> Vec<f64> {
            (first..=last)
                .filter(|decade| decade.rem_euclid(step) == 0)
                .flat_map(|decade| digits.iter().map(move |digit| scaled(*digit, decade)))
                .filter(within)
                .collect()
        };
        let fine = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0];
        let candidates = [
            of(&[1.0, 1.5, 2.0, 3.0, 5.0, 7.0], 1),
            of(&[1.0, 2.0, 5.0], 1),
            of(&[1.0, 3.0], 1),
            of(&[1.0], 1),
            of(&[1.0], 2),
            of(&[1.0], 3),
        ];
        let named = candidates
            .into_iter()
            .find(|ticks| ticks.len() <= most)
            .unwrap_or_default();
        let faint = if high - low > 4.0 {
            of(&[1.0], 1)
        } else {
            of(&fine, 1)
        };
        Ticks {
            faint: faint
                .into_iter()
                .filter(|value| !named.contains(value))
                .collect(),
            named,
        }
    }
}

/// `digit` × 10^`decade`, rounded once: 3e-4 is the number of that name.
fn scaled(digit: f64, decade: i32) -> f64 {
    format!("{digit}e{decade}")
        .parse()
        .expect("digits and an exponent are a number")
}

/// Where an axis has lines.
#[derive(Clone, Debug, PartialEq)]
pub struct Ticks {
    /// Values with a name.
    pub named: Vec<f64>,
    /// Values between those.
    pub faint: Vec<f64>,
}

/// The least and largest of `values` that are above 0 and finite, if there are any.
pub fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values
        .filter(|value| *value > 0.0 && value.is_finite())
        .fold(None, |range, value| {
            let [low, high] = range.unwrap_or([value; 2]);
            Some([f64::min(low, value), f64::max(high, value)])
        })
}

/// `range` with `share` of its decades, and of one decade at least, added at both ends.
pub fn padded(range: [f64; 2], share: f64) -> [f64; 2] {
    let decades = libm::log10(range[1] / range[0]).max(1.0);
    let factor = libm::pow(10.0, decades * share);
    [range[0] / factor, range[1] * factor]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decades_are_equally_far_apart() {
        let scale = LogScale::new([1e-2, 1e2], [100.0, 500.0]);
        let pixels = [1e-2, 1e-1, 1.0, 10.0, 100.0].map(|value| scale.at(value));
        for (pixel, expected) in pixels.iter().zip([100.0, 200.0, 300.0, 400.0, 500.0]) {
            assert!((pixel - expected).abs() < 1e-9, "{pixels:?}");
        }
        assert_eq!(LogScale::new([5.0, 5.0], [0.0, 10.0]).at(5.0), 5.0);
    }

    #[test]
    fn ticks_are_round_within_and_few() {
        let ticks = |low: f64, high: f64, most| LogScale::new([low, high], [0.0, 1.0]).ticks(most);
        assert_eq!(ticks(150.0, 7000.0, 6).named, [200.0, 500.0, 1e3, 2e3, 5e3]);
        assert_eq!(
            ticks(1e-5, 1.0, 6).named,
            [1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0]
        );
        assert_eq!(ticks(1e-8, 1.0, 5).named, [1e-8, 1e-6, 1e-4, 1e-2, 1.0]);
        let fine = ticks(1.0, 10.0, 4);
        assert_eq!(fine.named, [1.0, 2.0, 5.0, 10.0]);
        assert_eq!(fine.faint, [3.0, 4.0, 6.0, 7.0, 8.0, 9.0]);
    }

    #[test]
    fn ranges_skip_what_no_logarithm_takes() {
        let values = [f64::NAN, 0.0, 3.0, 0.5, f64::INFINITY, -1.0];
        assert_eq!(range(values.into_iter()), Some([0.5, 3.0]));
        assert_eq!(range([0.0].into_iter()), None);
        let [low, high] = padded([1.0, 100.0], 0.5);
        assert!((low - 0.1).abs() < 1e-12 && (high - 1000.0).abs() < 1e-9);
    }
}
