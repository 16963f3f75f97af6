//! Which layer of a material answers P-NDF queries.

use crate::exit::{CommandError, Failure};
use glintbake_format::view::MaterialLayers;
use glintbake_runtime::Package;

/// The layer whose instances answer: the one `asked` for, or the only one that has a map; `None` if the package holds no
/// material, and all instances may answer.
///
/// # Errors
/// [`Failure::Usage`] if several layers have maps and none is asked for, [`Failure::NotBaked`] if the one asked for has none, and
/// [`Failure::Package`] if the layers are damaged.
pub(super) fn choose(
    package: &Package<'_>,
    asked: Option<u16>,
) -> Result<Option<u16>, CommandError> {
    if MaterialLayers::open(package.container())?.is_none() {
        return match asked {
            None | Some(0) => Ok(None),
            Some(layer) => Err(CommandError::new(
                Failure::NotBaked,
                format!("--layer {layer}: the package holds no material; leave the option out"),
            )),
        };
    }
    let mut mapped: Vec<u16> = package.instances().map(|instance| instance.layer).collect();
    mapped.dedup();
    let words = || {
        let names: Vec<_> = package
            .instances()
            .map(|instance| format!("{} ({})", instance.layer, instance.method.name()))
            .collect();
        names.join(", ")
    };
    match (asked, &*mapped) {
        (Some(layer), _) if mapped.contains(&layer) => Ok(Some(layer)),
        (None, &[layer]) => Ok(Some(layer)),
        (_, []) => Err(CommandError::new(
            Failure::NotBaked,
            "no layer of the material has a map, and so no P-NDF",
        )),
        (Some(layer), _) => Err(CommandError::new(
            Failure::NotBaked,
            format!(
                "--layer {layer}: it has no map; layers that have are {}",
                words()
            ),
        )),
        (None, _) => Err(CommandError::new(
            Failure::Usage,
            format!(
                "--layer: the package holds a material of several maps, of layers {}; say which is to answer",
                words()
            ),
        )),
    }
}
