//! The command `splatvol`.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    splatvol_cli::run(std::env::args_os()).into()
}
