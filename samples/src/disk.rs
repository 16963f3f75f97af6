//! The texels of a round feature.

use core::ops::Range;

/// A disk on a tile that repeats, in texels.
#[derive(Clone, Copy, Debug)]
pub struct Disk {
    /// (x, y) of its middle.
    pub centre: [f64; 2],
    pub radius: f64,
}

impl Disk {
    /// Visits the texels of `rows` whose centres lie in the disk, those of its copies to the left and right included,
    /// as (index from the first texel of `rows`, offset from the middle); a disk wider than the tile visits texels more
    /// than once.
    #[inline]
    pub fn visit_texels(
        &self,
        rows: Range<usize>,
        width: usize,
        mut visit: impl FnMut(usize, [f64; 2]),
    ) {
        let [x, y] = self.centre;
        let near = texels(y, self.radius);
        let first = near.start.max(rows.start as i64);
        let end = near.end.min(rows.end as i64);
        for row in first..end {
            let dy = row as f64 + 0.5 - y;
            let half_chord = (self.radius * self.radius - dy * dy).max(0.0).sqrt();
            let start = (row as usize - rows.start) * width;
            let columns = texels(x, half_chord);
            let mut column = columns.start.rem_euclid(width as i64) as usize;
            for unwrapped in columns {
                visit(start + column, [unwrapped as f64 + 0.5 - x, dy]);
                column += 1;
                if column == width {
                    column = 0;
                }
            }
        }
    }
}

/// The texels whose centres are within `reach` of `x`.
fn texels(x: f64, reach: f64) -> Range<i64> {
    (x - reach - 0.5).ceil() as i64..(x + reach - 0.5).floor() as i64 + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_are_those_nearer_than_the_radius_to_a_copy() {
        let width = 7;
        for (centre, radius) in [
            ([3.2, 5.9], 2.5),
            ([6.9, 4.0], 3.0),
            ([0.1, 8.3], 9.4),
            ([2.0, 2.0], 0.2),
        ] {
            let mut found = vec![0; 7 * 6];
            Disk { centre, radius }.visit_texels(4..10, width, |index, offset| {
                let texel = [index % width, index / width + 4].map(|i| i as f64 + 0.5);
                // A whole number of tiles away.
                let tiles = (centre[0] + offset[0] - texel[0]) / 7.0;
                assert!((tiles - tiles.round()).abs() < 1e-12);
                assert!((centre[1] + offset[1] - texel[1]).abs() < 1e-12);
                found[index] += 1;
            });
            for (index, &count) in found.iter().enumerate() {
                let [x, y] = [index % width, index / width + 4].map(|i| i as f64 + 0.5);
                let near = |copy: &i32| {
                    let dx = x + 7.0 * f64::from(*copy) - centre[0];
                    dx.hypot(y - centre[1]) <= radius
                };
                let expected = (-5..=5).filter(near).count();
                assert_eq!(count, expected, "({x}, {y}) of {centre:?}, {radius}");
            }
        }
    }
}
