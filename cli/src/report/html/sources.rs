//! Where the error of binned normals comes from.

use super::super::document::{ErrorSources, MapReport};
use super::super::markup::Markup;
use super::super::panel::sorted;
use super::super::plot::frame::Axis;
use super::super::plot::lines::{LinePlot, Point, Series};
use super::super::plot::marks::{Look, Shape};
use super::super::plot::scale;
use super::super::units::{self, EXACT};
use super::{plots, size_name};

/// A source: its name, what it does wrong, its number, its colour and shape.
struct Source {
    name: &'static str,
    text: &'static str,
    value: fn(&ErrorSources) -> f64,
    colour: &'static str,
    shape: Shape,
    is_dashed: bool,
}

const SOURCES: [Source; 6] = [
    Source {
        name: "bin centres",
        text: "every normal at the centre of its bin",
        value: |sources| sources.centres,
        colour: "var(--h2)",
        shape: Shape::Circle,
        is_dashed: false,
    },
    Source {
        name: "45 bins only",
        text: "true normals, but only of the 45 bins around the half vector",
        value: |sources| sources.truncation_45,
        colour: "var(--h6)",
        shape: Shape::Circle,
        is_dashed: false,
    },
    Source {
        name: "21 bins only",
        text: "the same with the paper's 21 bins",
        value: |sources| sources.truncation_21,
        colour: "var(--h3)",
        shape: Shape::Circle,
        is_dashed: true,
    },
    Source {
        name: "outline by centres",
        text: "texels on the outline of the footprint in or out by their centre",
        value: |sources| sources.boundary,
        colour: "var(--h4)",
        shape: Shape::Circle,
        is_dashed: true,
    },
    Source {
        name: "all, as published",
        text: "all of it with 21 bins: what the published structure answers",
        value: |sources| sources.published,
        colour: "var(--h1)",
        shape: Shape::Diamond,
        is_dashed: false,
    },
    Source {
        name: "flake-bins",
        text: "bin centres and exact weights over 45 bins: what flake-bins answers",
        value: |sources| sources.ours,
        colour: "var(--h0)",
        shape: Shape::Square,
        is_dashed: false,
    },
];

/// Draws a plot for each roughness, and the table of all numbers.
pub fn draw(section: &mut Markup, map: &MapReport) {
    section.element("section", &[("class", &"panel")], |section| {
        section.inline("h3", &[], "Where the error of binned normals comes from");
        section.inline(
            "p",
            &[],
            "Relative L1 errors of sums that do one thing wrong at a time, all in double precision, under square boxes and \
             for half vectors drawn from the truth. Errors that partly cancel add up to less than their sum.",
        );
        let plots: Vec<LinePlot> = sorted(map.sources.iter().map(|sources| sources.roughness))
            .into_iter()
            .filter_map(|roughness| plot(map, roughness))
            .collect();
        plots::draw_lines(section, &plots);
        draw_table(section, map);
    });
}

fn plot(map: &MapReport, roughness: f64) -> Option<LinePlot> {
    let mut here: Vec<&ErrorSources> = map
        .sources
        .iter()
        .filter(|sources| sources.roughness == roughness)
        .collect();
    here.sort_by(|one, other| one.sigma.total_cmp(&other.sigma));
    let values = || {
        here.iter()
            .flat_map(|sources| SOURCES.iter().map(|source| (source.value)(sources)))
    };
    let range = scale::range(values().filter(|value| *value >= EXACT)).unwrap_or([0.01, 1.0]);
    let [low, high] = scale::padded(range, 0.06);
    let series = SOURCES.iter().map(|source| Series {
        name: source.name.to_owned(),
        look: Look {
            colour: source.colour.to_owned(),
            shape: source.shape,
            is_dashed: source.is_dashed,
        },
        points: here
            .iter()
            .map(|sources| {
                let error = (source.value)(sources);
                Point {
                    at: [sources.sigma, error],
                    span: None,
                    title: format!(
                        "{}\n{}\nerror {} %",
                        source.name,
                        size_name(sources.sigma, 1.0),
                        units::percent(error)
                    ),
                }
            })
            .collect(),
    });
    let sizes = sorted(here.iter().map(|sources| sources.sigma));
    let title = format!("Sources of error, α = {}", units::plain(roughness));
    Some(LinePlot {
        description: format!(
            "{title}, {}: relative L1 error against the size of the footprint",
            map.name
        ),
        title,
        axes: [
            plots::size_axis(&sizes)?,
            Axis {
                label: "relative L1 error".to_owned(),
                range: [low.max(EXACT), high],
                ticks: Vec::new(),
                name: units::percent_tick,
            },
        ],
        strip: values().any(|value| value < EXACT),
        proportional: false,
        series: series.collect(),
    })
}

fn draw_table(section: &mut Markup, map: &MapReport) {
    section.element("div", &[("class", &"scroll")], |scroll| {
        scroll.element("table", &[], |table| {
            table.element("thead", &[], |head| {
                head.element("tr", &[], |row| {
                    for name in ["α", "σ", "queries"] {
                        row.inline("th", &[("scope", &"col")], name);
                    }
                    for source in &SOURCES {
                        row.inline(
                            "th",
                            &[("scope", &"col"), ("title", &source.text)],
                            format_args!("{} %", source.name),
                        );
                    }
                });
            });
            table.element("tbody", &[], |body| {
                for sources in &map.sources {
                    body.element("tr", &[], |row| {
                        row.inline("td", &[], units::plain(sources.roughness));
                        row.inline("td", &[], units::plain(sources.sigma));
                        row.inline("td", &[], sources.queries);
                        for source in &SOURCES {
                            row.inline("td", &[], units::percent((source.value)(sources)));
                        }
                    });
                }
            });
        });
    });
    section.element("dl", &[("class", &"norms")], |list| {
        for source in &SOURCES {
            list.inline("dt", &[], source.name);
            list.inline("dd", &[], source.text);
        }
    });
}
