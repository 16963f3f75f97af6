//! How far lobes spread, rounded up.

use glintbake_format::records::LobeSpreads;
use zerocopy::little_endian::F32;

/// The record of children whose lobes spread at most `spreads`.
pub(super) fn encode(spreads: &[f64; 16]) -> LobeSpreads {
    let most = spreads.iter().copied().fold(0.0, f64::max);
    let mut step = (most / 255.0) as f32;
    while 255.0 * f64::from(step) < most {
        step = step.next_up();
    }
    let mut greatest = [0; 16];
    for (byte, &spread) in greatest.iter_mut().zip(spreads) {
        while f64::from(*byte) * f64::from(step) < spread {
            let units = (spread / f64::from(step)).ceil().clamp(1.0, 255.0) as u8;
            *byte = units.max(*byte + 1);
        }
    }
    LobeSpreads {
        step: F32::new(step),
        greatest,
    }
}

/// The greatest of a node's spreads.
pub(super) fn greatest(spreads: &LobeSpreads) -> f64 {
    let most = spreads.greatest.iter().copied().max().unwrap_or(0);
    f64::from(most) * f64::from(spreads.step.get())
}
