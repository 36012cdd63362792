//! Messages on stderr: warnings, notes, and progress bars where a person is watching.

use std::any::Any;
use std::borrow::Cow;
use std::fmt::Display;
use std::io::{IsTerminal, Write};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use splatvol_document::{Listener, ReadRules, Reading};

use crate::args::Verbosity;

/// Writes a line to stderr. Where that is full or closed, the exit code still says what happened.
pub(crate) fn say(message: impl Display) {
    let _ = writeln!(std::io::stderr().lock(), "splatvol: {message}");
}

/// Messages, as verbose as the user wants them.
pub(crate) struct Terminal {
    verbosity: Verbosity,
}

impl Terminal {
    pub(crate) fn new(verbosity: Verbosity) -> Self {
        Self { verbosity }
    }

    /// Something odd that did not stop the command.
    pub(crate) fn warn(&self, message: impl Display) {
        if !self.verbosity.quiet {
            say(format_args!("warning: {message}"));
        }
    }

    /// Reports a result.
    pub(crate) fn note(&self, message: impl Display) {
        if !self.verbosity.quiet {
            say(message);
        }
    }

    /// Reports a choice, with `--verbose`.
    pub(crate) fn detail(&self, message: impl Display) {
        if self.verbosity.verbose {
            say(message);
        }
    }

    /// Reads files from the paths given, and reports on it. `rules`: what is refused.
    pub(crate) fn reads(&self, rules: ReadRules) -> Reading<'_> {
        Reading {
            rules,
            folder: None,
            listener: self,
        }
    }

    /// A bar from 0 to 1; hidden in pipes and with `--quiet`.
    pub(crate) fn progress(&self, label: impl Into<Cow<'static, str>>) -> Progress {
        if self.verbosity.quiet || !std::io::stderr().is_terminal() {
            return Progress(ProgressBar::hidden());
        }
        let bar = ProgressBar::new(Progress::STEPS);
        if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {percent:>3} % {elapsed}") {
            bar.set_style(style);
        }
        bar.set_message(label);
        Progress(bar)
    }

    /// A bar of frames, with the remaining time; hidden in pipes and with `--quiet`.
    pub(crate) fn frames(&self, count: u32) -> Progress {
        let bar = self.progress("Rendering");
        bar.0.set_length(u64::from(count));
        if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {elapsed}, {eta} left")
        {
            bar.0.set_style(style);
        }
        bar
    }

    /// A spinner for work of unknown length.
    pub(crate) fn spinner(&self, label: String) -> Progress {
        if self.verbosity.quiet || !std::io::stderr().is_terminal() {
            return Progress(ProgressBar::hidden());
        }
        let bar = ProgressBar::new_spinner().with_message(label);
        bar.enable_steady_tick(Duration::from_millis(120));
        Progress(bar)
    }
}

impl Listener for Terminal {
    fn warn(&self, message: &str) {
        Self::warn(self, message);
    }

    fn detail(&self, message: &str) {
        Self::detail(self, message);
    }

    fn reading(&self, file: &str) -> Box<dyn Any> {
        Box::new(self.spinner(format!("Reading {file}")))
    }
}

/// A progress display that disappears when dropped.
pub(crate) struct Progress(ProgressBar);

impl Progress {
    const STEPS: u64 = 1000;

    /// Shows the finished share, 0..1.
    pub(crate) fn set(&self, share: f64) {
        self.0.set_position((share * Self::STEPS as f64) as u64);
    }

    /// Shows the finished share, 0..1, and what is being done.
    #[cfg(feature = "lab")]
    pub(crate) fn show(&self, share: f64, label: impl Into<Cow<'static, str>>) {
        self.set(share);
        self.0.set_message(label);
    }

    /// Shows one more frame as finished.
    pub(crate) fn advance(&self) {
        self.0.inc(1);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
