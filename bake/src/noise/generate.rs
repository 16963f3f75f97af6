//! A noise map by chance.

use super::{MAX_COPIES, NoiseCopy, NoiseError, NoiseMap, NoiseSource, Transform, fault_of};
use crate::build::numbers::Numbers;
use serde::Serialize;

/// What chance may do.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct NoiseOptions {
    /// How many copies.
    pub instances: u32,
    /// What chance begins with.
    pub seed: u64,
    /// Least and greatest rotation, in degrees counter-clockwise in the picture.
    pub rotation: [f64; 2],
    /// Least and greatest scale; its logarithm is what chance takes.
    pub scale: [f64; 2],
    /// Least and greatest shear.
    pub shear: [f64; 2],
    /// How many of all copies are mirrored, 0 to 1.
    pub mirrored: f64,
    /// How dense copies are, if not everywhere alike.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density: Option<Density>,
}

impl NoiseOptions {
    /// `instances` copies, turned any way, half of them mirrored, of the example's own size.
    pub const fn new(instances: u32, seed: u64) -> Self {
        Self {
            instances,
            seed,
            rotation: [0.0, 360.0],
            scale: [1.0; 2],
            shear: [0.0; 2],
            mirrored: 0.5,
            density: None,
        }
    }
}

/// A picture of how dense copies are: bright where there are many.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Density {
    /// Columns and rows.
    pub size: [u32; 2],
    /// Brightness row by row, none negative.
    #[serde(skip)]
    pub values: Vec<f64>,
    /// What names the values in a recipe: their BLAKE3 hash.
    pub blake3: String,
}

impl Density {
    /// The picture of `values`, row by row.
    ///
    /// # Errors
    /// [`NoiseError::Option`] if it is dark everywhere, or has a value that is no number or negative.
    pub fn new(size: [u32; 2], values: Vec<f64>) -> Result<Self, NoiseError> {
        let sum: f64 = values.iter().sum();
        if !(sum > 0.0 && sum.is_finite()) || values.iter().any(|&value| value < 0.0) {
            return Err(NoiseError::Option {
                option: "--density",
                value: format!("{}x{}", size[0], size[1]),
                reason:
                    "the picture is dark everywhere, or has values that are negative or no numbers"
                        .to_owned(),
            });
        }
        let mut hash = blake3::Hasher::new();
        for value in &values {
            hash.update(&value.to_le_bytes());
        }
        Ok(Self {
            size,
            values,
            blake3: hash.finalize().to_hex().to_string(),
        })
    }
}

/// The noise map of `options`; the same options give the same copies on every machine.
///
/// Without a density, centres are jittered over a square grid of as many cells as copies or some more, so that they neither clump
/// nor repeat; with one, each is drawn by itself.
///
/// # Errors
/// [`NoiseError::Option`] for 0 copies, more than [`MAX_COPIES`], or transformations that are none.
pub fn generate(options: &NoiseOptions) -> Result<NoiseMap, NoiseError> {
    let count = options.instances as usize;
    let refused = |option: &'static str, value: String, reason: &str| NoiseError::Option {
        option,
        value,
        reason: reason.to_owned(),
    };
    if !(1..=MAX_COPIES).contains(&count) {
        let reason = "a surface has 1 to 4194304 copies of its example";
        return Err(refused("--instances", count.to_string(), reason));
    }
    let ranges = [
        ("--rotation", options.rotation),
        ("--scale", options.scale),
        ("--shear", options.shear),
    ];
    for (option, [least, most]) in ranges {
        if !(least.is_finite() && most.is_finite() && least <= most) {
            let reason = "give the least and the greatest, as in 0.5..2";
            return Err(refused(option, format!("{least}..{most}"), reason));
        }
    }
    let [least, most] = options.scale;
    if least <= 0.0 {
        return Err(refused(
            "--scale",
            format!("{least}..{most}"),
            "scales are positive",
        ));
    }
    if !(0.0..=1.0).contains(&options.mirrored) {
        let reason = "the share of mirrored copies lies between 0 and 1";
        return Err(refused("--mirrored", options.mirrored.to_string(), reason));
    }
    let mut numbers = Numbers::new(options.seed);
    let centres = match &options.density {
        None => jittered(count, &mut numbers),
        Some(density) => drawn(count, density, &mut numbers),
    };
    let mut copies = Vec::with_capacity(count);
    for centre in centres {
        let mut between = |[least, most]: [f64; 2]| least + numbers.uniform() * (most - least);
        let rotation = between(options.rotation);
        let scale = libm::exp(between(options.scale.map(libm::log)));
        let shear = between(options.shear);
        let transform = Transform {
            rotation,
            scale: [scale; 2],
            shear,
            is_mirrored: between([0.0, 1.0]) < options.mirrored,
        };
        let matrix = transform.matrix();
        if let Some(reason) = fault_of(matrix) {
            return Err(refused("--scale", format!("{least}..{most}"), &reason));
        }
        copies.push(NoiseCopy { centre, matrix });
    }
    Ok(NoiseMap {
        copies,
        source: NoiseSource::Generated(options.clone()),
    })
}

/// One centre in each of `count` cells of a square grid that has at least as many, which ones by chance.
fn jittered(count: usize, numbers: &mut Numbers) -> Vec<[f64; 2]> {
    let side = (1..).find(|side| side * side >= count).unwrap_or(1);
    let mut cells: Vec<usize> = (0..side * side).collect();
    // Fisher and Yates: the first `count` are a draw without replacement.
    for place in 0..count {
        let other = place + numbers.below(cells.len() - place);
        cells.swap(place, other);
    }
    cells.truncate(count);
    cells
        .into_iter()
        .map(|cell| {
            [cell % side, cell / side].map(|along| (along as f64 + numbers.uniform()) / side as f64)
        })
        .collect()
}

/// `count` centres drawn by `density`.
fn drawn(count: usize, density: &Density, numbers: &mut Numbers) -> Vec<[f64; 2]> {
    let mut sums = Vec::with_capacity(density.values.len());
    let mut sum = 0.0;
    for value in &density.values {
        sum += value;
        sums.push(sum);
    }
    let [columns, rows] = density.size.map(|side| side as usize);
    (0..count)
        .map(|_| {
            let at = numbers.uniform() * sum;
            let pixel = sums.partition_point(|&sum| sum <= at).min(sums.len() - 1);
            let [x, y] = [pixel % columns, pixel / columns];
            [
                (x as f64 + numbers.uniform()) / columns as f64,
                (y as f64 + numbers.uniform()) / rows as f64,
            ]
        })
        .collect()
}
