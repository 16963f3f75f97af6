//! Proof that the runtime needs neither std nor an allocator: it links into a library that has neither.
#![no_std]

use glintbake_runtime::model::{Footprint, HalfVector};
use glintbake_runtime::{Ndf, Package};

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}

/// Opens a package, evaluates, samples and asks for the pdf: everything the query path can reach gets linked.
fn answer(bytes: &[u8]) -> Option<f64> {
    let package = Package::open(bytes).ok()?;
    let ndf = package.ndf(1).ok()?;
    let footprint = Footprint {
        centre: [0.5, 0.5],
        edge_1: [0.1, 0.0],
        edge_2: [0.0, 0.1],
    };
    let drawn = ndf.sample(&footprint, [0.5; 4]).ok()?;
    let half_vector = drawn.unwrap_or(HalfVector { s: 0.0, t: 0.0 });
    let density = ndf.eval(&footprint, half_vector).ok()?;
    Some(density + ndf.pdf(&footprint, half_vector).ok()?)
}

/// The density and pdf of a drawn half vector added up, or -1: a symbol that keeps everything above alive.
#[unsafe(no_mangle)]
pub extern "C" fn glintbake_no_std_proof() -> f64 {
    static PACKAGE: &[u8] = include_bytes!("../../golden/v1/noise-32.glint");
    answer(PACKAGE).unwrap_or(-1.0)
}
