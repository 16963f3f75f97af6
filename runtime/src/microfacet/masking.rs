//! Masking of the map's own normals: how much of the facets a direction sees, \[AWKK21\] eq. 5, `G_x`.

use glintbake_format::model::MaskingGrid;
use glintbake_format::records::Instance;
use glintbake_format::view::MaskingTable;
use glintbake_format::{Container, Finding};

/// Smith masking of a whole map, by direction.
///
/// It is the map's, not the footprint's: masking is by far facets as much as by near ones.
#[derive(Clone, Copy, Debug, Default)]
pub struct Masking<'a> {
    table: Option<MaskingTable<'a>>,
}

impl<'a> Masking<'a> {
    /// No masking: every direction above the horizon sees all facets. What packages baked without it have.
    pub const NONE: Self = Self { table: None };

    /// The masking of the map that `instance` of `container` was baked from, [`NONE`](Self::NONE) if it was baked
    /// without. O(instances).
    ///
    /// # Errors
    /// If the section is not of the right size.
    pub fn of_map(container: &Container<'a>, instance: &Instance) -> Result<Self, Finding> {
        Ok(Self {
            table: MaskingTable::of_map(container, instance)?,
        })
    }

    /// Whether the package holds a table.
    pub const fn is_baked(&self) -> bool {
        self.table.is_some()
    }

    /// The share `G1` of the facets facing `direction` that it sees, in [0, 1]; 0 at the horizon and below.
    ///
    /// `G1(ω) = (ω·n) / Σ_k w_k max(0, ω·t_k) / (t_k·n)` over all texels of the map, at most 1; any length of
    /// `direction` will do. What is interpolated between four values has no pole at the horizon, so the error is a share of
    /// G1 down to cosines of 0.001: on the sample maps 0.2 % on average and 0.7 % at most, but up to 7 % across brushes,
    /// whose slopes all lie along one line. Two square roots.
    pub fn g1(&self, direction: [f64; 3]) -> f64 {
        let Some(place) = MaskingGrid::place_of(direction) else {
            return 0.0;
        };
        let Some(table) = &self.table else {
            return 1.0;
        };
        // Casts from float saturate, and the table counts columns around and rows up to its last.
        let (column, row) = (place.column as u32, place.row as u32);
        let (x, y) = (place.column - f64::from(column), place.row - f64::from(row));
        let between = |row| {
            let (left, right) = (
                table.excess(column, row),
                table.excess(column.saturating_add(1), row),
            );
            left + x * (right - left)
        };
        let (below, above) = (between(row), between(row.saturating_add(1)));
        let excess = below + y * (above - below);
        if excess > 0.0 {
            place.height / (place.height + (1.0 - place.height) * excess)
        } else {
            1.0
        }
    }

    /// The share of the facets facing both `light` and `view` that is lit and seen: `G1(light) G1(view)`, the
    /// uncorrelated form, in [0, 1].
    pub fn g(&self, light: [f64; 3], view: [f64; 3]) -> f64 {
        self.g1(light) * self.g1(view)
    }
}
