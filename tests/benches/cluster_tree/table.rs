//! Rows, on the screen and in a file, and what all of them say together.

use std::fmt::Write as _;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// A narrow lobe: σr up to it.
const NARROW: f64 = 0.02;

/// A cell: one map, roughness and size of footprint.
#[derive(Clone, Debug)]
pub struct Row {
    /// Name of the map.
    pub map: String,
    /// σr.
    pub roughness: f64,
    /// Texels.
    pub sigma: f64,
    /// Microseconds a query of the tree, the paper's structure and the scan; NaN of who did not take part.
    pub times: [f64; 3],
    /// Queries asked, and those of them that were timed.
    pub queries: [usize; 2],
    /// Relative L1 error of the tree; NaN if all is dark.
    pub l1: f64,
    /// Worst error as a share of the greatest density.
    pub worst: f64,
    /// What the tree's densities add up to beyond those of the truth, as a share.
    pub energy: f64,
    /// Relative L1 error of the paper's structure, over the timed queries.
    pub paper_l1: f64,
}

impl Row {
    /// How many times as long the paper's structure takes.
    fn paper_ratio(&self) -> f64 {
        self.times[1] / self.times[0]
    }

    /// How many times as long the scan takes.
    fn scan_ratio(&self) -> f64 {
        self.times[2] / self.times[0]
    }

    /// How many times as long the faster of both takes.
    fn best_ratio(&self) -> f64 {
        // The least of a number and NaN is the number.
        self.paper_ratio().min(self.scan_ratio())
    }

    fn place(&self) -> String {
        format!("{}, σr {}, σ {}", self.map, self.roughness, self.sigma)
    }
}

/// Prints what stands above rows.
pub fn print_head() {
    println!(
        "{:<20} {:>7} {:>5} {:>9} {:>9} {:>9} {:>7} {:>7} {:>8} {:>8} {:>9} {:>9}",
        "map",
        "σr",
        "σ",
        "tree µs",
        "paper µs",
        "scan µs",
        "paper/",
        "scan/",
        "L1 %",
        "worst %",
        "energy %",
        "paper L1 %"
    );
}

/// Prints `row`.
pub fn print(row: &Row) {
    let [tree, paper, scan] = row.times;
    println!(
        "{:<20} {:>7} {:>5} {tree:>9.3} {paper:>9.3} {scan:>9.3} {:>7.2} {:>7.2} {:>8.4} {:>8.4} {:>+9.4} {:>9.2}",
        row.map,
        row.roughness,
        row.sigma,
        row.paper_ratio(),
        row.scan_ratio(),
        100.0 * row.l1,
        100.0 * row.worst,
        100.0 * row.energy,
        100.0 * row.paper_l1,
    );
}

/// Writes `rows` to the file at `path`; shares are not in percent.
///
/// # Errors
/// If the file cannot be written.
pub fn write(rows: &[Row], path: &Path) -> io::Result<()> {
    let mut file = BufWriter::new(std::fs::File::create(path)?);
    writeln!(
        file,
        "map,sigma_r,sigma,tree_us,paper_us,scan_us,paper_over_tree,scan_over_tree,l1,worst,energy,paper_l1,queries,timed"
    )?;
    for row in rows {
        // Names of files may have commas and quotes.
        let mut line = format!("\"{}\"", row.map.replace('"', "\"\""));
        let numbers = [row.roughness, row.sigma]
            .into_iter()
            .chain(row.times)
            .chain([row.paper_ratio(), row.scan_ratio()])
            .chain([row.l1, row.worst, row.energy, row.paper_l1]);
        for number in numbers {
            line.push(',');
            // Nothing to say is an empty field.
            if !number.is_nan() {
                let _ = write!(line, "{number}");
            }
        }
        let [queries, timed] = row.queries;
        writeln!(file, "{line},{queries},{timed}")?;
    }
    file.flush()
}

/// Prints what all `rows` say together.
pub fn summarise(rows: &[Row]) {
    println!("\nmedians over cells: how many times as long as the tree");
    for (name, most) in [("all", f64::INFINITY), ("σr ≤ 0.02", NARROW)] {
        let ratios = |of: fn(&Row) -> f64| {
            let narrow = rows.iter().filter(|row| row.roughness <= most);
            median(narrow.map(of).filter(|ratio| !ratio.is_nan()).collect())
        };
        println!(
            "{name:<10} paper {}, scan {}, the faster of both {}",
            said(ratios(Row::paper_ratio)),
            said(ratios(Row::scan_ratio)),
            said(ratios(Row::best_ratio)),
        );
    }
    println!("the faster of paper and scan against the tree, by σ: worst cell, median");
    let mut sigmas: Vec<f64> = rows.iter().map(|row| row.sigma).collect();
    sigmas.sort_by(f64::total_cmp);
    sigmas.dedup();
    for sigma in sigmas {
        let cells = || rows.iter().filter(|row| row.sigma == sigma);
        let ratio = |row: &&Row| row.best_ratio();
        let worst = cells().min_by(|a, b| ratio(a).total_cmp(&ratio(b)));
        if let Some(worst) = worst {
            println!(
                "{sigma:>6}: {:.2} ({}), {}",
                worst.best_ratio(),
                worst.place(),
                said(median(cells().map(Row::best_ratio).collect())),
            );
        }
    }
    for (name, of) in [
        ("L1", (|row| row.l1) as fn(&Row) -> f64),
        ("single error", |row| row.worst),
        ("energy error", |row| row.energy.abs()),
    ] {
        let lit = rows.iter().filter(|row| !of(row).is_nan());
        if let Some(row) = lit.max_by(|a, b| of(a).total_cmp(&of(b))) {
            println!("worst {name}: {:.4} % ({})", 100.0 * of(row), row.place());
        }
    }
}

/// The median, the mean of two where there are two.
fn median(mut numbers: Vec<f64>) -> Option<f64> {
    numbers.sort_by(f64::total_cmp);
    let middle = numbers.len() / 2;
    match numbers.len() {
        0 => None,
        count if count % 2 == 1 => Some(numbers[middle]),
        _ => Some(0.5 * (numbers[middle - 1] + numbers[middle])),
    }
}

fn said(number: Option<f64>) -> String {
    number.map_or_else(|| "none".to_owned(), |number| format!("{number:.2}"))
}
