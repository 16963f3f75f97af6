//! The map that `picture ndf --reference` counts samples of.

use crate::args::ReferenceArgs;
use crate::exit::{CommandError, Failure};
use crate::picture::binning::{Pair, Reference};
use glintbake_bake::image::HashedFile;
use glintbake_bake::normals;
use glintbake_format::model::{Filter, Interpolation, Kernel};
use glintbake_format::records::Structure;
use glintbake_runtime::{Ndf, SurfaceNdf};
use serde_json::{Value, json};
use std::fmt;
use std::path::Path;

/// The map at `image`, to be sampled as `ndf` answers.
///
/// # Errors
/// [`Failure::Usage`] if `ndf` answers under another filter or kernel than samples do, or the map has another size or border;
/// whatever reading the image fails with.
pub(super) fn read(
    image: &Path,
    arguments: &ReferenceArgs,
    ndf: &SurfaceNdf<'_>,
) -> Result<Reference, CommandError> {
    let usage = |message: String| CommandError::new(Failure::Usage, message);
    if ndf.filter() != Filter::Gaussian {
        return Err(usage(
            "--reference: samples are drawn from a Gaussian; add --filter gaussian".to_owned(),
        ));
    }
    let instance = ndf.instance();
    let kernel = match ndf {
        SurfaceNdf::ClusterTree(tree) => tree.kernel(),
        _ => instance.kernel(),
    };
    let (Kernel::Disk, Some(roughness)) = (kernel, instance.roughness) else {
        let method = instance.method.name();
        return Err(usage(format!(
            "--reference: samples have the kernel disk, and {method} answers with {}; choose lobes, analytic, lean, or \
             cluster-tree with --kernel disk",
            kernel.name()
        )));
    };
    let recipe = arguments.decode.recipe();
    let file = HashedFile::open(image, &())?;
    let (map, _) = normals::read(&file, &recipe.read_options(), &recipe.decode, &())?;
    let (size, baked) = (
        [map.width(), map.height()],
        [instance.width, instance.height],
    );
    if size != baked {
        return Err(usage(format!(
            "--reference {}: it has {} x {} texels, and the package {} x {}; name the map it was baked from",
            image.display(),
            size[0],
            size[1],
            baked[0],
            baked[1]
        )));
    }
    if map.wrap() != instance.wrap {
        return Err(usage(format!(
            "--reference {}: the package continues beyond its border by {1}; add --wrap {1}",
            image.display(),
            instance.wrap.name()
        )));
    }
    let interpolation = arguments.interpolate.unwrap_or(match instance.structure {
        Structure::Surface { interpolation } => interpolation,
        Structure::Lobes(_) | Structure::MipLobes(_) | Structure::NdfMaps(_) => {
            Interpolation::Linear
        }
        Structure::Bins(_) | Structure::Pyramid { .. } | Structure::Clusters { .. } => {
            Interpolation::None
        }
    });
    Ok(Reference {
        map,
        interpolation,
        roughness,
        samples: arguments.samples.unwrap_or(ReferenceArgs::SAMPLES),
    })
}

/// What counting came to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Counted {
    interpolation: Interpolation,
    samples: u64,
    peak: f64,
    integral: f64,
    distance: f64,
}

impl Counted {
    pub(super) fn new(reference: &Reference, pair: &Pair) -> Self {
        Self {
            interpolation: reference.interpolation,
            samples: reference.samples,
            peak: pair.reference.peak,
            integral: pair.reference.integral,
            distance: pair.distance,
        }
    }

    pub(super) fn document(&self) -> Value {
        json!({
            "distance": self.distance,
            "integral": self.integral,
            "interpolation": self.interpolation.name(),
            "peak": self.peak,
            "samples": self.samples,
        })
    }
}

impl fmt::Display for Counted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "beside {} samples of the map, interpolation {}: D up to {:.4}; integral {:.4}; relative L1 distance {:.4}, \
             with their noise",
            self.samples,
            self.interpolation.name(),
            self.peak,
            self.integral,
            self.distance
        )
    }
}
