//! Seconds to bake maps of 1024² texels and more, stage by stage, on all threads.
//!
//! `cargo bench -p glintbake-tests --bench scale`, with `--up-to 16384` after `--` for larger maps (default 8192; 16384
//! takes 6 GB) and `--plot FILE` for a picture of the result, an SVG.
//!
//! Waves at α = 0.01 with block lists and masking: from normals in memory to a package in the system's folder for
//! temporary files. Making the map is not timed. What is written may still be in the system's cache. Maps below 8192²
//! are baked several times, and the fastest bake counts.

use glintbake_bake::normals::NormalMap;
use glintbake_bake::package::publish;
use glintbake_bake::{MethodRecipe, Progress, Recipe, Stage, bake_with_progress};
use glintbake_cli::report::plot::frame::Axis;
use glintbake_cli::report::plot::lines::{LinePlot, Series, range_of};
use glintbake_cli::report::units;
use glintbake_format::model::{Method, Wrap};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::sample_map;
use std::path::PathBuf;
use std::sync::Mutex;
use std::time::Instant;

const ALPHA: f64 = 0.01;
const MOST_ROUNDS: u32 = 5;
const SIDES: [u32; 5] = [1024, 2048, 4096, 8192, 16384];
/// What is timed, with the colour of its line.
const PARTS: [(&str, &str); 4] = [
    ("total", "#111"),
    ("bin map", "#1f6fb4"),
    ("structures", "#c2571a"),
    ("write", "#3a8f3a"),
];

fn main() {
    let arguments = Arguments::parse(std::env::args().skip(1)).unwrap_or_else(|message| {
        eprintln!("error: {message}");
        std::process::exit(2);
    });
    println!("threads: {}\n", rayon::current_num_threads());
    println!("  side     texels   bin map  structures     write     total  bytes/texel  ns/texel");
    let mut seconds: Vec<(f64, [f64; 4])> = Vec::new();
    for side in SIDES {
        if side > arguments.up_to {
            break;
        }
        let (parts, bytes) = measure(side);
        let [total, bin_map, structures, write] = parts;
        let texels = f64::from(side).powi(2);
        println!(
            "{side:>6} {texels:>10} {bin_map:>7.3} s {structures:>9.3} s {write:>7.3} s {total:>7.3} s {:>12.2} {:>9.1}",
            bytes as f64 / texels,
            total / texels * 1e9,
        );
        seconds.push((texels, parts));
    }
    if let [(least, first), .., (most, last)] = &*seconds {
        let exponent = (last[0] / first[0]).ln() / (most / least).ln();
        println!("\ntotal grows with the {exponent:.3}-th power of the texels, from first to last");
    }
    if let Some(path) = arguments.plot
        && let Some(plot) = plot(&seconds)
        && let Err(error) = std::fs::write(&path, plot.to_svg())
    {
        eprintln!("error: cannot write {}: {error}", path.display());
        std::process::exit(1);
    }
}

/// Seconds of each of [`PARTS`], and bytes of the package, of a map of `side` × `side` texels.
fn measure(side: u32) -> ([f64; 4], u64) {
    let map = sample_map(Kind::Waves, side, side, 7, Wrap::Repeat);
    let rounds = (8192 / side).clamp(1, MOST_ROUNDS);
    (0..rounds)
        .map(|_| bake_once(&map))
        .reduce(|one, other| if other.0[0] < one.0[0] { other } else { one })
        .expect("a round or more")
}

fn bake_once(map: &NormalMap) -> ([f64; 4], u64) {
    let recipe = Recipe::new(vec![MethodRecipe::new(Method::FlakeBins, &[ALPHA])]);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let begins = Begins::default();
    let start = Instant::now();
    let plan = bake_with_progress(map, &recipe, None, &begins).expect("in range");
    let built = Instant::now();
    let bytes = publish(&folder.path().join("waves.glint"), |file| plan.write(file))
        .expect("a temporary folder with room");
    let written = Instant::now();
    let begins = begins.0.into_inner().expect("nobody panicked");
    let structures = begins
        .iter()
        .find(|(stage, _)| *stage == Stage::Structures)
        .expect("a bake of flake-bins builds structures")
        .1;
    let parts = [
        written - start,
        structures - start,
        built - structures,
        written - built,
    ];
    (parts.map(|part| part.as_secs_f64()), bytes)
}

/// When stages began.
#[derive(Default)]
struct Begins(Mutex<Vec<(Stage, Instant)>>);

impl Progress for Begins {
    fn report(&self, stage: Stage, _done: u64, _total: u64) {
        let mut begins = self.0.lock().expect("nobody panicked");
        begins.push((stage, Instant::now()));
    }
}

/// The plot of what was measured, if anything was.
fn plot(seconds: &[(f64, [f64; 4])]) -> Option<LinePlot> {
    let series: Vec<Series> = PARTS
        .iter()
        .enumerate()
        .map(|(part, &(name, colour))| {
            let points = seconds.iter().map(|(texels, parts)| [*texels, parts[part]]);
            Series::new(name, colour, &points.collect::<Vec<_>>())
        })
        .collect();
    let title = format!("Baking waves at α = {ALPHA}");
    let texels = [seconds.first()?.0, seconds.last()?.0];
    Some(LinePlot {
        description: format!("{title}: seconds by number of texels"),
        title,
        axes: [
            Axis {
                label: "texels of the map".to_owned(),
                range: texels,
                ticks: seconds
                    .iter()
                    .map(|(texels, _)| (*texels, format!("{}²", texels.sqrt())))
                    .collect(),
                name: units::plain,
            },
            Axis {
                label: "seconds".to_owned(),
                range: range_of(series.iter())?,
                ticks: Vec::new(),
                name: units::plain,
            },
        ],
        strip: false,
        proportional: true,
        series,
    })
}

struct Arguments {
    up_to: u32,
    plot: Option<PathBuf>,
}

impl Arguments {
    fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut parsed = Self {
            up_to: 8192,
            plot: None,
        };
        while let Some(argument) = arguments.next() {
            match argument.as_str() {
                "--up-to" => {
                    let side = arguments.next().and_then(|side| side.parse().ok());
                    parsed.up_to = side
                        .filter(|side| *side >= SIDES[0])
                        .ok_or("--up-to: give the largest side, from 1024")?;
                }
                "--plot" => {
                    let path = arguments.next().ok_or("--plot: name a file to write")?;
                    parsed.plot = Some(path.into());
                }
                // From `cargo bench`.
                "--bench" => {}
                other => return Err(format!("{other}: not an option; see the head of the file")),
            }
        }
        Ok(parsed)
    }
}
