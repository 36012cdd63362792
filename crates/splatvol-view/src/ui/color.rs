//! A button that shows a colour, and changes it.

use eframe::egui::{Role, Ui, WidgetInfo};

/// A button of a colour, sRGB, 0..1, with a name for screen readers; returns whether the colour was changed.
pub(super) fn button(ui: &mut Ui, rgb: &mut [f64; 3], name: String) -> bool {
    let mut codes = rgb.map(|channel| (255.0 * channel).round() as u8);
    let button = ui.color_edit_button_srgb(&mut codes);
    button.widget_info(|| WidgetInfo::labeled(Role::ColorWell, true, &name));
    if button.changed() {
        *rgb = codes.map(|code| f64::from(code) / 255.0);
    }
    button.changed()
}
