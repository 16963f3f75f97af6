//! A report on a terminal.

use super::document::Report;
use super::panel::{Panel, panels};
use super::units;
use std::fmt::{self, Write};

/// Columns of text that a line may have.
const WIDTH: usize = 118;

/// The report as text of at most 118 columns: for each map, kernel, surface, filter and roughness a table of error and time of
/// `eval` by contestant and size under square footprints, bytes a texel and seconds of the bake, and who is on the
/// Pareto front.
pub fn text(report: &Report) -> String {
    let mut text = String::new();
    write_report(&mut text, report).expect("a string takes any text");
    text
}

fn write_report(text: &mut String, report: &Report) -> fmt::Result {
    if !report.complete {
        writeln!(text, "not complete: the run is going on or was interrupted")?;
    }
    if !report.head.optimised {
        writeln!(text, "compiled without optimisation: times mean little")?;
    }
    for map in &report.maps {
        writeln!(
            text,
            "{}: {} x {} texels",
            printable(&map.name),
            map.width,
            map.height
        )?;
        for panel in panels(map) {
            writeln!(text)?;
            write_panel(text, &panel)?;
        }
        for skipped in &map.skipped {
            writeln!(text, "\nnot measured: {}", printable(&skipped.to_string()))?;
        }
        writeln!(text)?;
    }
    write!(
        text,
        "Relative L1 error in % against the truth of every texel / time of an eval; square footprints of size σ (half the\n\
         edge, in texels), half vectors drawn from the truth. * on the Pareto front of its size: nothing is faster and closer.\n"
    )
}

fn write_panel(text: &mut String, panel: &Panel<'_>) -> fmt::Result {
    let names: Vec<String> = panel
        .contestants
        .iter()
        .map(|contestant| printable(&contestant.name()))
        .collect();
    let widest = names
        .iter()
        .map(|name| name.chars().count())
        .max()
        .unwrap_or(0);
    let name_width = widest.max(12);
    let sizes = panel.sizes(1.0);
    let fronts: Vec<Vec<usize>> = sizes.iter().map(|&sigma| panel.front(sigma, 1.0)).collect();
    writeln!(text, "  {}", printable(&panel.title()))?;
    let cells: Vec<Vec<String>> = sizes
        .iter()
        .zip(&fronts)
        .map(|(&sigma, front)| {
            let cell = |index: usize| cell(panel, index, sigma, front.contains(&index));
            (0..names.len()).map(cell).collect()
        })
        .collect();
    let longest = cells
        .iter()
        .flatten()
        .map(|cell| cell.chars().count())
        .max();
    let width = longest.unwrap_or(0).max(8) + 1;
    // What does not fit beside each other is below each other; bytes and seconds are in the first part.
    let columns = (WIDTH.saturating_sub(2 + name_width + 16) / width).max(1);
    for (part, sigmas) in sizes.chunks(columns).enumerate() {
        let mut line = format!("  {:name_width$}", "");
        for sigma in sigmas {
            write!(line, "{:>width$}", format!("σ {} ", units::plain(*sigma)))?;
        }
        if part == 0 {
            write!(line, "{:>8}{:>8}", "B/texel", "bake")?;
        }
        writeln!(text, "{}", line.trim_end())?;
        for (index, (contestant, name)) in panel.contestants.iter().zip(&names).enumerate() {
            let mut line = format!("  {name:name_width$}");
            for cells in &cells[part * columns..part * columns + sigmas.len()] {
                write!(line, "{:>width$}", cells[index])?;
            }
            if part == 0
                && let Some(package) = panel.package(contestant)
            {
                let bytes = units::significant(package.bytes_per_texel, 3);
                let seconds = units::seconds(package.bake_seconds).replace(' ', "");
                write!(line, "{bytes:>8}{seconds:>8}")?;
            }
            writeln!(text, "{}", line.trim_end())?;
        }
    }
    write_front(text, &names, &fronts)
}

/// Error and time of the contestant of that index, with a star if it `is_best`.
fn cell(panel: &Panel<'_>, index: usize, sigma: f64, is_best: bool) -> String {
    match panel.found(panel.contestants[index], sigma, 1.0) {
        Some(row) => format!(
            "{}/{}{}",
            row.truth
                .relative_l1
                .map_or_else(|| "-".to_owned(), units::percent),
            units::time_tight(row.times.eval.median_ns),
            if is_best { '*' } else { ' ' }
        ),
        None => "- ".to_owned(),
    }
}

/// Who is on the front of every size, and of some.
fn write_front(text: &mut String, names: &[String], fronts: &[Vec<usize>]) -> fmt::Result {
    let mut always = Vec::new();
    let mut sometimes = Vec::new();
    for (index, name) in names.iter().enumerate() {
        let count = fronts.iter().filter(|front| front.contains(&index)).count();
        if count > 0 && count == fronts.len() {
            always.push(name.as_str());
        } else if count > 0 {
            sometimes.push(name.as_str());
        }
    }
    write_list(text, "on the front at every size: ", &always)?;
    write_list(text, "at some sizes: ", &sometimes)
}

/// A list of names, in lines of at most [`WIDTH`] columns.
fn write_list(text: &mut String, title: &str, names: &[&str]) -> fmt::Result {
    if names.is_empty() {
        return Ok(());
    }
    let mut line = format!("  {title}");
    for (place, name) in names.iter().enumerate() {
        let piece = if place + 1 < names.len() {
            format!("{name}, ")
        } else {
            (*name).to_owned()
        };
        if place > 0 && line.chars().count() + piece.trim_end().chars().count() > WIDTH {
            writeln!(text, "{}", line.trim_end())?;
            line = "    ".to_owned();
        }
        line += &piece;
    }
    writeln!(text, "{}", line.trim_end())
}

/// `name` without what a terminal would obey.
pub(super) fn printable(name: &str) -> String {
    let plain = |letter: char| {
        if letter.is_control() {
            char::REPLACEMENT_CHARACTER
        } else {
            letter
        }
    };
    name.chars().map(plain).collect()
}

#[cfg(test)]
mod tests {
    use super::super::fixtures;
    use super::*;

    #[test]
    fn the_table_is_as_it_was() {
        let text = text(&fixtures::report());
        insta::assert_snapshot!("table", text);
    }

    #[test]
    fn no_line_is_wider_than_a_terminal_whatever_the_sizes() {
        let mut report = fixtures::report();
        report.complete = false;
        report.head.optimised = false;
        report.maps[0].name = "\u{1b}[31mred.png".to_owned();
        let mut more = report.maps[0].rows.clone();
        for row in &mut more {
            row.cell.sigma *= 1.5;
            row.truth.relative_l1 = Some(123.456);
            row.times.eval.median_ns = 123_456.0;
        }
        report.maps[0].rows.extend(more);
        let text = text(&report);
        for line in text.lines() {
            // The two lines at the end are sentences.
            assert!(line.chars().count() <= 120, "{line}");
        }
        assert!(text.contains("not complete") && text.contains("without optimisation"));
        assert!(!text.contains('\u{1b}'));
        let header = text.lines().find(|line| line.contains("B/texel")).unwrap();
        assert!(header.chars().count() <= WIDTH, "{header}");
        assert!(text.contains("σ 384"), "sizes that do not fit are below");
    }

    #[test]
    fn stars_are_where_the_front_is() {
        let text = text(&fixtures::report());
        let line = text
            .lines()
            .find(|line| line.trim_start().starts_with("ndf-mip-map"))
            .unwrap();
        assert_eq!(
            line.matches('*').count(),
            fixtures::SIZES.len(),
            "the fastest: {line}"
        );
        let line = text
            .lines()
            .find(|line| line.contains("paper-forest"))
            .unwrap();
        assert_eq!(line.matches('*').count(), 0, "slower and further: {line}");
    }
}
