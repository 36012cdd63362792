//! `splatvol view`: a window.

use std::path::Path;

use splatvol_view::Start;

use super::studio::threads_within;
use crate::args::ViewArgs;
use crate::failure::{During, Failure, Step};
use crate::record;
use crate::terminal::Terminal;

pub(crate) fn run(args: &ViewArgs, terminal: &Terminal) -> Result<(), Failure> {
    let start = Start {
        files: args.files.clone(),
        command: record::command_line(Path::new("")),
        rules: args.rules(),
        threads: args.threads.and_then(|asked| threads_within(asked, terminal)),
        engine: args.engine.into(),
    };
    splatvol_view::run(start)
        .during(Step::Render)
        .map_err(|failure| failure.hint("splatvol render makes pictures without a window"))
}
