//! Weights from lists of positions: every texel of the window's lists that meets the ellipse, with its exact weight.

use super::Target;
use super::forms::{Form, Forms};
use super::texels::for_each_copy;
use crate::error::QueryError;
use crate::ndf::bin_weights::forest::Lists;
use crate::ndf::bin_weights::map_shape;
use crate::overlap::GaussianFootprint;
use crate::simd::Work;
use glintbake_format::records::TexelPosition;
use glintbake_format::view::InverseBinMap;

/// Positions tested together.
const TOGETHER: usize = 16;

/// Adds the weights of all wanted texels under `footprint` to the sums.
pub(super) struct Walk<'s, 't> {
    pub target: &'s mut Target<'t>,
    pub footprint: &'s GaussianFootprint,
    pub inverse: &'s InverseBinMap<'s>,
    pub forms: &'s Forms,
}

impl Work for Walk<'_, '_> {
    type Output = Result<(), QueryError>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self {
            target,
            footprint,
            inverse,
            forms,
        } = self;
        let lists = Lists::new(target.tables, inverse, target.runs)?;
        for_each_copy(
            map_shape(target.tables),
            footprint,
            false,
            &mut |footprint| {
                for (place, positions) in lists.positions(inverse) {
                    let weight = weigh(footprint, &forms.block, forms.block_rule.end, positions);
                    target.sums.add(place, weight);
                }
                Ok(())
            },
        )
    }
}

/// The weight of the texels at `positions`, of which those beyond `end` have none.
#[inline(always)]
fn weigh(footprint: &GaussianFootprint, form: &Form, end: f32, positions: &[TexelPosition]) -> f64 {
    let [x, y] = footprint
        .centred(0.5, 0.5)
        .map(|coordinate| coordinate as f32);
    let mut sum = 0.0;
    for positions in positions.chunks(TOGETHER) {
        let mut near = [false; TOGETHER];
        let mut any = false;
        for (position, near) in positions.iter().zip(&mut near) {
            let column = f32::from(position.column.get());
            let row = f32::from(position.row.get());
            *near = form.distance_squared(column + x, row + y) <= end;
            any |= *near;
        }
        if any {
            for (position, near) in positions.iter().zip(near) {
                if near {
                    let (column, row) = (position.column.get(), position.row.get());
                    sum += footprint.texel_weight(i64::from(column), i64::from(row));
                }
            }
        }
    }
    sum
}
