//! Asking memory for what will be needed.

use core::hint::black_box;

/// Reads the element at `place` of `elements`, if there is one, for nothing but to have its cache line on its way.
///
/// Whoever waits for one line may as well wait for several: reads that nothing depends on overlap, while the branches on
/// what is read do not. The processor's own instruction for this gains too little over it to be worth unsafe code.
#[inline(always)]
pub(crate) fn fetch<T: Copy>(elements: &[T], place: usize) {
    if let Some(element) = elements.get(place) {
        black_box(*element);
    }
}
