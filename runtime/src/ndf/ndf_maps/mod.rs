//! `ndf-maps`: images of the NDFs of the tiles of a tiny example, whose copies make up the surface.
//!
//! Paper: \[XTXW24\] Xing, Tan, Xu, Wang, "A Tiny Example Based Procedural Model for Real-Time Glinty Appearance Rendering", 2024. A
//! footprint is cut into the copies under it, these into tiles, and what is left below the finest tiles into lobes; each copy turns
//! the query's normal back into that of the example. Copies whose image is dark at that normal, and most are, cost one look.
//!
//! ```text
//! footprint ──scattered──► copies ──turn──► normal of the example ──image──► dark? done
//!                                                                   └─walk──► tiles ──lobes──► Σ ──► D
//! ```

mod frame;
mod hidden;
mod image;
mod lobes;
mod scattered;
mod turn;
mod walk;

use super::bin_weights::check_finite;
use super::{Facet, Ndf};
use crate::error::QueryError;
use crate::microfacet::Masking;
use core::f64::consts::TAU;
use frame::{Frame, Local};
use glintbake_format::model::{
    Filter, Footprint, HalfVector, NdfMapLayout, intrinsic_from_beckmann,
};
use glintbake_format::records::Instance;
use glintbake_format::view::{self, Copied};
use glintbake_format::{Container, Fault, Finding};
use hidden::{Hidden, Shadows};
use image::Probe;
use lobes::Lobes;
use scattered::{Candidate, Cells};
use walk::Walk;

/// The most tiles of an example, of 32 texels a side.
const MAX_TILES: usize = 1365;

/// Copies from which on the image of the surface stands for them all.
const MANY_COPIES: f64 = 4096.0;

/// Tiled copies from which on their edges no longer matter.
const MANY_TILED: f64 = 4096.0;

/// The most copies that are not looked at twice.
const KEPT: usize = 160;

/// Texels across a footprint from which on the ripple of lobes' positions is less than 2e-3 of it.
const EVEN_TEXELS: f64 = 20.0;

/// The P-NDF of an `ndf-maps` instance.
#[derive(Clone, Copy, Debug)]
pub struct NdfMaps<'a> {
    instance: Instance,
    maps: view::NdfMaps<'a>,
    masking: Masking<'a>,
    sigma: f64,
    filter: Filter,
    tolerance: f64,
}

impl<'a> NdfMaps<'a> {
    /// The tolerance unless [`with_tolerance`](Self::with_tolerance) says otherwise: with it densities are within 2 % in relative L1,
    /// of footprints of any size.
    pub const DEFAULT_TOLERANCE: f64 = 0.012;

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
            maps: view::NdfMaps::open(container, instance)?,
            masking: Masking::of_map(container, instance)?,
            sigma: intrinsic_from_beckmann(roughness),
            filter: instance.filter,
            tolerance: Self::DEFAULT_TOLERANCE,
        })
    }

    /// The same P-NDF, tiles that a footprint covers in part divided until what one of them may err by is `tolerance` of the density,
    /// about; 0 divides them all, down to the lobes.
    ///
    /// # Errors
    /// [`QueryError::NotFinite`] of a number that is none, or negative.
    pub fn with_tolerance(mut self, tolerance: f64) -> Result<Self, QueryError> {
        // So that NaN is refused.
        let is_one = (0.0..=1e6).contains(&tolerance);
        if !is_one {
            return Err(QueryError::NotFinite);
        }
        self.tolerance = tolerance;
        Ok(self)
    }

    /// The same P-NDF under another filter; that of the instance unless this says otherwise. Queries refuse all but the box.
    #[must_use]
    pub fn with_filter(mut self, filter: Filter) -> Self {
        self.filter = filter;
        self
    }

    /// The filter asked for; queries refuse all but the box.
    pub const fn filter(&self) -> Filter {
        self.filter
    }

    /// The example, its images and its copies.
    pub const fn layout(&self) -> NdfMapLayout {
        self.maps.layout
    }

    /// The share of the surface that copies cover, 0 to 1.
    pub fn covered(&self) -> f64 {
        self.maps.root.covered.get()
    }

    fn frame(&self, footprint: &Footprint) -> Result<Frame, QueryError> {
        if self.filter != Filter::Box {
            return Err(QueryError::BoxesOnly(self.instance.method));
        }
        Frame::new(footprint, &self.maps.layout)
    }

    fn example(&self) -> f64 {
        f64::from(self.maps.layout.example())
    }

    /// The peak of the kernel, which values of pixels are in.
    fn peak(&self) -> f64 {
        1.0 / (TAU * self.sigma * self.sigma)
    }

    fn density(&self, footprint: &Footprint, half_vector: HalfVector) -> Result<f64, QueryError> {
        check_finite(half_vector)?;
        let frame = self.frame(footprint)?;
        let normal = [half_vector.s, half_vector.t];
        if !half_vector.is_on_disk() {
            return Ok(0.0);
        }
        let value = if self.maps.layout.is_scattered {
            self.scattered(&frame, normal)
        } else {
            self.tiled(&frame, normal)
        };
        let density = value * self.peak();
        // Numbers of damaged packages may be none.
        let is_number = density > 0.0 && density < f64::INFINITY;
        Ok(if is_number { density } else { 0.0 })
    }

    fn lobes_at(&self, normal: [f64; 2]) -> Lobes<'_> {
        Lobes {
            maps: &self.maps,
            wrap: self.instance.wrap,
            sigma: self.sigma,
            normal,
            farthest: if self.tolerance > 0.0 {
                lobes::FAR
            } else {
                lobes::FARTHEST
            },
        }
    }

    fn probe(&self, normal: [f64; 2]) -> Probe {
        let pitch = self.maps.root.pitch.get();
        Probe::new(normal, pitch, self.maps.layout.pixels)
    }

    /// The value of the whole example at `probe`.
    fn top(&self, probe: &Probe) -> f64 {
        let layout = &self.maps.layout;
        let place = layout.tiles_before(layout.levels().wrapping_sub(1));
        let image = self.maps.images.get(place);
        f64::from(image.map_or(0.0, |image| probe.value(image, self.maps.pixels)))
    }

    /// The value at `normal` of copies that lie close to each other.
    ///
    /// All show the same normal of the example. Were the footprint's edge everywhere between copies, the value would be the example's;
    /// each copy that the edge crosses differs from that by what it shows less its share of it.
    fn tiled(&self, frame: &Frame, normal: [f64; 2]) -> f64 {
        let Some(copied) = self.maps.copied(0) else {
            return 0.0;
        };
        let layout = &self.maps.layout;
        let (own, area) = turn::pulled_back(copied.matrix, layout.scales_slopes, normal);
        let example = self.example();
        let local = frame.of_copy(&copied, [0.0; 2], example);
        let mut known = [f32::NAN; MAX_TILES];
        let mut walk = Walk {
            maps: &self.maps,
            local,
            probe: self.probe(own),
            lobes: self.lobes_at(own),
            hidden: &Hidden::NONE,
            known: known.get_mut(..layout.images()).unwrap_or_default(),
            threshold: 0.0,
            unit: 1.0 / self.peak(),
        };
        let top = layout.levels().wrapping_sub(1);
        let value = walk.value(top, 0, 0);
        if value <= 0.0 {
            return 0.0;
        }
        let cells = local.axes.map(|axis| {
            let [low, high] = axis.range();
            libm::floor(low / example)..=libm::floor(high / example)
        });
        let [across, down] = cells.clone().map(|range| range.end() - range.start() + 1.0);
        let whole = walk.share_of(top);
        walk.threshold = self.tolerance * value;
        // So that the cells of a damaged package, which may be no number, are not counted through.
        let is_few = across * down <= MANY_TILED;
        if !is_few || 0.5 * whole <= self.tolerance {
            return area * value;
        }
        let mut rest = 1.0;
        let mut sum = 0.0;
        let [columns, rows] = cells;
        let mut row = *rows.start();
        while row <= *rows.end() {
            let mut column = *columns.start();
            while column <= *columns.end() {
                let offset = [column * example, row * example];
                column += 1.0;
                if local.relation(offset, example).is_some() {
                    continue;
                }
                walk.local = local.moved(offset);
                let region = walk.local.region([0.0; 2], example);
                let share = region.area();
                if share > 0.0 {
                    rest -= share;
                    sum += walk.tile(top, [0, 0], value, &region, Shadows::NONE);
                }
            }
            row += 1.0;
        }
        let total = if is_even(&local) {
            1.0
        } else {
            lobes::ripple(&local, &frame::Region::UNIT_SQUARE)
        };
        area * (sum + rest.max(0.0) * value) / total
    }

    /// The value at `normal` of copies that have places of their own.
    fn scattered(&self, frame: &Frame, normal: [f64; 2]) -> f64 {
        let cells = Cells::new(&self.maps, frame);
        if cells.count(&self.maps) > MANY_COPIES {
            return self.surface(normal);
        }
        let area = frame.area();
        let mut kept = [Bright::DARK; KEPT];
        let mut count = 0_usize;
        let mut rough = 0.0;
        cells.each(&self.maps, |candidate| {
            if let Some(bright) = self.bright(candidate, normal) {
                rough += bright.value * self.share(candidate, area).min(1.0);
                if let Some(slot) = kept.get_mut(count) {
                    *slot = bright;
                }
                count = count.wrapping_add(1);
            }
        });
        let ground = self.ground(normal);
        let threshold = self.tolerance * (rough + ground * (1.0 - self.covered()));
        let mut sum = 0.0;
        if count <= KEPT {
            for bright in kept.iter().take(count) {
                if let Some(candidate) = bright.candidate(&self.maps) {
                    sum += self.seen(frame, &candidate, bright.value, normal, threshold);
                }
            }
        } else {
            cells.each(&self.maps, |candidate| {
                if let Some(bright) = self.bright(candidate, normal) {
                    sum += self.seen(frame, candidate, bright.value, normal, threshold);
                }
            });
        }
        // The finest texels that copies have are those of the surface, or about.
        let is_even = is_even(&Local { axes: frame.axes() });
        if is_even && ground <= 0.0 {
            return sum;
        }
        let (covered, mass) = self.covered_under(frame, &cells, !is_even, threshold / ground);
        let bare = (1.0 - covered).max(0.0);
        let total = if is_even { 1.0 } else { bare + mass };
        (sum + bare * ground) / total
    }

    /// The value at `normal` of the whole surface.
    fn surface(&self, normal: [f64; 2]) -> f64 {
        let image = self.maps.images.last();
        let probe = self.probe(normal);
        f64::from(image.map_or(0.0, |image| probe.value(image, self.maps.pixels)))
    }

    /// The value of the ground at `normal`.
    fn ground(&self, normal: [f64; 2]) -> f64 {
        if self.maps.root.covered.get() >= 1.0 {
            return 0.0;
        }
        let [s, t] = self.maps.root.ground.map(|x| x.get());
        let deviation = self.maps.root.ground_deviation.get();
        let (s, t) = ((normal[0] - s) / deviation, (normal[1] - t) / deviation);
        let squared = s * s + t * t;
        if squared > 40.0 {
            return 0.0;
        }
        let ratio = self.sigma / deviation;
        libm::exp(-0.5 * squared) * ratio * ratio
    }

    /// The share of the footprint of `area` texels that a copy is, as far as it is seen.
    fn share(&self, candidate: &Candidate, area: f64) -> f64 {
        let [[xx, xy], [yx, yy]] = candidate.copied.matrix;
        let example = self.example();
        (xx * yy - xy * yx).abs() * example * example / area * self.visible(candidate.number)
    }

    /// The share of copy `number` that is seen.
    fn visible(&self, number: usize) -> f64 {
        let copy = self.maps.copies.get(number);
        copy.map_or(0.0, |copy| f64::from(copy.visible.get()) / 65535.0)
    }

    /// `candidate` at `normal`, if it is not dark there.
    #[inline]
    fn bright(&self, candidate: &Candidate, normal: [f64; 2]) -> Option<Bright> {
        let matrix = candidate.copied.matrix;
        let (own, area) = turn::pulled_back(matrix, self.maps.layout.scales_slopes, normal);
        let value = area * self.top(&self.probe(own));
        (value > 0.0).then_some(Bright {
            number: candidate.number as u32,
            surface: candidate.surface.map(|along| along as i32),
            value,
        })
    }

    /// What the footprint sees of a copy that shows `value` at `normal`, in shares of the footprint times the unit of values.
    fn seen(
        &self,
        frame: &Frame,
        candidate: &Candidate,
        value: f64,
        normal: [f64; 2],
        threshold: f64,
    ) -> f64 {
        let example = self.example();
        let local = frame.of_copy(&candidate.copied, candidate.shift, example);
        let whole = example * example * local.texel();
        let visible = self.visible(candidate.number);
        let relation = local.relation([0.0; 2], example);
        if relation == Some(false) {
            return 0.0;
        }
        if relation == Some(true) && Walk::chance(value, whole * visible, whole) <= threshold {
            return value * whole * visible;
        }
        let region = local.region([0.0; 2], example);
        let area = region.area();
        if area <= 0.0 {
            return 0.0;
        }
        if Walk::chance(value, area * visible, whole) <= threshold {
            return value * area * visible;
        }
        self.walked(frame, candidate, &local, &region, normal, threshold)
    }

    /// The same, tile by tile, of the part `region` of the footprint that lies over the copy.
    #[inline(never)]
    fn walked(
        &self,
        frame: &Frame,
        candidate: &Candidate,
        local: &Local,
        region: &frame::Region,
        normal: [f64; 2],
        threshold: f64,
    ) -> f64 {
        let layout = &self.maps.layout;
        let matrix = candidate.copied.matrix;
        let (own, area) = turn::pulled_back(matrix, layout.scales_slopes, normal);
        let hidden = Hidden::of(&self.maps, frame, candidate);
        let mut walk = Walk {
            maps: &self.maps,
            local: *local,
            probe: self.probe(own),
            lobes: self.lobes_at(own),
            hidden: &hidden,
            known: &mut [],
            threshold: threshold / area,
            unit: 1.0 / self.peak(),
        };
        let top = layout.levels().wrapping_sub(1);
        let value = walk.value(top, 0, 0);
        area * walk.tile(top, [0, 0], value, region, hidden.all())
    }

    /// The share of the footprint that copies cover, but for errors of `threshold` a copy, and, if `with_ripple`, the integral of their
    /// lobes' positions.
    fn covered_under(
        &self,
        frame: &Frame,
        cells: &Cells,
        with_ripple: bool,
        threshold: f64,
    ) -> (f64, f64) {
        let example = self.example();
        let (mut covered, mut mass) = (0.0, 0.0);
        cells.each(&self.maps, |candidate| {
            let local = frame.of_copy(&candidate.copied, candidate.shift, example);
            let relation = local.relation([0.0; 2], example);
            if relation == Some(false) {
                return;
            }
            let whole = example * example * local.texel();
            let visible = self.visible(candidate.number);
            if relation == Some(true) && !with_ripple {
                covered += whole * visible;
                return;
            }
            let region = local.region([0.0; 2], example);
            if region.is_empty() {
                return;
            }
            let area = region.area();
            if !with_ripple && Walk::chance(1.0, area * visible, whole) <= threshold {
                covered += area * visible;
                return;
            }
            let hidden = Hidden::of(&self.maps, frame, candidate);
            let (shadows, seen) = hidden.left(&region, hidden.all());
            covered += seen;
            if with_ripple && seen > 0.0 {
                let pieces = hidden.pieces(&region, shadows);
                let pieces = pieces.regions().iter();
                mass += pieces
                    .map(|piece| lobes::ripple(&local, piece))
                    .sum::<f64>();
            }
        });
        (covered, mass)
    }

    /// The copy that is seen at `point` of the surface, and where it lies.
    fn owner(&self, point: [f64; 2]) -> Option<Candidate> {
        let frame = Frame {
            centre: point,
            edges: [[0.0; 2]; 2],
        };
        let example = self.example();
        let mut nearest = f64::INFINITY;
        let mut owner = None;
        Cells::new(&self.maps, &frame).each(&self.maps, |candidate| {
            let local = frame.of_copy(&candidate.copied, candidate.shift, example);
            let is_within = |at: f64| (0.0..=example).contains(&at);
            let [x, y] = local.axes;
            if !(is_within(x.constant) && is_within(y.constant)) {
                return;
            }
            let Candidate { copied, shift, .. } = candidate;
            let dx = point[0] - copied.centre[0] - shift[0];
            let dy = point[1] - copied.centre[1] - shift[1];
            let squared = dx * dx + dy * dy;
            if squared < nearest {
                nearest = squared;
                owner = Some(*candidate);
            }
        });
        owner
    }

    /// A normal of the copy `copied` where its example is at `place`, by a number that draws the lobe and two that draw from it.
    fn draw(
        &self,
        copied: &Copied,
        place: [f64; 2],
        uniform: f64,
        [third, fourth]: [f64; 2],
    ) -> Option<[f64; 2]> {
        let deviation = glintbake_format::model::LobeLattice::DEVIATION;
        let [column, row] = place.map(|at| libm::floor(at) as i64);
        let fall = |at: f64, texel: i64| {
            let distance = (at - texel as f64 - 0.5) / deviation;
            libm::exp(-0.5 * distance * distance)
        };
        let offsets = [-2, -1, 0, 1, 2];
        let across = offsets.map(|offset| fall(place[0], column + offset));
        let down = offsets.map(|offset| fall(place[1], row + offset));
        let total: f64 = across.iter().sum::<f64>() * down.iter().sum::<f64>();
        let mut left = uniform * total * (1.0 - 1e-12);
        for (y, down) in offsets.into_iter().zip(down) {
            for (x, across) in offsets.into_iter().zip(across) {
                left -= across * down;
                if left >= 0.0 {
                    continue;
                }
                let (x, y) = (column.wrapping_add(x), row.wrapping_add(y));
                let lobe = lobes::lobe(&self.maps, self.instance.wrap, x, y)?;
                let (dx, dy) = (place[0] - x as f64 - 0.5, place[1] - y as f64 - 0.5);
                let own = [
                    lobe.normal[0] + lobe.across[0] * dx + lobe.down[0] * dy,
                    lobe.normal[1] + lobe.across[1] * dx + lobe.down[1] * dy,
                ];
                let own = normal_draw(own, self.sigma, [third, fourth]);
                let scales = self.maps.layout.scales_slopes;
                let is_on_disk = own[0] * own[0] + own[1] * own[1] < 1.0;
                return is_on_disk.then(|| turn::pushed_forward(copied.matrix, scales, own));
            }
        }
        None
    }
}

/// A copy that is not dark at the query's normal.
#[derive(Clone, Copy, Debug)]
struct Bright {
    number: u32,
    /// In which repetition of the surface it lies.
    surface: [i32; 2],
    value: f64,
}

impl Bright {
    const DARK: Self = Self {
        number: 0,
        surface: [0; 2],
        value: 0.0,
    };

    /// The copy itself.
    fn candidate(&self, maps: &view::NdfMaps<'_>) -> Option<Candidate> {
        let number = self.number as usize;
        let surface = self.surface.map(i64::from);
        Candidate::new(maps, number, surface)
    }
}

/// Whether the ripple of lobes' positions hardly matters under the footprint.
fn is_even(local: &Local) -> bool {
    let [x, y] = local.axes;
    let square = |edge: usize| {
        let read = |slope: [f64; 2]| slope.get(edge).copied().unwrap_or_default();
        let (x, y) = (read(x.slope), read(y.slope));
        x * x + y * y
    };
    let longest = square(0).max(square(1));
    // The width across the longer edge.
    let determinant = 1.0 / local.texel();
    longest > 0.0 && determinant * determinant >= EVEN_TEXELS * EVEN_TEXELS * longest
}

/// A point about `mean` by a Gaussian of `deviation` (Box and Muller 1958).
fn normal_draw(mean: [f64; 2], deviation: f64, [first, second]: [f64; 2]) -> [f64; 2] {
    let radius = deviation * libm::sqrt(-2.0 * libm::log1p(-first));
    let (sine, cosine) = libm::sincos(TAU * second);
    [mean[0] + radius * cosine, mean[1] + radius * sine]
}

/// Numbers in [0, 1) from those of a sample, for draws that are thrown away: `SplitMix` (Steele, Lea and Flood 2014) of their bits.
struct Numbers(u64);

impl Numbers {
    fn new(uniform: [f64; 4]) -> Self {
        let mix = |state: u64, number: f64| {
            state.rotate_left(17).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ number.to_bits()
        };
        Self(uniform.into_iter().fold(0, mix))
    }

    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

impl Ndf for NdfMaps<'_> {
    fn instance(&self) -> &Instance {
        &self.instance
    }

    fn masking(&self) -> Masking<'_> {
        self.masking
    }

    /// Visits one facet: what mirrors at `half_vector` has normals within σr of it, and images keep no others apart.
    fn facets(
        &self,
        footprint: &Footprint,
        half_vector: HalfVector,
        visit: &mut dyn FnMut(Facet),
    ) -> Result<(), QueryError> {
        let density = self.density(footprint, half_vector)?;
        if density > 0.0 {
            visit(Facet {
                normal: half_vector.direction(),
                density,
                weight: 1.0,
            });
        }
        Ok(())
    }

    fn eval(&self, footprint: &Footprint, half_vector: HalfVector) -> Result<f64, QueryError> {
        self.density(footprint, half_vector)
    }

    /// The first two numbers draw a point of the footprint, the third the lobe there, and the last two, what is left of the third being
    /// drawn anew, a normal of it. Points are drawn as dense as lobes' positions are: one in nine is thrown away, and others take its
    /// place that follow from the same four numbers. Images of points, the paper's, are rougher than the lobes that are drawn from:
    /// there [`pdf`](Ndf::pdf) is only about the density of samples.
    fn sample(
        &self,
        footprint: &Footprint,
        uniform: [f64; 4],
    ) -> Result<Option<HalfVector>, QueryError> {
        if !uniform.iter().all(|x| x.is_finite()) {
            return Err(QueryError::NotFinite);
        }
        let frame = self.frame(footprint)?;
        let mut numbers = Numbers::new(uniform);
        let [mut first, mut second, third, fourth] = uniform;
        // Each round ends with a chance of 8 in 9: a hundred leave nothing.
        for _ in 0..100 {
            let [x, y] = frame.axes();
            let at = [first - 0.5, second - 0.5];
            let point = [x.at(at), y.at(at)];
            let owner = if self.maps.layout.is_scattered {
                let size = f64::from(self.maps.layout.size);
                self.owner(point.map(|along| along - size * libm::floor(along / size)))
                    .map(|candidate| (candidate, point))
            } else {
                self.maps.copied(0).map(|copied| {
                    let candidate = Candidate {
                        number: 0,
                        copied,
                        surface: [0; 2],
                        shift: [0.0; 2],
                    };
                    (candidate, point)
                })
            };
            let Some((candidate, point)) = owner else {
                if numbers.next() * lobes::GREATEST_RIPPLE < 1.0 {
                    let ground = self.maps.root.ground.map(|x| x.get());
                    let deviation = self.maps.root.ground_deviation.get();
                    let [s, t] = normal_draw(ground, deviation, [third, fourth]);
                    let drawn = HalfVector { s, t };
                    return Ok(drawn.is_on_disk().then_some(drawn));
                }
                (first, second) = (numbers.next(), numbers.next());
                continue;
            };
            let folded = if self.maps.layout.is_scattered {
                let size = f64::from(self.maps.layout.size);
                point.map(|along| along - size * libm::floor(along / size))
            } else {
                point
            };
            let here = Frame {
                centre: folded,
                edges: [[0.0; 2]; 2],
            };
            let [x, y] = here
                .of_copy(&candidate.copied, candidate.shift, self.example())
                .axes;
            let place = [x.constant, y.constant];
            if numbers.next() * lobes::GREATEST_RIPPLE >= lobes::ripple_at(place) {
                (first, second) = (numbers.next(), numbers.next());
                continue;
            }
            let lobe = numbers.next();
            let drawn = self.draw(&candidate.copied, place, lobe, [third, fourth]);
            return Ok(drawn
                .map(|[s, t]| HalfVector { s, t })
                .filter(|drawn| drawn.is_on_disk()));
        }
        Ok(None)
    }

    /// `D (h·n)` with the surface's normal n, which is what samples are drawn by.
    fn pdf(&self, footprint: &Footprint, half_vector: HalfVector) -> Result<f64, QueryError> {
        let density = self.density(footprint, half_vector)?;
        let [.., cosine] = half_vector.direction();
        Ok(density * cosine)
    }
}
