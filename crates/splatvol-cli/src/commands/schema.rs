//! `splatvol schema`: the JSON schema of scene files and of the settings in pictures.

use crate::failure::{During, Failure, Step};
use crate::output::Target;

pub(crate) fn run() -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(&splatvol_document::schema()).during(Step::Output)?;
    Target::Stdout.write(format!("{text}\n").as_bytes(), false)
}
