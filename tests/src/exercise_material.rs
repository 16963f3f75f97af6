//! Asking any material everything there is to ask.

use glintbake_format::Container;
use glintbake_format::model::Footprint;
use glintbake_runtime::{Composition, Material, QueryError};

/// Opens the material of `container`, if it holds one, and asks for values, samples and densities: numbers that are finite and not
/// negative, or the error the question deserves. A package in which verification finds nothing, if `is_sound`, may not be called
/// damaged.
///
/// # Panics
/// If an answer is none of these.
pub fn interrogate(container: &Container<'_>, is_sound: bool) {
    let material = match Material::open(container) {
        Ok(material) => material,
        Err(QueryError::NotBaked { .. }) => return,
        Err(QueryError::Damaged(_)) if !is_sound => return,
        Err(error) => panic!("{error}"),
    };
    let is_excused = |error: QueryError| match error {
        QueryError::Damaged(_) => !is_sound,
        // A layer may repeat its map a thousand times where the material is seen once.
        QueryError::FootprintTooLarge | QueryError::TooManyTexels { .. } => true,
        _ => false,
    };
    let is_number = |x: f64| x.is_finite() && x >= 0.0;
    let up = [0.0, 0.0, 1.0];
    for footprint in FOOTPRINTS {
        for (number, light) in [[0.0, 0.6, 0.8], [0.8, -0.6, 1e-3], up]
            .into_iter()
            .enumerate()
        {
            for composition in [Composition::BothWays, Composition::HalfVector] {
                let material = material.with_composition(composition);
                match material.eval(&footprint, light, up) {
                    Ok(rgb) => assert!(rgb.iter().copied().all(is_number), "{rgb:?}"),
                    Err(error) => assert!(is_excused(error), "{error}"),
                }
            }
            let share = 0.1 + 0.37 * number as f64;
            let drawn = material.sample(&footprint, light, [share, 0.7, 0.2, share]);
            let light = match drawn {
                Ok(drawn) => drawn.unwrap_or(light),
                Err(error) => {
                    assert!(is_excused(error), "{error}");
                    light
                }
            };
            assert!(light.iter().all(|x| x.is_finite()) && light[2] > 0.0);
            match material.pdf(&footprint, light, up) {
                Ok(pdf) => assert!(is_number(pdf), "{pdf}"),
                Err(error) => assert!(is_excused(error), "{error}"),
            }
        }
    }
    for layer in material.layers() {
        match layer.opacity(&layer.placed(&FOOTPRINTS[0])) {
            Ok(opacity) => assert!((0.0..=1.0).contains(&opacity), "{opacity}"),
            Err(error) => assert!(is_excused(error), "{error}"),
        }
    }
    let nowhere = Footprint {
        centre: [f64::NAN, 0.0],
        ..FOOTPRINTS[0]
    };
    assert_eq!(material.eval(&nowhere, up, up), Err(QueryError::NotFinite));
    assert_eq!(material.pdf(&nowhere, up, up), Err(QueryError::NotFinite));
    assert_eq!(
        material.sample(&nowhere, up, [0.5; 4]),
        Err(QueryError::NotFinite)
    );
}

/// A point, a patch, a needle.
const FOOTPRINTS: [Footprint; 3] = [
    Footprint {
        centre: [0.3, 0.8],
        edge_1: [0.0; 2],
        edge_2: [0.0; 2],
    },
    Footprint {
        centre: [-3.7, 0.1],
        edge_1: [0.3, 0.1],
        edge_2: [-0.1, 0.4],
    },
    Footprint {
        centre: [0.5, 0.5],
        edge_1: [0.9, 0.4],
        edge_2: [1e-7, 2e-7],
    },
];
