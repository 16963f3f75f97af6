//! The `glintbake` program; all it does is in the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    glintbake_cli::main()
}
