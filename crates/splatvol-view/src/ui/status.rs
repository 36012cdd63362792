//! The status line: what the picture is, how long it took, what is under the pointer, and messages. It is one line, whatever it says, so
//! that the picture keeps its size.

use std::time::Duration;

use eframe::egui::{Align, Label, Layout, ProgressBar, RichText, TextStyle, Ui, Vec2};

use super::style;
use crate::model::probe::Probe;
use crate::model::{Message, Model};

/// Seconds for which a message is shown that is no error, and for each of its characters.
const SHOWN: f64 = 5.0;
const PER_CHARACTER: f64 = 0.06;
/// Least width for what is said at the right, points.
const LEAST: f32 = 60.0;

/// The message that is shown, and since when, in the window's time.
#[derive(Default)]
pub(super) struct StatusLine {
    said: Option<(Message, f64)>,
}

impl StatusLine {
    /// Shows it; `flies`: keys and drags fly.
    pub(super) fn show(&mut self, ui: &mut Ui, model: &mut Model, (hovered, flies): (Option<&Probe>, bool)) {
        self.forget(ui, model);
        let size = Vec2::new(ui.available_width(), height(ui));
        ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
            ui.set_min_height(size.y);
            at_left(ui, model, flies);
            if ui.available_width() < LEAST {
                return;
            }
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                match (model.message().cloned(), hovered) {
                    (Some(message), _) => self.message(ui, model, &message),
                    (None, Some(probe)) => {
                        ui.add(Label::new(under(model, probe)).truncate());
                    }
                    (None, None) => {}
                }
            });
        });
    }

    /// Takes a message away that is no error, once it could be read.
    fn forget(&mut self, ui: &Ui, model: &mut Model) {
        let now = ui.input(|input| input.time);
        let Some(message) = model.message() else {
            self.said = None;
            return;
        };
        let known = self.said.as_ref().filter(|(said, _)| said == message);
        let since = known.map_or(now, |(_, since)| *since);
        let lasts = SHOWN + PER_CHARACTER * message.text.chars().count() as f64;
        let left = since + lasts - now;
        self.said = Some((message.clone(), since));
        if message.is_error {
            return;
        }
        if left <= 0.0 {
            model.dismiss();
        } else {
            ui.request_repaint_after(Duration::from_secs_f64(left));
        }
    }

    /// A message, as much of it as there is room for; all of it where the pointer is, as long as it is there.
    fn message(&mut self, ui: &mut Ui, model: &mut Model, message: &Message) {
        if ui.small_button("Dismiss").clicked() {
            model.dismiss();
        }
        let (sign, color) = match message.is_error {
            true => ("Error: ", style::WARNING),
            false => ("", style::TEXT),
        };
        let text = format!("{sign}{}", message.text);
        ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
            let label = ui.add(Label::new(RichText::new(text).color(color)).truncate());
            if label.hovered() {
                self.said = Some((message.clone(), ui.input(|input| input.time)));
            }
        });
    }
}

/// Height of the line: that of its buttons.
fn height(ui: &Ui) -> f32 {
    let spacing = ui.spacing();
    let button = ui.text_style_height(&TextStyle::Button) + 2.0 * spacing.button_padding.y;
    spacing.interact_size.y.max(button)
}

/// What the picture is, and what is being done.
fn at_left(ui: &mut Ui, model: &Model, flies: bool) {
    if let Some(letter) = model.looks().letter() {
        ui.label(RichText::new(format!("Look {letter}")).color(style::ACCENT));
        ui.separator();
    }
    if flies {
        let text = "Flying: W S A D E Q, drag to look around; Esc ends";
        ui.label(RichText::new(text).color(style::ACCENT));
        ui.separator();
    }
    ui.label(state(model));
    if let Some(share) = model.progress().filter(|share| *share < 1.0) {
        bar(ui, share);
    }
    if let Some(share) = model.writing() {
        ui.separator();
        ui.label("Writing");
        bar(ui, share);
        if ui.small_button("Stop writing").clicked() {
            model.stop_writing();
        }
    }
}

fn bar(ui: &mut Ui, share: f64) {
    ui.add(
        ProgressBar::new(share as f32)
            .desired_width(90.0)
            .desired_height(0.8 * height(ui))
            .show_percentage(),
    );
}

/// What the picture is.
fn state(model: &Model) -> String {
    if let Some(since) = model.asked_since() {
        let seconds = since.elapsed().as_secs_f64();
        return match seconds > 1.0 {
            true => format!("reading, {seconds:.0} s"),
            false => "reading".to_owned(),
        };
    }
    let Some(shown) = model.shown() else {
        return String::new();
    };
    let [width, height] = [shown.view_size.width(), shown.view_size.height()];
    let milliseconds = 1e3 * shown.seconds;
    match (shown.draft_step, model.is_final()) {
        (Some(step), _) => format!("draft 1/{step:.1}, {milliseconds:.0} ms  ·  {width} x {height}"),
        (None, true) => format!("final, {milliseconds:.0} ms  ·  {width} x {height}"),
        (None, false) => format!("earlier picture  ·  {width} x {height}"),
    }
}

/// Value and place under the pointer.
fn under(model: &Model, probe: &Probe) -> String {
    let visible = model.document().items.iter().filter(|item| item.is_visible());
    let item = visible.into_iter().nth(probe.item);
    let unit = item
        .and_then(|item| model.facts(item)?.values.as_ref().map(|values| values.unit))
        .unwrap_or("");
    let place = probe.place;
    let mut text = format!(
        "value {}   at x {:.2}  y {:.2}  z {:.2} {unit}",
        number(probe.value),
        place.x,
        place.y,
        place.z
    );
    if let Some(item) = item.filter(|_| model.document().items.len() > 1) {
        text.push_str(&format!("   in {}", item.file));
    }
    text
}

/// A number in as many digits as a person reads: four, or more where it is large.
pub(super) fn number(value: f64) -> String {
    let magnitude = value.abs();
    match magnitude {
        0.0 => "0".to_owned(),
        _ if !(1e-3..1e6).contains(&magnitude) => format!("{value:.3e}"),
        _ if magnitude >= 100.0 => format!("{value:.1}"),
        _ if magnitude >= 10.0 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    }
}

/// Numbers that stand side by side, with the decimals that their step has.
pub(super) fn aligned(value: f64, step: f64) -> String {
    if !(1e-6..1e6).contains(&step) {
        return number(value);
    }
    let decimals = (-libm::floor(libm::log10(step) + 1e-9)).max(0.0) as usize;
    // No zero has a sign.
    let value = if value.abs() < 0.5 * step { 0.0 } else { value };
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_beside_each_other_have_the_same_digits() {
        assert_eq!([48.317, 103.5].map(number), ["48.32", "103.5"]);
        assert_eq!(
            [0.0, 50.0, 250.0].map(|value| aligned(value, 50.0)),
            ["0", "50", "250"]
        );
        assert_eq!(
            [-0.2, -1e-17, 0.4].map(|value| aligned(value, 0.2)),
            ["-0.2", "0.0", "0.4"]
        );
        assert_eq!(aligned(3e-9, 1e-9), "3.000e-9");
    }
}
