//! Decoders may panic on hostile files; nothing beyond this boundary does.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

thread_local! {
    /// Whether a panic of this thread is expected to be caught by [`catch`].
    static DECODING: Cell<bool> = const { Cell::new(false) };
}

/// Resets the flag also when the decoder unwinds.
struct Decoding;

impl Decoding {
    fn begin() -> Self {
        DECODING.set(true);
        Self
    }
}

impl Drop for Decoding {
    fn drop(&mut self) {
        DECODING.set(false);
    }
}

/// The result of `decode`, or the message of its panic.
///
/// The panic hook is process-wide and prints before anything is caught. So a hook is set once that asks a
/// thread-local flag and otherwise calls the hook it replaced: panics of other threads, and of this thread outside
/// of `decode`, are reported as before. The decoders used here run on the calling thread only.
pub(super) fn catch<T>(decode: impl FnOnce() -> T) -> Result<T, String> {
    static HOOK: Once = Once::new();
    // Exchanging the hook on an unwinding thread would panic itself, and abort.
    if !std::thread::panicking() {
        HOOK.call_once(|| {
            let previous = panic::take_hook();
            panic::set_hook(Box::new(move |info| {
                if !DECODING.get() {
                    previous(info);
                }
            }));
        });
    }
    let decoding = Decoding::begin();
    // Nothing that `decode` borrowed is looked at after it panicked: readers and buffers die with it.
    let result = panic::catch_unwind(AssertUnwindSafe(decode));
    drop(decoding);
    result.map_err(|payload| {
        payload
            .downcast_ref::<&str>()
            .map(ToString::to_string)
            .or_else(|| payload.downcast_ref::<String>().cloned())
            .unwrap_or_else(|| "no message".to_owned())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_its_message_and_later_calls_still_work() {
        assert_eq!(catch(|| 7), Ok(7));
        assert_eq!(
            catch(|| -> u8 { panic!("index {} out of bounds", 9) }),
            Err("index 9 out of bounds".to_owned())
        );
        assert!(
            !DECODING.get(),
            "the flag must be reset after a panic, or later panics go unreported"
        );
        assert_eq!(catch(|| 8), Ok(8));
    }
}
