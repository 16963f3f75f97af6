//! Half vectors where distributions end and where they peak.

use super::numbers::Numbers;
use crate::measure::subject::{Patch, Reference};
use glintbake_format::model::HalfVector;

/// Pole, rim, just inside it, and outside the disk.
const LANDMARKS: [[f64; 2]; 5] = [
    [0.0, 0.0],
    [1.0, 0.0],
    [-0.6, 0.8],
    [0.0, -0.999_999_999],
    [0.9, 0.9],
];

/// Half vectors drawn from the model.
const DRAWN: usize = 3;

/// The half vectors to ask for under `patch`: landmarks, some that `model` draws, a normal of the patch, and one up to
/// four `widths` from it.
pub fn extreme(
    patch: &Patch<'_>,
    model: &dyn Reference,
    width: f64,
    numbers: &mut Numbers,
) -> Vec<HalfVector> {
    let mut half_vectors: Vec<_> = LANDMARKS.map(|[s, t]| HalfVector { s, t }).into();
    half_vectors.extend((0..DRAWN).filter_map(|_| model.draw(patch, numbers.four())));
    let [s, t] = patch.normal_by_weight(numbers.uniform());
    let mut moved = |x: f64| x + 4.0 * width * numbers.between(-1.0, 1.0);
    half_vectors.push(HalfVector { s, t });
    half_vectors.push(HalfVector {
        s: moved(s),
        t: moved(t),
    });
    half_vectors
}
