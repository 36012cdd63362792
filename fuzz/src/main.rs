//! Feeds every reader with damaged files: any answer will do that comes in bounded time and memory, without a panic.
//!
//! `cargo run -p splatvol-fuzz -- --seconds 600 dicom` runs one target, `--all` all of them; `--list` names them.
//! The parent process starts a child per target, which makes inputs from seeds, and survives its death; what fails is
//! written to a folder.
//!
//! | module | holds |
//! |---|---|
//! | [`targets`], `seeds` | the formats, and small valid files of each |
//! | [`target`] | reading and rendering an input |
//! | [`mutate`], [`coat`] | damage to bytes and texts; damage behind checksums |
//! | [`campaign`], [`trial`] | the child: the choice of inputs by their answers; bounds of time and memory |
//! | [`parent`], [`minimise`] | children and findings |
//! | [`allocator`] | counts memory |

mod allocator;
mod campaign;
mod coat;
mod input;
mod minimise;
mod mutate;
mod parent;
mod random;
mod seeds;
mod target;
mod targets;
mod trial;

// Generators of the readers' own tests.
#[path = "../../crates/splatvol-io/tests/it/common/mod.rs"]
mod common;

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::Parser;

use campaign::Extent;
use input::Input;
use parent::Run;
use target::Target;
use targets::TARGETS;
use trial::{Clock, Trial};

/// Feeds every reader with damaged files.
#[derive(Debug, Parser)]
struct Arguments {
    /// Targets to run.
    targets: Vec<String>,
    /// Run all targets.
    #[arg(long)]
    all: bool,
    /// Name the targets.
    #[arg(long)]
    list: bool,
    /// Seconds of the processor per target: what other programs take does not count.
    #[arg(long, default_value_t = 60.0)]
    seconds: f64,
    /// Inputs per target, if they take less time.
    #[arg(long, default_value_t = u64::MAX)]
    inputs: u64,
    /// The inputs that the tests run, however long they take: only what goes on for ever counts as slow.
    #[arg(long)]
    quick: bool,
    /// Targets at the same time.
    #[arg(long, default_value_t = 1)]
    jobs: usize,
    /// Seed of the damage.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Where findings are written.
    #[arg(long, default_value = "target/fuzz-findings")]
    findings: PathBuf,
    /// Try the input of a finding's folder once.
    #[arg(long)]
    replay: Option<PathBuf>,
    #[arg(long, hide = true, requires = "work")]
    child: bool,
    #[arg(long, hide = true)]
    work: Option<PathBuf>,
}

fn main() -> Result<ExitCode> {
    let arguments = Arguments::parse();
    if arguments.list {
        TARGETS.iter().for_each(|target| println!("{}", target.name));
        return Ok(ExitCode::SUCCESS);
    }
    let targets = chosen(&arguments)?;
    let first = targets
        .first()
        .context("name targets, or --all; --list lists them")?;
    if let Some(folder) = &arguments.replay {
        return replay(first, folder);
    }
    std::fs::create_dir_all(&arguments.findings).with_context(|| arguments.findings.display().to_string())?;
    let extent = Extent {
        seed: arguments.seed,
        inputs: arguments.inputs,
        seconds: if arguments.quick { 1e6 } else { arguments.seconds },
        clock: if arguments.quick {
            Clock::Ignored
        } else {
            Clock::Judges
        },
    };
    if arguments.child {
        let work = arguments.work.context("--work")?;
        campaign::run(first, &extent, &work, &arguments.findings)?;
        return Ok(ExitCode::SUCCESS);
    }
    let run = Run {
        extent,
        quick: arguments.quick,
        jobs: arguments.jobs,
        findings: arguments.findings,
    };
    let findings = run.targets(&targets)?;
    println!("{} targets, {findings} findings", targets.len());
    Ok(ExitCode::from(u8::from(findings > 0)))
}

fn chosen(arguments: &Arguments) -> Result<Vec<&'static Target>> {
    if arguments.all {
        return Ok(TARGETS.iter().collect());
    }
    let of_name = |name: &String| {
        let found = TARGETS.iter().find(|target| target.name == name);
        found.with_context(|| format!("there is no target {name}: --list lists them"))
    };
    arguments.targets.iter().map(of_name).collect()
}

/// Reads and renders one saved input; the exit status tells the fault.
fn replay(target: &Target, folder: &std::path::Path) -> Result<ExitCode> {
    let input = Input::read(folder, &minimise::opened(target, folder))?;
    let work = parent::work_folder()?;
    let outcome = Trial::new(target.reader, work.path().to_owned(), Clock::Judges).run(&input, true)?;
    println!("{}", outcome.answer);
    let Some(fault) = outcome.fault else {
        return Ok(ExitCode::SUCCESS);
    };
    println!("{}", fault.line());
    Ok(ExitCode::from(fault.status() as u8))
}
