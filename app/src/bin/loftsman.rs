//! The program `loftsman`: [`loftsman::program`] with what is built in.

use std::process::ExitCode;

fn main() -> ExitCode {
    loftsman::program::main(loftsman::registry())
}
