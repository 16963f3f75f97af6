//! `mip-lobes` of a quilted surface beside the plain sum over its lobes: bytes, baking, µs a query, error, by map, clusters and footprint.
//!
//! `cargo bench -p glintbake-tests --bench mip_lobes [-- --target N] [--rough σr] [--maps leather,waves] [--clusters 16,32]
//! [--edges 10,30] [--long N] [--plot FILE]`
//!
//! Both run in turn, with the same vectors; a time is the least of several rounds. Errors are relative L1 over queries, against the plain
//! sum in f64 over the expanded surface, of lobes four a texel, and in brackets that of the paper's levels. `--long` makes
//! footprints so many times as long as wide. `--plot` draws the times of the last map and clusters.

use core::f64::consts::SQRT_2;
use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle::lobes::Prepared;
use glintbake_bake::{MethodRecipe, QuiltRecipe, Recipe, bake};
use glintbake_cli::measure::baselines::plain_lobes::PlainLobes;
use glintbake_cli::measure::plan::Shape;
use glintbake_cli::measure::stream::Stream;
use glintbake_cli::rebuild;
use glintbake_format::model::{Filter, LobeLattice, Method, Wrap};
use glintbake_runtime::{MipLobes, Ndf, Package, SurfaceNdf};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::sample_map;
use glintbake_tests::queries::{Query, lit_query};
use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

/// Side of the samples.
const SAMPLE: u32 = 256;
/// Rounds of which the fastest counts.
const ROUNDS: usize = 3;
/// Lobes that a cell may visit in one round of the plain sum.
const VISITED: f64 = 2e7;
/// Queries that the oracle checks, and lobes that it may visit for them.
const CHECKED: f64 = 24.0;
const MOST_CHECKED: f64 = 1e7;

const LATTICE: LobeLattice = LobeLattice {
    curved: true,
    per_side: 2,
};

struct Options {
    target: u32,
    roughness: f64,
    maps: Vec<String>,
    clusters: Vec<u32>,
    edges: Vec<f64>,
    long: f64,
    plot: Option<String>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = options()?;
    println!("map, clusters, edge: µs / µs of the plain sum = ratio; L1 (of the paper's levels)");
    let mut times = Vec::new();
    for name in &options.maps {
        let kind = Kind::from_name(name).ok_or("no such map")?;
        let sample = sample_map(kind, SAMPLE, SAMPLE, 7, Wrap::Repeat);
        let mut plain = None;
        for &clusters in &options.clusters {
            let recipe = Recipe::new(vec![MethodRecipe {
                clusters: Some(clusters),
                quilt: Some(QuiltRecipe::new([options.target; 2])),
                masking: false,
                ..MethodRecipe::new(Method::MipLobes, &[options.roughness * SQRT_2])
            }]);
            let start = Instant::now();
            let bytes = bake(&sample, &recipe, None)?.to_bytes();
            let seconds = start.elapsed().as_secs_f64();
            println!(
                "{name}, {clusters}: {:.2} MB, baked in {seconds:.2} s",
                bytes.len() as f64 / 1e6
            );
            let package = Package::open(&bytes)?;
            let SurfaceNdf::MipLobes(ndf) = package.ndf(1)? else {
                return Err("baked for mip-lobes".into());
            };
            let map = rebuild::normal_map(package.container(), ndf.instance())
                .map_err(|finding| finding.to_string())?
                .ok_or("the surface is there")?;
            // The quilt is the same for any number of clusters.
            let plain = plain.get_or_insert_with(|| PlainLobes::new(&doubled(&map), true));
            times = options
                .edges
                .iter()
                .map(|&edge| {
                    let name = format!("{name}, {clusters}, {edge}");
                    cell(&name, &map, &ndf, plain, edge, &options)
                })
                .collect();
        }
    }
    match &options.plot {
        Some(path) => Ok(std::fs::write(path, plot(&options.edges, &times))?),
        None => Ok(()),
    }
}

/// The bilinear surface at quarters of texels: the lobes' lattice, four a texel.
fn doubled(map: &NormalMap) -> NormalMap {
    let (width, height) = (map.width(), map.height());
    let texel = |x: u32, y: u32| map.texels()[((y % height) * width + x % width) as usize];
    let mix = |a: [f32; 2], b: [f32; 2], part: f32| {
        [a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1])]
    };
    let texels = (0..4 * width * height)
        .map(|place| {
            let (x, y) = (place % (2 * width), place / (2 * width));
            let part = |place: u32, side: u32| {
                if place.is_multiple_of(2) {
                    (place / 2 + side - 1, 0.75)
                } else {
                    (place / 2, 0.25)
                }
            };
            let ((i, p), (j, q)) = (part(x, width), part(y, height));
            let upper = mix(texel(i, j), texel(i + 1, j), p);
            mix(upper, mix(texel(i, j + 1), texel(i + 1, j + 1), p), q)
        })
        .collect();
    NormalMap::new(2 * width, 2 * height, Wrap::Repeat, texels)
}

/// Microseconds of a query, and of the plain sum.
fn cell(
    name: &str,
    map: &NormalMap,
    ndf: &MipLobes<'_>,
    plain: &PlainLobes,
    edge: f64,
    options: &Options,
) -> [f64; 2] {
    let sigma = 0.5 * edge;
    let shape = Shape {
        filter: Filter::Gaussian,
        sigma,
        anisotropy: options.long,
    };
    let visited = 4.0 * 16.0 * core::f64::consts::PI * (sigma * sigma + 0.05);
    let count = ((VISITED / visited) as usize).clamp(8, 1000);
    let mut stream = Stream::new(11);
    let queries: Vec<Query> = (0..count)
        .map(|_| lit_query(map, shape, options.roughness, &mut stream))
        .collect();
    let by_levels = |(footprint, h): &Query| ndf.eval(footprint, *h).expect("in range");
    let by_sum = |(footprint, h): &Query| plain.eval(footprint, *h, options.roughness);
    let mut least = [f64::INFINITY; 2];
    for round in 0..ROUNDS {
        for turn in 0..2 {
            let who = (turn + round) % 2;
            let start = Instant::now();
            for query in &queries {
                black_box(if who == 0 {
                    by_levels(query)
                } else {
                    by_sum(query)
                });
            }
            let microseconds = start.elapsed().as_secs_f64() * 1e6 / queries.len() as f64;
            least[who] = least[who].min(microseconds);
        }
    }
    // The oracle looks nine deviations far.
    let checked = (MOST_CHECKED / (5.0 * visited)).min(CHECKED) as usize;
    let by_area = ndf.with_levels_by_area(true);
    let (mut off, mut paper_off, mut sum) = (0.0, 0.0, 0.0);
    for query in queries
        .iter()
        .take(checked.max(if checked > 0 { 8 } else { 0 }))
    {
        let (footprint, h) = query;
        let truth = Prepared::new(map, footprint, LATTICE, true).ndf(*h, ndf.roughness());
        off += (by_levels(query) - truth).abs();
        paper_off += (by_area.eval(footprint, *h).expect("in range") - truth).abs();
        sum += truth;
    }
    let error = if checked > 0 {
        format!("{:.3} ({:.3})", off / sum, paper_off / sum)
    } else {
        "-".to_owned()
    };
    let [own, other] = least;
    println!(
        "{name}: {own:.1} / {other:.1} = {:.2}; {error}",
        other / own
    );
    least
}

/// Times by edge, both axes by their logarithms, as an SVG document.
fn plot(edges: &[f64], times: &[[f64; 2]]) -> String {
    let (width, height, margin) = (640.0, 360.0, 56.0);
    let span = |values: &mut dyn Iterator<Item = f64>| {
        let logs: Vec<f64> = values.map(f64::log10).collect();
        let low = logs.iter().copied().fold(f64::INFINITY, f64::min).floor();
        let high = logs
            .iter()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max)
            .ceil();
        (low, high.max(low + 1.0))
    };
    let (left, right) = span(&mut edges.iter().copied());
    let (low, high) = span(&mut times.iter().flatten().copied());
    let x = |edge: f64| margin + (edge.log10() - left) / (right - left) * (width - 2.0 * margin);
    let y =
        |time: f64| height - margin - (time.log10() - low) / (high - low) * (height - 2.0 * margin);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n"
    );
    for decade in left as i32..=right as i32 {
        let at = x(10_f64.powi(decade));
        svg += &format!(
            "<path d=\"M{at:.1} {margin}V{:.1}\" stroke=\"#ddd\"/><text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\n",
            height - margin,
            height - margin + 18.0,
            10_f64.powi(decade)
        );
    }
    for decade in low as i32..=high as i32 {
        let at = y(10_f64.powi(decade));
        svg += &format!(
            "<path d=\"M{margin} {at:.1}H{:.1}\" stroke=\"#ddd\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\n",
            width - margin,
            margin - 6.0,
            at + 4.0,
            10_f64.powi(decade)
        );
    }
    for (who, (name, colour)) in [("mip-lobes", "#c33"), ("plain sum of lobes", "#36c")]
        .into_iter()
        .enumerate()
    {
        let points: Vec<String> = edges
            .iter()
            .zip(times)
            .map(|(&edge, time)| format!("{:.1},{:.1}", x(edge), y(time[who])))
            .collect();
        svg += &format!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" fill=\"{colour}\">{name}</text>\n",
            points.join(" "),
            margin + 12.0,
            margin + 16.0 * (who as f64 + 1.0)
        );
    }
    svg += &format!(
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">edge of the footprint, texels</text>\n\
         <text x=\"14\" y=\"{:.1}\" transform=\"rotate(-90 14 {:.1})\" text-anchor=\"middle\">µs a query</text>\n</svg>\n",
        width / 2.0,
        height - 14.0,
        height / 2.0,
        height / 2.0
    );
    svg
}

fn options() -> Result<Options, Box<dyn Error>> {
    let mut options = Options {
        target: 1024,
        roughness: 0.005,
        maps: ["leather", "scratches", "brushed", "waves"]
            .map(str::to_owned)
            .to_vec(),
        clusters: vec![16, 32, 64],
        edges: vec![2.0, 5.0, 10.0, 30.0, 100.0, 300.0],
        long: 1.0,
        plot: None,
    };
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        if argument == "--bench" {
            continue;
        }
        let value = arguments
            .next()
            .ok_or_else(|| format!("{argument} needs a value"))?;
        let list = || value.split(',');
        match argument.as_str() {
            "--target" => options.target = value.parse()?,
            "--rough" => options.roughness = value.parse()?,
            "--long" => options.long = value.parse()?,
            "--edges" => options.edges = list().map(str::parse).collect::<Result<_, _>>()?,
            "--clusters" => options.clusters = list().map(str::parse).collect::<Result<_, _>>()?,
            "--maps" => options.maps = list().map(str::to_owned).collect(),
            "--plot" => options.plot = Some(value),
            _ => return Err(format!("{argument}: no such option").into()),
        }
    }
    Ok(options)
}
