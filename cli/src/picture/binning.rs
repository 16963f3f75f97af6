//! What a package answers beside what counting samples of its map gives, as in \[YHJ*14\] Fig. 9.

use super::ndf::{Densities, NdfPicture};
use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle::binning::{Binned, Window};
use glintbake_format::model::{Footprint, Interpolation};
use glintbake_runtime::{Ndf, QueryError};

/// Seed of the samples: the same picture every time.
const SEED: u64 = 7;

/// The surface that samples are drawn from, and how many.
#[derive(Clone, Debug)]
pub struct Reference {
    /// The map.
    pub map: NormalMap,
    /// How its normals continue between texels.
    pub interpolation: Interpolation,
    /// Beckmann's roughness α.
    pub roughness: f64,
    /// Samples to draw.
    pub samples: u64,
}

/// Two P-NDFs side by side.
#[derive(Clone, Debug)]
pub struct Pair {
    /// What the package answers left, the reference right; peak and integral are those of the answer.
    pub picture: NdfPicture,
    /// Columns of the picture; it has as many rows as one of the two.
    pub width: u32,
    /// What was counted.
    pub reference: Densities,
    /// Relative L1 distance of the answer from the reference, pixel by pixel; what the noise of the samples adds is in it.
    pub distance: f64,
}

/// Columns between two pictures of `side` columns.
fn gap(side: u32) -> u32 {
    side.div_ceil(64)
}

/// The P-NDF of `ndf` as [`draw`](super::ndf::draw) has it, and beside it `reference` of the same patch, both on the scale of the
/// first.
///
/// Samples are counted by pixel, so that they average over it as the 2 × 2 evaluations of the first do; their noise is
/// `1 / √count` of a pixel.
///
/// # Errors
/// As [`Ndf::facets`].
pub fn draw(
    ndf: &(impl Ndf + Sync),
    footprint: &Footprint,
    side: u32,
    zoom: f64,
    reference: &Reference,
) -> Result<Pair, QueryError> {
    let answer = Densities::of(ndf, footprint, side, zoom)?;
    let window = Window {
        centre: [0.0; 2],
        extent: 1.0 / zoom,
        side: side as usize,
    };
    let binned = Binned::new(
        &reference.map,
        footprint,
        reference.interpolation,
        reference.roughness,
        window,
        reference.samples,
        SEED,
    );
    let counted = answer.replaced(&binned.densities());
    let distance = answer.distance_from(&counted);
    let brightest = answer.brightest();
    let (pixels, width) = beside(
        &answer.colours(brightest),
        &counted.colours(brightest),
        side,
    );
    Ok(Pair {
        picture: NdfPicture {
            pixels,
            peak: answer.peak,
            integral: answer.integral,
        },
        width,
        reference: counted,
        distance,
    })
}

/// Two pictures of `side` columns beside each other with black between, and the columns of both.
fn beside(left: &[u8], right: &[u8], side: u32) -> (Vec<u8>, u32) {
    let row = 3 * side as usize;
    let between = vec![0; 3 * gap(side) as usize];
    let rows = left.chunks_exact(row).zip(right.chunks_exact(row));
    let pixels = rows
        .flat_map(|(left, right)| [left, &between, right].concat())
        .collect();
    (pixels, 2 * side + gap(side))
}

#[cfg(test)]
mod tests {
    use super::super::fixtures;
    use super::*;
    use glintbake_bake::MethodRecipe;
    use glintbake_format::model::{Filter, Kernel, Method};
    use glintbake_runtime::SurfaceNdf;

    const PATCH: Footprint = Footprint {
        centre: [0.5, 0.5],
        edge_1: [0.25, 0.0],
        edge_2: [0.0, 0.25],
    };

    /// Flakes by the cluster tree, whose sum over texels is what samples of uninterpolated flakes add up to.
    fn pair(roughness: f64, samples: u64) -> Pair {
        let map = fixtures::flake_map();
        let recipe = MethodRecipe::new(Method::ClusterTree, &[0.2]);
        let bytes = fixtures::package(&map, recipe);
        let SurfaceNdf::ClusterTree(tree) = fixtures::ndf(&bytes) else {
            panic!("another method was baked");
        };
        let ndf = tree.with_kernel(Kernel::Disk).expect("it has that kernel");
        let reference = Reference {
            map,
            interpolation: Interpolation::None,
            roughness,
            samples,
        };
        draw(
            &ndf.with_filter(Filter::Gaussian),
            &PATCH,
            24,
            1.0,
            &reference,
        )
        .expect("the footprint is in range")
    }

    #[test]
    fn samples_add_up_to_the_answer_and_to_no_other() {
        let [few, many] = [2_000, 2_000_000].map(|samples| pair(0.2, samples).distance);
        // Half the disk's 450 pixels hold most samples: a count of 8000 is off by 1 % on average.
        assert!(many < 0.01, "{many}");
        assert!(few > 5.0 * many, "{few} to {many}");
        let other = pair(0.1, 2_000_000).distance;
        assert!(other > 0.2, "{other}");
    }

    #[test]
    fn both_pictures_are_on_one_scale_with_black_between() {
        let pair = pair(0.2, 200_000);
        assert_eq!(pair.width, 49);
        let mut other = Vec::new();
        // Flakes that all samples miss leave the disk as dark as no sample does.
        let scale = |row: &[u8]| row.iter().map(|&byte| u64::from(byte)).sum::<u64>();
        for row in pair.picture.pixels.chunks_exact(3 * 49) {
            assert_eq!(row[72..75], [0; 3]);
            other.push([scale(&row[..72]), scale(&row[75..])]);
        }
        assert_eq!(other.len(), 24);
        let [left, right] = [0, 1].map(|half| other.iter().map(|row| row[half]).sum::<u64>());
        assert!(left.abs_diff(right) < left / 50, "{left} and {right}");
        let [answer, counted] = [pair.picture.integral, pair.reference.integral];
        assert!((answer - counted).abs() < 0.01, "{answer} and {counted}");
    }
}
