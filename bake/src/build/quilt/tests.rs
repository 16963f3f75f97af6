use super::cuts::cheapest;
use super::expand::expand;
use super::texels::difference;
use super::*;
use glintbake_format::model::Wrap;

fn noise(width: u32, height: u32, wrap: Wrap, seed: u64) -> NormalMap {
    let mut numbers = Numbers::new(seed);
    let texels = (0..width * height)
        .map(|_| [0, 1].map(|_| (0.8 * numbers.uniform() - 0.4) as f32))
        .collect();
    NormalMap::new(width, height, wrap, texels)
}

/// A wave that repeats every `period` texels along both axes.
fn wave(side: u32, period: u32) -> NormalMap {
    let texels = (0..side * side)
        .map(|place| {
            let angle = |x: u32| f64::from(x % period) / f64::from(period) * core::f64::consts::TAU;
            let (x, y) = (angle(place % side), angle(place / side));
            [(0.3 * libm::sin(x)) as f32, (0.3 * libm::cos(y)) as f32]
        })
        .collect();
    NormalMap::new(side, side, Wrap::Repeat, texels)
}

fn options(layout: QuiltLayout, tolerance: f64, seed: u64) -> QuiltOptions {
    QuiltOptions {
        layout,
        alpha: 0.9,
        tolerance,
        seed,
    }
}

/// A quilt of 4 × 3 patches of 16 texels.
fn layout(sample: &NormalMap, overlap: u8, grid_log: u8) -> QuiltLayout {
    let size = [sample.width(), sample.height()];
    QuiltLayout::new([64, 48], size, 4, overlap, grid_log).expect("the sample is large enough")
}

#[test]
fn cuts_are_the_cheapest_of_all() {
    let mut numbers = Numbers::new(5);
    for _ in 0..40 {
        let (length, overlap) = (5, 3);
        let costs: Vec<f64> = (0..length * overlap).map(|_| numbers.uniform()).collect();
        let at = |line: u32, place: u32| costs[(line * overlap + place) as usize];
        let seam = |line: u32, cut: u32| match cut {
            0 => at(line, 0),
            3 => at(line, 2),
            _ => 0.5 * (at(line, cut - 1) + at(line, cut)),
        };
        let (cuts, mean) = cheapest(length, overlap, at);
        let sum =
            |cuts: &[u32]| -> f64 { (0..).zip(cuts).map(|(line, &cut)| seam(line, cut)).sum() };
        let found: Vec<u32> = cuts.iter().map(|&cut| u32::from(cut)).collect();
        assert!(found.windows(2).all(|pair| pair[0].abs_diff(pair[1]) <= 1));
        assert!((sum(&found) / 5.0 - mean).abs() < 1e-12);
        for code in 0..4_u32.pow(5) {
            let other: Vec<u32> = (0..5).map(|line| code / 4_u32.pow(line) % 4).collect();
            let is_way = other.windows(2).all(|pair| pair[0].abs_diff(pair[1]) <= 1);
            assert!(
                !is_way || sum(&other) >= sum(&found) - 1e-12,
                "{other:?} {found:?}"
            );
        }
    }
}

#[test]
fn differences_of_blocks_are_those_of_their_texels() {
    let sample = noise(32, 24, Wrap::Repeat, 3);
    let layout = layout(&sample, 3, 3);
    let texels = Texels::new(&sample, 0.9);
    let origins = candidates(&sample, &layout);
    assert_eq!(origins.len(), 12);
    let overlaps = Overlaps::new(&texels, &layout, &origins);
    for (a, &first) in origins.iter().enumerate() {
        for (b, &second) in origins.iter().enumerate() {
            let (mut beside, mut below) = (0.0, 0.0);
            for along in 0..19 {
                for across in 0..3 {
                    beside += difference(
                        texels.at(first, [16 + across, along]),
                        texels.at(second, [across, along]),
                    );
                    below += difference(
                        texels.at(first, [along, 16 + across]),
                        texels.at(second, [along, across]),
                    );
                }
            }
            let near = |found: f32, sum: f64| (f64::from(found) - sum / 57.0).abs() < 1e-5;
            assert!(near(overlaps.beside(a, b), beside));
            assert!(near(overlaps.below(a, b), below));
        }
    }
}

#[test]
fn what_repeats_on_the_grid_is_quilted_without_a_seam() {
    let sample = wave(64, 8);
    let layout = layout(&sample, 2, 3);
    let quilt = build(&sample, &options(layout, 1e-6, 1));
    assert_eq!(quilt.forced, 0);
    assert!(quilt.mean_error < 1e-9, "{}", quilt.mean_error);
    let surface = expand(&sample, &layout, &quilt.origins, &quilt.cuts);
    for (place, texel) in (0..).zip(surface.texels()) {
        let (x, y) = (place % 64, place / 64);
        assert_eq!(*texel, sample.texels()[(y * 64 + x) as usize], "({x}, {y})");
    }
}

#[test]
fn texels_are_of_their_own_block_or_of_one_before_it() {
    let sample = noise(40, 40, Wrap::Clamp, 9);
    let layout = layout(&sample, 4, 3);
    let quilt = build(&sample, &options(layout, 0.5, 2));
    let surface = expand(&sample, &layout, &quilt.origins, &quilt.cuts);
    let mut moved = 0;
    for y in 0..48_u32 {
        for x in 0..64_u32 {
            let of_block = |left: u32, up: u32| {
                let (column, row) = ((x / 16 + 4 - left) % 4, (y / 16 + 3 - up) % 3);
                let [i, j] = quilt.origins[(row * 4 + column) as usize].map(u32::from);
                let (i, j) = (i + x % 16 + 16 * left, j + y % 16 + 16 * up);
                (i < 40 && j < 40).then(|| sample.texels()[(j * 40 + i) as usize])
            };
            let texel = surface.texels()[(y * 64 + x) as usize];
            let own = of_block(0, 0) == Some(texel);
            let others = [(1, 0), (0, 1), (1, 1)];
            let is_shared = x % 16 < 4 || y % 16 < 4;
            let from = |&(left, up): &(u32, u32)| of_block(left, up) == Some(texel);
            assert!(own || (is_shared && others.iter().any(from)), "({x}, {y})");
            moved += u32::from(!own);
        }
    }
    assert!(moved > 100, "cuts lie within what is shared: {moved}");
}

#[test]
fn chance_depends_on_the_seed_and_on_nothing_else() {
    let sample = noise(64, 64, Wrap::Repeat, 4);
    let layout = layout(&sample, 2, 3);
    let with = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads can be had")
            .install(|| build(&sample, &options(layout, 10.0, seed)))
    };
    assert_eq!(with(1, 7), with(3, 7));
    assert_ne!(with(1, 7).origins, with(1, 8).origins);
}

#[test]
fn the_surface_goes_on_across_its_border_as_well_as_within() {
    let sample = noise(64, 64, Wrap::Repeat, 6);
    let layout = layout(&sample, 4, 3);
    let quilt = build(&sample, &options(layout, 0.0, 3));
    assert_eq!(quilt.forced, 12, "all are the least bad");
    let texels = Texels::new(&sample, 0.9);
    let (_, mean) = cuts::cut(&texels, &layout, &quilt.origins);
    let unit = texels.mean_difference(3);
    // Chosen for the border as well: seams there differ as much as elsewhere, about, and less than texels anywhere.
    let seam = |column: usize| {
        let mut sum = 0.0;
        for row in 0..3 {
            let own = quilt.origins[row * 4 + column].map(u32::from);
            let left = quilt.origins[row * 4 + (column + 3) % 4].map(u32::from);
            let (_, mean) = cheapest(16, 4, |y, x| {
                difference(texels.at(left, [16 + x, y]), texels.at(own, [x, y]))
            });
            sum += mean / 3.0;
        }
        sum
    };
    assert!(mean < 0.8 * unit, "{mean} {unit}");
    assert!(seam(0) < 1.5 * seam(1).max(seam(2)), "{}", seam(0));
}

#[test]
fn one_normal_makes_one_normal() {
    let sample = NormalMap::new(24, 24, Wrap::Repeat, vec![[0.25, -0.5]; 576]);
    let layout = layout(&sample, 2, 3);
    let quilt = build(&sample, &options(layout, 0.0, 0));
    assert_eq!((quilt.forced, quilt.mean_error), (0, 0.0));
    let surface = expand(&sample, &layout, &quilt.origins, &quilt.cuts);
    assert!(surface.texels().iter().all(|texel| *texel == [0.25, -0.5]));
}

#[test]
fn neighbours_are_not_copies_of_each_other() {
    let sample = wave(64, 64);
    let layout = layout(&sample, 2, 3);
    let quilt = build(&sample, &options(layout, 0.2, 5));
    for row in 0..3_usize {
        for column in 1..4_usize {
            let [left, own] =
                [column - 1, column].map(|x| quilt.origins[row * 4 + x].map(u32::from));
            assert!(!is_copy(&layout, left, own, [-1, 0]), "{left:?} {own:?}");
        }
    }
}

#[test]
fn samples_of_any_size_are_quilted() {
    let mut numbers = Numbers::new(11);
    for seed in 0..24 {
        let mut side = || 12 + numbers.below(28) as u32;
        let (width, height) = (side(), side());
        let overlap = seed as u8 % 5;
        let wrap = [Wrap::Repeat, Wrap::Clamp][seed as usize / 5 % 2];
        let sample = noise(width, height, wrap, seed);
        let layout = QuiltLayout::new([32, 24], [width, height], 3, overlap, 3).expect("it fits");
        let quilt = build(&sample, &options(layout, 0.3, seed));
        assert_eq!(quilt.origins.len(), 12);
        assert_eq!(quilt.cuts.len(), 12 * 16);
        assert!(quilt.cuts.iter().all(|&cut| cut <= overlap));
        for origin in &quilt.origins {
            for (&at, side) in origin.iter().zip([width, height]) {
                assert!(u32::from(at) < side && at % 8 == 0, "{origin:?}");
            }
        }
        let surface = expand(&sample, &layout, &quilt.origins, &quilt.cuts);
        assert_eq!((surface.width(), surface.height()), (32, 24));
    }
}
