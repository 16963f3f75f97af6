//! `lean`: one Gaussian lobe from a pyramid of moments, \[OB10\].

use super::{Bake, BakeMethod, bins, masking, roughness};
use crate::build::pyramid::{self, Means};
use crate::error::BakeError;
use crate::normals::NormalMap;
use crate::progress::Stage;
use crate::recipe::{DEFAULT_LEAF_SIZE, MethodRecipe};
use glintbake_format::model::{Method, PyramidLayout};
use glintbake_format::records::{Instance, MEANS, SPREADS, Structure};

pub(super) struct Lean;

/// The least roughness for which means of 16 bits will do: they are off by 0.3 % of σr at most, which moves a lobe by 0.25 %
/// of its energy.
const NARROW_ROUGHNESS: f64 = 0.01;

impl BakeMethod for Lean {
    fn method(&self) -> Method {
        Method::Lean
    }

    fn check(&self, recipe: &MethodRecipe) -> Result<(), BakeError> {
        let refuse = |option, value: String, reason: &str| {
            Err(BakeError::Option {
                option,
                value,
                reason: format!("lean {reason}; leave the option out, or use flake-bins"),
            })
        };
        if let Some(bins) = recipe.bins {
            return refuse("--bins", bins.to_string(), "has no bins");
        }
        if let Some(kind) = recipe.inverse {
            let kind = kind.name().to_owned();
            return refuse(
                "--index",
                kind,
                "has no bins whose texels could be looked for",
            );
        }
        if recipe.leaf_size != DEFAULT_LEAF_SIZE {
            let size = recipe.leaf_size.to_string();
            return refuse("--leaf-size", size, "has no forest");
        }
        if let Some(kernel) = recipe.kernel {
            return refuse("--kernel", kernel.name().to_owned(), "has one kernel");
        }
        if recipe.exact_normals {
            let reason = "keeps moments in place of normals";
            return refuse("--exact-normals", String::new(), reason);
        }
        if recipe.raster_normals {
            let reason = "keeps moments in place of normals";
            return refuse("--raster-normals", String::new(), reason);
        }
        roughness::check(recipe)
    }

    fn bake(
        &self,
        map: &NormalMap,
        recipe: &MethodRecipe,
        bake: &mut Bake<'_>,
    ) -> Result<(), BakeError> {
        bins::check_sides(map)?;
        let (width, height) = (map.width(), map.height());
        let finest_level = recipe.finest_level.unwrap_or(0);
        let layout = PyramidLayout::new(width, height, finest_level).ok_or_else(|| {
            let top = PyramidLayout::top_of(width, height);
            BakeError::Option {
                option: "--finest-level",
                value: finest_level.to_string(),
                reason: format!("a map of {width} x {height} texels has levels 0 to {top}"),
            }
        })?;
        let wide = recipe
            .roughness
            .iter()
            .any(|&alpha| alpha < NARROW_ROUGHNESS);
        for (place, &alpha) in recipe.roughness.iter().enumerate() {
            let instance = Instance {
                layer: bake.layer,
                number: bake.next_number(),
                method: Method::Lean,
                wrap: map.wrap(),
                width,
                height,
                roughness: Some(alpha),
                filter: recipe.filter,
                structure: Structure::Pyramid { finest_level },
            };
            bake.begin(Stage::Structures);
            if place == 0 {
                let pyramid = pyramid::build(map, layout, wide);
                match pyramid.means {
                    Means::Narrow(means) => bake.plan.add(instance.section(MEANS), means),
                    Means::Wide(means) => bake.plan.add(instance.section(MEANS), means),
                }
                if pyramid.spreads.is_empty() {
                    bake.leave_out(&instance, "SPRD", "a map of one texel has no spread");
                } else {
                    bake.plan.add(instance.section(SPREADS), pyramid.spreads);
                }
            } else {
                let reason = "stored once, with the first roughness: moments do not depend on it";
                bake.leave_out(&instance, "MEAN", reason);
                bake.leave_out(&instance, "SPRD", reason);
            }
            masking::add(map, recipe, &instance, bake);
            bake.instances.push(instance);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Recipe;
    use crate::bake;
    use glintbake_format::model::Wrap;

    #[test]
    fn means_are_as_fine_as_the_finest_lobe_needs() {
        let map = NormalMap::new(4, 4, Wrap::Repeat, vec![[0.1, 0.2]; 16]);
        for (roughness, bytes) in [
            (&[0.01][..], 4),
            (&[0.4, 0.02], 4),
            (&[0.4, 0.0099], 8),
            (&[0.0001], 8),
        ] {
            let recipe = Recipe::new(vec![MethodRecipe::new(Method::Lean, roughness)]);
            let package = bake(&map, &recipe, None).unwrap().to_bytes();
            let container = glintbake_format::Container::open(&package).unwrap();
            let instance = container.instances().next().unwrap().unwrap();
            let entry = container.find(instance.section(MEANS)).unwrap();
            assert_eq!(entry.element_size.get(), bytes, "{roughness:?}");
        }
    }

    #[test]
    fn a_level_beyond_the_top_is_refused_with_the_levels_there_are() {
        let map = NormalMap::new(5, 3, Wrap::Repeat, vec![[0.0, 0.0]; 15]);
        for (level, is_fine) in [(0, true), (2, true), (3, false), (u32::MAX, false)] {
            let lean = MethodRecipe {
                finest_level: Some(level),
                ..MethodRecipe::new(Method::Lean, &[0.1])
            };
            let plan = bake(&map, &Recipe::new(vec![lean]), None);
            let error = plan.err().map(|error| error.to_string());
            assert_eq!(error.is_none(), is_fine, "{level}: {error:?}");
            assert!(error.is_none_or(|error| error.contains("5 x 3 texels has levels 0 to 2")));
        }
    }
}
