//! Asking any bytes everything there is to ask: what fuzzing runs, and the suite on the stable toolchain.
//!
//! Bounded in time: every query visits a bounded number of texels, footprints stay within a few tiles, and of a package
//! of many instances the first few are asked.

use crate::exercise_material;
use crate::lies::reseal;
use crate::tolerances::{WEIGHT, WEIGHT_SUM};
use glintbake_format::check;
use glintbake_format::model::{Filter, Footprint, HalfVector, Kernel, Neighbourhood};
use glintbake_format::records::InverseKind;
use glintbake_runtime::microfacet::{brdf, fresnel::Fresnel};
use glintbake_runtime::ndf::Lookup;
use glintbake_runtime::{
    Accuracy, Analytic, ClusterTree, FlakeBins, Lobes, MipLobes, Ndf, NdfMaps, Package, QueryError,
    Setting, SurfaceNdf, TriangleForm,
};

/// Instances of one package that are asked.
const MOST_INSTANCES: usize = 8;

/// Asks `bytes` as they are or, if they do not open, with header and checksums made right, which no fuzzer would guess.
/// Nothing but verification sees the checksums of bytes that open.
///
/// # Panics
/// If an answer is not what any bytes must give: see [`interrogate`].
pub fn exercise(bytes: &[u8]) {
    if Package::open(bytes).is_ok() {
        interrogate(bytes);
        return;
    }
    let mut sealed = bytes.to_vec();
    if reseal(&mut sealed) {
        interrogate(&sealed);
    }
}

/// Opens `bytes`, verifies them, and asks every instance by each method, setting and way to look up: a number that is
/// finite and not negative, or the error the question deserves.
///
/// Of a package in which verification finds no fault of structure more is asked: no query may call it damaged, and all
/// ways to look up must agree.
///
/// # Panics
/// If an answer is none of these.
pub fn interrogate(bytes: &[u8]) {
    let Ok(package) = Package::open(bytes) else {
        return;
    };
    let (mut in_structure, mut in_all) = (0, 0);
    check::structure(package.container(), &mut |_| in_structure += 1);
    check::full(package.container(), &mut |_| in_all += 1);
    assert!(in_all >= in_structure, "the full check is the wider one");
    let is_sound = in_structure == 0;
    exercise_material::interrogate(package.container(), is_sound);
    for instance in package.instances().take(MOST_INSTANCES) {
        let size = [instance.width, instance.height];
        match package.ndf(instance.number) {
            Ok(ndf) => {
                shade(&ndf, size);
                for ndf in variants(ndf) {
                    ask(&ndf, size, is_sound);
                }
                if let SurfaceNdf::FlakeBins(ndf) = ndf {
                    compare_lookups(&ndf.with_filter(Filter::Box), size, is_sound);
                    let gaussian = ndf.with_filter(Filter::Gaussian).with_tolerance(0.0);
                    compare_lookups(&gaussian, size, is_sound);
                }
            }
            Err(error) => assert!(is_excused(error, is_sound), "{error}"),
        }
    }
}

/// Evaluates the BRDF, which looks masking up, once from above and once at a grazing angle.
fn shade(ndf: &SurfaceNdf<'_>, size: [u32; 2]) {
    let footprint = Footprint::square([0.3, 0.6], 3.0, size[0], size[1]);
    for light in [[0.0, 0.6, 0.8], [0.8, -0.6, 1e-3]] {
        let view = [0.0, 0.0, 1.0];
        if let Ok(f) = brdf::eval(ndf, &footprint, light, view, Fresnel::Perfect) {
            assert!(f.is_finite() && f >= 0.0, "{f}");
        }
    }
}

/// `ndf` by every setting it has and every way to look up, under boxes and Gaussians.
fn variants(ndf: SurfaceNdf<'_>) -> Vec<SurfaceNdf<'_>> {
    match ndf.with_filter(Filter::Gaussian) {
        SurfaceNdf::Lobes(ndf) => return of_lobes(ndf),
        SurfaceNdf::Analytic(ndf) => return of_surface(ndf),
        SurfaceNdf::MipLobes(ndf) => return of_levels(ndf),
        SurfaceNdf::NdfMaps(ndf) => return of_images(ndf),
        _ => {}
    }
    let mut variants = vec![ndf];
    let settings = [
        Setting::Binned(Neighbourhood::Bins21),
        Setting::Binned(Neighbourhood::Bins45),
        Setting::Exact,
    ];
    for setting in settings {
        match ndf.with_setting(setting) {
            Ok(other) if setting != Setting::default() => variants.push(other),
            Ok(_) | Err(QueryError::SettingUnsupported(_) | QueryError::NotBaked { .. }) => {}
            Err(error) => panic!("{error}"),
        }
    }
    if let SurfaceNdf::FlakeBins(ndf) = ndf
        && inverse_of(&ndf) != InverseKind::None
    {
        let forced = [Lookup::Lists, Lookup::Scan];
        variants.extend(forced.map(|lookup| SurfaceNdf::FlakeBins(ndf.with_lookup(lookup))));
    }
    if let SurfaceNdf::ClusterTree(ndf) = ndf {
        variants.extend(of_tree(ndf));
    }
    let gaussian = ndf.with_filter(Filter::Gaussian);
    variants.extend([gaussian, gaussian.with_tolerance(0.0)]);
    variants.extend(gaussian.with_setting(Setting::Exact));
    variants
}

/// `ndf` for needles and for blunt flakes, by the other kernel, and with next to nothing skipped.
fn of_tree(ndf: ClusterTree<'_>) -> impl Iterator<Item = SurfaceNdf<'_>> {
    let [needle, blunt] = ClusterTree::ROUGHNESS;
    let settings = [
        (needle, Kernel::Disk, Filter::Box, Accuracy::DEFAULT),
        (blunt, Kernel::Beckmann, Filter::Gaussian, Accuracy::DEFAULT),
        (0.1, Kernel::Disk, Filter::Gaussian, 1e-9),
    ];
    settings
        .into_iter()
        .map(move |(alpha, kernel, filter, eps)| {
            let ndf = ndf.with_kernel(kernel);
            let ndf = ndf.and_then(|ndf| ndf.with_roughness(alpha));
            let ndf = ndf.expect("what every tree answers for");
            let accuracy = Accuracy::Fast(eps);
            SurfaceNdf::ClusterTree(ndf.with_filter(filter).with_accuracy(accuracy))
        })
}

/// Lobes under Gaussians, for needles and for blunt kernels, and by the papers' plain sum.
fn of_lobes(ndf: Lobes<'_>) -> Vec<SurfaceNdf<'_>> {
    let rough = [1e-5, 2.0].map(|alpha| ndf.with_roughness(alpha).expect("in range"));
    let [needle, blunt] = rough.map(SurfaceNdf::Lobes);
    let raw = SurfaceNdf::Lobes(ndf.with_raw_sum(true));
    vec![SurfaceNdf::Lobes(ndf), needle, blunt, raw]
}

/// Surfaces under Gaussians, for blunt kernels, and by the paper's quadratics.
fn of_surface(ndf: Analytic<'_>) -> Vec<SurfaceNdf<'_>> {
    let blunt = ndf.with_roughness(2.0).expect("in range");
    let paper = ndf.with_form(TriangleForm::Paper);
    [ndf, blunt, paper].map(SurfaceNdf::Analytic).into()
}

/// Clustered lobes under Gaussians, for needles, by the paper's levels, and by levels far below and above.
fn of_levels(ndf: MipLobes<'_>) -> Vec<SurfaceNdf<'_>> {
    let needle = ndf.with_roughness(1e-5).expect("in range");
    let moved = [-64.0, 2.5].map(|bias| ndf.with_level_bias(bias).expect("finite"));
    let [below, above] = moved;
    [ndf, needle, ndf.with_levels_by_area(true), below, above]
        .map(SurfaceNdf::MipLobes)
        .into()
}

/// Images under boxes, with tiles divided where it matters, and nowhere.
fn of_images(ndf: NdfMaps<'_>) -> Vec<SurfaceNdf<'_>> {
    let boxes = ndf.with_filter(Filter::Box);
    let undivided = boxes.with_tolerance(1e6).expect("in range");
    [boxes, undivided].map(SurfaceNdf::NdfMaps).into()
}

/// What finds the texels of a bin of `ndf`.
fn inverse_of(ndf: &FlakeBins<'_>) -> InverseKind {
    let bins = ndf.instance().bins();
    bins.map_or(InverseKind::None, |bins| bins.inverse)
}

/// Whether `error` may answer a question that is in order.
fn is_excused(error: QueryError, is_sound: bool) -> bool {
    match error {
        QueryError::Damaged(_) => !is_sound,
        QueryError::TooManyTexels { .. } => true,
        _ => false,
    }
}

/// Footprints that must be answered, on a map of `size` texels.
fn footprints(size: [u32; 2]) -> [Footprint; 9] {
    let texel = size.map(|side| 1.0 / f64::from(side));
    let texels = |centre, first: [f64; 2], second: [f64; 2]| Footprint {
        centre,
        edge_1: [first[0] * texel[0], first[1] * texel[1]],
        edge_2: [second[0] * texel[0], second[1] * texel[1]],
    };
    [
        // A point, on a corner of texels; segments, one of them along a row; thinner than rounding.
        texels([0.5, 0.5], [0.0; 2], [0.0; 2]),
        texels([0.3, 0.6], [2.0, 1.0], [-4.0, -2.0]),
        texels([0.0, 1.0], [5.5, 0.0], [0.0; 2]),
        texels([0.7, 0.2], [9.0, 4.0], [1e-6, 3e-6]),
        // Within a texel, a few texels, a few texels on the other side of the world.
        texels([0.41, 0.77], [1e-3, 2e-4], [-3e-4, 8e-4]),
        texels([0.1, 0.9], [3.1, 0.7], [-0.4, 2.3]),
        texels([-1e6 + 0.3, 1e6 + 0.1], [2.0, -1.0], [1.0, 2.0]),
        // Half a tile, several tiles.
        Footprint {
            centre: [0.5, 0.4],
            edge_1: [0.6, 0.2],
            edge_2: [-0.1, 0.7],
        },
        Footprint {
            centre: [-7.2, 3.9],
            edge_1: [1.7, 0.4],
            edge_2: [-0.3, 1.2],
        },
    ]
}

/// Footprints that must be refused, and how.
fn refused_footprints() -> [(Footprint, QueryError); 3] {
    let with = |centre, edge_2| Footprint {
        centre,
        edge_1: [0.1, 0.0],
        edge_2,
    };
    [
        (with([f64::NAN, 0.0], [0.0, 0.1]), QueryError::NotFinite),
        (with([0.0; 2], [f64::INFINITY, 0.1]), QueryError::NotFinite),
        (with([0.0; 2], [0.0, -300.0]), QueryError::FootprintTooLarge),
    ]
}

/// Half vectors: at the pole, between, on the rim, outside the disk.
const HALF_VECTORS: [HalfVector; 4] = [
    HalfVector { s: 0.0, t: 0.0 },
    HalfVector { s: 0.13, t: -0.21 },
    HalfVector { s: -0.6, t: 0.8 },
    HalfVector { s: 0.9, t: 0.9 },
];

/// Evaluates, samples and asks for the pdf.
fn ask(ndf: &SurfaceNdf<'_>, size: [u32; 2], is_sound: bool) {
    let check = |footprint: &Footprint, h: HalfVector, answer: Result<f64, QueryError>| match answer
    {
        Ok(value) => assert!(
            value.is_finite() && value >= 0.0,
            "{:?}, {footprint:?}, {h:?}: {value}",
            ndf.instance()
        ),
        Err(error) => assert!(is_excused(error, is_sound), "{error}"),
    };
    for (number, footprint) in footprints(size).iter().enumerate() {
        // A number for each footprint, in place of chance.
        let share = (number as f64 + 0.5) / 9.0;
        let drawn = match ndf.sample(footprint, [share, 1.0 - share, 0.3, share]) {
            Ok(drawn) => drawn,
            Err(error) => {
                assert!(is_excused(error, is_sound), "{error}");
                None
            }
        };
        if let Some(h) = drawn {
            assert!(h.s.is_finite() && h.t.is_finite(), "{h:?}");
        }
        let given = HALF_VECTORS[number % HALF_VECTORS.len()];
        for h in drawn.into_iter().chain([given]) {
            check(footprint, h, ndf.eval(footprint, h));
        }
        let h = drawn.unwrap_or(given);
        check(footprint, h, ndf.pdf(footprint, h));
        if let SurfaceNdf::ClusterTree(tree) = ndf
            && tree.kernel() == Kernel::Disk
            && number % 4 == 1
        {
            let strict = tree.with_accuracy(Accuracy::Strict(0.5));
            let bounded = strict.eval_bounded(footprint, h);
            check(footprint, h, bounded.map(|bounded| bounded.density));
            // It says nothing of a tree that lies, but a bound it is.
            check(footprint, h, bounded.map(|bounded| bounded.bound));
        }
    }
    let [h, ..] = HALF_VECTORS;
    for (footprint, error) in refused_footprints() {
        assert_eq!(ndf.eval(&footprint, h), Err(error));
        assert_eq!(ndf.pdf(&footprint, h), Err(error));
        assert_eq!(ndf.sample(&footprint, [0.5; 4]), Err(error));
    }
    let [footprint, ..] = footprints(size);
    let nowhere = HalfVector {
        s: 0.1,
        t: f64::NAN,
    };
    assert_eq!(
        ndf.eval(&footprint, nowhere),
        Err(QueryError::NotFinite),
        "a half vector is checked like a footprint"
    );
}

/// Asks for bin weights by each way to look up.
fn compare_lookups(ndf: &FlakeBins<'_>, size: [u32; 2], is_sound: bool) {
    for (number, footprint) in footprints(size).iter().enumerate() {
        let h = match ndf.sample(footprint, [0.4, 0.6, 0.0, 0.0]) {
            Ok(Some(drawn)) => drawn,
            _ => HALF_VECTORS[number % HALF_VECTORS.len()],
        };
        // A bin map alone has no lists to look up.
        let lists = match inverse_of(ndf) {
            InverseKind::None => Lookup::Auto,
            InverseKind::Forest | InverseKind::Tiles => Lookup::Lists,
        };
        let ways = [Lookup::Auto, lists, Lookup::Scan].map(|lookup| {
            let mut weights = Vec::new();
            ndf.with_lookup(lookup)
                .bin_weights(
                    footprint,
                    h,
                    Neighbourhood::Bins45,
                    &mut |column, row, weight| {
                        assert!(
                            weight.is_finite() && weight >= 0.0,
                            "{lookup:?} of {:?}, {footprint:?}, {h:?}: {weight}",
                            ndf.instance()
                        );
                        weights.push(((column, row), weight));
                    },
                )
                .map(|()| weights)
        });
        let mut answered = Vec::new();
        for way in ways {
            match way {
                Ok(weights) => answered.push(weights),
                Err(error) => assert!(is_excused(error, is_sound), "{error}"),
            }
        }
        let [first, others @ ..] = &*answered else {
            continue;
        };
        if !is_sound {
            continue;
        }
        // What a Gaussian's ellipse cuts off is given back to what is left.
        let most = match ndf.filter() {
            Filter::Box => WEIGHT_SUM,
            Filter::Gaussian => 1e-5 + WEIGHT_SUM,
        };
        let sum: f64 = first.iter().map(|(_, weight)| weight).sum();
        assert!(
            sum <= 1.0 + most,
            "weights of {footprint:?} add up to {sum}"
        );
        for other in others {
            for (these, those) in [(first, other), (other, first)] {
                for (bin, weight) in these {
                    let elsewhere = those.iter().find(|(other, _)| other == bin);
                    let other = elsewhere.map_or(0.0, |(_, weight)| *weight);
                    assert!(
                        (weight - other).abs() <= WEIGHT,
                        "bin {bin:?} of {footprint:?}: {weight} or {other}"
                    );
                }
            }
        }
    }
}
