//! What a file has to choose from: its channel, time point, level of detail and series.

use eframe::egui::{ComboBox, Slider, Ui};
use splatvol_document::keys::ItemKeys;

use crate::model::opening::without_look;
use crate::model::{Choices, Model};

/// Colour maps of channels that are shown together.
const MAPS: [&str; 6] = ["green", "magenta", "cyan", "yellow", "red", "blue"];

/// Shows the choices of an item, and makes others.
pub(super) fn show(ui: &mut Ui, model: &mut Model, (index, item): (usize, &ItemKeys)) {
    let Some(choices) = model.facts(item).map(|facts| facts.choices.clone()) else {
        return;
    };
    channels(ui, model, (index, item, &choices));
    if choices.series.len() > 1 {
        let of = |name: &String| item.series.as_deref() == Some(series_key(name));
        let shown = choices.series.iter().find(|name| of(name));
        let shown = shown.map_or("the first or largest", String::as_str);
        if let Some(other) = combo(ui, "Series", (shown, &choices.series)) {
            let key = series_key(&choices.series[other]).to_owned();
            choose(model, index, |item| ItemKeys {
                series: Some(key),
                ..without_look(item)
            });
        }
    }
    if choices.times > 1 {
        // While it is dragged, nothing is read yet.
        let id = ui.scope_id().with("time point");
        let dragged = ui.data(|data| data.get_temp(id));
        let mut time = dragged.unwrap_or(item.time.unwrap_or(0));
        let response = ui.add(Slider::new(&mut time, 0..=choices.times - 1).text("Time point"));
        if response.dragged() {
            ui.data_mut(|data| data.insert_temp(id, time));
        } else if response.changed() || response.drag_stopped() {
            ui.data_mut(|data| data.remove::<usize>(id));
            choose(model, index, |item| ItemKeys {
                time: Some(time),
                ..item.clone()
            });
        }
    }
    if choices.levels.len() > 1 {
        let names: Vec<String> = choices
            .levels
            .iter()
            .map(|[x, y, z]| format!("{x} x {y} x {z}"))
            .collect();
        let level = item.level.unwrap_or(0).min(names.len() - 1);
        if let Some(other) = combo(ui, "Level of detail", (&names[level].clone(), &names)) {
            choose(model, index, |item| ItemKeys {
                level: Some(other),
                ..item.clone()
            });
        }
    }
}

/// What names a series: readers describe it as `2: head 5 mm`, or by its name alone.
fn series_key(name: &str) -> &str {
    name.split_once(": ").map_or(name, |(key, _)| key)
}

fn channels(ui: &mut Ui, model: &mut Model, (index, item, choices): (usize, &ItemKeys, &Choices)) {
    let count = choices.channels.len();
    if count < 2 {
        return;
    }
    let chosen = item.channel.unwrap_or(0).min(count - 1);
    if let Some(other) = combo(ui, "Channel", (&choices.channels[chosen], &choices.channels)) {
        choose(model, index, |item| ItemKeys {
            channel: Some(other),
            ..without_look(item)
        });
    }
    let all = ui.button("All channels together");
    if all
        .on_hover_text("an item and a colour for each channel")
        .clicked()
    {
        let mut document = model.document().clone();
        let each = (0..count).map(|channel| ItemKeys {
            channel: Some(channel),
            cmap: Some(MAPS[channel % MAPS.len()].to_owned()),
            ..without_look(item)
        });
        document.items.splice(index..=index, each);
        model.change(document);
    }
}

/// A list of names; returns the number of the one that was chosen instead.
fn combo(ui: &mut Ui, label: &str, (shown, names): (&str, &[String])) -> Option<usize> {
    let mut chosen = None;
    ComboBox::from_label(label)
        .selected_text(shown)
        .width(120.0)
        .show_ui(ui, |ui| {
            for (number, name) in names.iter().enumerate() {
                if ui.selectable_label(name == shown, name).clicked() && name != shown {
                    chosen = Some(number);
                }
            }
        });
    chosen
}

/// Asks for other data of the same file, as a step.
fn choose(model: &mut Model, index: usize, change: impl FnOnce(&ItemKeys) -> ItemKeys) {
    let mut document = model.document().clone();
    if let Some(item) = document.items.get_mut(index) {
        *item = change(item);
        model.change(document);
    }
}
