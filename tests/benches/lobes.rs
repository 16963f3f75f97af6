//! `lobes` beside the plain sum over the lobes within four standard deviations of the footprint: bytes, baking, µs a query, error.
//!
//! `cargo bench -p glintbake-tests --bench lobes [-- --size N] [--rough σr] [--maps waves,brushed] [--sigmas 1,16]`
//!
//! Both run in turn, with the same vectors; a time is the least of several rounds. The error is that of a few queries of up to
//! σ = 4 against the oracle's plain sum in f64, and of all queries against the baseline, which leaves out 3e-4.

use core::f64::consts::SQRT_2;
use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle::lobes::Prepared;
use glintbake_bake::{MethodRecipe, Recipe, bake};
use glintbake_cli::measure::baselines::plain_lobes::PlainLobes;
use glintbake_cli::measure::plan::Shape;
use glintbake_cli::measure::stream::Stream;
use glintbake_format::model::{Filter, LobeLattice, Method, Wrap};
use glintbake_runtime::{Lobes, Ndf, Package, SurfaceNdf};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::sample_map;
use glintbake_tests::queries::{Query, lit_query};
use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

/// Rounds of which the fastest counts.
const ROUNDS: usize = 5;
/// Lobes that a cell may visit in one round of the plain sum.
const VISITED: f64 = 2e7;
/// Queries that the oracle checks, and up to which size.
const CHECKED: usize = 20;
const MOST_CHECKED: f64 = 4.0;

struct Options {
    size: u32,
    roughness: Vec<f64>,
    maps: Vec<String>,
    sigmas: Vec<f64>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = options()?;
    println!(
        "map, lobes, σr, σ: µs of lobes / of the plain sum = ratio; L1 beside it, and beside the oracle"
    );
    for name in &options.maps {
        let kind = Kind::from_name(name).ok_or("no such map")?;
        let map = sample_map(kind, options.size, options.size, 7, Wrap::Repeat);
        for curved in [true, false] {
            contest(name, &map, curved, &options)?;
        }
    }
    Ok(())
}

fn contest(
    name: &str,
    map: &NormalMap,
    curved: bool,
    options: &Options,
) -> Result<(), Box<dyn Error>> {
    let lattice = LobeLattice {
        curved,
        per_side: 1,
    };
    let kind = if curved { "curved" } else { "flat" };
    let least = options
        .roughness
        .iter()
        .copied()
        .fold(f64::INFINITY, f64::min);
    let recipe = Recipe::new(vec![MethodRecipe {
        lattice: Some(lattice),
        masking: false,
        ..MethodRecipe::new(Method::Lobes, &[least * SQRT_2])
    }]);
    let start = Instant::now();
    let bytes = bake(map, &recipe, None)?.to_bytes();
    let seconds = start.elapsed().as_secs_f64();
    let texels = f64::from(map.width()) * f64::from(map.height());
    println!(
        "{name}, {kind}: {:.1} MB, {:.2} bytes a lobe, baked in {seconds:.2} s",
        bytes.len() as f64 / 1e6,
        bytes.len() as f64 / texels
    );
    let package = Package::open(&bytes)?;
    let SurfaceNdf::Lobes(ndf) = package.ndf(1)? else {
        return Err("baked for lobes".into());
    };
    let plain = PlainLobes::new(map, curved);
    for &roughness in &options.roughness {
        let ndf = ndf.with_roughness(roughness * SQRT_2)?;
        for &sigma in &options.sigmas {
            cell(
                &format!("{name}, {kind}"),
                map,
                &ndf,
                &plain,
                roughness,
                sigma,
            );
        }
    }
    Ok(())
}

fn cell(
    name: &str,
    map: &NormalMap,
    ndf: &Lobes<'_>,
    plain: &PlainLobes,
    roughness: f64,
    sigma: f64,
) {
    let shape = Shape {
        filter: Filter::Gaussian,
        sigma,
        anisotropy: 1.0,
    };
    let visited = 16.0 * core::f64::consts::PI * (sigma * sigma + 0.2);
    let count = ((VISITED / visited) as usize).clamp(8, 1000);
    let mut stream = Stream::new(11);
    let queries: Vec<Query> = (0..count)
        .map(|_| lit_query(map, shape, roughness, &mut stream))
        .collect();
    let by_lobes = |(footprint, h): &Query| ndf.eval(footprint, *h).expect("in range");
    let by_sum = |(footprint, h): &Query| plain.eval(footprint, *h, roughness);
    let mut least = [f64::INFINITY; 2];
    for round in 0..ROUNDS {
        for turn in 0..2 {
            let who = (turn + round) % 2;
            let start = Instant::now();
            for query in &queries {
                black_box(if who == 0 {
                    by_lobes(query)
                } else {
                    by_sum(query)
                });
            }
            let microseconds = start.elapsed().as_secs_f64() * 1e6 / queries.len() as f64;
            least[who] = least[who].min(microseconds);
        }
    }
    let l1 = |pairs: &mut dyn Iterator<Item = (f64, f64)>| {
        let (off, sum) = pairs.fold((0.0, 0.0), |(off, sum), (found, truth)| {
            (off + (found - truth).abs(), sum + truth)
        });
        off / sum
    };
    let beside = l1(&mut queries.iter().map(|query| (by_lobes(query), by_sum(query))));
    let checked = if sigma <= MOST_CHECKED {
        let pairs = queries.iter().take(CHECKED).map(|query| {
            let (footprint, h) = query;
            let truth = Prepared::new(map, footprint, ndf.lattice(), true);
            (by_lobes(query), truth.ndf(*h, ndf.roughness()))
        });
        format!("{:.1e}", l1(&mut pairs.into_iter()))
    } else {
        "-".to_owned()
    };
    let [own, sum] = least;
    println!(
        "{name}, {roughness}, {sigma}: {own:.2} / {sum:.2} = {:.2}; {beside:.1e}, {checked}",
        sum / own
    );
}

fn options() -> Result<Options, Box<dyn Error>> {
    let mut options = Options {
        size: 2048,
        roughness: vec![0.005],
        maps: vec!["waves".to_owned()],
        sigmas: vec![0.25, 1.0, 4.0, 16.0, 64.0, 256.0],
    };
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        if argument == "--bench" {
            continue;
        }
        let value = arguments
            .next()
            .ok_or_else(|| format!("{argument} needs a value"))?;
        let numbers = || {
            value
                .split(',')
                .map(str::parse)
                .collect::<Result<Vec<f64>, _>>()
        };
        match argument.as_str() {
            "--size" => options.size = value.parse()?,
            "--rough" => options.roughness = numbers()?,
            "--sigmas" => options.sigmas = numbers()?,
            "--maps" => options.maps = value.split(',').map(str::to_owned).collect(),
            _ => return Err(format!("{argument}: no such option").into()),
        }
    }
    Ok(options)
}
