//! Errors as the user sees them: which step failed (hence the exit code), why, and what to do about it.

use std::fmt::Display;

use splatvol::SceneError;
use splatvol_document::DocumentError;

use crate::terminal::say;

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

    /// Prints error, causes and hint to stderr, and returns the exit code.
    pub(crate) fn report(&self) -> u8 {
        say(format_args!("error: {}", self.text()));
        self.step.exit_code()
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

impl From<DocumentError> for Failure {
    /// Names keys as the flags of the same names.
    fn from(error: DocumentError) -> Self {
        let step = match error {
            DocumentError::Scene(SceneError::Source { .. }) => Step::Input,
            DocumentError::Refused { .. } | DocumentError::Scene(_) => Step::Usage,
            DocumentError::Malformed { .. } | DocumentError::Input { .. } | DocumentError::Sample(_) => {
                Step::Input
            }
        };
        match error {
            DocumentError::Refused {
                message,
                context,
                hint,
            } => {
                let context = context.map_or_else(String::new, |of| format!(" ({of})"));
                Self {
                    hint,
                    ..Self::usage(format!("{}{context}", as_flags(&message)))
                }
            }
            DocumentError::Input { error, hint } => Self {
                hint,
                ..Self::of(step, (*error).into())
            },
            other => Self::of(step, other.into()),
        }
    }
}

impl Failure {
    /// Names keys as a scene file has them, and the file, if they are those of an item, which has no flags.
    pub(crate) fn of_scene(error: DocumentError, file: &str) -> Self {
        match error {
            DocumentError::Refused {
                ref message,
                ref hint,
                ..
            } => {
                let of_item = message.starts_with("`item[");
                let place = if of_item {
                    format!("{file}: ")
                } else {
                    String::new()
                };
                Self {
                    hint: hint.clone(),
                    ..Self::usage(format!("{place}{error}"))
                }
            }
            other => other.into(),
        }
    }
}

/// Turns a message about a document's keys, which stand between backquotes, into one about flags. An item with a number
/// is one of several, which have no flags.
fn as_flags(message: &str) -> String {
    let spoken = |(i, part): (usize, &str)| match i % 2 {
        0 => part.to_owned(),
        _ => flag(part),
    };
    message.split('`').enumerate().map(spoken).collect()
}

/// The flag of a key, or the key where there is none: of several items, and of what stands in files only.
pub(crate) fn flag(key: &str) -> String {
    if key.starts_with("item[") || key.starts_with("effects.regions") {
        return key.to_owned();
    }
    let name = match key {
        "item.color" => "point-color",
        "camera.position" => "camera-pos",
        "camera.target" => "camera-target",
        "camera.up" => "camera-up",
        "camera.fov" => "camera-fov",
        key => key.rsplit_once('.').map_or(key, |(_, name)| name),
    };
    format!("--{name}")
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
