//! The scene: its items, whether they are shown, and where they stand.

use eframe::egui::{CollapsingHeader, DragValue, Grid, RichText, Ui};
use splatvol_document::Edit;
use splatvol_document::keys::{ItemKeys, Scale};

use super::choices;
use crate::model::Model;

/// Shows the list; returns whether a file is to be added.
pub(super) fn show(ui: &mut Ui, model: &mut Model, selected: &mut usize) -> bool {
    ui.heading("Scene");
    let items = model.session().items().to_vec();
    for (index, item) in items.iter().enumerate() {
        ui.push_id(index, |ui| row(ui, model, (index, item, items.len()), selected));
    }
    let adds = ui.button("Add a file ...").clicked();
    ui.separator();
    if let Some(item) = items.get(*selected) {
        choices::show(ui, model, (*selected, item));
        CollapsingHeader::new("Place").show(ui, |ui| place(ui, model, (*selected, item)));
    }
    adds
}

/// The last part of a path, and the channel, if one is named.
pub(super) fn short_name(item: &ItemKeys) -> String {
    let file = item.file.trim_end_matches('/');
    let name = file.rsplit('/').next().unwrap_or(file);
    match item.channel {
        Some(channel) => format!("{name}, channel {}", channel + 1),
        None => name.to_owned(),
    }
}

fn row(
    ui: &mut Ui,
    model: &mut Model,
    (index, item, count): (usize, &ItemKeys, usize),
    selected: &mut usize,
) {
    let name = short_name(item);
    ui.horizontal(|ui| {
        let mut visible = item.is_visible();
        let shows_others = model
            .session()
            .items()
            .iter()
            .filter(|item| item.is_visible())
            .count()
            > 1;
        let toggle = ui.add_enabled_ui(shows_others || !visible, |ui| {
            let response = ui.checkbox(&mut visible, "");
            response.widget_info(|| {
                eframe::egui::WidgetInfo::selected(
                    eframe::egui::Role::CheckBox,
                    true,
                    visible,
                    format!("Show {name}"),
                )
            });
            response.on_hover_text("shown or hidden").changed()
        });
        if toggle.inner {
            let path = format!("item[{index}].visible");
            // What is hidden has no look yet, if it never was shown.
            let mut document = model.document().clone();
            document.items[index].visible = if visible { None } else { Some(false) };
            match document.items[index].transfer_function.is_some() {
                true => model.edit(match visible {
                    true => Edit::unset(path),
                    false => Edit::set(path, false),
                }),
                false => model.change(document),
            }
        }
        if ui
            .selectable_label(*selected == index, &name)
            .on_hover_text(&item.file)
            .clicked()
        {
            *selected = index;
        }
        if count > 1
            && ui
                .small_button("Remove")
                .on_hover_text(format!("remove {name}"))
                .clicked()
        {
            model.remove(index);
        }
    });
    if let Some(facts) = model.facts(item) {
        ui.label(RichText::new(&facts.summary).small().weak());
    }
}

/// Shift and scale.
fn place(ui: &mut Ui, model: &mut Model, (index, item): (usize, &ItemKeys)) {
    let mut shift = item.translate.unwrap_or_default();
    let mut changed = false;
    Grid::new("shift").show(ui, |ui| {
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let label = ui.label(format!("Shift {name}"));
            let value = ui
                .add(DragValue::new(&mut shift[axis]).speed(0.5))
                .labelled_by(label.id);
            changed |= value.changed();
            ui.end_row();
        }
    });
    if changed {
        model.gesture(|session| session.adjust_item(index, "translate", &shift));
    }
    let mut scale = match item.scale {
        None => 1.0,
        Some(Scale::Uniform(scale)) => scale,
        Some(Scale::Axes(_)) => {
            ui.label("The document scales each axis by a factor of its own.");
            return;
        }
    };
    ui.horizontal(|ui| {
        let label = ui.label("Scale");
        let value = DragValue::new(&mut scale).speed(0.01).range(1e-3..=1e3);
        if ui.add(value).labelled_by(label.id).changed() {
            model.gesture(|session| session.adjust_item(index, "scale", &Scale::Uniform(scale)));
        }
    });
}
