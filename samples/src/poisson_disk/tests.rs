//! Distance and room by comparing everything with everything.

use super::*;

fn centres(disk: &PoissonDisk) -> Vec<[f64; 2]> {
    let mut centres = Vec::new();
    disk.visit_rows(-1.0..disk.size[1] + 1.0, |centre| {
        // Once each: those of the tile's own cells.
        if (0..disk.counts[1] as i64).contains(&centre.cell[1]) {
            centres.push(centre.position);
        }
    });
    centres
}

/// The distance from `a` to the nearest copy of `b`.
fn distance(size: [u32; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let [dx, dy] = [0, 1].map(|axis| {
        let side = f64::from(size[axis]);
        let offset = (a[axis] - b[axis]).rem_euclid(side);
        offset.min(side - offset)
    });
    dx.hypot(dy)
}

#[test]
fn centres_keep_their_distance_and_leave_no_room() {
    for (size, radius) in [
        ([90, 70], 4.7),
        ([61, 64], 7.3),
        ([64, 64], 1.7),
        ([1, 300], 4.7),
        ([300, 3], 2.2),
        ([7, 90], 5.0),
        ([31, 33], 30.0),
    ] {
        let disk = PoissonDisk::new(3, size, radius);
        let centres = centres(&disk);
        for (i, &a) in centres.iter().enumerate() {
            for &b in &centres[..i] {
                let apart = distance(size, a, b);
                assert!(apart >= radius - 1e-9, "{size:?}: {apart} < {radius}");
            }
        }
        for i in 0..16 * size[0] * size[1] {
            let point = [i % (4 * size[0]), i / (4 * size[0])].map(|k| f64::from(k) / 4.0);
            let near = |&centre: &[f64; 2]| distance(size, point, centre) <= radius * REACH;
            assert!(centres.iter().any(near), "{size:?}: room at {point:?}");
        }
    }
}

#[test]
fn a_tile_within_the_radius_has_one_centre() {
    for size in [[1, 1], [5, 4], [20, 1]] {
        let disk = PoissonDisk::new(0, size, 300.0);
        assert_eq!(centres(&disk).len(), 1, "{size:?}");
    }
}

#[test]
fn centres_are_as_dense_as_random_sequential_ones() {
    let size = [800, 700];
    let count = centres(&PoissonDisk::new(1, size, 6.0)).len() as f64;
    let covered = count * core::f64::consts::PI * 9.0 / (800.0 * 700.0);
    // Feder 1980: 0.547 when no other fits.
    assert!((covered - 0.547).abs() < 0.01, "{covered}");
}

#[test]
fn centres_are_uniform_over_the_tile_and_its_cells() {
    let size = [900, 800];
    let disk = PoissonDisk::new(7, size, 5.0);
    let centres = centres(&disk);
    for axis in 0..2 {
        for period in [f64::from(size[axis]), disk.cell_size[axis]] {
            let mut shares: Vec<_> = centres
                .iter()
                .map(|centre| (centre[axis] / period).rem_euclid(1.0))
                .collect();
            shares.sort_by(f64::total_cmp);
            let distance = crate::tests::distance_from_uniform(&shares);
            assert!(distance < 1.0, "axis {axis}, {period}: {distance}");
        }
    }
}

#[test]
fn threads_do_not_move_a_centre() {
    let [one, three] = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a pool of a few threads")
            .install(|| centres(&PoissonDisk::new(9, [311, 257], 3.0)))
    });
    assert_eq!(one, three);
}
