//! The plots of a panel.

use super::super::document::{Contestant, Row, Timing};
use super::super::markup::Markup;
use super::super::panel::{Panel, sorted};
use super::super::plot::bars::{Bar, BarPlot};
use super::super::plot::frame::Axis;
use super::super::plot::lines::{self, LinePlot, Point, Series};
use super::super::plot::marks::Looks;
use super::super::plot::scale;
use super::super::plot::scatter::{Mark, ScatterPlot};
use super::super::units::{self, EXACT};
use super::size_name;

/// Radius of the mark of a contestant of so many bytes a texel: its area is proportional to them from 2.5 on.
pub fn radius(bytes_per_texel: Option<f64>) -> f64 {
    bytes_per_texel.map_or(3.4, |bytes| (1.9 * bytes.max(0.0).sqrt()).clamp(3.0, 13.0))
}

/// Error against time under square footprints, one plot for each size, all on the same axes.
pub fn scatter(panel: &Panel<'_>, looks: &Looks<'_>) -> Vec<ScatterPlot> {
    let sizes = panel.sizes(1.0);
    let all: Vec<Vec<Mark>> = sizes
        .iter()
        .map(|&sigma| marks(panel, looks, sigma))
        .collect();
    let marks = || all.iter().flatten();
    let times = marks().flat_map(|mark| [mark.at[0], mark.span[0], mark.span[1]]);
    let Some(times) = scale::range(times) else {
        return Vec::new();
    };
    let (errors, strip) = error_range(marks().map(|mark| mark.at[1]));
    let axes = [
        axis(
            "time of an eval",
            scale::padded(times, 0.07),
            units::time_tick,
        ),
        axis("relative L1 error", errors, units::percent_tick),
    ];
    let plot = |(sigma, marks): (f64, Vec<Mark>)| {
        let names: Vec<String> = panel
            .front(sigma, 1.0)
            .into_iter()
            .map(|index| panel.contestants[index].name())
            .collect();
        ScatterPlot {
            title: size_name(sigma, 1.0),
            description: format!(
                "Relative L1 error against time of an eval, {}, {}. On the Pareto front, fastest first: {}.",
                panel.title(),
                size_name(sigma, 1.0),
                names.join(", ")
            ),
            axes: axes.clone(),
            strip,
            marks,
        }
    };
    let filled = sizes
        .into_iter()
        .zip(all)
        .filter(|(_, marks)| !marks.is_empty());
    filled.map(plot).collect()
}

fn marks(panel: &Panel<'_>, looks: &Looks<'_>, sigma: f64) -> Vec<Mark> {
    let mark = |contestant: &&Contestant| {
        let row = panel.found(contestant, sigma, 1.0)?;
        let error = row.truth.relative_l1.filter(|error| error.is_finite())?;
        let Timing {
            median_ns,
            low_ns,
            high_ns,
            ..
        } = row.times.eval;
        if !(median_ns > 0.0 && high_ns.is_finite()) {
            return None;
        }
        // A quartile of 0, as coarse clocks give, has no logarithm.
        let low_ns = if low_ns > 0.0 { low_ns } else { median_ns };
        let bytes = panel
            .package(contestant)
            .map(|package| package.bytes_per_texel);
        let mut title = format!(
            "{}\nerror {} %\neval {} ({} to {})",
            contestant.name(),
            units::percent(error),
            units::time(median_ns),
            units::time(low_ns),
            units::time(high_ns),
        );
        if let Some(bytes) = bytes {
            title += &format!("\n{} bytes a texel", units::significant(bytes, 3));
        }
        Some(Mark {
            name: contestant.name(),
            look: looks.of(contestant).clone(),
            at: [median_ns, error],
            span: [low_ns, high_ns],
            radius: radius(bytes),
            title,
        })
    };
    let mut marks: Vec<Mark> = panel.contestants.iter().filter_map(mark).collect();
    // Small marks last, or large ones would hide them.
    marks.sort_by(|one, other| other.radius.total_cmp(&one.radius));
    marks
}

/// Range of an axis of errors, and whether it needs a strip for those that are shown as none.
fn error_range(errors: impl Iterator<Item = f64> + Clone) -> ([f64; 2], bool) {
    let strip = errors.clone().any(|error| error < EXACT);
    let range = scale::range(errors.filter(|error| *error >= EXACT)).unwrap_or([0.01, 1.0]);
    let [low, high] = scale::padded(range, 0.06);
    ([low.max(EXACT), high], strip)
}

fn axis(label: &str, range: [f64; 2], name: fn(f64) -> String) -> Axis {
    Axis {
        label: label.to_owned(),
        range,
        ticks: Vec::new(),
        name,
    }
}

/// The axis of sizes, named by those that were measured.
pub fn size_axis(sizes: &[f64]) -> Option<Axis> {
    let range = scale::range(sizes.iter().copied())?;
    Some(Axis {
        ticks: sizes
            .iter()
            .map(|&sigma| (sigma, units::plain(sigma)))
            .collect(),
        ..axis(
            "size σ of the footprint, texels",
            scale::padded(range, 0.03),
            units::plain,
        )
    })
}

/// Error against size for each anisotropy, then time against size in random and in coherent order.
pub fn lines(panel: &Panel<'_>, looks: &Looks<'_>) -> Vec<LinePlot> {
    let errors: Vec<(f64, Vec<Series>)> = panel
        .anisotropies()
        .into_iter()
        .map(|anisotropy| {
            let error = |row: &Row| row.truth.relative_l1.map(|error| (error, None));
            let name = |value| format!("error {} %", units::percent(value));
            (anisotropy, series(panel, looks, anisotropy, error, name))
        })
        .collect();
    let eval = |row: &Row| Some(timed(&row.times.eval));
    let coherent = |row: &Row| Some(timed(&row.times.eval_coherent));
    let times = [
        (
            "Time of an eval, random order",
            eval as fn(&Row) -> Option<Value>,
        ),
        ("Time of an eval, coherent order", coherent),
    ]
    .map(|(title, value)| (title, series(panel, looks, 1.0, value, units::time)));
    let sizes = sorted(panel.rows.iter().map(|row| row.cell.sigma));
    let Some(x) = size_axis(&sizes) else {
        return Vec::new();
    };
    let all_errors = errors
        .iter()
        .flat_map(|(_, series)| series)
        .flat_map(|line| &line.points);
    let (error_range, strip) = error_range(all_errors.map(|point| point.at[1]));
    let time_range = lines::range_of(times.iter().flat_map(|(_, series)| series));
    let described = |what: &str| {
        format!(
            "{what} against the size of the footprint, {}",
            panel.title()
        )
    };
    let mut plots = Vec::new();
    for (anisotropy, series) in errors {
        let shape = if anisotropy == 1.0 {
            "square footprints".to_owned()
        } else {
            format!("{}:1 footprints", units::plain(anisotropy))
        };
        plots.push(LinePlot {
            title: format!("Error, {shape}"),
            description: described(&format!("Relative L1 error under {shape}")),
            axes: [
                x.clone(),
                axis("relative L1 error", error_range, units::percent_tick),
            ],
            strip,
            proportional: false,
            series,
        });
    }
    for (title, series) in times {
        if let Some(range) = time_range {
            plots.push(LinePlot {
                title: title.to_owned(),
                description: described(title),
                axes: [
                    x.clone(),
                    axis("time, square footprints", range, units::time_tick),
                ],
                strip: false,
                proportional: false,
                series,
            });
        }
    }
    plots.retain(|plot| !plot.series.is_empty());
    plots
}

/// A value with what it may be as well.
type Value = (f64, Option<[f64; 2]>);

fn timed(timing: &Timing) -> Value {
    (timing.median_ns, Some([timing.low_ns, timing.high_ns]))
}

/// A line for each contestant: `value` of its rows of `anisotropy` with half vectors found by the truth.
fn series(
    panel: &Panel<'_>,
    looks: &Looks<'_>,
    anisotropy: f64,
    value: impl Fn(&Row) -> Option<Value>,
    name: impl Fn(f64) -> String,
) -> Vec<Series> {
    let sizes = panel.sizes(anisotropy);
    let line = |contestant: &&Contestant| {
        let point = |&sigma: &f64| {
            let (y, span) = value(panel.found(contestant, sigma, anisotropy)?)?;
            let is_bar = |span: &[f64; 2]| span.iter().all(|end| *end > 0.0 && end.is_finite());
            Some(Point {
                at: [sigma, y],
                span: span.filter(is_bar),
                title: format!(
                    "{}\n{}\n{}",
                    contestant.name(),
                    size_name(sigma, anisotropy),
                    name(y)
                ),
            })
        };
        let points: Vec<Point> = sizes.iter().filter_map(point).collect();
        (!points.is_empty()).then(|| Series {
            name: contestant.name(),
            look: looks.of(contestant).clone(),
            points,
        })
    };
    panel.contestants.iter().filter_map(line).collect()
}

/// Memory and time of the bake.
pub fn bars(panel: &Panel<'_>, looks: &Looks<'_>) -> Vec<BarPlot> {
    let packages: Vec<_> = panel
        .contestants
        .iter()
        .filter_map(|contestant| panel.package(contestant))
        .collect();
    if packages.is_empty() {
        return Vec::new();
    }
    let plot = |title: &str, value: &dyn Fn(usize) -> (f64, String)| BarPlot {
        title: title.to_owned(),
        description: format!("{title}, {}", panel.title()),
        bars: packages
            .iter()
            .enumerate()
            .map(|(place, package)| {
                let (value, text) = value(place);
                Bar {
                    name: package.contestant.name(),
                    look: looks.of(&package.contestant).clone(),
                    value,
                    text,
                }
            })
            .collect(),
    };
    vec![
        plot("Memory, bytes a texel", &|place| {
            let bytes = packages[place].bytes_per_texel;
            (bytes, units::significant(bytes, 3))
        }),
        plot("Time of the bake", &|place| {
            let seconds = packages[place].bake_seconds;
            (seconds, units::seconds(seconds))
        }),
    ]
}

/// Draws plots side by side.
pub fn draw_lines(section: &mut Markup, plots: &[LinePlot]) {
    section.element("div", &[("class", &"plots")], |inside| {
        for plot in plots {
            plot.draw(inside);
        }
    });
}
