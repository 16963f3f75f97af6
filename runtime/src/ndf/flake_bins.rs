//! `flake-bins`: rough flakes over an inverse bin map.
//!
//! Paper: \[AWKK21\] Atanasov, Wilkie, Koylazov, Křivánek, "A Multiscale Microfacet Model Based on Inverse Bin
//! Mapping", 2021. `D(h) = Σ_j W_j D^α(h, b_j)` over the bins near h (eq. 15), or `Σ_k w_k D^α(h, t_k)` over the
//! texels under the footprint (eq. 11).

use super::bin_weights::{
    BinWindow, How, Lookup, Patch, bin_weights, check_finite, for_each_texel, map_shape,
    patch_under, texel_under,
};
use super::{Facet, Ndf};
use crate::error::QueryError;
use crate::microfacet::{Masking, beckmann};
use crate::simd::Instructions;
use glintbake_format::model::{Filter, Footprint, HalfVector, Neighbourhood};
use glintbake_format::records::{EXACT_NORMALS, Instance};
use glintbake_format::view::{BinTables, ExactNormals};
use glintbake_format::{Container, Fault, Finding};

/// Which of the paper's sums answers a query.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    /// Eq. 15: bins near the half vector, each flake at its bin's centre. Cost hardly grows with the footprint.
    Binned(Neighbourhood),
    /// Eq. 11: every texel under the footprint, each with its own normal. Cost is the number of texels; needs the
    /// section of exact normals.
    Exact,
}

impl Default for Setting {
    fn default() -> Self {
        Self::Binned(Neighbourhood::default())
    }
}

impl Setting {
    /// The word used in metadata and in the header of query results.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Binned(neighbourhood) => neighbourhood.name(),
            Self::Exact => "exact",
        }
    }
}

/// The P-NDF of a `flake-bins` instance.
#[derive(Clone, Copy, Debug)]
pub struct FlakeBins<'a> {
    tables: BinTables<'a>,
    /// A package stores them once, with its finest bins.
    exact: Option<ExactNormals<'a>>,
    masking: Masking<'a>,
    roughness: f64,
    setting: Setting,
    pub(super) how: How,
}

impl<'a> FlakeBins<'a> {
    /// The P-NDF of `instance` of `container`, which must have been baked for this method.
    ///
    /// # Errors
    /// [`QueryError::Damaged`] if a section is missing or of the wrong size.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Self, QueryError> {
        let roughness = instance
            .roughness
            .ok_or(Finding::new(Fault::InstanceField))?;
        Ok(Self {
            tables: BinTables::open(container, instance)?,
            exact: find_exact_normals(container, instance)?,
            masking: Masking::of_map(container, instance)?,
            roughness,
            setting: Setting::default(),
            how: How::new(instance),
        })
    }

    /// The same P-NDF under `setting`.
    ///
    /// # Errors
    /// [`QueryError::NotBaked`] if `setting` is [`Setting::Exact`] and the package has no exact normals.
    pub fn with_setting(mut self, setting: Setting) -> Result<Self, QueryError> {
        if setting == Setting::Exact && self.exact.is_none() {
            return Err(NO_EXACT_NORMALS);
        }
        self.setting = setting;
        Ok(self)
    }

    /// The same P-NDF, its bin weights found by `lookup`; every choice gives the same weights within rounding.
    #[must_use]
    pub fn with_lookup(mut self, lookup: Lookup) -> Self {
        self.how.lookup = lookup;
        self
    }

    /// The same P-NDF, Gaussian footprints weighed with `instructions`; every choice gives the same bits. Boxes are weighed
    /// by integers and a few comparisons, which wider vectors do not speed up.
    #[must_use]
    pub fn with_instructions(mut self, instructions: Instructions) -> Self {
        self.how.instructions = instructions;
        self
    }

    /// The same P-NDF under another filter; that of the instance unless this says otherwise.
    #[must_use]
    pub fn with_filter(mut self, filter: Filter) -> Self {
        self.how.filter = filter;
        self
    }

    /// The same P-NDF, Gaussian footprints weighed within `tolerance`: see
    /// [`SurfaceNdf::with_tolerance`](super::SurfaceNdf::with_tolerance).
    #[must_use]
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.how.tolerance = tolerance;
        self
    }

    /// The setting queries are answered under.
    pub const fn setting(&self) -> Setting {
        self.setting
    }

    /// The filter that weighs footprints.
    pub const fn filter(&self) -> Filter {
        self.how.filter
    }

    /// Calls `visit(column, row, weight)` for the bins of the neighbourhood around `half_vector`'s bin that have
    /// weight over `footprint`: the `W_j` of \[AWKK21\] eq. 13.
    ///
    /// # Errors
    /// As [`Ndf::facets`].
    pub fn bin_weights(
        &self,
        footprint: &Footprint,
        half_vector: HalfVector,
        neighbourhood: Neighbourhood,
        visit: &mut dyn FnMut(u32, u32, f64),
    ) -> Result<(), QueryError> {
        check_finite(half_vector)?;
        let patch = patch_under(&self.tables, footprint, self.how.filter)?;
        self.weigh(&patch, half_vector, neighbourhood, visit)
    }

    fn weigh(
        &self,
        patch: &Patch,
        half_vector: HalfVector,
        neighbourhood: Neighbourhood,
        visit: &mut dyn FnMut(u32, u32, f64),
    ) -> Result<(), QueryError> {
        let (column, row) = self.tables.bins.grid.bin_of(half_vector);
        let window = BinWindow {
            column,
            row,
            neighbourhood: Some(neighbourhood),
        };
        bin_weights(
            &self.tables,
            patch,
            window,
            self.how,
            &mut |column, row, weight| visit(column, row, weight),
        )
    }

    /// The normal of texel (`column`, `row`) as the setting sees it: its own, or its bin's centre.
    fn normal_of_texel(&self, column: u32, row: u32) -> Result<[f64; 3], QueryError> {
        if self.setting != Setting::Exact {
            let grid = self.tables.bins.grid;
            let (bin_column, bin_row) = grid.column_row(self.tables.bin_of_texel(column, row)?);
            return Ok(grid.centre(bin_column, bin_row));
        }
        let exact = self.exact.as_ref().ok_or(NO_EXACT_NORMALS)?;
        Ok(exact.normal(column, row)?.direction())
    }
}

const NO_EXACT_NORMALS: QueryError = QueryError::NotBaked {
    section: EXACT_NORMALS,
    option: "--exact-normals",
};

/// The exact normals of the map of `instance`, which some instance of the package may store for all.
fn find_exact_normals<'a>(
    container: &Container<'a>,
    instance: &Instance,
) -> Result<Option<ExactNormals<'a>>, Finding> {
    for other in container.instances() {
        let other = other?;
        if (other.layer, other.method) == (instance.layer, instance.method)
            && (other.width, other.height) == (instance.width, instance.height)
            && let Some(normals) = ExactNormals::open(container, &other)?
        {
            return Ok(Some(normals));
        }
    }
    Ok(None)
}

impl Ndf for FlakeBins<'_> {
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
        // Refuse a bad footprint whatever the half vector, so that an error does not depend on the light.
        let patch = patch_under(&self.tables, footprint, self.how.filter)?;
        if !half_vector.is_on_disk() {
            return Ok(());
        }
        let direction = half_vector.direction();
        let mut emit = |normal: [f64; 3], weight: f64| {
            let density = beckmann::density(direction, normal, self.roughness);
            if density > 0.0 {
                visit(Facet {
                    normal,
                    density,
                    weight,
                });
            }
        };
        match self.setting {
            Setting::Binned(neighbourhood) => {
                let grid = self.tables.bins.grid;
                self.weigh(
                    &patch,
                    half_vector,
                    neighbourhood,
                    &mut |column, row, weight| emit(grid.centre(column, row), weight),
                )
            }
            Setting::Exact => {
                let shape = map_shape(&self.tables);
                let mut visit = |column, row, weight| {
                    if weight > 0.0 {
                        emit(self.normal_of_texel(column, row)?, weight);
                    }
                    Ok(())
                };
                match &patch {
                    Patch::Box(footprint) => shape.scan(footprint, &mut |rows| {
                        for row in rows {
                            for column in row.columns.clone() {
                                visit(column, row.row, row.weight(column))?;
                            }
                        }
                        Ok(())
                    }),
                    Patch::Gaussian(footprint) => for_each_texel(shape, footprint, &mut visit),
                }
            }
        }
    }

    fn sample(
        &self,
        footprint: &Footprint,
        uniform: [f64; 4],
    ) -> Result<Option<HalfVector>, QueryError> {
        let (texel_column, texel_row) = texel_under(
            &self.tables,
            footprint,
            self.how.filter,
            [uniform[0], uniform[1]],
        )?;
        let centre = self.normal_of_texel(texel_column, texel_row)?;
        let drawn = beckmann::sample(centre, self.roughness, [uniform[2], uniform[3]]);
        if drawn[2] <= 0.0 {
            return Ok(None);
        }
        let half_vector = HalfVector::from_direction(drawn);
        if let Setting::Binned(neighbourhood) = self.setting {
            // `eval` at the drawn vector looks no further than its neighbourhood, so neither may the sampler.
            let grid = self.tables.bins.grid;
            let (own_column, own_row) =
                grid.column_row(self.tables.bin_of_texel(texel_column, texel_row)?);
            let (column, row) = grid.bin_of(half_vector);
            let dx = i64::from(own_column) - i64::from(column);
            let dy = i64::from(own_row) - i64::from(row);
            let limit = i64::from(neighbourhood.reach()) + 1;
            let clamp = |distance: i64| distance.clamp(-limit, limit) as i32;
            if !neighbourhood.holds(clamp(dx), clamp(dy)) {
                return Ok(None);
            }
        }
        Ok(half_vector.is_on_disk().then_some(half_vector))
    }
}
