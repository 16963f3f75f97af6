//! What the methods with a kernel have in common: the roughnesses they are baked for.

use crate::error::BakeError;
use crate::recipe::{DEFAULT_ROUGHNESS, MethodRecipe};

/// Smallest Beckmann roughness: below it eq. 16 of \[AWKK21\] wants more bins than 16-bit columns and rows can name.
const LEAST_ROUGHNESS: f64 = 1e-4;
/// Largest Beckmann roughness: the paper's neighbourhood covers the lobe up to there.
const MOST_ROUGHNESS: f64 = 1.0;

/// Refuses a recipe without roughness, and what [`check_range`] refuses.
pub(super) fn check(recipe: &MethodRecipe) -> Result<(), BakeError> {
    if recipe.roughness.is_empty() {
        return Err(BakeError::Option {
            option: "--roughness",
            value: String::new(),
            reason: format!(
                "{} is baked for given roughnesses; name at least one, such as 0.01",
                recipe.method.name()
            ),
        });
    }
    check_range(recipe)
}

/// Refuses a recipe with a roughness out of range, or with one twice.
pub(super) fn check_range(recipe: &MethodRecipe) -> Result<(), BakeError> {
    for (place, &alpha) in recipe.roughness.iter().enumerate() {
        let reason = if !(LEAST_ROUGHNESS..=MOST_ROUGHNESS).contains(&alpha) {
            format!("Beckmann roughness must lie between {LEAST_ROUGHNESS} and {MOST_ROUGHNESS}")
        } else if recipe.roughness[..place].contains(&alpha) {
            "the same roughness is named twice".to_owned()
        } else {
            continue;
        };
        return Err(BakeError::Option {
            option: "--roughness",
            value: alpha.to_string(),
            reason,
        });
    }
    Ok(())
}

/// The roughnesses of a recipe for a method that answers for any: what its instances store for queries that name none.
pub(super) fn or_default(recipe: &MethodRecipe) -> &[f64] {
    match &*recipe.roughness {
        [] => &[DEFAULT_ROUGHNESS],
        given => given,
    }
}
