//! Colours and text sizes of the window.

use eframe::egui::{Color32, Context, FontFamily, FontId, TextStyle, Theme, Visuals};
use splatvol::glam::DVec3;

/// Behind the picture.
pub(super) const BACKDROP: Color32 = Color32::from_rgb(16, 17, 20);
/// Text on the picture.
pub(super) const TEXT: Color32 = Color32::from_rgb(232, 234, 238);
/// Frames and grids.
pub(super) const FAINT: Color32 = Color32::from_rgb(92, 96, 106);
/// What is selected or has the keys.
pub(super) const ACCENT: Color32 = Color32::from_rgb(86, 180, 233);
/// Warnings and errors, apart from the accent for every kind of colour vision.
pub(super) const WARNING: Color32 = Color32::from_rgb(240, 170, 60);
/// Bars of a histogram.
pub(super) const BARS: Color32 = Color32::from_rgb(70, 76, 90);

/// The world's axes: colours of Okabe and Ito, which can be told apart by every kind of colour vision, with letters.
pub(super) const AXES: [(&str, DVec3, Color32); 3] = [
    ("x", DVec3::X, Color32::from_rgb(230, 120, 40)),
    ("y", DVec3::Y, Color32::from_rgb(0, 190, 140)),
    ("z", DVec3::Z, Color32::from_rgb(86, 180, 233)),
];

/// Sets up a window: dark, so that it does not outshine the picture, and without motion.
pub(super) fn apply(context: &Context) {
    context.set_theme(Theme::Dark);
    let mut visuals = Visuals::dark();
    visuals.panel_fill = Color32::from_rgb(30, 32, 37);
    visuals.window_fill = Color32::from_rgb(36, 38, 44);
    visuals.extreme_bg_color = Color32::from_rgb(18, 19, 23);
    visuals.override_text_color = Some(Color32::from_rgb(220, 223, 228));
    visuals.selection.bg_fill = Color32::from_rgb(30, 92, 140);
    visuals.slider_trailing_fill = true;
    context.set_visuals(visuals);
    context.all_styles_mut(|style| {
        // Nothing moves by itself.
        style.animation_time = 0.0;
        style.spacing.item_spacing.y = 5.0;
        style.spacing.slider_width = 130.0;
        style
            .text_styles
            .insert(TextStyle::Heading, FontId::new(15.0, FontFamily::Proportional));
        style
            .text_styles
            .insert(TextStyle::Body, FontId::new(13.5, FontFamily::Proportional));
        style
            .text_styles
            .insert(TextStyle::Button, FontId::new(13.5, FontFamily::Proportional));
        style
            .text_styles
            .insert(TextStyle::Small, FontId::new(12.0, FontFamily::Proportional));
    });
}
