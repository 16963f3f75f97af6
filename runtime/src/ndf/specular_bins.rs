//! `specular-bins`: mirror flakes over equal-solid-angle bins.
//!
//! Paper: \[ABKK20\] Atanasov, Křivánek, Koylazov, Wilkie, "Efficient Multiscale Rendering of Specular
//! Microstructure", 2020. `D(h) = Σ |A ∩ T_k| / (|H| |A|)` over the texels whose normal shares h's bin H (§2):
//! the true density averaged over that bin.

use super::bin_weights::{BinWindow, How, bin_weights, check_finite, patch_under, texel_under};
use super::{Facet, Ndf};
use crate::error::QueryError;
use crate::microfacet::Masking;
use glintbake_format::Container;
use glintbake_format::model::{Footprint, HalfVector};
use glintbake_format::records::Instance;
use glintbake_format::view::BinTables;

/// The P-NDF of a `specular-bins` instance.
#[derive(Clone, Copy, Debug)]
pub struct SpecularBins<'a> {
    tables: BinTables<'a>,
    masking: Masking<'a>,
    pub(super) how: How,
}

impl<'a> SpecularBins<'a> {
    /// The P-NDF of `instance` of `container`, which must have been baked for this method.
    ///
    /// # Errors
    /// [`QueryError::Damaged`] if a section is missing or of the wrong size.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Self, QueryError> {
        Ok(Self {
            tables: BinTables::open(container, instance)?,
            masking: Masking::of_map(container, instance)?,
            how: How::new(instance),
        })
    }
}

impl Ndf for SpecularBins<'_> {
    fn instance(&self) -> &Instance {
        &self.tables.instance
    }

    fn masking(&self) -> Masking<'_> {
        self.masking
    }

    fn facets(
        &self,
        footprint: &Footprint,
        half_vector: HalfVector,
        visit: &mut dyn FnMut(Facet),
    ) -> Result<(), QueryError> {
        check_finite(half_vector)?;
        let patch = patch_under(&self.tables, footprint, self.how.filter)?;
        if !half_vector.is_on_disk() {
            return Ok(());
        }
        let grid = self.tables.bins.grid;
        let (column, row) = grid.bin_of(half_vector);
        let window = BinWindow {
            column,
            row,
            neighbourhood: None,
        };
        bin_weights(
            &self.tables,
            &patch,
            window,
            self.how,
            &mut |_, _, weight| {
                visit(Facet {
                    normal: half_vector.direction(),
                    density: 1.0 / grid.solid_angle(),
                    weight,
                });
            },
        )
    }

    fn sample(
        &self,
        footprint: &Footprint,
        uniform: [f64; 4],
    ) -> Result<Option<HalfVector>, QueryError> {
        let (column, row) = texel_under(
            &self.tables,
            footprint,
            self.how.filter,
            [uniform[0], uniform[1]],
        )?;
        let grid = self.tables.bins.grid;
        let (column, row) = grid.column_row(self.tables.bin_of_texel(column, row)?);
        // Equal areas of the square are equal solid angles: uniform in the bin's square is uniform in the bin.
        Ok(Some(
            grid.normal_in_bin(column, row, uniform[2], uniform[3]),
        ))
    }
}
