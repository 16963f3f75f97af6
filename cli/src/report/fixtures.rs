//! A report of invented but plausible numbers, for tests.

use super::document::{
    Cell, Contestant, Energy, ErrorSources, Errors, FORMAT, HalfVectors, Head, MapReport,
    PackageReport, Report, Role, Row, Skipped, Times, Timing, VERSION,
};

/// Sizes σ of every panel.
pub(crate) const SIZES: [f64; 5] = [1.0, 4.0, 16.0, 64.0, 256.0];

/// Who answers: role, method, variant, kernels, error and time at σ = 1, how time grows with σ, bytes a texel, seconds.
type Made = (
    Role,
    &'static str,
    &'static str,
    &'static [&'static str],
    [f64; 3],
    f64,
    f64,
);

const ROUGH: &[&str] = &["beckmann"];
const DISK: &[&str] = &["disk"];
const MEAN: &[&str] = &["bin-average"];
const ALL: &[&str] = &["beckmann", "disk", "bin-average"];

const MADE: [Made; 15] = [
    (
        Role::Method,
        "flake-bins",
        "bins-45",
        ROUGH,
        [0.031, 1100.0, 0.62],
        4.74,
        0.21,
    ),
    (
        Role::Method,
        "flake-bins",
        "bins-21",
        ROUGH,
        [0.052, 710.0, 0.6],
        4.74,
        0.21,
    ),
    (
        Role::Method,
        "flake-bins",
        "exact",
        ROUGH,
        [3e-5, 900.0, 1.7],
        8.74,
        0.24,
    ),
    (
        Role::Paper,
        "flake-bins",
        "paper",
        ROUGH,
        [0.085, 820.0, 0.66],
        9.8,
        0.48,
    ),
    (
        Role::Method,
        "lean",
        "blended",
        DISK,
        [0.71, 38.0, 0.01],
        26.7,
        0.05,
    ),
    (
        Role::Method,
        "lean",
        "mip",
        DISK,
        [0.83, 21.0, 0.01],
        26.7,
        0.05,
    ),
    (
        Role::Method,
        "specular-bins",
        "",
        MEAN,
        [0.002, 320.0, 0.5],
        4.2,
        0.18,
    ),
    (
        Role::Baseline,
        "exact-scan",
        "",
        ALL,
        [0.0, 1500.0, 1.9],
        8.0,
        0.0,
    ),
    (
        Role::Baseline,
        "plain-scan",
        "",
        ROUGH,
        [0.032, 900.0, 1.75],
        2.0,
        0.02,
    ),
    (
        Role::Baseline,
        "paper-forest",
        "",
        ROUGH,
        [0.052, 5200.0, 0.9],
        9.1,
        0.7,
    ),
    (
        Role::Baseline,
        "point-sampling",
        "1",
        ALL,
        [1.6, 31.0, 0.02],
        8.0,
        0.0,
    ),
    (
        Role::Baseline,
        "point-sampling",
        "16",
        ALL,
        [0.62, 240.0, 0.02],
        8.0,
        0.0,
    ),
    (
        Role::Baseline,
        "point-sampling",
        "256",
        ALL,
        [0.21, 3100.0, 0.02],
        8.0,
        0.0,
    ),
    (
        Role::Baseline,
        "point-sampling",
        "4096",
        ALL,
        [0.055, 48_000.0, 0.02],
        8.0,
        0.0,
    ),
    (
        Role::Baseline,
        "ndf-mip-map",
        "",
        ALL,
        [0.93, 12.0, 0.0],
        1.4,
        0.01,
    ),
];

/// A complete report of one map and two roughnesses.
pub(crate) fn report() -> Report {
    Report {
        format: FORMAT.to_owned(),
        version: VERSION,
        complete: true,
        head: Head {
            glintbake: "0.1.0".to_owned(),
            command: "glintbake report waves.png --roughness 0.01,0.04 -o report".to_owned(),
            seed: 7,
            processor: "AMD EPYC 7B13".to_owned(),
            threads: 2,
            target: "x86_64-unknown-linux-gnu".to_owned(),
            target_features: "none".to_owned(),
            compiler: "rustc 1.95.0".to_owned(),
            optimised: true,
            clock_resolution_ns: 20.0,
        },
        maps: vec![map("waves.png")],
    }
}

/// A map of that name.
pub(crate) fn map(name: &str) -> MapReport {
    let roughnesses = [0.01, 0.04];
    let mut rows = Vec::new();
    for kernel in ALL {
        for roughness in roughnesses {
            // Without a roughness there is one panel, not one for each.
            if *kernel == "bin-average" && roughness > 0.01 {
                continue;
            }
            for sigma in SIZES {
                for anisotropy in [1.0, 8.0] {
                    for half_vectors in [HalfVectors::Found, HalfVectors::Uniform] {
                        let cell = Cell {
                            filter: "box".to_owned(),
                            roughness: (*kernel != "bin-average").then_some(roughness),
                            sigma,
                            anisotropy,
                            half_vectors,
                        };
                        let here = MADE.iter().filter(|made| made.3.contains(kernel));
                        rows.extend(here.map(|made| row(made, kernel, &cell)));
                    }
                }
            }
        }
    }
    // Panels by roughness first, as a run makes them.
    rows.sort_by_key(|row| {
        row.cell
            .roughness
            .map_or(2, |roughness| u8::from(roughness > 0.01))
    });
    MapReport {
        name: name.to_owned(),
        blake3: "5e7c0b1f2a".repeat(6) + "00aa",
        width: 2048,
        height: 2048,
        packages: MADE
            .iter()
            .flat_map(|made| packages(made, &roughnesses))
            .collect(),
        rows,
        sources: roughnesses
            .iter()
            .flat_map(|roughness| SIZES.map(|sigma| sources(*roughness, sigma)))
            .collect(),
        skipped: vec![Skipped {
            contestant: Contestant {
                role: Role::Method,
                method: "lean".to_owned(),
                variant: "from level 12".to_owned(),
            },
            cell: None,
            reason: "the map has no such level".to_owned(),
        }],
    }
}

fn contestant(made: &Made) -> Contestant {
    Contestant {
        role: made.0,
        method: made.1.to_owned(),
        variant: made.2.to_owned(),
    }
}

fn packages(made: &Made, roughnesses: &[f64]) -> Vec<PackageReport> {
    let package = |roughness| PackageReport {
        contestant: contestant(made),
        roughness,
        bytes: (made.5 * 2048.0 * 2048.0) as u64,
        bytes_per_texel: made.5,
        bake_seconds: made.6,
        bake_peak_bytes: (made.0 == Role::Method).then_some(64 << 20),
    };
    if made.1 == "flake-bins" {
        roughnesses
            .iter()
            .map(|roughness| package(Some(*roughness)))
            .collect()
    } else {
        vec![package(None)]
    }
}

fn row(made: &Made, kernel: &str, cell: &Cell) -> Row {
    let [error, time, growth] = made.4;
    let elongated = if cell.anisotropy > 1.0 { 1.3 } else { 1.0 };
    let rough = cell
        .roughness
        .map_or(1.0, |roughness| libm::sqrt(0.01 / roughness));
    let uniform = if cell.half_vectors == HalfVectors::Uniform {
        1.6
    } else {
        1.0
    };
    let error = error * elongated * uniform * rough / libm::pow(cell.sigma, 0.22);
    let time = time * elongated * libm::pow(cell.sigma, growth);
    let is_answered_by_sampling = made.0 != Role::Baseline;
    Row {
        contestant: contestant(made),
        kernel: kernel.to_owned(),
        surface: "texels".to_owned(),
        cell: cell.clone(),
        queries: 2000,
        lit: 1987,
        truth: errors(error),
        model: is_answered_by_sampling.then(|| errors(2.1e-6)),
        energy: is_answered_by_sampling.then_some(Energy {
            share: 0.9981,
            standard_error: 0.0012,
        }),
        times: Times {
            eval: timing(time),
            eval_coherent: timing(time * 0.7),
            sample: is_answered_by_sampling.then(|| timing(time * 1.4)),
            pdf: is_answered_by_sampling.then(|| timing(time * 1.1)),
            point_sampling_error: (made.1 != "point-sampling")
                .then_some(1.6 / libm::sqrt(time / 31.0)),
        },
    }
}

fn errors(relative_l1: f64) -> Errors {
    Errors {
        relative_l1: Some(relative_l1),
        rms: Some(relative_l1 * 1.7),
        percentile_99: Some(relative_l1 * 2.2),
        worst: Some(relative_l1 * 4.1),
        worst_unlit: relative_l1 * 1e-3,
    }
}

fn timing(median: f64) -> Timing {
    Timing {
        median_ns: median,
        low_ns: median * 0.95,
        high_ns: median * 1.12,
        repetitions: 15,
        calls: 4096,
    }
}

fn sources(roughness: f64, sigma: f64) -> ErrorSources {
    let scale = 1.0 / libm::pow(sigma, 0.3);
    ErrorSources {
        roughness,
        sigma,
        queries: 500,
        centres: 0.03 * scale,
        truncation_45: 8e-4,
        truncation_21: 0.021,
        boundary: 0.09 * scale * scale,
        published: 0.11 * scale,
        ours: 0.031 * scale,
    }
}
