//! Vector instructions, chosen at run time for `cluster-tree`, which they speed up 1.5 to 2 times, and for Gaussian footprints of
//! the methods with bins, 1.2 to 2 times from 256 × 256 texels on. With the feature `simd`, the one module with unsafe code.
//!
//! Public for measuring alternatives to this library with the same instructions: whatever is compared with a query should
//! run with the vectors that the query has.
//!
//! There is no second implementation behind it: the same safe code is compiled once for every processor of the target
//! and once more for those with wider vectors, and runs in whichever form the processor has. As neither form fuses or
//! reorders a floating-point operation, both give the same bits.

/// Which instructions a query may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Instructions {
    /// The widest vectors the processor has, with the feature `simd` on x86-64; else as [`Self::Portable`].
    #[default]
    Fastest,
    /// Those that every processor of the target has.
    Portable,
}

impl Instructions {
    /// What queries really use on this processor: `avx2` or `portable`.
    pub fn name(self) -> &'static str {
        match self {
            #[cfg(all(feature = "simd", target_arch = "x86_64"))]
            Self::Fastest if wide::are_available() => "avx2",
            _ => "portable",
        }
    }

    /// Does `work` with these instructions, and returns what it returns.
    ///
    /// Costs a load and a branch besides. The same bits come out with all instructions, as long as `work` calls no function
    /// that asks for the target's features itself.
    #[inline(always)]
    pub fn run<W: Work>(self, work: W) -> W::Output {
        #[cfg(all(feature = "simd", target_arch = "x86_64"))]
        if self == Self::Fastest && wide::are_available() {
            return wide::run(work);
        }
        work.run()
    }
}

/// Asks memory for the line that `item` begins in, without waiting for it.
#[inline(always)]
pub(crate) fn fetch<T>(item: &T) {
    #[cfg(all(feature = "simd", target_arch = "x86_64"))]
    {
        use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        #[expect(unsafe_code, reason = "the instruction takes a pointer")]
        // SAFETY: a hint that reads nothing, faults on no address, and is part of every x86-64.
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(core::ptr::from_ref(item).cast());
        }
    }
    #[cfg(not(all(feature = "simd", target_arch = "x86_64")))]
    let _ = item;
}

/// Something that wider vectors speed up: safe code that [`Instructions::run`] compiles once more for them.
///
/// Only what is inlined into [`run`](Self::run) gets them. So everything hot below it is `#[inline(always)]`, and closures,
/// which cannot be, are avoided. Nothing else needs doing: loops over arrays of lanes are for the compiler to vectorise.
///
/// ```
/// use glintbake_runtime::{Instructions, Work};
///
/// struct Sum<'a>(&'a [i32]);
///
/// impl Work for Sum<'_> {
///     type Output = i32;
///
///     #[inline(always)]
///     fn run(self) -> i32 {
///         let mut sum = 0;
///         for x in self.0 {
///             sum += x;
///         }
///         sum
///     }
/// }
///
/// assert_eq!(Instructions::Fastest.run(Sum(&[1, 2, 3])), 6);
/// ```
pub trait Work {
    /// What comes of it.
    type Output;

    /// Does it. Implementations are `#[inline(always)]`.
    fn run(self) -> Self::Output;
}

#[cfg(all(feature = "simd", target_arch = "x86_64"))]
mod wide {
    use super::Work;

    cpufeatures::new!(features, "avx2", "bmi1", "bmi2", "popcnt");

    /// Whether the processor and the operating system have what [`compiled`] is compiled for. A load after the first call.
    #[inline(always)]
    pub(super) fn are_available() -> bool {
        features::get()
    }

    /// Does `work` with AVX2 and bit manipulation.
    #[inline(always)]
    pub(super) fn run<W: Work>(work: W) -> W::Output {
        assert!(are_available(), "checked by the caller");
        #[expect(
            unsafe_code,
            reason = "a function with more target features than its caller"
        )]
        // SAFETY: the features that `compiled` enables are those just asserted. It takes and returns ordinary values
        // and does nothing but call safe code.
        unsafe {
            compiled(work)
        }
    }

    #[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
    fn compiled<W: Work>(work: W) -> W::Output {
        work.run()
    }
}
