//! The global NDF, for bounces after the first, \[YHJ*14\] §6.

use glintbake_format::model::HalfVector;
use glintbake_format::view;

/// What the whole map looks like from far: a density to evaluate and to draw from in no time.
///
/// A mixture of tents about the pixels of an image, so that its density is the image interpolated bilinearly, and drawing is a
/// pixel by its share and a place in its tent: both agree exactly. It is of the whole map, evenly weighed, under the roughness that
/// the instance was baked with, and a pitch wide at least, a 127th of the range of normals.
#[derive(Clone, Copy, Debug)]
pub struct GlobalNdf<'a> {
    view: view::GlobalNdf<'a>,
}

impl<'a> GlobalNdf<'a> {
    pub(super) const fn new(view: view::GlobalNdf<'a>) -> Self {
        Self { view }
    }

    /// The density at `half_vector`, per area of the disk, ≥ 0; 0 outside the disk. O(1).
    pub fn eval(&self, half_vector: HalfVector) -> f64 {
        if !half_vector.is_on_disk() {
            return 0.0;
        }
        let ([low_s, low_t], [pitch_s, pitch_t]) = (self.view.low, self.view.pitch);
        let (x, y) = (
            (half_vector.s - low_s) / pitch_s,
            (half_vector.t - low_t) / pitch_t,
        );
        let (column, row) = (libm::floor(x), libm::floor(y));
        let (right, down) = (x - column, y - row);
        let (column, row) = (column as i64, row as i64);
        let share = |i: i64, j: i64| {
            self.view
                .share(column.saturating_add(i), row.saturating_add(j))
        };
        let above = (1.0 - right) * share(0, 0) + right * share(1, 0);
        let below = (1.0 - right) * share(0, 1) + right * share(1, 1);
        ((1.0 - down) * above + down * below) / (pitch_s * pitch_t)
    }

    /// A half vector drawn with density [`pdf`](Self::pdf) from four numbers in [0, 1); `None` with the probability that
    /// the density leaves outside the disk. O(log pixels).
    pub fn sample(&self, uniform: [f64; 4]) -> Option<HalfVector> {
        let [first, _, third, fourth] = uniform;
        let wanted = first * f64::from(u32::MAX);
        let place = self
            .view
            .sums
            .partition_point(|sum| f64::from(sum.get()) <= wanted);
        let side = self.view.side as usize;
        let column = place.checked_rem(side)? as f64;
        let row = place.checked_div(side)? as f64;
        let ([low_s, low_t], [pitch_s, pitch_t]) = (self.view.low, self.view.pitch);
        let drawn = HalfVector {
            s: low_s + pitch_s * (column + tent(third)),
            t: low_t + pitch_t * (row + tent(fourth)),
        };
        drawn.is_on_disk().then_some(drawn)
    }

    /// The density per solid angle with which [`sample`](Self::sample) draws `half_vector`: `D (h·n)`.
    pub fn pdf(&self, half_vector: HalfVector) -> f64 {
        let [.., cosine] = half_vector.direction();
        self.eval(half_vector) * cosine
    }
}

/// The place that `uniform`, in [0, 1), draws from a tent between -1 and 1.
fn tent(uniform: f64) -> f64 {
    if uniform < 0.5 {
        libm::sqrt(2.0 * uniform) - 1.0
    } else {
        1.0 - libm::sqrt(2.0 - 2.0 * uniform)
    }
}
