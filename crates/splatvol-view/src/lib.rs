//! The viewer: a window in which volumes, meshes, points and 3-D Gaussians are turned, cut and given a look.
//!
//! What the window shows is a document ([`splatvol_document::Document`]): gestures and panels edit it, pictures carry it,
//! and `splatvol render --like` makes the same bytes. The [`model`] holds it without any window; [`ui`] is egui around it.
//!
//! While something moves the picture is a draft, on a raster that is coarse enough to be in time; at rest it is what `render` makes
//! with the same engine. Pictures are saved by the CPU's engine, whose bytes are the same everywhere.
#![forbid(unsafe_code)]

pub mod model;
pub mod ui;

use eframe::egui::ViewportBuilder;

pub use model::Start;

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    /// There is no display, or no OpenGL on it.
    #[error("no window can be opened: {0}")]
    Window(String),
}

/// Opens a window, and returns when it is closed.
///
/// # Errors
/// No display, or no OpenGL.
pub fn run(start: Start) -> Result<(), ViewError> {
    let title = match &start.files[..] {
        [] => "splatvol".to_owned(),
        files => format!("{} - splatvol", files.join(", ")),
    };
    let options = eframe::NativeOptions {
        viewport: ViewportBuilder::default()
            .with_title(&title)
            .with_app_id("splatvol")
            .with_inner_size([1280.0, 800.0])
            .with_min_inner_size([640.0, 420.0])
            .with_drag_and_drop(true),
        ..eframe::NativeOptions::default()
    };
    let created = eframe::run_native(
        "splatvol",
        options,
        Box::new(|creation| Ok(Box::new(ui::Viewer::new(&creation.egui_ctx, start)?))),
    );
    created.map_err(|error| ViewError::Window(without_source(&error.to_string())))
}

/// The text of an error of the system, `os error at FILE.rs:LINE: ...`, without the place in the sources of the library that met it.
fn without_source(text: &str) -> String {
    let parts = text.split_once("os error at ").and_then(|(before, place)| {
        let (_, after) = place.split_once(".rs:")?;
        let (_, message) = after.split_once(": ")?;
        Some(format!("{before}{message}"))
    });
    parts.unwrap_or_else(|| text.to_owned())
}

#[cfg(test)]
mod tests {
    use super::without_source;

    #[test]
    fn errors_of_the_system_name_no_source_of_a_library() {
        let own = "winit EventLoopError: os error at /sources/winit-0.30.13/src/linux/mod.rs:764: no DISPLAY is set: none";
        assert_eq!(
            without_source(own),
            "winit EventLoopError: no DISPLAY is set: none"
        );
        assert_eq!(without_source("no OpenGL"), "no OpenGL");
    }
}
