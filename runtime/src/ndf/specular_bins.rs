//! `specular-bins`: mirror flakes over equal-solid-angle bins.
//!
//! Paper: \[ABKK20\] Atanasov, Křivánek, Koylazov, Wilkie, "Efficient Multiscale Rendering of Specular
//! Microstructure", 2020. `D(h) = Σ |A ∩ T_k| / (|H| |A|)` over the texels whose normal shares h's bin H (§2):
//! the true density averaged over that bin.

use super::bin_weights::{BinWindow, Lookup, bin_weights, map_shape};
use super::flake_bins::check_finite;
use super::{Facet, Ndf};
use crate::error::QueryError;
use crate::overlap::Parallelogram;
use glintbake_format::Container;
use glintbake_format::model::{Footprint, HalfVector};
use glintbake_format::records::Instance;
use glintbake_format::view::BinTables;

/// The P-NDF of a `specular-bins` instance.
#[derive(Clone, Copy, Debug)]
pub struct SpecularBins<'a> {
    tables: BinTables<'a>,
}

impl<'a> SpecularBins<'a> {
    /// The P-NDF of `instance` of `container`, which must have been baked for this method.
    ///
    /// # Errors
    /// [`QueryError::Damaged`] if a section is missing or of the wrong size.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Self, QueryError> {
        Ok(Self {
            tables: BinTables::open(container, instance)?,
        })
    }

    fn parallelogram(&self, footprint: &Footprint) -> Result<Parallelogram, QueryError> {
        let Instance {
            width,
            height,
            wrap,
            ..
        } = self.tables.instance;
        Parallelogram::new(footprint, width, height, wrap)
    }
}

impl Ndf for SpecularBins<'_> {
    fn instance(&self) -> &Instance {
        &self.tables.instance
    }

    fn facets(
        &self,
        footprint: &Footprint,
        half_vector: HalfVector,
        visit: &mut dyn FnMut(Facet),
    ) -> Result<(), QueryError> {
        check_finite(half_vector)?;
        let footprint = self.parallelogram(footprint)?;
        if !half_vector.is_on_disk() {
            return Ok(());
        }
        let grid = self.tables.instance.grid;
        let (column, row) = grid.bin_of(half_vector);
        let window = BinWindow {
            column,
            row,
            neighbourhood: None,
        };
        bin_weights(
            &self.tables,
            &footprint,
            window,
            Lookup::Auto,
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
        let footprint = self.parallelogram(footprint)?;
        let (column, row) =
            map_shape(&self.tables).texel_at(&footprint, uniform[0] - 0.5, uniform[1] - 0.5);
        let texel = self.tables.texel(column, row);
        let grid = self.tables.instance.grid;
        let (column, row) = grid.column_row(self.tables.bin_of_texel(texel)?);
        // Equal areas of the square are equal solid angles: uniform in the bin's square is uniform in the bin.
        Ok(Some(
            grid.normal_in_bin(column, row, uniform[2], uniform[3]),
        ))
    }

    fn pdf(&self, footprint: &Footprint, half_vector: HalfVector) -> Result<f64, QueryError> {
        // A mirror facet's normal is the half vector itself, so the factor (h · normal) is 1.
        self.eval(footprint, half_vector)
    }
}
