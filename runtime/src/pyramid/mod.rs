//! Footprints over MIP pyramids: which cells a footprint looks at, and how much of each.
//!
//! ```text
//! footprint ──probes──► level and places ──for_each_cell──► cells and shares
//! ```
//!
//! Of normals (`ndf/lean`) and of opacities (`layers/opacity`) alike: whatever is averaged is looked up in the same places.

mod probes;

pub(crate) use probes::Probes;

use crate::error::QueryError;
use crate::overlap::Placement;
use glintbake_format::model::Wrap;

/// Calls `visit(column, row, weight)` for the cells of one level that `probes` about the centre of `placement` look at: each
/// probe is bilinear between four cells, so that there are at most 15 × 4, and their weights add up to `share`. `size` is the
/// level's in cells, `map_size` the map's in texels, which goes on as `wrap` says.
///
/// # Errors
/// What `visit` returns.
pub(crate) fn for_each_cell(
    placement: &Placement,
    probes: &Probes,
    map_size: [u32; 2],
    size: [u32; 2],
    wrap: Wrap,
    share: f64,
    visit: &mut impl FnMut(u32, u32, f64) -> Result<(), QueryError>,
) -> Result<(), QueryError> {
    let [width, height] = map_size.map(f64::from);
    let [columns, rows] = size.map(f64::from);
    let scale = [columns / width, rows / height];
    probes.for_each(&mut |offset, weight| {
        // The fraction first: it may be small beside the cell.
        let column = placement.cell[0] + (placement.centre[0] + offset[0]);
        let row = placement.cell[1] + (placement.centre[1] + offset[1]);
        let columns = Nearby::new(column * scale[0], size[0], wrap);
        let rows = Nearby::new(row * scale[1], size[1], wrap);
        let weight = share * weight;
        for (row, row_share) in rows.0 {
            for (column, column_share) in columns.0 {
                let weight = weight * row_share * column_share;
                if weight > 0.0 {
                    visit(column, row, weight)?;
                }
            }
        }
        Ok(())
    })
}

/// The two cells whose middles a place lies between, on one axis, and their shares.
#[derive(Clone, Copy, Debug)]
struct Nearby([(u32, f64); 2]);

impl Nearby {
    /// At `place`, in cells, of `count` cells that go on as `wrap` says.
    fn new(place: f64, count: u32, wrap: Wrap) -> Self {
        let from_middle = place - 0.5;
        let whole = libm::floor(from_middle);
        let share = from_middle - whole;
        let fold = |cell: i64| match wrap {
            Wrap::Repeat => cell.rem_euclid(i64::from(count)) as u32,
            Wrap::Clamp => cell.clamp(0, i64::from(count) - 1) as u32,
        };
        let cell = whole as i64;
        Self([
            (fold(cell), 1.0 - share),
            (fold(cell.saturating_add(1)), share),
        ])
    }
}
