//! Scene files: the items of one picture, their placement and appearance, as TOML.
//!
//! ```toml
//! background = "black"                  # as the command's --background; likewise size = "800x600"
//!
//! [[item]]
//! file = "scan.nii.gz"                  # beside this file; or sample:NAME
//! cmap = "gray"                         # tf, cmap, opacity, clim, iso, unit-distance: as the flags
//! clim = [100, 900]
//!
//! [[item]]
//! file = "electrodes.ply"
//! color = [1, 0.8, 0.2]                 # points without colours of their own
//! rotate = ["z", 30]                    # axis and degrees, or the rows of a matrix
//! translate = [10, 0, 5]                # world = translate + rotate * scale * (what the file says)
//!
//! [camera]                              # all of it optional, as the flags
//! view = "front"
//!
//! [settings]                            # any of `splatvol_scene::FlatSettings`
//! sheet-thickness = 0.5
//! ```
//!
//! Unknown keys are refused, so that a misspelt one is not silently ignored. Relative names stay inside the file's
//! folder; a name outside of it has to be absolute.

mod keys;

use std::ops::Range;
use std::path::{Component, Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3};

pub use keys::{Axis, Opacity, Rotate, Scale, SceneCamera, SceneFile, SceneItem};

use crate::IoError;
use crate::error::Context;
use crate::source::read_file;

/// Format, as errors have it.
const FORMAT: &str = "scene";

/// True where a file is a scene: TOML that does not list frames of depth cameras.
pub fn is_scene(path: impl AsRef<Path>) -> bool {
    let path = path.as_ref();
    if !path.is_file() || !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) {
        return false;
    }
    let Ok(bytes) = read_file(path, &Context::new(FORMAT, path)) else {
        return false;
    };
    let starts = |line: &[u8]| {
        let line = line.trim_ascii();
        line.starts_with(b"[[frame]]") || line.starts_with(b"frame")
    };
    !bytes.split(|byte| *byte == b'\n').any(starts)
}

/// Reads a scene. Names of files become paths that lead there from the current folder.
///
/// # Errors
/// See [`IoError`]: unknown keys, values of the wrong kind, no items, names that lead out of the folder.
pub fn read_scene(path: impl AsRef<Path>) -> Result<SceneFile, IoError> {
    let path = path.as_ref();
    let context = &Context::new(FORMAT, path);
    let bytes = read_file(path, context)?;
    let text = std::str::from_utf8(&bytes)
        .map_err(|error| context.field("contents", error, None, "text in UTF-8"))?;
    let mut scene: SceneFile = toml::from_str(text).map_err(|error| refused(&error, text, context))?;
    if scene.items.is_empty() {
        return Err(context.field("item", "none", None, "at least one [[item]]"));
    }
    for (i, item) in scene.items.iter_mut().enumerate() {
        let named = |key: &str| format!("item[{i}].{key}");
        if item.file.is_empty() {
            return Err(context.field(named("file"), "", None, "the name of a file"));
        }
        let checked = item.world_from_file().map_err(|(key, value)| {
            context.field(
                named(key),
                value,
                None,
                "finite numbers that make an invertible place",
            )
        });
        checked?;
        item.file = beside(&item.file, &named("file"), context)?;
        for (key, file) in [("tf", &mut item.tf), ("drape", &mut item.drape)] {
            if let Some(file) = file {
                *file = beside(file, &named(key), context)?;
            }
        }
    }
    Ok(scene)
}

impl SceneItem {
    /// Whether the scene file places the item.
    pub fn is_placed(&self) -> bool {
        self.scale.is_some() || self.rotate.is_some() || self.translate.is_some()
    }

    /// Placement of the item: scale, rotation and shift, without `up`.
    ///
    /// # Errors
    /// The key and its value, where they make no place.
    pub fn world_from_file(&self) -> Result<DAffine3, (&'static str, String)> {
        let scale = match self.scale {
            None => DVec3::ONE,
            Some(Scale::Uniform(scale)) => DVec3::splat(scale),
            Some(Scale::Axes(axes)) => DVec3::from_array(axes),
        };
        if !(scale.is_finite() && scale.abs().min_element() > 0.0) {
            return Err(("scale", format!("{:?}", scale.to_array())));
        }
        let rotation = match &self.rotate {
            None => DMat3::IDENTITY,
            Some(rotate) => rotate.matrix().ok_or_else(|| ("rotate", format!("{rotate:?}")))?,
        };
        let shift = DVec3::from_array(self.translate.unwrap_or_default());
        if !shift.is_finite() {
            return Err(("translate", format!("{:?}", shift.to_array())));
        }
        Ok(DAffine3::from_mat3_translation(
            rotation * DMat3::from_diagonal(scale),
            shift,
        ))
    }
}

impl Rotate {
    /// The matrix, if it is one of a rotation.
    fn matrix(&self) -> Option<DMat3> {
        match self {
            Self::Axis(axis, degrees) => {
                let direction = match axis {
                    Axis::Name(name) => match name.as_str() {
                        "x" => DVec3::X,
                        "y" => DVec3::Y,
                        "z" => DVec3::Z,
                        _ => return None,
                    },
                    Axis::Direction(direction) => DVec3::from_array(*direction),
                };
                let axis = direction.try_normalize()?;
                degrees
                    .is_finite()
                    .then(|| DMat3::from_axis_angle(axis, degrees.to_radians()))
            }
            Self::Matrix(rows) => {
                let matrix = DMat3::from_cols_array_2d(rows).transpose();
                let product = matrix * matrix.transpose();
                let is_rotation = product.abs_diff_eq(DMat3::IDENTITY, 1e-4) && matrix.determinant() > 0.0;
                is_rotation.then_some(matrix)
            }
        }
    }
}

/// The path of a file that a scene names.
fn beside(name: &str, field: &str, context: &Context<'_>) -> Result<String, IoError> {
    if name.starts_with("sample:") || Path::new(name).is_absolute() {
        return Ok(name.to_owned());
    }
    let inside = |component| matches!(component, Component::Normal(_) | Component::CurDir);
    let refused = |expected: &str| Err(context.field(field, name, None, expected));
    if name.contains('\0') || !Path::new(name).components().all(inside) {
        return refused("a name inside the scene's folder, or an absolute one");
    }
    let folder = match context.path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new(""),
    };
    let path: PathBuf = folder.join(name);
    let Ok(real) = path.canonicalize() else {
        return Err(IoError::MissingDataFile {
            data: path,
            path: context.path.to_owned(),
        });
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

/// Converts an error of the TOML parser, adding the key and the value of its line.
fn refused(error: &toml::de::Error, text: &str, context: &Context<'_>) -> IoError {
    let Range { start, end } = error.span().unwrap_or(0..0);
    let line_start = text[..start.min(text.len())].rfind('\n').map_or(0, |at| at + 1);
    let line = text[line_start..].lines().next().unwrap_or_default();
    let number = text[..line_start].matches('\n').count() + 1;
    let (key, value) = line.split_once('=').unwrap_or((line, ""));
    let key = key.trim();
    let value = match value.trim() {
        "" => text.get(start..end).unwrap_or_default(),
        value => value,
    };
    let expected = format!("otherwise, line {number}: {}", error.message().trim());
    context.field(key, value, start as u64, expected)
}

#[cfg(test)]
mod tests;
