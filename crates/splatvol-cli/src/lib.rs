//! The command `splatvol` as a library, so that other programs can include it: a Python package runs the same
//! command.
//!
//! Flags (`args`) become a document, which `splatvol-document` resolves and the `commands` carry out. Messages go to
//! stderr, results to files or stdout.
#![forbid(unsafe_code)]
#![warn(clippy::print_stderr, clippy::print_stdout)]

mod args;
mod commands;
mod failure;
mod output;
mod record;
mod terminal;

use std::ffi::OsString;

use args::{Cli, Command, help};
use terminal::Terminal;

/// Runs the command, and returns its exit code. The first argument is the program's name.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    match help::parse(&arguments) {
        Ok(cli) => {
            record::set_command_line(arguments);
            carry_out(&cli)
        }
        Err(message) => {
            let code = u8::try_from(message.exit_code()).unwrap_or(u8::MAX);
            // If a message cannot be written, the code still says what happened.
            let _ = message.print();
            code
        }
    }
}

fn carry_out(cli: &Cli) -> u8 {
    let terminal = Terminal::new(cli.verbosity);
    let done = match &cli.command {
        Command::Render(args) => commands::render::run(args, &terminal),
        Command::Animate(args) => commands::animate::run(args, &terminal),
        Command::Info(args) => commands::info::run(args, &terminal),
        Command::Sample(args) => commands::sample::run(args, &terminal),
        Command::Convert(args) => commands::convert::run(args, &terminal),
        Command::Serve(args) => commands::serve::run(args, &terminal),
        Command::Export(args) => commands::export::run(args, &terminal),
        Command::Part(args) => commands::part::run(args, &terminal),
        Command::Assemble(args) => commands::part::assemble(args, &terminal),
        Command::Compare(args) => commands::compare::run(args, &terminal),
        Command::Bench(args) => commands::bench::run(args, &terminal),
        Command::Schema => commands::schema::run(),
        #[cfg(feature = "lab")]
        Command::Lab(args) => commands::lab::run(args, &terminal),
        #[cfg(feature = "view")]
        Command::View(args) => commands::view::run(args, &terminal),
    };
    match done {
        Ok(()) => 0,
        Err(failure) => failure.report(),
    }
}
