//! What every kind owes: determinism, seams like the interior, normals of the hemisphere, clear refusals.

use crate::{
    KINDS, Kind, MAX_DENSITY, MAX_SCALE, MAX_SIDE, MIN_SCALE, Options, Sample, SampleError,
};

/// The Kolmogorov-Smirnov distance of `sorted` from uniform over [0, 1], as a multiple of the value that chance
/// exceeds once in a thousand times (1.95/√n).
pub fn distance_from_uniform(sorted: &[f64]) -> f64 {
    let count = sorted.len() as f64;
    let distance = sorted.iter().enumerate().fold(0.0, |worst: f64, (i, x)| {
        worst
            .max((x - i as f64 / count).abs())
            .max((x - (i + 1) as f64 / count).abs())
    });
    distance * count.sqrt() / 1.95
}

/// (∂h/∂column, ∂h/∂row) of every texel.
pub fn slopes(sample: &Sample) -> Vec<[f64; 2]> {
    let slope = |&[s, t]: &[f32; 2]| {
        let [s, t] = [f64::from(s), f64::from(t)];
        let z = (1.0 - s * s - t * t).sqrt();
        [-s / z, t / z]
    };
    sample.normals.iter().map(slope).collect()
}

fn generate(kind: Kind, options: &Options) -> Sample {
    crate::generate(kind, options).expect("the options are valid")
}

fn sized(kind: Kind, width: u32, height: u32) -> Options {
    Options {
        width,
        height,
        ..Options::new(kind, 1)
    }
}

fn assert_inside_disk(sample: &Sample, what: &str) {
    for (i, normal) in sample.normals.iter().enumerate() {
        let [s, t] = normal.map(f64::from);
        let squared = s * s + t * t;
        assert!(squared < 1.0 - 1e-6, "{what}, texel {i}: {normal:?}");
    }
    let blue = sample.rgb8().into_iter().skip(2).step_by(3);
    assert!(blue.min() >= Some(128), "{what}: z must encode as positive");
}

#[test]
fn every_size_gives_normals_of_the_hemisphere() {
    let sizes = [
        (1, 1),
        (2, 1),
        (1, 2),
        (2, 2),
        (1, 257),
        (257, 1),
        (3, 200),
        (13, 17),
        (65, 129),
        (128, 64),
        (251, 127),
    ];
    for &kind in KINDS {
        for (width, height) in sizes {
            let sample = generate(kind, &sized(kind, width, height));
            assert_eq!((sample.width, sample.height), (width, height));
            assert_eq!(sample.normals.len(), (width * height) as usize);
            assert_inside_disk(&sample, &format!("{kind} {width} x {height}"));
        }
    }
}

#[test]
fn the_ends_of_every_option_give_normals_of_the_hemisphere() {
    for &kind in KINDS {
        let usual = sized(kind, 53, 31);
        let ends = [
            (
                "smallest scale",
                Options {
                    scale: MIN_SCALE,
                    ..usual
                },
            ),
            (
                "largest scale",
                Options {
                    scale: MAX_SCALE,
                    ..usual
                },
            ),
            (
                "steepest",
                Options {
                    roughness: kind.max_roughness(),
                    ..usual
                },
            ),
            (
                "tiny roughness",
                Options {
                    roughness: 1e-300,
                    ..usual
                },
            ),
            (
                "densest",
                Options {
                    density: MAX_DENSITY,
                    ..usual
                },
            ),
            (
                "empty",
                Options {
                    density: 0.0,
                    ..usual
                },
            ),
            (
                "last seed",
                Options {
                    seed: u64::MAX,
                    ..usual
                },
            ),
            (
                "all at once",
                Options {
                    scale: MIN_SCALE,
                    density: MAX_DENSITY,
                    roughness: kind.max_roughness(),
                    ..usual
                },
            ),
        ];
        for (what, options) in ends {
            assert_inside_disk(&generate(kind, &options), &format!("{kind}, {what}"));
        }
        let flat = generate(
            kind,
            &Options {
                roughness: 0.0,
                ..usual
            },
        );
        assert!(
            flat.normals.iter().all(|&normal| normal == [0.0; 2]),
            "{kind} without roughness"
        );
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    for &kind in KINDS {
        // More rows than one band.
        let options = sized(kind, 96, 200);
        let [one, three] = [1, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.expect("a pool of a few threads")
                .install(|| generate(kind, &options))
        });
        let bits = |sample: &Sample| -> Vec<_> {
            sample
                .normals
                .iter()
                .map(|normal| normal.map(f32::to_bits))
                .collect()
        };
        assert_eq!(bits(&one), bits(&three), "{kind}");
    }
}

#[test]
fn bytes_are_those_of_earlier_versions() {
    // FNV-1a over the 16-bit encoding. A sample is named by its kind and options wherever results are reported:
    // change these only together with a changelog entry.
    let known = [
        (Kind::Flakes, 0x6ff0_8916_e457_9a59),
        (Kind::Voronoi, 0xa221_0c82_1fbb_fc74),
        (Kind::Scratches, 0x969f_180b_110b_3221),
        (Kind::Brushed, 0xfc46_ff59_a2ab_4b69),
        (Kind::Dents, 0x63ab_398d_0a97_9ee2),
        (Kind::Waves, 0x0e81_e53b_34d2_640b),
        (Kind::Spectrum, 0xbc7f_c49f_ce04_ebac),
        (Kind::Ocean, 0x3026_3fe4_9877_bec1),
        (Kind::Leather, 0x0697_7fc1_84f6_f351),
        (Kind::Flat, 0x7573_3db3_c303_264d),
        (Kind::Noise, 0xcd63_42a6_844f_7785),
    ];
    assert_eq!(known.map(|(kind, _)| kind), *KINDS);
    let found = known.map(|(kind, _)| {
        let sample = generate(
            kind,
            &Options {
                seed: 5,
                ..sized(kind, 70, 90)
            },
        );
        let bytes = sample.rgb16().into_iter().flat_map(u16::to_le_bytes);
        let hash = bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
        });
        (kind, hash)
    });
    assert_eq!(found, known, "{found:x?}");
}

#[test]
fn seeds_and_only_seeds_make_another_map() {
    for &kind in KINDS {
        let options = sized(kind, 64, 64);
        let first = generate(kind, &options);
        assert_eq!(first, generate(kind, &options), "{kind}");
        let second = generate(kind, &Options { seed: 1, ..options });
        let same = first
            .normals
            .iter()
            .zip(&second.normals)
            .filter(|(a, b)| a == b)
            .count();
        if kind == Kind::Flat {
            assert_eq!(same, 64 * 64);
        } else {
            assert!(same < 64 * 64 / 100, "{kind}: {same} texels are the same");
        }
    }
}

/// Mean |Δn| between each column and the next, the last being the seam; then the same for rows.
fn steps(normals: &[[f32; 2]], [width, height]: [usize; 2]) -> [Vec<f64>; 2] {
    let difference = |a: usize, b: usize| {
        let [s, t] = [0, 1].map(|axis| f64::from(normals[a][axis] - normals[b][axis]));
        s.hypot(t)
    };
    let columns = (0..width).map(|x| {
        let next = (x + 1) % width;
        (0..height)
            .map(|y| difference(y * width + x, y * width + next))
            .sum()
    });
    let rows = (0..height).map(|y| {
        let next = (y + 1) % height;
        (0..width)
            .map(|x| difference(y * width + x, next * width + x))
            .sum()
    });
    [columns.collect(), rows.collect()]
}

/// Whether the last step could be one of the others: not above the steepest by more than a step differs from its like by
/// chance (cell borders lie on the seam as on one column in twenty, and are steeper than most), nor half the smoothest,
/// as a repeated or mirrored edge would be.
fn seam_is_like_interior(steps: &[f64]) -> bool {
    let (seam, interior) = steps.split_last().expect("not empty");
    let low = interior.iter().copied().fold(f64::INFINITY, f64::min);
    let high = interior.iter().copied().fold(0.0, f64::max);
    (0.5 * low..=1.15 * high).contains(seam)
}

#[test]
fn the_seam_is_like_the_interior() {
    for &kind in KINDS {
        let [width, height] = [192, 150];
        let sample = generate(kind, &sized(kind, 192, 150));
        for steps in steps(&sample.normals, [width, height]) {
            assert!(seam_is_like_interior(&steps), "{kind}: {steps:?}");
        }
        // A part of the map does not tile: this test would notice, but for noise, and for grooves, which are too sparse
        // (`scratches` compares each texel with all copies of all grooves instead).
        if matches!(kind, Kind::Flat | Kind::Noise | Kind::Scratches) {
            continue;
        }
        let part: Vec<_> = sample
            .normals
            .chunks(width)
            .take(101)
            .flat_map(|row| row[..121].to_vec())
            .collect();
        let tiles = steps(&part, [121, 101])
            .iter()
            .all(|steps| seam_is_like_interior(steps));
        assert!(!tiles, "{kind}: a cut-out seems to tile");
    }
}

#[test]
fn reliefs_come_back_to_their_height_around_the_tile() {
    for kind in [
        Kind::Brushed,
        Kind::Dents,
        Kind::Waves,
        Kind::Spectrum,
        Kind::Ocean,
        Kind::Leather,
    ] {
        let size = 512;
        let options = Options {
            scale: 8.0,
            ..Options::new(kind, size as u32)
        };
        let slopes = slopes(&generate(kind, &options));
        // Sums along whole rows and columns are closed line integrals of ∇h.
        for axis in 0..2 {
            let mut worst = 0.0_f64;
            for line in 0..size {
                let along =
                    (0..size).map(|i| slopes[[line * size + i, i * size + line][axis]][axis]);
                let (sum, length) = along.fold((0.0, 0.0), |(sum, length), x| {
                    (sum + x, length + f64::abs(x))
                });
                worst = worst.max(f64::abs(sum) / length);
            }
            // Creases have kinks, where sums are only of first order in the pitch.
            let bound = if kind == Kind::Leather { 0.02 } else { 1e-3 };
            assert!(worst < bound, "{kind}, axis {axis}: {worst}");
        }
    }
}

#[test]
fn names_and_descriptions_identify_kinds() {
    for &kind in KINDS {
        assert_eq!(Kind::from_name(kind.name()), Some(kind));
        assert_eq!(kind.to_string(), kind.name());
        let description = kind.description();
        assert!(!description.is_empty() && !description.contains('\n'));
    }
    assert_eq!(Kind::from_name("Flakes"), None);
    assert_eq!(Kind::from_name(""), None);
}

#[test]
fn options_out_of_range_are_refused_by_name() {
    let usual = Options::new(Kind::Flakes, 4);
    let refusal =
        |options: Options| crate::generate(Kind::Flakes, &options).expect_err("out of range");
    assert_eq!(
        refusal(Options { height: 0, ..usual }),
        SampleError::EmptySize {
            width: 4,
            height: 0
        }
    );
    assert_eq!(
        refusal(Options {
            width: MAX_SIDE + 1,
            ..usual
        }),
        SampleError::TooLarge {
            width: MAX_SIDE + 1,
            height: 4
        }
    );
    for value in [0.0, -1.0, MIN_SCALE * 0.99, MAX_SCALE * 1.01, f64::INFINITY] {
        assert_eq!(
            refusal(Options {
                scale: value,
                ..usual
            }),
            SampleError::Scale { value }
        );
    }
    for value in [-0.1, 1.1, f64::INFINITY] {
        assert_eq!(
            refusal(Options {
                roughness: value,
                ..usual
            }),
            SampleError::Roughness { value, max: 1.0 }
        );
    }
    for value in [-0.1, MAX_DENSITY * 1.01] {
        assert_eq!(
            refusal(Options {
                density: value,
                ..usual
            }),
            SampleError::Density { value }
        );
    }
    let nan = f64::NAN;
    let messages = [
        refusal(Options {
            scale: nan,
            ..usual
        }),
        refusal(Options {
            roughness: nan,
            ..usual
        }),
        refusal(Options {
            density: nan,
            ..usual
        }),
    ]
    .map(|error| error.to_string());
    for (message, word) in messages.iter().zip(["scale", "roughness", "density"]) {
        assert!(
            message.starts_with(word) && message.contains("NaN"),
            "{message}"
        );
    }
}
