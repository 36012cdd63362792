//! The command `splatvol`: flags ([`args`]) become a document, which `splatvol-document` resolves and the [`commands`] carry
//! out. Messages go to stderr, results to files or stdout.
#![forbid(unsafe_code)]

mod args;
mod commands;
mod failure;
mod output;
mod record;
mod terminal;

use std::process::ExitCode;

use args::{Command, help};
use terminal::Terminal;

fn main() -> ExitCode {
    let cli = help::parse();
    let terminal = Terminal::new(cli.verbosity);
    let done = match &cli.command {
        Command::Render(args) => commands::render::run(args, &terminal),
        Command::Animate(args) => commands::animate::run(args, &terminal),
        Command::Info(args) => commands::info::run(args, &terminal),
        Command::Sample(args) => commands::sample::run(args, &terminal),
        Command::Convert(args) => commands::convert::run(args, &terminal),
        Command::Compare(args) => commands::compare::run(args, &terminal),
        Command::Bench(args) => commands::bench::run(args, &terminal),
        Command::Schema => commands::schema::run(),
        #[cfg(feature = "lab")]
        Command::Lab(args) => commands::lab::run(args, &terminal),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
