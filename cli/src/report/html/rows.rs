//! Every row of a panel with all its numbers.

use super::super::document::{Contestant, Errors, HalfVectors, Row, Timing};
use super::super::markup::Markup;
use super::super::panel::Panel;
use super::super::plot::marks::Looks;
use super::super::units;
use super::legend::draw_key;

const COLUMNS: [&str; 19] = [
    "contestant",
    "half vectors",
    "shape",
    "σ",
    "lit / queries",
    "rel. L1 %",
    "RMS %",
    "99th %",
    "worst %",
    "unlit /sr",
    "model L1 %",
    "model worst %",
    "energy %",
    "eval",
    "quartiles",
    "coherent",
    "sample",
    "pdf",
    "sampling as long %",
];

/// Draws the table, closed until it is asked for: by contestant, kind of half vectors, shape and size.
pub fn draw(section: &mut Markup, panel: &Panel<'_>, looks: &Looks<'_>) {
    section.element("details", &[], |details| {
        details.inline(
            "summary",
            &[],
            format_args!("All {} rows", panel.rows.len()),
        );
        details.element(
            "div",
            &[("class", &"scroll"), ("tabindex", &"0")],
            |scroll| {
                scroll.element("table", &[("class", &"rows")], |table| {
                    table.element("thead", &[], |head| {
                        head.element("tr", &[], |row| {
                            for column in COLUMNS {
                                row.inline("th", &[("scope", &"col")], column);
                            }
                        });
                    });
                    for contestant in &panel.contestants {
                        table.element("tbody", &[], |body| {
                            draw_group(body, panel, contestant, looks)
                        });
                        table.end_line();
                    }
                });
            },
        );
    });
}

fn draw_group(body: &mut Markup, panel: &Panel<'_>, contestant: &Contestant, looks: &Looks<'_>) {
    let mut rows: Vec<&Row> = panel
        .rows
        .iter()
        .copied()
        .filter(|row| row.contestant == *contestant)
        .collect();
    rows.sort_by(|one, other| {
        let (one, other) = (&one.cell, &other.cell);
        one.half_vectors
            .cmp(&other.half_vectors)
            .then(one.anisotropy.total_cmp(&other.anisotropy))
            .then(one.sigma.total_cmp(&other.sigma))
    });
    for (place, row) in rows.iter().enumerate() {
        body.element("tr", &[], |line| {
            if place == 0 {
                line.element(
                    "th",
                    &[("scope", &"rowgroup"), ("rowspan", &rows.len())],
                    |name| {
                        draw_key(name, looks.of(contestant));
                        name.text(format_args!(" {}", contestant.name()));
                    },
                );
            }
            for cell in cells(row) {
                line.inline("td", &[], cell);
            }
        });
    }
}

/// What the columns after the first hold.
fn cells(row: &Row) -> [String; COLUMNS.len() - 1] {
    let times = &row.times;
    let share = |share: Option<f64>| {
        share.map_or_else(|| "–".to_owned(), |share| units::precise(share * 100.0))
    };
    let median = |timing: Option<Timing>| {
        timing.map_or_else(|| "–".to_owned(), |timing| units::time(timing.median_ns))
    };
    let Errors {
        relative_l1,
        rms,
        percentile_99,
        worst,
        worst_unlit,
    } = row.truth;
    [
        match row.cell.half_vectors {
            HalfVectors::Found => "found".to_owned(),
            HalfVectors::Uniform => "uniform".to_owned(),
        },
        format!("{}:1", units::plain(row.cell.anisotropy)),
        units::plain(row.cell.sigma),
        format!("{} / {}", row.lit, row.queries),
        share(relative_l1),
        share(rms),
        share(percentile_99),
        share(worst),
        units::precise(worst_unlit),
        share(row.model.and_then(|model| model.relative_l1)),
        share(row.model.and_then(|model| model.worst)),
        row.energy.map_or_else(
            || "–".to_owned(),
            |energy| {
                let [share, error] =
                    [energy.share, energy.standard_error].map(|share| share * 100.0);
                format!("{share:.2} ± {error:.2}")
            },
        ),
        units::time(times.eval.median_ns),
        format!(
            "{} to {}",
            units::time_tight(times.eval.low_ns),
            units::time_tight(times.eval.high_ns)
        ),
        units::time(times.eval_coherent.median_ns),
        median(times.sample),
        median(times.pdf),
        share(times.point_sampling_error),
    ]
}
