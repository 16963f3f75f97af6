//! Any bytes as a package: no panic, no hang, no number that is not one.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| glintbake_tests::exercise::exercise(bytes));
