//! The labels of a segmentation: a colour and an opacity each.

use eframe::egui::{Button, DragValue, Grid, Role, ScrollArea, Ui, WidgetInfo};
use splatvol::{Label, TransferFunction};
use splatvol_document::keys::ItemKeys;

use super::color;
use super::look::Changed;
use crate::model::shown_volume::ShownVolume;

/// Most labels that are listed.
const MOST: usize = 256;
/// Height of the list, points.
const HEIGHT: f32 = 300.0;
/// Opacity of a label that is shown and never had one.
const OPACITY: f64 = 0.9;

/// The labels of the data that are shown, and the opacities of those that are hidden.
#[derive(Default)]
pub(super) struct LabelsState {
    source: Option<ItemKeys>,
    values: Vec<f64>,
    hidden: Vec<(f64, f64)>,
}

impl LabelsState {
    /// Searches other data for their labels.
    fn follow(&mut self, shown: ShownVolume<'_>) {
        let source = shown.source();
        if self.source.as_ref() != Some(&source) {
            self.values = shown.volume.whole_values(MOST).unwrap_or_default();
            self.source = Some(source);
            self.hidden.clear();
        }
    }

    /// Shows a label as it was, or hides it.
    fn show(&mut self, label: &mut Label, is_shown: bool) {
        let of = |(value, _): &(f64, f64)| *value == label.value;
        let before = self
            .hidden
            .iter()
            .position(of)
            .map(|at| self.hidden.swap_remove(at));
        match is_shown {
            true if label.opacity == 0.0 => label.opacity = before.map_or(OPACITY, |(_, opacity)| opacity),
            true => {}
            false => {
                let last = if label.opacity > 0.0 {
                    Some(label.opacity)
                } else {
                    before.map(|b| b.1)
                };
                self.hidden.extend(last.map(|opacity| (label.value, opacity)));
                label.opacity = 0.0;
            }
        }
    }
}

/// Shows the labels, and takes edits of them.
pub(super) fn show(
    ui: &mut Ui,
    (function, shown): (&TransferFunction, Option<ShownVolume<'_>>),
    (state, changed): (&mut LabelsState, &mut Changed),
) {
    if let Some(shown) = shown {
        state.follow(shown);
    }
    if state.values.is_empty() {
        ui.label(format!("It has no labels, or more than {MOST}."));
        return;
    }
    let label = |&value: &f64| Label {
        value,
        rgb: function.color(value),
        opacity: function.opacity(value),
    };
    let labels: Vec<Label> = state.values.iter().map(label).collect();
    let mut edited = labels.clone();
    ui.label(format!("{} labels", labels.len()));
    ScrollArea::vertical().max_height(HEIGHT).show(ui, |ui| {
        Grid::new("labels").striped(true).show(ui, |ui| {
            for index in 0..edited.len() {
                row(ui, (&mut edited, index), state);
                ui.end_row();
            }
        });
    });
    if edited != labels {
        *changed = Some(TransferFunction::of_labels(&edited, function.unit_distance));
    }
}

fn row(ui: &mut Ui, (labels, index): (&mut [Label], usize), state: &mut LabelsState) {
    let label = &mut labels[index];
    let name = label.value.to_string();
    let mut is_shown = label.opacity > 0.0;
    let checkbox = ui.checkbox(&mut is_shown, "");
    checkbox
        .widget_info(|| WidgetInfo::selected(Role::CheckBox, true, is_shown, format!("Show label {name}")));
    if checkbox.changed() {
        state.show(label, is_shown);
    }
    color::button(ui, &mut label.rgb, format!("Colour of label {name}"));
    ui.label(&name);
    let drag = DragValue::new(&mut label.opacity).speed(0.005).range(0.0..=1.0);
    let drag = ui.add(drag.max_decimals(4));
    let opacity = label.opacity;
    drag.widget_info(|| WidgetInfo {
        label: Some(format!("Opacity of label {name}")),
        ..WidgetInfo::drag_value(true, opacity)
    });
    let only = ui.add(Button::new("Only").small());
    only.widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("Only label {name}")));
    if only.on_hover_text("hide all others").clicked() {
        for (other, label) in labels.iter_mut().enumerate() {
            state.show(label, other == index);
        }
    }
}
