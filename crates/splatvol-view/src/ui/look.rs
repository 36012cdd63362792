//! The look of an item: its transfer function, by names, by numbers, and by hand.

use eframe::egui::{CollapsingHeader, ComboBox, DragValue, Grid, Slider, Ui};
use splatvol::{ColorMap, OpacityCurve, SceneError, TransferFunction};
use splatvol_document::keys::ItemKeys;

use super::curve::{self, CurveState, Names};
use super::fading;
use super::labels::{self, LabelsState};
use super::regions::{self, RegionsState};
use super::scene::short_name;
use super::status::number;
use crate::model::opening::without_look;
use crate::model::shown_volume::ShownVolume;
use crate::model::{Facts, Model, Values, curve as edits};

/// How the editors of looks are shown.
#[derive(Default)]
pub(super) struct LookState {
    curve: CurveState,
    regions: RegionsState,
    labels: LabelsState,
    fading: CurveState,
}

/// Maps that every kind of colour vision can read, which come first.
const FAIR_MAPS: [&str; 4] = ["viridis", "cividis", "magma", "gray"];

pub(super) fn show(ui: &mut Ui, model: &mut Model, (selected, state): (usize, &mut LookState)) {
    let Some(item) = model.session().items().get(selected).cloned() else {
        return;
    };
    ui.heading(format!("Look of {}", short_name(&item)));
    let Some(function) = item.transfer_function.clone() else {
        points(ui, model, (selected, &item));
        return;
    };
    let values = model.facts(&item).and_then(|facts: &Facts| facts.values.clone());
    let mut changed = None;
    if item.labels == Some(true) {
        let shown = ShownVolume::of(model, selected);
        labels::show(ui, (&function, shown), (&mut state.labels, &mut changed));
    } else if has_gradients(&values) && regions::choice(ui, model, (selected, &item), &mut state.regions) {
        regions::show(ui, model, (selected, &item, values.as_ref()), &mut state.regions);
        return;
    } else {
        of_values(ui, (&function, values.as_ref()), (&mut state.curve, &mut changed));
        if has_gradients(&values) {
            CollapsingHeader::new("Opacity by gradient")
                .id_salt("fading")
                .show(ui, |ui| {
                    fading::show(ui, (model, selected), (&mut state.fading, &mut state.regions));
                });
        }
    }
    unit_distance(ui, (&function, values.as_ref()), &mut changed);
    ui.horizontal(|ui| {
        if ui
            .button("Automatic")
            .on_hover_text("the look that the data suggest")
            .clicked()
        {
            let mut document = model.document().clone();
            if let Some(item) = document.items.get_mut(selected) {
                *item = ItemKeys {
                    labels: item.labels,
                    ..without_look(item)
                };
            }
            model.change(document);
        }
        if item.labels != Some(true) {
            surface(ui, model, (selected, values.as_ref()));
        }
    });
    match changed {
        Some(Ok(function)) if function != item.transfer_function.clone().unwrap_or(function.clone()) => {
            model.gesture(|session| session.adjust_item(selected, "transfer-function", &function));
        }
        Some(Err(error)) => model.say(SceneError::to_string(&error), true),
        _ => {}
    }
}

/// Whether gradients of values are known: those of volumes.
fn has_gradients(values: &Option<Values>) -> bool {
    values.as_ref().is_some_and(|values| values.is_grid)
}

/// The function of values: names, the curve, its range and its points.
fn of_values(
    ui: &mut Ui,
    (function, values): (&TransferFunction, Option<&Values>),
    (state, changed): (&mut CurveState, &mut Changed),
) {
    names(ui, function, changed);
    curve::show(ui, (function, values), (state, changed));
    range(ui, function, changed);
    CollapsingHeader::new("Points")
        .id_salt("points")
        .show(ui, |ui| curve::table(ui, function, Names::LOOK, (state, changed)));
}

/// A change of the transfer function, or why it cannot be.
pub(super) type Changed = Option<Result<TransferFunction, SceneError>>;

fn names(ui: &mut Ui, function: &TransferFunction, changed: &mut Changed) {
    ui.horizontal(|ui| {
        ComboBox::from_id_salt("colour map")
            .selected_text("Colour map")
            .width(130.0)
            .show_ui(ui, |ui| {
                let others = ColorMap::names().filter(|name| !FAIR_MAPS.contains(name));
                for name in FAIR_MAPS.into_iter().chain(others) {
                    if ui.selectable_label(false, name).clicked() {
                        *changed =
                            Some(ColorMap::from_name(name).and_then(|map| edits::with_map(function, map)));
                    }
                }
            })
            .response
            .on_hover_text("colours by name; the first four can be read with any colour vision");
        ComboBox::from_id_salt("opacity curve")
            .selected_text("Opacity curve")
            .width(130.0)
            .show_ui(ui, |ui| {
                for name in OpacityCurve::names() {
                    if ui.selectable_label(false, &name).clicked() {
                        let curve = OpacityCurve::from_name(&name);
                        *changed = Some(curve.and_then(|curve| edits::with_curve(function, &curve)));
                    }
                }
            })
            .response
            .on_hover_text("opacities by name, over the present range");
    });
}

fn range(ui: &mut Ui, function: &TransferFunction, changed: &mut Changed) {
    let [mut low, mut high] = edits::span(function);
    let speed = (high - low) / 300.0;
    ui.horizontal(|ui| {
        let from = ui.label("Range from");
        let first = ui.add(DragValue::new(&mut low).speed(speed)).labelled_by(from.id);
        let to = ui.label("to");
        let last = ui.add(DragValue::new(&mut high).speed(speed)).labelled_by(to.id);
        if (first.changed() || last.changed()) && high > low {
            *changed = Some(edits::with_span(function, [low, high]));
        }
    });
}

/// The length to which opacities refer, and what that means: a half-depth.
fn unit_distance(
    ui: &mut Ui,
    (function, values): (&TransferFunction, Option<&Values>),
    changed: &mut Changed,
) {
    let spacing = values.map_or(1.0, |values| values.spacing);
    let unit = values.map_or("", |values| values.unit);
    let mut length = function.unit_distance.unwrap_or(spacing);
    if length_slider(ui, &mut length, (spacing, unit)) {
        *changed = Some(edits::with_unit_distance(function, Some(length)));
    }
    let most = function
        .opacities()
        .iter()
        .map(|point| point.opacity)
        .fold(0.0, f64::max);
    let text = match edits::half_depth(most, length) {
        Some(depth) => format!(
            "The densest material takes half of the light in {} {unit}.",
            number(depth)
        ),
        None => "Everything is transparent.".to_owned(),
    };
    ui.label(text.replace(" .", "."));
}

/// The length to which opacities refer, around the spacing of the samples; returns whether it was changed.
pub(super) fn length_slider(ui: &mut Ui, length: &mut f64, (spacing, unit): (f64, &str)) -> bool {
    let slider = Slider::new(length, 0.01 * spacing..=100.0 * spacing)
        .logarithmic(true)
        .suffix(format!(" {unit}"))
        .text("Opacity per");
    ui.add(slider).changed()
}

/// A surface of one value in place of the curves.
fn surface(ui: &mut Ui, model: &mut Model, (selected, values): (usize, Option<&Values>)) {
    let Some(values) = values else {
        return;
    };
    let id = ui.scope_id().with("surface value");
    let [low, high] = values.range;
    let mut value: f64 = ui.data_mut(|data| *data.get_temp_mut_or(id, 0.5 * (low + high)));
    if ui
        .button("Surface of")
        .on_hover_text("show the surface of one value")
        .clicked()
    {
        let keys = ItemKeys {
            iso: Some(value),
            ..ItemKeys::default()
        };
        model.change_look(selected, keys);
    }
    let drag = ui.add(
        DragValue::new(&mut value)
            .speed((high - low) / 300.0)
            .range(low..=high),
    );
    drag.widget_info(|| eframe::egui::WidgetInfo::drag_value(true, value));
    if drag.on_hover_text("value of the surface").changed() {
        ui.data_mut(|data| data.insert_temp(id, value));
    }
}

/// The look of points, which have no transfer function.
fn points(ui: &mut Ui, model: &mut Model, (selected, item): (usize, &ItemKeys)) {
    if item.kind.as_deref() == Some("gaussians") {
        return;
    }
    let Some(mut color) = item.color else {
        ui.label("It has colours of its own.");
        return;
    };
    Grid::new("points").show(ui, |ui| {
        for (channel, name) in ["Red", "Green", "Blue"].into_iter().enumerate() {
            if ui
                .add(Slider::new(&mut color[channel], 0.0..=1.0).text(name))
                .changed()
            {
                model.gesture(|session| session.adjust_item(selected, "color", &color));
            }
            ui.end_row();
        }
    });
}
