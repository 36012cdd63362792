//! The parent process: starts children, one per target and job, and survives what they do not.

use std::collections::VecDeque;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;

use anyhow::{Context, Result, bail};

use crate::campaign::{Counts, Extent, is_known};
use crate::input::Input;
use crate::minimise::minimise;
use crate::target::Target;
use crate::trial::{Clock, HUNG};

/// Children of one target that may die before it is given up.
const DEATHS: usize = 10;

/// A run of several targets.
pub(crate) struct Run {
    pub(crate) extent: Extent,
    /// Inputs of the tests' run instead of the extent's.
    pub(crate) quick: bool,
    pub(crate) jobs: usize,
    pub(crate) findings: PathBuf,
}

/// A folder in memory, if the system has one: every input is written and deleted.
pub(crate) fn work_folder() -> Result<tempfile::TempDir> {
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() {
        tempfile::tempdir_in(memory)
    } else {
        tempfile::tempdir()
    };
    folder.context("a folder for inputs")
}

impl Run {
    /// Runs the targets; returns the number of findings.
    pub(crate) fn targets(&self, targets: &[&Target]) -> Result<u64> {
        let queue = Mutex::new(targets.iter().copied().collect::<VecDeque<_>>());
        let next = || queue.lock().ok()?.pop_front();
        let work = || -> Result<u64> {
            let mut findings = 0;
            while let Some(target) = next() {
                findings += self.target(target)?.findings;
            }
            Ok(findings)
        };
        println!(
            "{:<16} {:>10} {:>10} {:>8} {:>9} {:>8} {:>7}",
            "target", "inputs", "accepted", "answers", "rendered", "findings", "seconds"
        );
        std::thread::scope(|scope| {
            let jobs: Vec<_> = (0..self.jobs.max(1)).map(|_| scope.spawn(work)).collect();
            let results = jobs
                .into_iter()
                .map(|job| job.join().unwrap_or_else(|_| bail!("a job panicked")));
            results.sum()
        })
    }

    fn target(&self, target: &Target) -> Result<Counts> {
        let work = work_folder()?;
        let mut total = Counts::default();
        let inputs = if self.quick {
            u64::from(target.quick)
        } else {
            self.extent.inputs
        };
        for death in 0..DEATHS {
            let extent = Extent {
                seed: self.extent.seed + 1000 * death as u64,
                inputs: inputs - total.inputs.min(inputs),
                seconds: self.extent.seconds - total.milliseconds as f64 * 1e-3,
                clock: self.extent.clock,
            };
            let (counts, complete) = self.child(target, &extent, work.path())?;
            total.inputs += counts.inputs;
            total.accepted += counts.accepted;
            total.rendered += counts.rendered;
            total.findings += counts.findings;
            total.milliseconds += counts.milliseconds;
            total.answers = total.answers.max(counts.answers);
            if complete {
                break;
            }
        }
        let Counts {
            inputs,
            accepted,
            answers,
            rendered,
            findings,
            milliseconds,
        } = total;
        println!(
            "{:<16} {inputs:>10} {accepted:>10} {answers:>8} {rendered:>9} {findings:>8} {:>7.1}",
            target.name,
            milliseconds as f64 * 1e-3
        );
        Ok(total)
    }

    /// Counts of a child, and whether it came to its end.
    fn child(&self, target: &Target, extent: &Extent, work: &Path) -> Result<(Counts, bool)> {
        let mut child = program()?;
        if extent.clock == Clock::Ignored {
            child.arg("--quick");
        }
        let mut child = child
            // What an abort has to say is its first line.
            .env("RUST_BACKTRACE", "0")
            .args(["--child", target.name])
            .args([
                "--seed",
                &extent.seed.to_string(),
                "--inputs",
                &extent.inputs.to_string(),
            ])
            .args(["--seconds", &extent.seconds.to_string()])
            .arg("--work")
            .arg(work)
            .arg("--findings")
            .arg(&self.findings)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .context("a child process")?;
        let mut counts = Counts::default();
        let output = child.stdout.take().context("the child's output")?;
        for line in BufReader::new(output).lines() {
            let line = line?;
            match line.split_once(' ') {
                Some(("counts", numbers)) => counts = Counts::of_line(numbers).unwrap_or(counts),
                Some(("finding", finding)) => {
                    let (name, fault) = finding.split_once(' ').unwrap_or((finding, ""));
                    self.keep(target, name, fault)?;
                }
                _ => println!("{line}"),
            }
        }
        let status = child.wait()?;
        match status.code() {
            Some(0) => return Ok((counts, true)),
            Some(1) => bail!("{}: the child gave up", target.name),
            _ => {}
        }
        // What was being read has killed it.
        let fault = if status.code() == Some(HUNG) {
            "it goes on for ever".to_owned()
        } else {
            format!("the process ended: {status}")
        };
        counts.inputs += 1;
        if is_known(target, &fault) {
            return Ok((counts, false));
        }
        counts.findings += 1;
        let name = format!("{}-{}-death", target.name, extent.seed);
        let open = (target.seeds)()
            .first()
            .map(|seed| seed.open.clone())
            .unwrap_or_default();
        let input = Input::read(&work.join("input"), &open)?;
        input.write(&self.findings.join(&name))?;
        self.keep(target, &name, &fault)?;
        Ok((counts, false))
    }

    /// Tells of a finding, and makes it smaller.
    fn keep(&self, target: &Target, name: &str, fault: &str) -> Result<()> {
        let folder = self.findings.join(name);
        println!("FINDING {}: {fault}", folder.display());
        let note = format!(
            "{fault}\n\nAgain: cargo run -p splatvol-fuzz -- --replay {} {}\n",
            folder.display(),
            target.name
        );
        std::fs::write(self.findings.join(format!("{name}.txt")), note)?;
        minimise(target, &folder)
    }
}

/// This program once more.
pub(crate) fn program() -> Result<Command> {
    Ok(Command::new(
        std::env::current_exe().context("the path of this program")?,
    ))
}
