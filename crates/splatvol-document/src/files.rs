//! The door to files: whatever a document names is read through here.
//!
//! Browsers give the engine's module no files, so there the door is shut, and the readers behind it are left out: those that pages
//! have are a module of their own, which makes no pictures (`splatvol_web::files`).

use std::io;
use std::path::Path;

use splatvol_io::{
    DataKind, DataOptions, IoError, Loaded, LoadedData, LoadedImage, Opened, ReadOptions, StoredCameraKey,
};
use splatvol_scene::{GradientOpacityPoint, TransferFunction, TransferFunction2d};

/// Whether there are files. A constant: what follows where there are none is no part of the program.
const ARE_THERE: bool = !cfg!(all(target_family = "wasm", target_os = "unknown"));

macro_rules! doors {
    ($($(#[$doc:meta])* $name:ident($($argument:ident: $kind:ty),*) -> $result:ty;)*) => {
        $(
            $(#[$doc])*
            pub(crate) fn $name(path: impl AsRef<Path> $(, $argument: $kind)*) -> Result<$result, IoError> {
                if !ARE_THERE {
                    return Err(none(path.as_ref()));
                }
                splatvol_io::$name(path $(, $argument)*)
            }
        )*
    };
}

doors! {
    /// See [`splatvol_io::data_kind`].
    data_kind(options: &DataOptions) -> DataKind;
    /// See [`splatvol_io::read_data`].
    read_data(options: &DataOptions) -> LoadedData;
    /// See [`splatvol_io::read_volume`].
    read_volume(options: &ReadOptions) -> Loaded;
    /// See [`splatvol_io::open_volume`].
    open_volume(options: &ReadOptions) -> Option<Opened>;
    /// See [`splatvol_io::read_transfer_function`].
    read_transfer_function(value_range: [f64; 2]) -> (TransferFunction, Vec<String>);
    /// See [`splatvol_io::read_transfer_function_2d`].
    read_transfer_function_2d(unit_distance: f64) -> TransferFunction2d;
    /// See [`splatvol_io::read_gradient_opacity`].
    read_gradient_opacity() -> Option<Vec<GradientOpacityPoint>>;
    /// See [`splatvol_io::read_image`].
    read_image() -> LoadedImage;
    /// See [`splatvol_io::read_image_metadata`].
    read_image_metadata() -> Vec<(String, String)>;
    /// See [`splatvol_io::read_camera_keys`].
    read_camera_keys() -> Vec<StoredCameraKey>;
}

/// See [`splatvol_io::read_text`].
pub(crate) fn read_text(format: &'static str, path: &Path) -> Result<String, IoError> {
    if !ARE_THERE {
        return Err(none(path));
    }
    splatvol_io::read_text(format, path)
}

fn none(path: &Path) -> IoError {
    IoError::Open {
        source: io::Error::new(io::ErrorKind::Unsupported, "there are no files here"),
        path: path.to_owned(),
    }
}
