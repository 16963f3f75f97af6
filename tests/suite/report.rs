//! The error columns of reports: within what each method states, and as they were.

use glintbake_cli::measure::clock::Clock;
use glintbake_cli::measure::errors::LIT;
use glintbake_cli::measure::plan::{Effort, Plan};
use glintbake_cli::measure::run::{MeasureError, measure};
use glintbake_cli::measure::subject;
use glintbake_cli::report::document::{HalfVectors, MapReport, Role, Row, Skipped};
use glintbake_format::model::{Filter, METHODS, Method, Wrap, beckmann_from_intrinsic};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::sample_map;

/// Enough queries to tell one norm from another, and next to no time on timings.
const EFFORT: Effort = Effort {
    queries: 16,
    footprints: 4,
    texels: 2e4,
    visits: 1e6,
    seconds: 1e-5,
    repetitions: 3,
    bakes: 1,
};

fn report(kind: Kind, filter: Filter) -> MapReport {
    let map = sample_map(kind, 48, 32, 5, Wrap::Repeat);
    let plan = Plan {
        // Quadrature takes minutes: `analytic` has its own suite, and stress.
        methods: METHODS
            .iter()
            .copied()
            .filter(|&method| filter == Filter::Box || method != Method::Analytic)
            .collect(),
        roughness: vec![beckmann_from_intrinsic(0.005), 0.2],
        filters: vec![filter],
        // Lobes of Gaussians reach over a hundred tiles at 20 texels.
        sigmas: match filter {
            Filter::Box => vec![0.25, 4.0, 20.0],
            Filter::Gaussian => vec![0.25, 4.0, 10.0],
        },
        seed: 3,
        effort: EFFORT,
    };
    let mut report = MapReport::new(
        kind.name().to_owned(),
        String::new(),
        map.width(),
        map.height(),
    );
    let mut told = 0;
    measure(
        &map,
        &plan,
        Clock::new(EFFORT.seconds, EFFORT.repetitions),
        &mut report,
        &mut |_, step| {
            assert_eq!(step.done, told, "each cell is told of once");
            told += 1;
            Ok::<(), MeasureError>(())
        },
    )
    .expect("the fixture's map can be measured");
    report
}

/// How far answers may be from their own model, in relative L1, and why.
fn allowed(row: &Row) -> f64 {
    match &*row.cell.filter {
        // The error that was asked for, which few queries of a cell meet less surely than many, and what rounding of normals
        // leaves under a texel or two.
        _ if row.contestant.method == "cluster-tree" => {
            let eps = row.contestant.variant.split(' ').next_back();
            1e-3 + 5.0 * eps.and_then(|eps| eps.parse().ok()).unwrap_or(0.0)
        }
        // What lobes leave out, round and merge.
        _ if row.contestant.method == "lobes" => 1e-3,
        // What their moments blur of needles: nearly all of a peak, and as much again beside it.
        _ if row.contestant.method == "mip-lobes" && row.contestant.variant != "unclustered" => 2.0,
        _ if row.contestant.method == "mip-lobes" => 1e-3,
        // Error functions as the paper has them.
        _ if (&*row.contestant.method, &*row.contestant.variant) == ("analytic", "paper") => 0.1,
        _ if row.contestant.method == "analytic" => 1e-4,
        // Normals are stored in 16 + 16 bits, which far out in the lobes shows most.
        _ if row.contestant.variant == "exact" => 1e-3,
        // Blocks of texels stand for themselves within the default tolerance.
        "gaussian" if !row.contestant.variant.ends_with("tolerance 0") => 1e-2,
        // Gaussians end at 4.8 standard deviations.
        "gaussian" => 1e-4,
        // Both sums are in f64.
        _ if row.kernel != "disk" => 1e-9,
        // Means and deviations of the pyramid are stored in 16 bits each.
        _ => 5e-2,
    }
}

#[test]
fn every_method_answers_its_own_model_and_loses_no_more_energy_than_it() {
    for kind in [Kind::Flakes, Kind::Waves] {
        for filter in [Filter::Box, Filter::Gaussian] {
            let report = report(kind, filter);
            let refusing = |skipped: &Skipped| {
                let method = Method::from_name(&skipped.contestant.method);
                // Quadrature of surfaces is left out where it takes seconds.
                skipped.reason.starts_with("its oracles would take")
                    // The maps are no squares of a power of two.
                    || method == Some(Method::NdfMaps)
                    || method
                        .is_some_and(|method| subject::find(method).variants(filter).is_empty())
            };
            assert!(report.skipped.iter().all(refusing), "{:?}", report.skipped);
            let mut judged = 0;
            for row in &report.rows {
                let name = (row.contestant.name(), &row.cell);
                let Some(model) = row.model else {
                    assert_ne!(row.contestant.role, Role::Method, "{name:?}");
                    continue;
                };
                // Where a stored normal is rounded near the rim, what is e^-20 of a lobe's peak moves by as much.
                let dark = match row.cell.roughness {
                    Some(alpha) if row.contestant.method == "cluster-tree" => {
                        LIT.max(1e-8 / (std::f64::consts::PI * alpha * alpha))
                    }
                    // Clusters are as wide as what they stand for, and light what lies between.
                    Some(alpha) if row.contestant.method == "mip-lobes" => {
                        1.0 / (std::f64::consts::PI * alpha * alpha)
                    }
                    _ => LIT,
                };
                assert!(model.worst_unlit <= dark, "{name:?}: {model:?}");
                // Of Gaussians a half vector from anywhere may meet only what lies beyond their end.
                let found = row.cell.half_vectors == HalfVectors::Found;
                // So it may of what skips terms far below the peak.
                let skips = row.contestant.method == "cluster-tree";
                if let Some(error) = model
                    .relative_l1
                    .filter(|_| found || (filter == Filter::Box && !skips))
                {
                    assert!(error <= allowed(row), "{name:?}: {error} of its model");
                    judged += 1;
                }
                if let Some(energy) = row.energy {
                    // The paper's 21 bins lose 1 %; flakes at the rim send some light below the horizon.
                    let least = if row.cell.roughness < Some(0.1) {
                        0.97
                    } else {
                        0.85
                    };
                    let slack = 4.0 * energy.standard_error;
                    assert!(
                        (least - slack..=1.0 + slack + 1e-2).contains(&energy.share),
                        "{name:?}: {energy:?}"
                    );
                }
            }
            assert!(judged > 60, "{judged}");
        }
    }
}

#[test]
fn errors_are_as_they_were() {
    insta::assert_snapshot!(lines(&report(Kind::Flakes, Filter::Box), METHODS));
}

/// The errors of `methods`, and all baselines if these are not some of them.
fn lines(report: &MapReport, methods: &[Method]) -> String {
    let mut lines = String::new();
    let is_told = |row: &&Row| match Method::from_name(&row.contestant.method) {
        Some(method) => methods.contains(&method),
        None => methods.len() == METHODS.len(),
    };
    for row in report.rows.iter().filter(is_told) {
        let digits = |value: Option<f64>| match value {
            None => "-".to_owned(),
            // Below that is rounding, which may differ between processors.
            Some(value) if value < 1e-5 => "0".to_owned(),
            Some(value) => format!("{value:.2e}"),
        };
        let cell = &row.cell;
        lines += &format!(
            "{} | α {} | σ {} x{} {:?} | lit {} of {} | L1 {} rms {} p99 {} worst {}\n",
            row.contestant.name(),
            cell.roughness
                .map_or_else(|| "-".to_owned(), |alpha| format!("{alpha:.4}")),
            cell.sigma,
            cell.anisotropy,
            cell.half_vectors,
            row.lit,
            row.queries,
            digits(row.truth.relative_l1),
            digits(row.truth.rms),
            digits(row.truth.percentile_99),
            digits(row.truth.worst),
        );
    }
    for source in &report.sources {
        lines += &format!(
            "α {:.4} σ {}: centres {:.2e}, 45 bins {:.2e}, 21 bins {:.2e}, boundary {:.2e}, published {:.2e}, ours {:.2e}\n",
            source.roughness,
            source.sigma,
            source.centres,
            source.truncation_45,
            source.truncation_21,
            source.boundary,
            source.published,
            source.ours,
        );
    }
    lines
}
