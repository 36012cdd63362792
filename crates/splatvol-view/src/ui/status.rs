//! The status line: what the picture is, how long it took, what is under the pointer, and messages.

use eframe::egui::{Align, Layout, ProgressBar, RichText, Ui};

use super::style;
use crate::model::Model;
use crate::model::probe::Probe;

/// Shows it; `flies`: keys and drags fly.
pub(super) fn show(ui: &mut Ui, model: &mut Model, (hovered, flies): (Option<&Probe>, bool)) {
    if let Some(message) = model.message().cloned() {
        ui.horizontal_wrapped(|ui| {
            let (sign, color) = match message.is_error {
                true => ("Error: ", style::WARNING),
                false => ("", style::TEXT),
            };
            ui.label(RichText::new(format!("{sign}{}", message.text)).color(color));
            if ui.button("Dismiss").clicked() {
                model.dismiss();
            }
        });
    }
    ui.horizontal(|ui| {
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
            if ui.button("Stop writing").clicked() {
                model.stop_writing();
            }
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if let Some(probe) = hovered {
                ui.label(under(model, probe));
            }
        });
    });
}

fn bar(ui: &mut Ui, share: f64) {
    ui.add(
        ProgressBar::new(share as f32)
            .desired_width(90.0)
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

/// A number in as many digits as a person reads.
pub(super) fn number(value: f64) -> String {
    let magnitude = value.abs();
    match magnitude {
        0.0 => "0".to_owned(),
        _ if !(1e-3..1e6).contains(&magnitude) => format!("{value:.3e}"),
        _ if magnitude >= 100.0 => format!("{value:.1}"),
        _ => format!("{value:.3}"),
    }
}
