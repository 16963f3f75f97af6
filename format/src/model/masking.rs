//! The directions at which the masking of a map's own normals is stored.

/// A grid over the directions above the horizon: columns around, rows from the horizon up.
///
/// A direction ω is looked at as `o = ω / (|ω_x| + |ω_y| + ω_z)`, a point of the octahedron (\[CDEHMM14\]),
/// whose coordinates are linear in ω within a quarter turn. Its row is `ROWS √o_z`: rows lie dense at the horizon,
/// where masking sets in within the slopes of the map, and wide around the pole, where there is none. Its column counts
/// quarter turns from +s over +t, each divided in proportion to `|ω_y| / (|ω_x| + |ω_y|)` (or x, in odd quarters), so
/// that the axes, along which brushes and scratches run, are columns. No transcendental function is needed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MaskingGrid;

/// Where a direction lies in a [`MaskingGrid`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaskingPlace {
    /// In [0, [`MaskingGrid::COLUMNS`]]; both ends are the same heading.
    pub column: f64,
    /// From 0 at the horizon to [`MaskingGrid::ROWS`] at the pole.
    pub row: f64,
    /// `o_z`, in (0, 1].
    pub height: f64,
}

impl MaskingGrid {
    /// Headings around the pole.
    pub const COLUMNS: u32 = 64;
    /// Heights from the horizon up; the pole would be the next.
    pub const ROWS: u32 = 32;
    /// Values of a table, row by row.
    pub const COUNT: usize = 64 * 32;
    /// Columns of a quarter turn.
    const QUARTER: u32 = Self::COLUMNS / 4;

    /// The horizontal direction (x, y) of `column`, with `|x| + |y| = 1`.
    pub fn heading(column: u32) -> [f64; 2] {
        let quarter = (column % Self::COLUMNS) / Self::QUARTER;
        let part = f64::from(column % Self::QUARTER) / f64::from(Self::QUARTER);
        let rest = 1.0 - part;
        match quarter {
            0 => [rest, part],
            1 => [-part, rest],
            2 => [-rest, -part],
            _ => [part, -rest],
        }
    }

    /// The height `o_z` of `row`, in [0, 1).
    pub fn height(row: u32) -> f64 {
        let root = f64::from(row) / f64::from(Self::ROWS);
        root * root
    }

    /// The place of `direction`, of any length, or `None` unless it points above the horizon.
    pub fn place_of(direction: [f64; 3]) -> Option<MaskingPlace> {
        let [x, y, z] = direction;
        let across = x.abs() + y.abs();
        let height = z / (across + z);
        // Also refuses what is not a number.
        if !(z > 0.0 && height > 0.0) {
            return None;
        }
        let turn = if across == 0.0 {
            0.0
        } else {
            match (x < 0.0, y < 0.0) {
                (false, false) => y / across,
                (true, false) => 1.0 - x / across,
                (true, true) => 2.0 - y / across,
                (false, true) => 3.0 + x / across,
            }
        };
        Some(MaskingPlace {
            column: turn * f64::from(Self::QUARTER),
            row: libm::sqrt(height) * f64::from(Self::ROWS),
            height,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_node_is_its_own_place() {
        for row in 1..MaskingGrid::ROWS {
            for column in 0..MaskingGrid::COLUMNS {
                let height = MaskingGrid::height(row);
                let [x, y] = MaskingGrid::heading(column).map(|part| part * (1.0 - height));
                for length in [0.1, 1.0, 7.0] {
                    let direction = [x, y, height].map(|part| part * length);
                    let place = MaskingGrid::place_of(direction).expect("above the horizon");
                    assert!(
                        (place.column - f64::from(column)).abs() < 1e-12,
                        "{place:?}"
                    );
                    assert!((place.row - f64::from(row)).abs() < 1e-12, "{place:?}");
                    assert!((place.height - height).abs() < 1e-15, "{place:?}");
                }
            }
        }
    }

    #[test]
    fn columns_turn_from_s_over_t_and_meet_again() {
        let mut previous = -1.0;
        for step in 0..1000 {
            let angle = f64::from(step) * core::f64::consts::TAU / 1000.0;
            let place = MaskingGrid::place_of([libm::cos(angle), libm::sin(angle), 0.3]);
            let column = place.expect("above the horizon").column;
            assert!(column > previous && column <= 64.0, "{step}: {column}");
            previous = column;
        }
        assert!(previous > 63.8, "{previous}");
        let axis = |direction| MaskingGrid::place_of(direction).map(|place| place.column);
        assert_eq!(axis([0.0, 1.0, 0.1]), Some(16.0));
        assert_eq!(axis([-1.0, 0.0, 0.1]), Some(32.0));
        assert_eq!(axis([0.0, -1.0, 0.1]), Some(48.0));
    }

    #[test]
    fn the_pole_is_the_last_row_and_the_horizon_is_no_place() {
        let pole = MaskingGrid::place_of([0.0, 0.0, 1.0]).expect("above the horizon");
        assert_eq!((pole.row, pole.height), (32.0, 1.0));
        for below in [
            [1.0, 0.0, 0.0],
            [1.0, 0.0, -0.1],
            [0.0, 0.0, -1.0],
            [0.0; 3],
            [f64::NAN, 0.0, 1.0],
            [1.0, 0.0, f64::NAN],
            [f64::INFINITY, 0.0, 1.0],
        ] {
            assert_eq!(MaskingGrid::place_of(below), None, "{below:?}");
        }
    }
}
