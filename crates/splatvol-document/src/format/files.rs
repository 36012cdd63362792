//! Scene files: documents of several items, beside the files that they name.

use std::path::{Component, Path, PathBuf};

use splatvol_io::IoError;

use crate::files::read_text;
use crate::{Document, DocumentError};

/// Format, as errors have it.
const FORMAT: &str = "scene";

/// True where a file is a scene: TOML that does not list frames of depth cameras, or JSON with items.
pub fn is_scene(path: impl AsRef<Path>) -> bool {
    let path = path.as_ref();
    let has = |extension: &str| {
        path.extension()
            .is_some_and(|e| e.eq_ignore_ascii_case(extension))
    };
    if !path.is_file() || !(has("toml") || has("json")) {
        return false;
    }
    let Ok(text) = read_text(FORMAT, path) else {
        return false;
    };
    let lists_frames = |line: &str| {
        let key = line.split('=').next().unwrap_or_default().trim();
        key == "frame" || key.starts_with("[[frame]]")
    };
    match has("toml") {
        true => !text.lines().any(lists_frames),
        false => text.contains("\"item\""),
    }
}

/// Reads a scene. Names of files become paths that lead there from the current folder.
///
/// # Errors
/// Unknown keys, values of the wrong kind, no items, names that lead out of the folder.
pub fn read_scene(path: impl AsRef<Path>) -> Result<Document, DocumentError> {
    let path = path.as_ref();
    let text = read_text(FORMAT, path)?;
    let is_json = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
    let mut document = match is_json {
        true => Document::from_json(&text, path)?,
        false => Document::from_toml(&text, path)?,
    };
    let malformed = |message: String| DocumentError::Malformed {
        path: path.to_owned(),
        message,
    };
    if document.items.is_empty() {
        return Err(malformed("item: none; expected at least one [[item]]".to_owned()));
    }
    for (i, item) in document.items.iter_mut().enumerate() {
        let named = |key: &str| format!("item[{i}].{key}");
        if item.file.is_empty() {
            return Err(malformed(format!(
                "{}: none; expected the name of a file",
                named("file")
            )));
        }
        let fine = item.check_values().and_then(|()| item.world_from_file());
        fine.map_err(|error| malformed(error.of_index(i).to_string()))?;
        item.file = beside(&item.file, &named("file"), path)?;
        let files = [
            ("tf", &mut item.tf),
            ("drape", &mut item.drape),
            ("solution", &mut item.solution),
        ];
        for (key, file) in files {
            if let Some(file) = file {
                *file = beside(file, &named(key), path)?;
            }
        }
    }
    let effects = &mut document.effects;
    let files = [
        ("effects.bump", &mut effects.bump),
        ("effects.environment", &mut effects.environment),
        ("effects.tf2d", &mut effects.tf2d),
        ("animation.path", &mut document.animation.path),
    ];
    for (key, file) in files {
        if let Some(file) = file {
            *file = beside(file, key, path)?;
        }
    }
    document
        .name
        .get_or_insert_with(|| path.to_string_lossy().into_owned());
    Ok(document)
}

/// The path of a file that a scene names.
fn beside(name: &str, key: &str, scene: &Path) -> Result<String, DocumentError> {
    let path = Path::new(name);
    if name.starts_with("sample:") || path.is_absolute() || splatvol_io::remote::address(path).is_some() {
        return Ok(name.to_owned());
    }
    let inside = |component| matches!(component, Component::Normal(_) | Component::CurDir);
    let refused = |expected: &str| {
        Err(DocumentError::Malformed {
            path: scene.to_owned(),
            message: format!("{key} = {name:?}: expected {expected}"),
        })
    };
    if name.contains('\0') || !Path::new(name).components().all(inside) {
        return refused("a name inside the scene's folder, or an absolute one");
    }
    let folder = match scene.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new(""),
    };
    let path: PathBuf = folder.join(name);
    let Ok(real) = path.canonicalize() else {
        return Err(DocumentError::from(IoError::MissingDataFile {
            data: path,
            path: scene.to_owned(),
        }));
    };
    let real_folder = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    if real_folder
        .canonicalize()
        .is_ok_and(|folder| !real.starts_with(folder))
    {
        return refused("a name inside the scene's folder (this is a link that leads out)");
    }
    Ok(path.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests;
