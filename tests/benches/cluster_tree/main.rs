//! `cluster-tree` against the paper's own structure and a vectorised exact scan, in one run.
//!
//! `cargo bench -p glintbake-tests --bench cluster_tree`; after `--` any of: names of maps, `--maps DIR` (PNG files besides the
//! samples), `--size 1024` (of the samples), `--sigmas 1,16` (sizes σ of footprints in texels), `--rough 0.005,0.08` (σr),
//! `--shape square|8:1`, `--halves footprint|uniform`, `--filter box|gaussian`, `--kernel beckmann|disk`, `--queries N`,
//! `--eps E`, `--no-paper`, `--csv FILE`.
//!
//! Maps of 2048²; footprints of area 4σ² at random angles and places; half vectors drawn from the footprint, the normal of a
//! texel under it moved by the kernel, or from the whole disk. Errors are over all queries of a cell: relative L1, the
//! worst as a share of the greatest D of the cell, and what all D add up to. The truth is the scan, whose own distance from
//! sums in double precision is measured along the way and printed.
//!
//! Times are of the cell's first queries, all of them up to σ = 16 and fewer of larger footprints, asked again in each
//! round by everybody in turn. A number is the least over rounds: what the machine does besides only ever adds.

mod options;
mod table;

use glintbake_bake::image::{HashedFile, ReadOptions};
use glintbake_bake::normals::{self, DecodeOptions, NormalMap};
use glintbake_bake::{MethodRecipe, Recipe, bake};
use glintbake_cli::measure::baselines::exact_scan::ExactScan;
use glintbake_cli::measure::baselines::paper_forest::{
    LEAF_SIZE, PaperForest, PaperLookup, Traversal,
};
use glintbake_cli::measure::machine;
use glintbake_cli::measure::plan::Shape;
use glintbake_cli::measure::stream::Stream;
use glintbake_cli::measure::subject::{self, Patch};
use glintbake_format::model::{
    BinGrid, Binning, Filter, Footprint, HalfVector, Kernel, Method, Neighbourhood, Wrap,
    beckmann_from_intrinsic, disk_grid_resolution,
};
use glintbake_runtime::microfacet::beckmann;
use glintbake_runtime::{Accuracy, ClusterTree, Instructions, Ndf, Package, SurfaceNdf};
use glintbake_samples::{Kind, Options as SampleOptions, generate};
use options::{Halves, Options};
use std::error::Error;
use std::f64::consts::TAU;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;
use table::Row;

/// Name and kind of each sample.
const SAMPLES: [(&str, Kind); 4] = [
    ("flakes", Kind::Flakes),
    ("smooth", Kind::Waves),
    ("scratches", Kind::Scratches),
    ("brushed", Kind::Brushed),
];
const ROUNDS: usize = 7;
/// Texels that the timed footprints of a cell cover together, at most.
const TIMED_TEXELS: f64 = 4e6;
/// Queries that are timed whatever they cover.
const LEAST_TIMED: usize = 24;
/// Queries of a cell that the scan is held to sums in double precision for, up to so large footprints.
const CHECKED: usize = 8;
const MOST_CHECKED_SIGMA: f64 = 16.0;

type Query = (Footprint, HalfVector);

fn main() {
    let options = Options::parse(std::env::args().skip(1)).unwrap_or_else(|message| {
        eprintln!("error: {message}");
        std::process::exit(2);
    });
    if let Err(error) = run(&options) {
        eprintln!("error: {error}");
        std::process::exit(1);
    }
}

fn run(options: &Options) -> Result<(), Box<dyn Error>> {
    println!(
        "{}; vectors: {}; {} queries a cell, {ROUNDS} rounds",
        machine::processor(),
        Instructions::Fastest.name(),
        options.queries
    );
    table::print_head();
    let mut results = Results {
        rows: Vec::new(),
        scan_error: 0.0,
    };
    for (name, kind) in SAMPLES {
        if options.wants(name) {
            contest(name, &sample(kind, options.size)?, options, &mut results)?;
        }
    }
    if let Some(folder) = &options.maps {
        let mut paths: Vec<_> = std::fs::read_dir(folder)?
            .map(|entry| entry.map(|entry| entry.path()))
            .collect::<Result<_, _>>()?;
        paths.retain(|path| path.extension().is_some_and(|extension| extension == "png"));
        paths.sort();
        for path in paths {
            let name = path.file_stem().unwrap_or_default().to_string_lossy();
            if options.wants(&name) {
                contest(&name, &image(&path)?, options, &mut results)?;
            }
        }
    }
    table::summarise(&results.rows);
    println!(
        "the scan against sums in double precision: {:.1e} of a cell's greatest density at most",
        results.scan_error
    );
    if let Some(path) = &options.csv {
        table::write(&results.rows, path)?;
    }
    Ok(())
}

fn sample(kind: Kind, size: u32) -> Result<NormalMap, Box<dyn Error>> {
    let options = SampleOptions {
        seed: 7,
        ..SampleOptions::new(kind, size)
    };
    let sample = generate(kind, &options)?;
    Ok(NormalMap::new(size, size, Wrap::Repeat, sample.normals))
}

fn image(path: &Path) -> Result<NormalMap, Box<dyn Error>> {
    let file = HashedFile::open(path, &())?;
    let (map, _) = normals::read(
        &file,
        &ReadOptions::default(),
        &DecodeOptions::default(),
        &(),
    )?;
    Ok(map)
}

/// What has been measured.
struct Results {
    rows: Vec<Row>,
    /// The scan's worst error found, as a share of its cell's greatest density.
    scan_error: f64,
}

fn contest(
    name: &str,
    map: &NormalMap,
    options: &Options,
    results: &mut Results,
) -> Result<(), Box<dyn Error>> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let recipe = Recipe::new(vec![MethodRecipe {
        masking: false,
        raster_normals: options.raster,
        ..MethodRecipe::new(Method::ClusterTree, &[0.01])
    }]);
    let start = Instant::now();
    let plan = pool.install(|| bake(map, &recipe, None))?;
    let seconds = start.elapsed().as_secs_f64();
    let bytes = plan.to_bytes();
    let scan = ExactScan::new(map);
    let texels = map.texels().len() as f64;
    println!(
        "{name}: {}×{}, {:.2} bytes a texel built in {seconds:.2} s on one thread; the scan has {:.2}",
        map.width(),
        map.height(),
        bytes.len() as f64 / texels,
        scan.bytes() as f64 / texels,
    );
    let package = Package::open(&bytes)?;
    let SurfaceNdf::ClusterTree(ndf) = package.ndf(1)? else {
        unreachable!("baked for cluster-tree");
    };
    for &roughness in &options.roughness {
        let alpha = beckmann_from_intrinsic(roughness);
        let grid = BinGrid::new(Binning::DiskGrid, disk_grid_resolution(alpha));
        let takes_part = options.with_paper
            && options.filter == Filter::Box
            && options.kernel == Kernel::Beckmann;
        let forest = grid
            .filter(|_| takes_part)
            .map(|grid| (PaperForest::new(map, grid, LEAF_SIZE), grid));
        let field = Field {
            name,
            map,
            roughness,
            options,
            tree: ndf
                .with_roughness(alpha)?
                .with_kernel(options.kernel)?
                .with_filter(options.filter)
                .with_accuracy(Accuracy::Fast(options.eps))
                .with_instructions(if options.portable {
                    Instructions::Portable
                } else {
                    Instructions::Fastest
                }),
            scan: &scan,
            forest: forest.as_ref(),
        };
        for &sigma in &options.sigmas {
            let row = field.cell(sigma, &mut results.scan_error)?;
            table::print(&row);
            results.rows.push(row);
        }
    }
    Ok(())
}

/// Who answers on one map, for one roughness.
struct Field<'a> {
    name: &'a str,
    map: &'a NormalMap,
    /// σr.
    roughness: f64,
    options: &'a Options,
    tree: ClusterTree<'a>,
    scan: &'a ExactScan,
    forest: Option<&'a (PaperForest, BinGrid)>,
}

impl Field<'_> {
    fn alpha(&self) -> f64 {
        beckmann_from_intrinsic(self.roughness)
    }

    fn by_tree(&self, (footprint, half_vector): &Query) -> f64 {
        self.tree.eval(footprint, *half_vector).expect("in range")
    }

    fn by_scan(&self, (footprint, half_vector): &Query) -> f64 {
        let Options { filter, kernel, .. } = *self.options;
        let alpha = self.alpha();
        self.scan
            .eval(footprint, *half_vector, filter, kernel, alpha)
    }

    fn cell(&self, sigma: f64, scan_error: &mut f64) -> Result<Row, Box<dyn Error>> {
        let shape = Shape {
            filter: self.options.filter,
            sigma,
            anisotropy: self.options.anisotropy,
        };
        let mut stream = Stream::new(11);
        let queries: Vec<Query> = (0..self.options.queries)
            .map(|_| self.query(shape, &mut stream))
            .collect();
        let most = (TIMED_TEXELS / shape.texels()) as usize;
        let timed = &queries[..queries.len().min(most.max(LEAST_TIMED))];
        let (times, paper) = self.times(timed);

        let tree: Vec<f64> = queries.iter().map(|query| self.by_tree(query)).collect();
        let truth: Vec<f64> = queries.iter().map(|query| self.by_scan(query)).collect();
        let (sum, greatest) = (truth.iter().sum::<f64>(), greatest(&truth));
        let errors = || tree.iter().zip(&truth).map(|(a, b)| a - b);
        let paper_errors = paper.iter().zip(&truth).map(|(a, b)| (a - b).abs());
        if sigma <= MOST_CHECKED_SIGMA && self.options.kernel == Kernel::Beckmann && greatest > 0.0
        {
            for (query, truth) in queries.iter().zip(&truth).take(CHECKED) {
                let error = (self.in_double_precision(query) - truth).abs();
                *scan_error = scan_error.max(error / greatest);
            }
        }
        Ok(Row {
            map: self.name.to_owned(),
            roughness: self.roughness,
            sigma,
            times,
            queries: [queries.len(), timed.len()],
            l1: errors().map(f64::abs).sum::<f64>() / sum,
            worst: errors().map(f64::abs).fold(0.0, f64::max) / greatest,
            energy: errors().sum::<f64>() / sum,
            paper_l1: if paper.is_empty() {
                f64::NAN
            } else {
                paper_errors.sum::<f64>() / truth[..paper.len()].iter().sum::<f64>()
            },
        })
    }

    /// Microseconds a query of tree, paper and scan, and what the paper's structure says.
    fn times(&self, queries: &[Query]) -> ([f64; 3], Vec<f64>) {
        let mut lookup = self
            .forest
            .map(|(forest, _)| PaperLookup::new(forest, Traversal::Together));
        let mut least = [f64::INFINITY; 3];
        let mut answers = Vec::new();
        for round in 0..ROUNDS {
            for turn in 0..3 {
                let who = (turn + round) % 3;
                let start = Instant::now();
                match (who, &mut lookup) {
                    (0, _) => {
                        for query in queries {
                            black_box(self.by_tree(query));
                        }
                    }
                    (1, Some(lookup)) => {
                        answers.clear();
                        for query in queries {
                            answers.push(self.by_paper(lookup, query));
                        }
                    }
                    (2, _) => {
                        for query in queries {
                            black_box(self.by_scan(query));
                        }
                    }
                    _ => continue,
                }
                let microseconds = start.elapsed().as_secs_f64() * 1e6 / queries.len() as f64;
                least[who] = least[who].min(microseconds);
            }
        }
        if lookup.is_none() {
            least[1] = f64::NAN;
        }
        (least, answers)
    }

    /// D by 21 bins.
    fn by_paper(&self, lookup: &mut PaperLookup<'_>, (footprint, h): &Query) -> f64 {
        let Some((_, grid)) = self.forest else {
            return f64::NAN;
        };
        let (direction, alpha) = (h.direction(), self.alpha());
        let mut density = 0.0;
        lookup.bin_weights(
            footprint,
            *h,
            Neighbourhood::Bins21,
            &mut |column, row, weight| {
                density += weight * beckmann::density(direction, grid.centre(column, row), alpha);
            },
        );
        density
    }

    /// D of Beckmann's kernel as the oracle has it.
    fn in_double_precision(&self, (footprint, h): &Query) -> f64 {
        let subject = subject::find(Method::FlakeBins);
        let filter = self.options.filter;
        let patch = Patch::new(self.map, footprint, filter);
        let variant = &subject.variants(filter)[0];
        subject.truth(variant, &patch, self.alpha()).ndf(*h)
    }

    /// A footprint, and a half vector for it.
    fn query(&self, shape: Shape, stream: &mut Stream) -> Query {
        let footprint = shape.footprint(self.map, stream);
        loop {
            let h = match self.options.halves {
                Halves::Footprint => self.half_vector_from(&footprint, stream),
                Halves::Uniform => {
                    let [radius, angle] = stream.uniforms();
                    let (radius, angle) = (f64::sqrt(radius), TAU * angle);
                    HalfVector {
                        s: radius * angle.cos(),
                        t: radius * angle.sin(),
                    }
                }
            };
            if h.is_on_disk() {
                return (footprint, h);
            }
        }
    }

    /// The normal of a texel that the filter chooses, moved by a Gaussian of deviation σr on the disk.
    fn half_vector_from(&self, footprint: &Footprint, stream: &mut Stream) -> HalfVector {
        let place = match self.options.filter {
            Filter::Box => stream.uniforms().map(|x: f64| x - 0.5),
            Filter::Gaussian => normals_of(stream).map(|x| 0.5 * x),
        };
        let index = |axis: usize, size: u32| {
            let x = footprint.centre[axis]
                + place[0] * footprint.edge_1[axis]
                + place[1] * footprint.edge_2[axis];
            ((x - x.floor()) * f64::from(size)) as usize % size as usize
        };
        let row = index(1, self.map.height());
        let texel = row * self.map.width() as usize + index(0, self.map.width());
        let [s, t] = self.map.texels()[texel].map(f64::from);
        let [x, y] = normals_of(stream).map(|x| self.roughness * x);
        HalfVector { s: s + x, t: t + y }
    }
}

/// Two numbers of the standard normal distribution.
fn normals_of(stream: &mut Stream) -> [f64; 2] {
    let [u, v]: [f64; 2] = stream.uniforms();
    // Of a number in (0, 1].
    let (radius, angle) = ((-2.0 * (1.0 - u).ln()).sqrt(), TAU * v);
    [radius * angle.cos(), radius * angle.sin()]
}

fn greatest(numbers: &[f64]) -> f64 {
    numbers.iter().copied().fold(0.0, f64::max)
}
