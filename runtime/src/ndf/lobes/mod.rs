//! `lobes`: Gaussians of position and normal, one or four for each texel.
//!
//! Paper: \[YHMR16\] Yan, Hašan, Marschner, Ramamoorthi, "Position-Normal Distributions for Efficient Rendering of Specular
//! Microstructure", 2016, as \[TZX22\] eq. 2-6 and \[XTXW24\] §3.2 restate it. Each lobe stands for a piece of the surface about a
//! lattice point, with a Gaussian of positions and, about the plane that normals lie on there, one of normals; under a Gaussian
//! footprint its share of the P-NDF is in closed form (`frame`). Lobes take their roughness from the query: one bake serves all.
//!
//! ```text
//! footprint ──placed──► copies ──box_pyramid──► cells and blocks within reach ──gather, term──► D
//! ```
//!
//! A block of 4 × 4 lobes is summed at once. A cell whose normals are alike beside the kernel, and which is small beside the
//! footprint, counts as one lobe, of its moments: so large footprints over smooth ground cost no more than small ones.

mod border;
mod frame;
mod gather;
mod lattice;
pub(super) mod placed;
pub(super) mod term;

use super::bin_weights::check_finite;
use super::{Facet, Ndf};
use crate::error::QueryError;
use crate::microfacet::Masking;
use crate::simd::Instructions;
use core::f64::consts::{PI, TAU};
use frame::Frame;
use gather::{Gather, REACH, Sink, Total};
use glintbake_format::model::{
    Filter, Footprint, HalfVector, LobeLattice, Wrap, intrinsic_from_beckmann,
};
use glintbake_format::records::Instance;
use glintbake_format::{Container, Fault, Finding, view};
use lattice::Line;
use placed::{Placed, lattice_sum};
use term::Term;

/// What is drawn farther out is no sample: as far as sums reach, less rounding.
const SAMPLED: f64 = 0.999 * 0.5 * REACH * REACH;

/// The P-NDF of a `lobes` instance.
#[derive(Clone, Copy, Debug)]
pub struct Lobes<'a> {
    instance: Instance,
    lobes: view::Lobes<'a>,
    masking: Masking<'a>,
    roughness: f64,
    filter: Filter,
    is_raw: bool,
    instructions: Instructions,
}

impl<'a> Lobes<'a> {
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
            lobes: view::Lobes::of_map(container, instance)?,
            masking: Masking::of_map(container, instance)?,
            roughness,
            filter: instance.filter,
            is_raw: false,
            instructions: Instructions::default(),
        })
    }

    /// The same P-NDF for Beckmann roughness `roughness`, 1e-6 to 10; that of the instance unless this says otherwise.
    ///
    /// Blocks are rounded for the least roughness the package was baked with; far below it, rounding shows.
    ///
    /// # Errors
    /// [`QueryError::RoughnessRange`].
    pub fn with_roughness(mut self, roughness: f64) -> Result<Self, QueryError> {
        self.roughness = super::within(Self::ROUGHNESS, roughness)?;
        self.instance.roughness = Some(roughness);
        Ok(self)
    }

    /// The papers' plain sum of lobes, if `is_raw`; else, unless this says otherwise, that sum over the sum of the lobes' weights.
    ///
    /// Lobes of the papers' width do not add up to 1: under the least footprints the plain sum ranges from 0.89 to 1.12 of what it
    /// should be, within 1e-3 only from a deviation of half a spacing on. Samples and their pdf are those of the quotient.
    #[must_use]
    pub fn with_raw_sum(mut self, is_raw: bool) -> Self {
        self.is_raw = is_raw;
        self
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

    /// What the lobes are.
    pub const fn lattice(&self) -> LobeLattice {
        self.lobes.lattice
    }

    /// Whether sums are the papers' plain ones.
    pub const fn is_raw_sum(&self) -> bool {
        self.is_raw
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
        Placed::new(footprint, [width, height], wrap, self.lobes.lattice)
    }

    /// Hands `sink` every lobe within reach.
    fn gather<S: Sink>(
        &self,
        placed: &Placed,
        half_vector: HalfVector,
        sink: S,
    ) -> Result<S, QueryError> {
        let mut sink = self.instructions.run(Gather {
            lobes: &self.lobes,
            placed,
            normal: [half_vector.s, half_vector.t],
            sigma: self.sigma(),
            sink,
        })?;
        if self.instance.wrap == Wrap::Clamp {
            let frame = Frame::of_lobes(placed);
            let sigma = self.sigma();
            border::beyond(&self.lobes, placed, &frame, &mut |mean, weight| {
                let [s, t] = [
                    (half_vector.s - mean[0]) / sigma,
                    (half_vector.t - mean[1]) / sigma,
                ];
                let squared = s * s + t * t;
                if squared > REACH * REACH {
                    return;
                }
                if S::EACH {
                    let variance = sigma * sigma;
                    let term = Term {
                        mean,
                        residual: [variance, 0.0, variance],
                        fan: [[0.0; 2]; 2],
                        position_squared: 0.0,
                    };
                    sink.term(&term, weight);
                } else {
                    sink.add(weight * libm::exp(-0.5 * squared));
                }
            })?;
        }
        Ok(sink)
    }

    /// One over the sum of all weights.
    fn per_weight(placed: &Placed) -> f64 {
        let frame = Frame::of_lobes(placed);
        let offset = placed.centre.map(|x| x - 0.5);
        1.0 / lattice_sum(offset, frame.total, placed.even)
    }

    /// The density, by the sum over the sum of weights if `is_raw` is not.
    fn density(
        &self,
        footprint: &Footprint,
        half_vector: HalfVector,
        is_raw: bool,
    ) -> Result<f64, QueryError> {
        check_finite(half_vector)?;
        let placed = self.placed(footprint)?;
        if !half_vector.is_on_disk() {
            return Ok(0.0);
        }
        let Total(sum) = self.gather(&placed, half_vector, Total(0.0))?;
        let sigma = self.sigma();
        let factor = if is_raw {
            1.0
        } else {
            Self::per_weight(&placed)
        };
        Ok(sum * factor / (TAU * sigma * sigma))
    }

    /// The lobe that two numbers in [0, 1) draw by its weight, as the column and row of the lattice without end.
    ///
    /// Rows first: a row weighs what a Gaussian of variance `S_yy` does there times the sum of the row's own Gaussian over its lattice,
    /// which is 1 but for rows that a thin footprint crosses. Those are kept with that probability over its greatest value; what is
    /// left of the random number decides, and then draws anew.
    fn lobe_under(placed: &Placed, [first, second]: [f64; 2]) -> [f64; 2] {
        /// Above the sum of any row: 1 + 2 exp(-2π² σh²) and a little.
        const MOST: f64 = 1.06;
        let frame = Frame::of_lobes(placed);
        let [xx, yy, xy] = frame.total;
        let [x, y] = placed.centre;
        let [width, height] = placed.size;
        let line = |mean, variance| Line { mean, variance };
        match placed.even {
            [true, true] => [libm::floor(first * width), libm::floor(second * height)],
            [true, false] => [libm::floor(first * width), line(y, yy).draw(second).0],
            [false, true] => [line(x, xx).draw(first).0, libm::floor(second * height)],
            [false, false] => {
                let root = 1.0 / (2.0 * PI * frame.amplitude);
                let given = |row: f64| line(x + xy / yy * (row + 0.5 - y), root * root / yy);
                let (mut row, mut rest) = line(y, yy).draw(first);
                for _ in 0..4 {
                    let kept = given(row).total() / MOST;
                    if rest < kept {
                        break;
                    }
                    (row, rest) = line(y, yy).draw((rest - kept) / (1.0 - kept));
                }
                [given(row).draw(second).0, row]
            }
        }
    }
}

/// Hands each lobe on as a facet.
struct Visit<'v> {
    visit: &'v mut dyn FnMut(Facet),
    point: [f64; 2],
    per_weight: f64,
}

impl Sink for Visit<'_> {
    const EACH: bool = true;

    fn add(&mut self, _: f64) {}

    fn term(&mut self, term: &Term, weight: f64) {
        let (exponent, factor) = term.exponent(self.point);
        // Positions are in the weight.
        let density = factor / TAU * libm::exp(0.5 * term.position_squared - exponent);
        let weight = weight * self.per_weight;
        // Lobes of damaged packages may be no numbers, and then are none.
        if density > 0.0 && density < f64::INFINITY && weight > 0.0 {
            (self.visit)(Facet {
                normal: term.normal().direction(),
                density,
                weight,
            });
        }
    }
}

impl Ndf for Lobes<'_> {
    fn instance(&self) -> &Instance {
        &self.instance
    }

    fn masking(&self) -> Masking<'_> {
        self.masking
    }

    /// Visits a facet for each lobe, or cell that counts as one, with its mean normal under the footprint.
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
        let sink = Visit {
            visit,
            point: [half_vector.s, half_vector.t],
            per_weight: if self.is_raw {
                1.0
            } else {
                Self::per_weight(&placed)
            },
        };
        self.gather(&placed, half_vector, sink)?;
        Ok(())
    }

    fn eval(&self, footprint: &Footprint, half_vector: HalfVector) -> Result<f64, QueryError> {
        self.density(footprint, half_vector, self.is_raw)
    }

    fn sample(
        &self,
        footprint: &Footprint,
        uniform: [f64; 4],
    ) -> Result<Option<HalfVector>, QueryError> {
        let placed = self.placed(footprint)?;
        let [first, second, third, fourth] = uniform;
        let place = Self::lobe_under(&placed, [first, second]);
        let frame = Frame::of_lobes(&placed);
        let [width, height] = placed.size;
        let is_beyond = |x: f64, side: f64| x < 0.0 || x >= side;
        let clamped = self.instance.wrap == Wrap::Clamp
            && (is_beyond(place[0], width) || is_beyond(place[1], height));
        let fold = |x: f64, side: f64| match self.instance.wrap {
            Wrap::Repeat => x - side * libm::floor(x / side),
            Wrap::Clamp => x.clamp(0.0, side - 1.0),
        };
        let stored = [fold(place[0], width), fold(place[1], height)];
        let mut lobe = border::lobe_at(&self.lobes, stored.map(|x| x as u32))?;
        let mut offset = [
            placed.centre[0] - place[0] - 0.5,
            placed.centre[1] - place[1] - 0.5,
        ];
        if clamped {
            (lobe.slope, offset) = ([0.0; 4], [0.0; 2]);
        }
        let variance = self.sigma() * self.sigma();
        let term = Term::new(&frame, offset, &lobe, [variance, 0.0, variance]);
        let (drawn, squared) = term.draw([third, fourth]);
        let is_reached = 0.5 * (term.position_squared + squared) <= SAMPLED;
        Ok((drawn.is_on_disk() && is_reached).then_some(drawn))
    }

    /// `D (h·n)` with the surface's normal n, D by the sum over the sum of weights, which is what samples are drawn by.
    fn pdf(&self, footprint: &Footprint, half_vector: HalfVector) -> Result<f64, QueryError> {
        let density = self.density(footprint, half_vector, false)?;
        let [.., cosine] = half_vector.direction();
        Ok(density * cosine)
    }
}
