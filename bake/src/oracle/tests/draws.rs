//! What oracles draw, against the integral of the pdf they say it has.

use super::super::{analytic, lobes};
use super::{Random, varied_map};
use core::f64::consts::PI;
use glintbake_format::model::{Footprint, HalfVector, Interpolation, LobeLattice, Wrap};

const ALPHA: f64 = 0.5;
const DRAWS: u32 = 20_000;
/// Rings and sectors of the disk, and midpoints of each along either.
const CELLS: [usize; 2] = [4, 6];
const MIDPOINTS: usize = 5;

/// Draws are counted in cells of equal area of the disk, and beyond the rim; each count may be off by 4.5 standard deviations,
/// which one of all 25 exceeds once in five thousand runs of other seeds.
fn check(
    draw: impl Fn([f64; 4]) -> Option<HalfVector>,
    pdf: impl Fn(HalfVector) -> f64,
    what: &str,
) {
    let [rings, sectors] = CELLS;
    let mut counts = vec![0_u32; rings * sectors + 1];
    let mut random = Random(3);
    for _ in 0..DRAWS {
        let drawn = draw(core::array::from_fn(|_| random.unit()));
        let cell = drawn.map_or(rings * sectors, |h| {
            let turn = (libm::atan2(h.t, h.s) / (2.0 * PI)).rem_euclid(1.0);
            let ring = ((h.s * h.s + h.t * h.t) * rings as f64) as usize;
            let sector = (turn * sectors as f64) as usize;
            ring.min(rings - 1) * sectors + sector.min(sectors - 1)
        });
        counts[cell] += 1;
    }
    let fine = CELLS.map(|count| count * MIDPOINTS);
    let mut masses = vec![0.0; rings * sectors];
    for ring in 0..fine[0] {
        for sector in 0..fine[1] {
            let radius = libm::sqrt((ring as f64 + 0.5) / fine[0] as f64);
            let (sine, cosine) = libm::sincos(2.0 * PI * (sector as f64 + 0.5) / fine[1] as f64);
            let h = HalfVector {
                s: radius * cosine,
                t: radius * sine,
            };
            // Solid angle is area of the disk over the height of the sphere.
            let height = libm::sqrt(1.0 - radius * radius);
            let angle = PI / ((fine[0] * fine[1]) as f64 * height);
            masses[ring / MIDPOINTS * sectors + sector / MIDPOINTS] += pdf(h) * angle;
        }
    }
    masses.push(1.0 - masses.iter().sum::<f64>());
    assert!(masses[rings * sectors] > 0.01, "{what}: nothing is lost");
    for (cell, (&count, mass)) in counts.iter().zip(masses).enumerate() {
        let expected = mass * f64::from(DRAWS);
        let deviation = libm::sqrt(expected * (1.0 - mass));
        // Midpoints miss at most a few thousandths of the largest cells.
        let off = (f64::from(count) - expected).abs() - 5e-3 * expected;
        assert!(
            off < 4.5 * deviation,
            "{what}, cell {cell}: {count}, not {expected}"
        );
    }
}

#[test]
fn draws_are_those_of_the_pdf() {
    for wrap in [Wrap::Repeat, Wrap::Clamp] {
        let map = varied_map(5, 4, wrap);
        let footprint = Footprint {
            centre: [0.1, 0.95],
            edge_1: [0.5, 0.2],
            edge_2: [-0.1, 0.3],
        };
        for (curved, per_side) in [(true, 1), (false, 2)] {
            let lattice = LobeLattice { curved, per_side };
            let raw = lobes::Prepared::new(&map, &footprint, lattice, false);
            let whole = lobes::Prepared::new(&map, &footprint, lattice, true);
            check(
                |uniform| raw.draw(ALPHA, uniform),
                |h| whole.pdf(h, ALPHA),
                &format!("{lattice:?} {wrap:?}"),
            );
        }
        for &interpolation in Interpolation::ALL {
            let surface = analytic::Prepared::new(&map, &footprint, interpolation);
            check(
                |uniform| surface.draw(ALPHA, uniform),
                |h| surface.pdf(h, ALPHA),
                &format!("{interpolation:?} {wrap:?}"),
            );
        }
    }
}
