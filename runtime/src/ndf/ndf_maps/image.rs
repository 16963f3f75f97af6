//! NDF images at one normal.

use glintbake_format::model::NdfPixels;
use glintbake_format::records::{NdfImage, unpack_ndf};
use zerocopy::little_endian::U16;

/// Where the pixels around a normal are, and how much each weighs: the same for all images, as they share their nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Probe {
    /// The first of four columns, and of four rows.
    node: [i32; 2],
    across: [f32; 4],
    down: [f32; 4],
}

impl Probe {
    /// That of `normal`, pixels lying `pitch` apart.
    pub fn new(normal: [f64; 2], pitch: f64, pixels: NdfPixels) -> Self {
        let axis = |at: f64| {
            let at = at / pitch;
            match pixels {
                NdfPixels::Splines => {
                    let whole = libm::floor(at);
                    (
                        (whole as i32).saturating_sub(1),
                        spline((at - whole) as f32),
                    )
                }
                NdfPixels::Points => {
                    // Pixels stand for their middles.
                    let at = at - 0.5;
                    let whole = libm::floor(at);
                    let share = (at - whole) as f32;
                    (whole as i32, [1.0 - share, share, 0.0, 0.0])
                }
            }
        };
        let [s, t] = normal;
        let ((column, across), (row, down)) = (axis(s), axis(t));
        Self {
            node: [column, row],
            across,
            down,
        }
    }

    /// The value of `image` there, in the unit of `pixels`, which are those of all images. 0 where the package is damaged.
    #[inline]
    pub fn value(&self, image: &NdfImage, pixels: &[U16]) -> f32 {
        let [columns, rows] = image.size.map(|side| i64::from(side.get()));
        let x = i64::from(self.node[0]) - i64::from(image.place[0].get());
        let y = i64::from(self.node[1]) - i64::from(image.place[1].get());
        if x <= -4 || y <= -4 || x >= columns || y >= rows {
            return 0.0;
        }
        let mut sum = 0.0;
        for (row, down) in (y..).zip(self.down) {
            if row < 0 || row >= rows {
                continue;
            }
            let start = i64::from(image.first.get()) + row * columns;
            let mut of_row = 0.0;
            if x >= 0 && x + 4 <= columns {
                let first = (start + x) as usize;
                let Some(four) = pixels.get(first..first.wrapping_add(4)) else {
                    return 0.0;
                };
                for (pixel, across) in four.iter().zip(self.across) {
                    of_row += across * unpack_ndf(pixel.get());
                }
            } else {
                for (column, across) in (x..).zip(self.across) {
                    if column >= 0 && column < columns {
                        let pixel = pixels.get((start + column) as usize);
                        of_row += across * pixel.map_or(0.0, |pixel| unpack_ndf(pixel.get()));
                    }
                }
            }
            sum += down * of_row;
        }
        sum
    }
}

/// The weights of the nodes -1, 0, 1 and 2 of a cubic B-spline, `x` past node 0.
fn spline(x: f32) -> [f32; 4] {
    let y = 1.0 - x;
    let (x_cube, y_cube) = (x * x * x, y * y * y);
    [
        y_cube * (1.0 / 6.0),
        (4.0 - 6.0 * x * x + 3.0 * x_cube) * (1.0 / 6.0),
        (4.0 - 6.0 * y * y + 3.0 * y_cube) * (1.0 / 6.0),
        x_cube * (1.0 / 6.0),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glintbake_format::records::pack_ndf;
    use zerocopy::little_endian::{I32, U32};

    fn image(place: [i32; 2], size: [u16; 2]) -> NdfImage {
        NdfImage {
            place: place.map(I32::new),
            size: size.map(U16::new),
            first: U32::new(0),
        }
    }

    #[test]
    fn splines_weigh_one_in_all_and_know_their_middle() {
        for step in 0..=10 {
            let x = step as f32 / 10.0;
            let weights = spline(x);
            let sum: f32 = weights.iter().sum();
            let middle: f32 = weights
                .iter()
                .zip([-1.0, 0.0, 1.0, 2.0])
                .map(|(w, at)| w * at)
                .sum();
            assert!((sum - 1.0).abs() < 1e-6 && (middle - x).abs() < 1e-6, "{x}");
        }
    }

    #[test]
    fn pixels_beyond_the_image_are_zero() {
        let pixels = [U16::new(pack_ndf(1.0)); 9];
        let image = image([-1, -1], [3, 3]);
        let at =
            |s: f64, t: f64| Probe::new([s, t], 0.1, NdfPixels::Splines).value(&image, &pixels);
        assert!((at(0.0, 0.0) - 1.0).abs() < 1e-6);
        assert!((at(0.1, 0.0) - 5.0 / 6.0).abs() < 1e-6);
        assert!((at(-0.2, -0.2) - 1.0 / 36.0).abs() < 1e-6);
        assert_eq!(at(0.3, 0.0), 0.0);
        assert_eq!(at(1e9, -1e9), 0.0);
    }

    #[test]
    fn points_are_read_between_their_middles() {
        let pixels = [1.0, 2.0, 3.0, 4.0].map(|value| U16::new(pack_ndf(value)));
        let image = image([0, 0], [2, 2]);
        let at = |s: f64, t: f64| Probe::new([s, t], 0.1, NdfPixels::Points).value(&image, &pixels);
        assert!((at(0.05, 0.05) - 1.0).abs() < 1e-6);
        assert!((at(0.1, 0.05) - 1.5).abs() < 1e-6);
        assert!((at(0.1, 0.1) - 2.5).abs() < 1e-6);
    }
}
