//! A generated map and its encodings.

/// A tileable map of unit normals as points (s, t) of the projected disk.
///
/// The third component is `√(1 − s² − t²)`, at least 0.0014: even next to the horizon it encodes as positive at 8 and
/// at 16 bits.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height` points, row-major from the top row; +s right, +t up (OpenGL).
    pub normals: Vec<[f32; 2]>,
}

impl Sample {
    /// The map as 16-bit RGB, interleaved, row-major: `round((n · ½ + ½) · 65535)`, green up (OpenGL).
    ///
    /// No code stands for 0: a flat normal becomes 32768 and decodes to 1.5e-5.
    pub fn rgb16(&self) -> Vec<u16> {
        self.encode(65535.0, |code| code as u16)
    }

    /// The map as 8-bit RGB, interleaved, row-major: `round((n · ½ + ½) · 255)`, green up (OpenGL).
    ///
    /// No code stands for 0: a flat normal becomes (128, 128, 255) and decodes to 0.0039.
    pub fn rgb8(&self) -> Vec<u8> {
        self.encode(255.0, |code| code as u8)
    }

    fn encode<T>(&self, largest_code: f64, to_integer: impl Fn(f64) -> T) -> Vec<T> {
        self.normals
            .iter()
            .flat_map(|&[s, t]| {
                let [s, t] = [f64::from(s), f64::from(t)];
                let z = (1.0 - s * s - t * t).max(0.0).sqrt();
                // Adding a half and flooring is rounding, for codes are never negative.
                [s, t, z].map(|x| to_integer(((x * 0.5 + 0.5) * largest_code + 0.5).floor()))
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encodings_match_worked_values() {
        let sample = Sample {
            width: 3,
            height: 1,
            normals: vec![[0.0, 0.0], [0.48, -0.6], [-0.28, 0.0]],
        };
        // The third components are 1, 0.64 and 0.96; 0.74·255 = 188.7, 0.2·255 = 51, 0.82·255 = 209.1, and so on.
        assert_eq!(sample.rgb8(), [128, 128, 255, 189, 51, 209, 92, 128, 250]);
        assert_eq!(
            sample.rgb16(),
            [
                32768, 32768, 65535, 48496, 13107, 53739, 23593, 32768, 64224
            ]
        );
    }
}
