//! Pictures against 16-bit PNGs kept with the tests.
//!
//! `UPDATE_SNAPSHOTS=1` rewrites the snapshots that exist, `ADD_SNAPSHOTS=1` creates those that are missing: a typo
//! in a name never passes as a new snapshot, and an update never adds.

use std::path::Path;

use splatvol_scene::Image;

use crate::assertion::{check_images, file_name, output_folder};
use crate::{Tolerance, picture};

/// Permission to write snapshots, from the environment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Permissions {
    update: bool,
    add: bool,
}

impl Permissions {
    fn from_environment() -> Self {
        let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty() && value != "0");
        Self {
            update: set("UPDATE_SNAPSHOTS"),
            add: set("ADD_SNAPSHOTS"),
        }
    }
}

/// Demands that a picture agrees with the snapshot `NAME.png` in `folder` (a test crate's `tests/snapshots`).
/// Both sides have passed through 16-bit sRGB.
///
/// # Panics
/// If the tolerance is violated, the snapshot is missing and may not be added, or a file cannot be read or written.
#[track_caller]
pub fn assert_snapshot(folder: impl AsRef<Path>, name: &str, actual: &Image, tolerance: Tolerance) {
    let permissions = Permissions::from_environment();
    if let Err(report) = check_snapshot((folder.as_ref(), name), actual, &tolerance, permissions) {
        panic!("{report}");
    }
}

fn check_snapshot(
    (folder, name): (&Path, &str),
    actual: &Image,
    tolerance: &Tolerance,
    permissions: Permissions,
) -> Result<(), String> {
    let path = folder.join(format!("{}.png", file_name(name)));
    let exists = path.exists();
    if (exists && permissions.update) || (!exists && permissions.add) {
        return picture::write(&path, actual).map_err(|error| format!("{}: {error}", path.display()));
    }
    if !exists {
        let seen = output_folder().join(format!("{}.png", file_name(name)));
        let left = match picture::write(&seen, actual) {
            Ok(()) => format!("it would be {}", seen.display()),
            Err(error) => format!("{}: {error}", seen.display()),
        };
        return Err(format!(
            "{name}: no snapshot {} (ADD_SNAPSHOTS=1 adds it; {left})",
            path.display()
        ));
    }
    let expected = picture::read(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let actual = picture::quantised(actual);
    check_images(&output_folder(), name, (&actual, &expected), tolerance)
        .map_err(|report| format!("{report}\n  UPDATE_SNAPSHOTS=1 accepts the new picture"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use splatvol_scene::ImageSize;

    const NONE: Permissions = Permissions {
        update: false,
        add: false,
    };
    const UPDATE: Permissions = Permissions {
        update: true,
        add: false,
    };
    const ADD: Permissions = Permissions {
        update: false,
        add: true,
    };

    #[test]
    fn snapshots_are_added_and_updated_only_when_asked() {
        let folder = tempfile::tempdir().unwrap();
        let picture = |value: f32| Image::filled(ImageSize::new(9, 7).unwrap(), [value; 4]);
        let check = |value, permissions| {
            let name = (folder.path(), "kit-snapshot");
            check_snapshot(name, &picture(value), &Tolerance::exact(), permissions)
        };
        assert!(
            check(0.25, NONE).unwrap_err().contains("ADD_SNAPSHOTS"),
            "missing"
        );
        assert!(
            check(0.25, UPDATE).unwrap_err().contains("no snapshot"),
            "an update adds nothing"
        );
        assert_eq!(check(0.25, ADD), Ok(()));
        assert_eq!(check(0.25, NONE), Ok(()), "both sides are quantised alike");
        assert!(check(0.26, NONE).unwrap_err().contains("UPDATE_SNAPSHOTS"));
        assert!(check(0.26, ADD).is_err(), "adding changes nothing that exists");
        assert_eq!(check(0.26, UPDATE), Ok(()));
        assert_eq!(check(0.26, NONE), Ok(()));
    }
}
