//! Errors as the user sees them: which step failed (hence the exit code), why, and what to do about it.

use std::fmt::Display;
use std::process::ExitCode;

/// The step that failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Step {
    /// Arguments that parse but make no sense.
    Usage,
    /// An input that cannot be read.
    Input,
    /// Rendering.
    Render,
    /// An output that cannot be written.
    Output,
}

impl Step {
    fn exit_code(self) -> u8 {
        match self {
            Self::Usage => 2,
            Self::Input => 3,
            Self::Render => 4,
            Self::Output => 5,
        }
    }
}

/// A failed command.
#[derive(Debug)]
pub(crate) struct Failure {
    step: Step,
    error: anyhow::Error,
    hint: Option<String>,
}

impl Failure {
    pub(crate) fn of(step: Step, error: anyhow::Error) -> Self {
        Self {
            step,
            error,
            hint: None,
        }
    }

    pub(crate) fn usage(message: impl Display) -> Self {
        Self::of(Step::Usage, anyhow::anyhow!("{message}"))
    }

    #[must_use]
    pub(crate) fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// Prints error, causes and hint to stderr.
    pub(crate) fn report(&self) -> ExitCode {
        eprintln!("splatvol: error: {}", self.text());
        ExitCode::from(self.step.exit_code())
    }

    fn text(&self) -> String {
        let mut text = self.error.to_string();
        let mut last = text.clone();
        for cause in self.error.chain().skip(1).map(ToString::to_string) {
            // Many errors already quote their cause.
            if !last.contains(&cause) {
                text.push_str(&format!("\n  caused by: {cause}"));
            }
            last = cause;
        }
        if let Some(hint) = &self.hint {
            text.push_str(&format!("\n  hint: {hint}"));
        }
        text
    }
}

/// Names the step in which an error arose.
pub(crate) trait During<T> {
    fn during(self, step: Step) -> Result<T, Failure>;
}

impl<T, E: Into<anyhow::Error>> During<T> for Result<T, E> {
    fn during(self, step: Step) -> Result<T, Failure> {
        self.map_err(|error| Failure::of(step, error.into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::Context;

    #[test]
    fn causes_are_named_once() {
        let failed: Result<(), _> = Err(std::io::Error::other("disk full"));
        let failure = failed
            .context("cannot write a.png")
            .during(Step::Output)
            .unwrap_err()
            .hint("buy one");
        assert_eq!(
            failure.text(),
            "cannot write a.png\n  caused by: disk full\n  hint: buy one"
        );
        let failed: Result<(), _> = Err(std::io::Error::other("disk full"));
        let failure = failed
            .context("cannot write: disk full")
            .during(Step::Output)
            .unwrap_err();
        assert_eq!(failure.text(), "cannot write: disk full");
    }
}
