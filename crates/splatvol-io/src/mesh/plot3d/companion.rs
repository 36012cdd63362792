//! Search for the companion file of a grid or a solution.

use std::path::{Path, PathBuf};

use super::layout::{Content, Layout};
use super::text;
use crate::IoError;
use crate::error::Context;
use crate::files;
use crate::source::read_file;

/// True for the extensions of grids and solutions, and of binary files.
pub(super) fn is_customary(path: &Path) -> bool {
    has_own_extension(path)
        || path
            .extension()
            .is_some_and(|extension| extension.eq_ignore_ascii_case("bin"))
}

/// True for the extensions of grids and solutions.
pub(super) fn has_own_extension(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let extension = extension.to_string_lossy();
    EXTENSIONS.iter().any(|names| names.contains(&extension.as_ref()))
}

/// True for a file that may be read to see whether it is a grid or a solution.
pub(super) fn is_candidate(path: &Path) -> bool {
    is_customary(path) && files::is_file(path)
}

/// True where a file of text has as many numbers as a grid or a solution, and is no table, or has its companion.
pub(super) fn is_text(path: &Path) -> bool {
    let context = &Context::new("PLOT3D", path);
    let Ok(bytes) = read_file(path, context) else {
        return false;
    };
    let mut contents = [Content::Grid, Content::Solution].into_iter();
    contents.any(|content| text::layout(&bytes, content).is_some())
        && (!text::is_table(&bytes) || pair(path, None, context).is_ok())
}

/// Whether a file holds this, a few bytes more or less.
fn holds(bytes: &[u8], content: Content) -> bool {
    match text::is_text(bytes) {
        true => text::layout(bytes, content).is_some(),
        false => Layout::near(bytes, bytes.len() as u64, content).is_some(),
    }
}

/// Whether a file holds this and nothing else.
fn holds_exactly(bytes: &[u8], content: Content) -> bool {
    match text::is_text(bytes) {
        true => holds(bytes, content),
        false => Layout::find(bytes, bytes.len() as u64, content).is_some(),
    }
}

/// Extensions, and ends or parts of names, of grids and of the solutions that go with them.
const EXTENSIONS: [&[&str]; 2] = [&["xyz", "x", "g", "grd", "p3d", "grid"], &["q", "sol"]];
const PARTS: [(&str, &str); 4] = [("xyz", "q"), ("grid", "q"), ("grid", "solution"), ("grid", "sol")];

/// The pair of grid and solution that `path` belongs to.
pub(super) fn pair(
    path: &Path,
    solution: Option<&Path>,
    context: &Context<'_>,
) -> Result<(PathBuf, PathBuf), IoError> {
    if let Some(solution) = solution {
        return Ok((path.to_owned(), solution.to_owned()));
    }
    let bytes = read_file(path, context)?;
    let exactly = |content| holds_exactly(&bytes, content);
    let is_grid = exactly(Content::Grid) || (holds(&bytes, Content::Grid) && !exactly(Content::Solution));
    let wanted = match is_grid {
        true => Content::Solution,
        false => Content::Grid,
    };
    let fits = |candidate: &PathBuf| {
        files::is_file(candidate) && read_file(candidate, context).is_ok_and(|bytes| holds(&bytes, wanted))
    };
    let found = candidates(path, wanted).into_iter().find(fits);
    match (found, wanted) {
        (Some(found), Content::Solution) => Ok((path.to_owned(), found)),
        (Some(found), Content::Grid) => Ok((found, path.to_owned())),
        (None, Content::Solution) => Err(context.unsupported(
            "a grid without a solution beside it (comb.xyz and comb.q, combxyz.bin and combq.bin); name the solution (`--solution`)",
        )),
        (None, Content::Grid) => Err(context.unsupported("a solution without its grid beside it")),
    }
}

/// Names that the other file may have, in its folder.
fn candidates(path: &Path, wanted: Content) -> Vec<PathBuf> {
    let stem = path
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let extension = path
        .extension()
        .map(|extension| extension.to_string_lossy().into_owned());
    let own = usize::from(wanted == Content::Grid);
    let mut found: Vec<PathBuf> = Vec::new();
    let known = |extension: &String| EXTENSIONS[own].contains(&extension.to_ascii_lowercase().as_str());
    if extension.as_ref().is_some_and(known) {
        found.extend(EXTENSIONS[1 - own].iter().map(|other| path.with_extension(other)));
    }
    for (grid, solution) in PARTS {
        let (from, to) = if own == 0 {
            (grid, solution)
        } else {
            (solution, grid)
        };
        if let Some(at) = stem.rfind(from) {
            let name = format!("{}{to}{}", &stem[..at], &stem[at + from.len()..]);
            found.push(match &extension {
                Some(extension) => path.with_file_name(format!("{name}.{extension}")),
                None => path.with_file_name(name),
            });
        }
    }
    found
}
