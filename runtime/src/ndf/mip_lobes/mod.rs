//! `mip-lobes`: clustered lobes, level by level, over a surface that is quilted from a small sample, or over a map.
//!
//! Paper: \[TZX22\] Tan, Zhu, Xu, Wang, Wang, "Real-Time Microstructure Rendering with MIP-mapped Normal Map Samples", 2022. A
//! footprint is answered by the lobes of the two levels whose cells are about as large as it is, so that a query costs as much
//! for large footprints as for small ones; below the lowest level by the `lobes` of the surface themselves, whose normals come
//! from the sample by way of the quilt. Lobes take their roughness from the query: one bake serves all.
//!
//! ```text
//! footprint ──levels──► two levels ──walk──► cells or texels within reach ──sixteen──► Σ value / Σ weight, each level ──► D
//! ```

mod batch;
mod levels;
mod sixteen;
mod walk;

use super::bin_weights::check_finite;
use super::lobes::placed::Placed;
use super::lobes::term::Term;
use super::{Facet, Ndf};
use crate::error::QueryError;
use crate::lanes::LANES;
use crate::microfacet::Masking;
use crate::simd::{Instructions, Work};
use core::f64::consts::TAU;
use glintbake_format::model::{
    Filter, Footprint, HalfVector, LobeLattice, MipLayout, intrinsic_from_beckmann,
};
use glintbake_format::records::Instance;
use glintbake_format::{Container, Fault, Finding, view};
use levels::{Choice, Share};
use sixteen::{Asked, Positions, Source};
use walk::{Visitor, Walk};

/// The P-NDF of a `mip-lobes` instance.
#[derive(Clone, Copy, Debug)]
pub struct MipLobes<'a> {
    instance: Instance,
    lobes: view::MipLobes<'a>,
    masking: Masking<'a>,
    roughness: f64,
    filter: Filter,
    choice: Choice,
    instructions: Instructions,
}

impl<'a> MipLobes<'a> {
    /// The least and the greatest Beckmann roughness α it answers for.
    pub const ROUGHNESS: [f64; 2] = [1e-6, 10.0];

    /// The P-NDF of `instance` of `container`, which must have been baked for this method.
    ///
    /// # Errors
    /// [`QueryError::Damaged`] if a section is missing or of the wrong size.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Self, QueryError> {
        let roughness = instance
            .roughness
            .ok_or(Finding::new(Fault::InstanceField))?;
        Ok(Self {
            instance: *instance,
            lobes: view::MipLobes::of_map(container, instance)?,
            masking: Masking::of_map(container, instance)?,
            roughness,
            filter: instance.filter,
            choice: Choice {
                is_by_area: false,
                bias: 0.0,
            },
            instructions: Instructions::default(),
        })
    }

    /// The same P-NDF for Beckmann roughness `roughness`, 1e-6 to 10; that of the instance unless this says otherwise.
    ///
    /// # Errors
    /// [`QueryError::RoughnessRange`].
    pub fn with_roughness(mut self, roughness: f64) -> Result<Self, QueryError> {
        self.roughness = super::within(Self::ROUGHNESS, roughness)?;
        self.instance.roughness = Some(roughness);
        Ok(self)
    }

    /// The same P-NDF with levels chosen by the footprint's area alone, if `is_by_area`, as \[TZX22\] eq. 8 has it; else, unless this
    /// says otherwise, by its shorter axis, up to a length of eight times that: long footprints are then not blurred across.
    #[must_use]
    pub fn with_levels_by_area(mut self, is_by_area: bool) -> Self {
        self.choice.is_by_area = is_by_area;
        self
    }

    /// The same P-NDF with levels `bias` above those it would take, or below if negative; 0 unless this says otherwise. Each level
    /// below takes up to four times as long, and blurs half as far.
    ///
    /// # Errors
    /// [`QueryError::NotFinite`].
    pub fn with_level_bias(mut self, bias: f64) -> Result<Self, QueryError> {
        if !bias.is_finite() {
            return Err(QueryError::NotFinite);
        }
        self.choice.bias = bias;
        Ok(self)
    }

    /// The same P-NDF under another filter; that of the instance unless this says otherwise. Queries refuse all but the Gaussian.
    #[must_use]
    pub fn with_filter(mut self, filter: Filter) -> Self {
        self.filter = filter;
        self
    }

    /// The same P-NDF with these instructions; the fastest unless this says otherwise.
    #[must_use]
    pub fn with_instructions(mut self, instructions: Instructions) -> Self {
        self.instructions = instructions;
        self
    }

    /// Beckmann's roughness α of the kernel; its σr is α / √2.
    pub const fn roughness(&self) -> f64 {
        self.roughness
    }

    /// The filter asked for; queries refuse all but the Gaussian.
    pub const fn filter(&self) -> Filter {
        self.filter
    }

    /// Levels, clusters, and the quilt if the surface is one.
    pub const fn layout(&self) -> MipLayout {
        self.lobes.layout
    }

    /// Whether levels are chosen by area alone.
    pub const fn has_levels_by_area(&self) -> bool {
        self.choice.is_by_area
    }

    fn sigma(&self) -> f64 {
        intrinsic_from_beckmann(self.roughness)
    }

    fn placed(&self, footprint: &Footprint) -> Result<Placed, QueryError> {
        if self.filter != Filter::Gaussian {
            return Err(QueryError::FilterUnsupported(self.instance.method));
        }
        let Instance {
            width,
            height,
            wrap,
            ..
        } = self.instance;
        // In texels, whatever the lobes' own lattice.
        let texels = LobeLattice {
            curved: true,
            per_side: 1,
        };
        Placed::new(footprint, [width, height], wrap, texels)
    }

    fn walk(&self, placed: &Placed, half_vector: HalfVector) -> Walk<'_> {
        let normal = [half_vector.s, half_vector.t];
        Walk::new(&self.lobes, placed, normal, self.sigma())
    }

    fn density(&self, footprint: &Footprint, half_vector: HalfVector) -> Result<f64, QueryError> {
        check_finite(half_vector)?;
        let placed = self.placed(footprint)?;
        if !half_vector.is_on_disk() {
            return Ok(0.0);
        }
        let mut density = 0.0;
        for Share { level, share } in self.choice.levels(&self.lobes.layout, &placed) {
            if share > 0.0 {
                let walk = self.walk(&placed, half_vector);
                density += share * self.instructions.run(Density { walk, level })?;
            }
        }
        let sigma = self.sigma();
        Ok(density / (TAU * sigma * sigma))
    }
}

/// The mean density of a level, in units of `1 / 2πσr²`.
struct Density<'q> {
    walk: Walk<'q>,
    level: Option<u8>,
}

impl Work for Density<'_> {
    type Output = Result<f64, QueryError>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let mut sums = Sums {
            asked: self.walk.asked,
            weight: 0.0,
            value: 0.0,
        };
        self.walk.level(self.level, &mut sums)?;
        let density = sums.value / sums.weight;
        // Lobes of damaged packages may be no numbers, and then are none.
        let is_number = density > 0.0 && density < f64::INFINITY;
        Ok(if is_number { density } else { 0.0 })
    }
}

struct Sums {
    asked: Asked,
    weight: f64,
    value: f64,
}

impl Visitor for Sums {
    #[inline(always)]
    fn sixteen(&mut self, positions: &Positions, source: &impl Source) {
        let (weight, value) = positions.sums(source, &self.asked);
        self.weight += f64::from(weight);
        self.value += f64::from(value);
    }
}

/// The sum of all weights of a level.
struct Weights<'q> {
    walk: Walk<'q>,
    level: Option<u8>,
}

struct WeightSum {
    asked: Asked,
    sum: f64,
}

impl Visitor for WeightSum {
    #[inline(always)]
    fn sixteen(&mut self, positions: &Positions, _: &impl Source) {
        let weights = positions.weights(&self.asked);
        for weight in weights {
            self.sum += counted(weight);
        }
    }
}

impl Work for Weights<'_> {
    type Output = Result<f64, QueryError>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let mut weights = WeightSum {
            asked: self.walk.asked,
            sum: 0.0,
        };
        self.walk.level(self.level, &mut weights)?;
        Ok(weights.sum)
    }
}

/// `weight`, or nothing: lobes of damaged packages may be no numbers.
#[inline(always)]
fn counted(weight: f32) -> f64 {
    if weight > 0.0 && weight < f32::INFINITY {
        f64::from(weight)
    } else {
        0.0
    }
}

/// The lobe of a level that `left`, below the sum of all weights, falls on.
struct Draw<'q> {
    walk: Walk<'q>,
    level: Option<u8>,
    left: f64,
}

struct Drawn {
    asked: Asked,
    left: f64,
    term: Option<Term>,
}

impl Visitor for Drawn {
    #[inline(always)]
    fn sixteen(&mut self, positions: &Positions, source: &impl Source) {
        if self.left < 0.0 {
            return;
        }
        for (lane, weight) in positions.weights(&self.asked).into_iter().enumerate() {
            let weight = counted(weight);
            if weight <= 0.0 {
                continue;
            }
            self.left -= weight;
            if self.left < 0.0 {
                let normals = source.normals(&self.asked);
                let (_, term) = positions.term(&normals, lane, &self.asked);
                self.term = Some(term);
                return;
            }
        }
    }
}

impl Work for Draw<'_> {
    type Output = Result<Option<Term>, QueryError>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let mut drawn = Drawn {
            asked: self.walk.asked,
            left: self.left,
            term: None,
        };
        self.walk.level(self.level, &mut drawn)?;
        Ok(drawn.term)
    }
}

/// Hands on each lobe with its part of all weights.
struct Each<F> {
    asked: Asked,
    per_weight: f64,
    visit: F,
}

impl<F: FnMut(f64, &Term)> Visitor for Each<F> {
    fn sixteen(&mut self, positions: &Positions, source: &impl Source) {
        let normals = source.normals(&self.asked);
        for lane in 0..LANES {
            let (weight, term) = positions.term(&normals, lane, &self.asked);
            if weight > 0.0 && weight < f64::INFINITY {
                (self.visit)(weight * self.per_weight, &term);
            }
        }
    }
}

impl Ndf for MipLobes<'_> {
    fn instance(&self) -> &Instance {
        &self.instance
    }

    fn masking(&self) -> Masking<'_> {
        self.masking
    }

    /// Visits a facet for each lobe of the levels that answer, with its mean normal under the footprint.
    fn facets(
        &self,
        footprint: &Footprint,
        half_vector: HalfVector,
        visit: &mut dyn FnMut(Facet),
    ) -> Result<(), QueryError> {
        check_finite(half_vector)?;
        let placed = self.placed(footprint)?;
        if !half_vector.is_on_disk() {
            return Ok(());
        }
        let point = [half_vector.s, half_vector.t];
        let walk = self.walk(&placed, half_vector);
        for Share { level, share } in self.choice.levels(&self.lobes.layout, &placed) {
            if share <= 0.0 {
                continue;
            }
            let instructions = self.instructions;
            let total = instructions.run(Weights { walk, level })?;
            if total <= 0.0 {
                continue;
            }
            let mut each = Each {
                asked: walk.asked,
                per_weight: 1.0 / total,
                visit: |weight: f64, term: &Term| {
                    let (exponent, factor) = term.exponent(point);
                    let density = factor / TAU * libm::exp(-exponent);
                    if density > 0.0 && density < f64::INFINITY {
                        visit(Facet {
                            normal: term.normal().direction(),
                            density,
                            weight: share * weight,
                        });
                    }
                },
            };
            walk.level(level, &mut each)?;
        }
        Ok(())
    }

    fn eval(&self, footprint: &Footprint, half_vector: HalfVector) -> Result<f64, QueryError> {
        self.density(footprint, half_vector)
    }

    /// The first number draws the level, what is left of it the lobe there, and the last two a normal of its Gaussian: without a
    /// vector beyond the rim.
    fn sample(
        &self,
        footprint: &Footprint,
        uniform: [f64; 4],
    ) -> Result<Option<HalfVector>, QueryError> {
        if !uniform.iter().all(|x| x.is_finite()) {
            return Err(QueryError::NotFinite);
        }
        let placed = self.placed(footprint)?;
        let [first, second, third, fourth] = uniform;
        let [lower, upper] = self.choice.levels(&self.lobes.layout, &placed);
        let level = if first < lower.share {
            lower.level
        } else {
            upper.level
        };
        let pole = HalfVector { s: 0.0, t: 0.0 };
        let walk = self.walk(&placed, pole);
        let total = self.instructions.run(Weights { walk, level })?;
        // Just below the sum of all, so that rounding leaves nothing beyond the last lobe.
        let left = second * total * (1.0 - 1e-12);
        let drawn = self.instructions.run(Draw { walk, level, left })?;
        let Some(term) = drawn else {
            return Ok(None);
        };
        let (half_vector, _) = term.draw([third, fourth]);
        Ok(half_vector.is_on_disk().then_some(half_vector))
    }

    /// `D (h·n)` with the surface's normal n, which is what samples are drawn by.
    fn pdf(&self, footprint: &Footprint, half_vector: HalfVector) -> Result<f64, QueryError> {
        let density = self.density(footprint, half_vector)?;
        let [.., cosine] = half_vector.direction();
        Ok(density * cosine)
    }
}
