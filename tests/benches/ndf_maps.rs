//! `ndf-maps`: bytes, baking, µs a query and error, by example, how copies lie, how many there are, and footprint.
//!
//! `cargo bench -p glintbake-tests --bench ndf_maps [-- --rough σr] [--maps scratches,waves] [--sides 16,32] [--instances 4096]
//! [--edges 0.25,1,8] [--plot FILE]`
//!
//! Edges are in examples: a square of 8 covers 64 of them. Half vectors are drawn from what the footprint shows. A time is the least
//! of several rounds; errors are relative L1 against the same package with nothing left undivided, which tests hold to the oracle
//! within 0.5 %, and in brackets those of the paper's images of 128 and 256 pixels. `--instances 0` is tiled. `--plot` draws the times.

use core::f64::consts::{SQRT_2, TAU};
use glintbake_bake::noise::{NoiseOptions, generate};
use glintbake_bake::normals::NormalMap;
use glintbake_bake::{MethodRecipe, NdfCopies, NdfMapRecipe, Recipe, bake};
use glintbake_cli::measure::stream::Stream;
use glintbake_format::model::{Footprint, Method, Wrap};
use glintbake_runtime::{Ndf, NdfMaps, Package, SurfaceNdf};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::sample_map;
use glintbake_tests::queries::Query;
use std::error::Error;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

/// Rounds of which the fastest counts.
const ROUNDS: usize = 3;
/// Queries of a cell.
const QUERIES: usize = 300;
/// Of these, how many are asked without tolerance.
const CHECKED: usize = 60;

struct Options {
    roughness: f64,
    maps: Vec<String>,
    sides: Vec<u32>,
    instances: Vec<u32>,
    edges: Vec<f64>,
    plot: Option<String>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = options()?;
    println!("map, side, copies, edge in examples: µs; L1 (of 128 and 256 pixels)");
    let mut lines = Vec::new();
    for name in &options.maps {
        let kind = Kind::from_name(name).ok_or("no such map")?;
        for &side in &options.sides {
            let example = sample_map(kind, side, side, 7, Wrap::Repeat);
            for &instances in &options.instances {
                let times = row(&options, name, &example, instances)?;
                lines.push((format!("{name} {side}, {instances} copies"), times));
            }
        }
    }
    match &options.plot {
        Some(path) => Ok(std::fs::write(path, plot(&options.edges, &lines))?),
        None => Ok(()),
    }
}

/// The package of `example`, and how long it took.
fn baked(
    options: &Options,
    example: &NormalMap,
    instances: u32,
    paper: Option<u32>,
) -> Result<(Vec<u8>, f64), Box<dyn Error>> {
    let side = example.width();
    let mut asked = NdfMapRecipe {
        paper_pixels: paper,
        ..NdfMapRecipe::default()
    };
    if instances > 0 {
        // As much as all copies have, so that they cover the surface about once.
        let size = (f64::from(instances).sqrt() * f64::from(side)).round() as u32;
        asked.size = Some(size.clamp(4 * side, 65535));
        asked.copies = NdfCopies::Scattered(Arc::new(generate(&NoiseOptions::new(instances, 3))?));
    }
    let recipe = Recipe::new(vec![MethodRecipe {
        ndf_maps: Some(asked),
        masking: false,
        ..MethodRecipe::new(Method::NdfMaps, &[options.roughness * SQRT_2])
    }]);
    let start = Instant::now();
    let bytes = bake(example, &recipe, None)?.to_bytes();
    Ok((bytes, start.elapsed().as_secs_f64()))
}

fn open(bytes: &[u8]) -> Result<NdfMaps<'_>, Box<dyn Error>> {
    match Package::open(bytes)?.ndf(1)? {
        SurfaceNdf::NdfMaps(ndf) => Ok(ndf),
        _ => Err("baked for ndf-maps".into()),
    }
}

/// Microseconds of a query, by edge.
fn row(
    options: &Options,
    name: &str,
    example: &NormalMap,
    instances: u32,
) -> Result<Vec<f64>, Box<dyn Error>> {
    let (bytes, seconds) = baked(options, example, instances, None)?;
    let side = example.width();
    let papers = [128, 256].map(|pixels| baked(options, example, instances, Some(pixels)));
    let [small, large] = papers;
    let (small, large) = (small?.0, large?.0);
    let ndf = open(&bytes)?;
    println!(
        "{name}, {side}, {instances}: {:.3} MB ({:.2} and {:.2}), baked in {seconds:.2} s, {:.0} % covered",
        bytes.len() as f64 / 1e6,
        small.len() as f64 / 1e6,
        large.len() as f64 / 1e6,
        100.0 * ndf.covered()
    );
    let papers = [open(&small)?, open(&large)?];
    options
        .edges
        .iter()
        .map(|&edge| {
            let name = format!("{name}, {side}, {instances}, {edge}");
            cell(&name, &ndf, &papers, edge)
        })
        .collect()
}

fn cell(
    name: &str,
    ndf: &NdfMaps<'_>,
    papers: &[NdfMaps<'_>; 2],
    edge: f64,
) -> Result<f64, Box<dyn Error>> {
    let mut stream = Stream::new(11);
    let edge = edge * f64::from(ndf.layout().example()) / f64::from(ndf.layout().size);
    let mut queries: Vec<Query> = Vec::new();
    while queries.len() < QUERIES {
        let [x, y, turn]: [f64; 3] = stream.uniforms();
        let (sine, cosine) = (TAU * turn).sin_cos();
        let footprint = Footprint {
            centre: [x, y],
            edge_1: [edge * cosine, edge * sine],
            edge_2: [-edge * sine, edge * cosine],
        };
        if let Some(h) = ndf.sample(&footprint, stream.uniforms())? {
            queries.push((footprint, h));
        }
    }
    let mut least = f64::INFINITY;
    for _ in 0..ROUNDS {
        let start = Instant::now();
        for (footprint, h) in &queries {
            black_box(ndf.eval(footprint, *h)?);
        }
        least = least.min(start.elapsed().as_secs_f64() * 1e6 / queries.len() as f64);
    }
    let exact = ndf.with_tolerance(0.0)?;
    let (mut off, mut sum) = ([0.0; 3], 0.0);
    for (footprint, h) in queries.iter().take(CHECKED) {
        let truth = exact.eval(footprint, *h)?;
        for (off, ndf) in off.iter_mut().zip([ndf, &papers[0], &papers[1]]) {
            *off += (ndf.eval(footprint, *h)? - truth).abs();
        }
        sum += truth;
    }
    let [own, small, large] = off.map(|off| off / sum);
    println!("{name}: {least:.2}; {own:.4} ({small:.3}, {large:.3})");
    Ok(least)
}

/// Times by edge, both axes by their logarithms, as an SVG document.
fn plot(edges: &[f64], lines: &[(String, Vec<f64>)]) -> String {
    const COLOURS: [&str; 6] = [
        "#2166ac", "#b2182b", "#1a9850", "#762a83", "#e08214", "#525252",
    ];
    let (width, height, margin) = (720.0, 400.0, 56.0);
    let logs = |values: &[f64]| -> Vec<f64> { values.iter().map(|x| x.log10()).collect() };
    let (left, right) = (logs(edges)[0].floor(), logs(edges)[edges.len() - 1].ceil());
    let all: Vec<f64> = lines.iter().flat_map(|(_, times)| logs(times)).collect();
    let low = all.iter().copied().fold(f64::INFINITY, f64::min).floor();
    let high = all.iter().copied().fold(f64::NEG_INFINITY, f64::max).ceil();
    let x = |log: f64| margin + (log - left) / (right - left) * (width - 2.0 * margin);
    let y = |log: f64| height - margin - (log - low) / (high - low) * (height - 2.0 * margin);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n"
    );
    let mut tick = |log: f64, is_across: bool| {
        let label = 10.0_f64.powf(log);
        svg += &if is_across {
            format!(
                "<path d=\"M{0:.1} {1:.1}V{2:.1}\" stroke=\"#dddddd\"/><text x=\"{0:.1}\" y=\"{3:.1}\" text-anchor=\"middle\">{label}</text>\n",
                x(log),
                y(low),
                y(high),
                y(low) + 18.0
            )
        } else {
            format!(
                "<path d=\"M{0:.1} {1:.1}H{2:.1}\" stroke=\"#dddddd\"/><text x=\"{3:.1}\" y=\"{4:.1}\" text-anchor=\"end\">{label}</text>\n",
                x(left),
                y(log),
                x(right),
                x(left) - 6.0,
                y(log) + 4.0
            )
        };
    };
    let steps =
        |from: f64, to: f64| (0..=(to - from) as i32).map(move |step| from + f64::from(step));
    steps(left, right).for_each(|log| tick(log, true));
    steps(low, high).for_each(|log| tick(log, false));
    for (place, (name, times)) in lines.iter().enumerate() {
        let colour = COLOURS[place % COLOURS.len()];
        let points: Vec<String> = logs(edges)
            .iter()
            .zip(logs(times))
            .map(|(&edge, time)| format!("{:.1},{:.1}", x(edge), y(time)))
            .collect();
        svg += &format!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>\n\
             <text x=\"{:.1}\" y=\"{:.1}\" fill=\"{colour}\">{name}</text>\n",
            points.join(" "),
            margin + 12.0,
            margin - 8.0 + 16.0 * place as f64
        );
    }
    svg += &format!(
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">edge of the footprint, in examples</text>\n\
         <text x=\"14\" y=\"{:.1}\" transform=\"rotate(-90 14 {:.1})\" text-anchor=\"middle\">µs a query</text>\n</svg>\n",
        0.5 * width,
        height - 12.0,
        0.5 * height,
        0.5 * height
    );
    svg
}

fn options() -> Result<Options, Box<dyn Error>> {
    let mut options = Options {
        roughness: 0.01,
        maps: ["scratches", "waves"].map(str::to_owned).to_vec(),
        sides: vec![16, 32],
        instances: vec![0, 4096],
        edges: vec![0.0625, 0.25, 1.0, 3.0, 8.0, 30.0],
        plot: None,
    };
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        fn list<T: std::str::FromStr>(text: &str) -> Result<Vec<T>, String> {
            text.split(',')
                .map(|part| part.parse().map_err(|_| format!("{part} is no number")))
                .collect()
        }
        match argument.as_str() {
            "--rough" => options.roughness = value()?.parse()?,
            "--maps" => options.maps = list(&value()?)?,
            "--sides" => options.sides = list(&value()?)?,
            "--instances" => options.instances = list(&value()?)?,
            "--edges" => options.edges = list(&value()?)?,
            "--plot" => options.plot = Some(value()?),
            // What cargo adds.
            "--bench" => {}
            other => return Err(format!("{other}: no such option").into()),
        }
    }
    Ok(options)
}
