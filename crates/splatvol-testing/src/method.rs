//! Settings of tests, varied from one base for any method.

use splatvol_scene::{FlatSettings, RenderSettings};

/// The settings that flat ones stand for.
///
/// # Panics
/// If no method has them.
pub fn checked(flat: FlatSettings) -> RenderSettings {
    match RenderSettings::try_from(flat) {
        Ok(settings) => settings,
        Err(error) => panic!("no method has these settings: {error}"),
    }
}
