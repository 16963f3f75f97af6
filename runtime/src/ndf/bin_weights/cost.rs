//! Which way to the weights is the cheaper one.
//!
//! Measured with `cargo bench -p glintbake-tests --bench weights`, 2048² maps at α = 0.01, microseconds a query at
//! edges of 4, 64, 256 and 1024 texels:
//!
//! | map | texels in a window's lists | scan | lists | auto |
//! |---|---|---|---|---|
//! | flakes | 46 000 | 1.0, 13, 90, 550 | 14, 17, 33, 108 | 0.7, 12, 18, 65 |
//! | brushed | 360 000 | 1.1, 16, 77, 740 | 17, 30, 81, 460 | 0.7, 12, 89, 325 |
//! | scratches | 1 700 000 | 1.0, 19, 129, 1200 | 35, 65, 263, 1060 | 1.0, 18, 145, 1670 |
//! | noise | 26 000 | 0.6, 10, 77, 890 | 16, 21, 33, 97 | 0.6, 10, 31, 89 |
//!
//! Two ways break even at 5 000 texels on flakes and at half a million on scratches: a scan costs the same wherever
//! it looks, lists cost more the longer they are.

use super::map_shape;
use crate::overlap::Parallelogram;
use glintbake_format::view::BinTables;

/// Texels under a footprint up to which a scan is always the cheaper way. Well below what it may visit on any map.
const SCAN_BELOW_TEXELS: f64 = 2000.0;
/// Nanoseconds a scan takes for a row of the map, above all waiting for its first texel.
const SCAN_ROW: f64 = 80.0;
/// Nanoseconds a scan takes for a texel.
const SCAN_TEXEL: f64 = 0.6;
/// Nanoseconds to find a list and its root.
const LIST: f64 = 220.0;
/// Nanoseconds to look through a crossing leaf of about 32 texels and the nodes above it, over √32.
const LEAF: f64 = 120.0;
/// Lists of about one length that share the cost of a scan: most of a window's 45.
const SHARING: f64 = 36.0;

/// The longest list that is looked through rather than scanned for, in texels: 0 for small footprints, `u32::MAX` for
/// such as a scan would take long for or refuse.
///
/// A scan pays for rows and for texels, whatever the number of bins. A list pays for the leaves the outline crosses:
/// leaves of a list of `n` of the map's `M` texels are `√(32 M / n)` texels wide, so that an outline of length `p`
/// crosses about `p √(n / 32 M)` of them. The limit is the `n` for which [`SHARING`] lists cost as much as a scan. It
/// depends on the footprint alone: each bin goes its own way, and so has the same weight in whichever window it is
/// found.
pub(super) fn longest_list(tables: &BinTables<'_>, footprint: &Parallelogram) -> u32 {
    let bounds = footprint.bounds();
    let width = bounds.high[0] - bounds.low[0];
    let height = bounds.high[1] - bounds.low[1];
    let texels = footprint.area() + 2.0 * (width + height);
    if texels < SCAN_BELOW_TEXELS {
        return 0;
    }
    let shape = map_shape(tables);
    let map_texels = f64::from(shape.width) * f64::from(shape.height);
    if texels > map_texels {
        // Lists count tiles that lie wholly inside without looking at a texel.
        return u32::MAX;
    }
    let scan = SCAN_ROW * height + SCAN_TEXEL * texels;
    let leaves = (scan / SHARING - LIST).max(0.0) / LEAF;
    let crossed = leaves / (0.5 * (width + height));
    // A float-to-integer cast saturates.
    (crossed * crossed * map_texels) as u32
}
