//! How the picture is made: its kind, its quality, its light, its size and background.

use eframe::egui::{CollapsingHeader, ComboBox, DragValue, RichText, Slider, Ui};
use serde_json::Value;
use splatvol::{EngineChoice, ImageSize};
use splatvol_document::Edit;
use splatvol_document::keys::names::{CompositingName, CoverageName, PresetName};
use splatvol_document::keys::{Background, PictureSize, SettingKeys};
use splatvol_document::look::Wishes;

use crate::model::{DrawnBy, Model};

const KINDS: [(CompositingName, &str, &str); 5] = [
    (
        CompositingName::ImageSheets,
        "Material",
        "colours and opacities, front to back",
    ),
    (CompositingName::Mip, "Maximum", "the largest value along the ray"),
    (
        CompositingName::Minip,
        "Minimum",
        "the smallest value along the ray",
    ),
    (CompositingName::Mean, "Mean", "the mean value along the ray"),
    (
        CompositingName::Xray,
        "X-ray",
        "the sum along the ray, as in a radiograph",
    ),
];

const QUALITIES: [(PresetName, &str, &str); 3] = [
    (PresetName::Fast, "Fast", "steep edges can show bands"),
    (PresetName::Balanced, "Balanced", "between fast and best"),
    (
        PresetName::Best,
        "Best",
        "closest to the exact integral, and slowest",
    ),
];

const ENGINES: [(EngineChoice, &str, &str); 3] = [
    (
        EngineChoice::Auto,
        "Automatic",
        "the GPU where there is one that draws the scene, else the processor",
    ),
    (
        EngineChoice::Cpu,
        "Processor",
        "everything, and the same everywhere",
    ),
    (
        EngineChoice::Gpu,
        "GPU",
        "what it does not draw is refused by name; pictures are saved by the processor all the same",
    ),
];

const BACKGROUNDS: [&str; 5] = ["charcoal", "black", "gray", "white", "none"];

pub(super) fn show(ui: &mut Ui, model: &mut Model) {
    ui.separator();
    CollapsingHeader::new("Method")
        .default_open(true)
        .show(ui, |ui| method(ui, model));
    CollapsingHeader::new("Light").show(ui, |ui| light(ui, model));
    CollapsingHeader::new("Picture").show(ui, |ui| picture(ui, model));
}

fn method(ui: &mut Ui, model: &mut Model) {
    let settings = model.document().settings.clone();
    let kind = settings.compositing.unwrap_or(CompositingName::ImageSheets);
    let known = KINDS.iter().find(|(name, ..)| *name == kind);
    let text = known.map_or_else(|| format!("{kind:?}"), |(_, text, _)| (*text).to_owned());
    let mut asked = None;
    ComboBox::from_label("Kind of picture")
        .selected_text(text)
        .show_ui(ui, |ui| {
            for (name, text, about) in KINDS {
                if ui
                    .selectable_label(kind == name, text)
                    .on_hover_text(about)
                    .clicked()
                {
                    asked = Some(SettingKeys {
                        compositing: Some(name),
                        ..SettingKeys::default()
                    });
                }
            }
        });
    ui.horizontal(|ui| {
        ui.label("Quality");
        for (name, text, about) in QUALITIES {
            let is_set = is_preset(&settings, name);
            if ui.selectable_label(is_set, text).on_hover_text(about).clicked() && !is_set {
                asked = Some(SettingKeys {
                    preset: Some(name),
                    ..SettingKeys::default()
                });
            }
        }
    });
    let mut smooth = settings.coverage == Some(CoverageName::Adaptive);
    let checkbox = ui.checkbox(&mut smooth, "Smooth edges");
    if checkbox
        .on_hover_text("several samples for pixels that differ from their neighbours")
        .changed()
    {
        asked = Some(SettingKeys {
            coverage: Some(if smooth {
                CoverageName::Adaptive
            } else {
                CoverageName::Off
            }),
            ..SettingKeys::default()
        });
    }
    if let Some(keys) = asked {
        model.change_settings(keys);
    }
    if EngineChoice::WITH_GPU {
        engine(ui, model);
    }
}

/// Which engine draws what the window shows, and who drew it.
fn engine(ui: &mut Ui, model: &mut Model) {
    let choice = model.engine_choice();
    let known = ENGINES.iter().find(|(known, ..)| *known == choice);
    ComboBox::from_label("Engine")
        .selected_text(known.map_or("", |(_, name, _)| *name))
        .show_ui(ui, |ui| {
            for (other, name, about) in ENGINES {
                let label = ui.selectable_label(choice == other, name);
                if label.on_hover_text(about).clicked() && choice != other {
                    model.choose_engine(other);
                }
            }
        });
    let drawn_by = model.shown().map(|shown| shown.drawn_by.clone());
    let text = match drawn_by.unwrap_or_default() {
        DrawnBy { device, .. } if !device.is_empty() => format!("Drawn by {device}"),
        DrawnBy { why, .. } if !why.is_empty() => format!("Drawn by the processor: {why}"),
        _ => "Drawn by the processor".to_owned(),
    };
    ui.label(RichText::new(text).small().weak());
}

/// Whether these are the settings of a preset.
fn is_preset(settings: &SettingKeys, name: PresetName) -> bool {
    let preset = SettingKeys {
        preset: Some(name),
        ..SettingKeys::default()
    };
    let resolved = |keys: &SettingKeys| keys.resolve(None, Wishes::default()).ok();
    let own = resolved(settings);
    own.is_some() && own == resolved(&preset.over(settings))
}

fn light(ui: &mut Ui, model: &mut Model) {
    let settings = model.document().settings.clone();
    let mut lit = settings.shade.unwrap_or(settings.ambient.is_some());
    if ui.checkbox(&mut lit, "Lit").changed() {
        model.change_settings(SettingKeys {
            shade: Some(lit),
            ..SettingKeys::default()
        });
        return;
    }
    let (Some(ambient), Some(diffuse), Some(specular), Some(power)) = (
        settings.ambient,
        settings.diffuse,
        settings.specular,
        settings.specular_power,
    ) else {
        return;
    };
    let sliders = [
        ("ambient", "Ambient", ambient, 0.0..=1.0),
        ("diffuse", "Diffuse", diffuse, 0.0..=1.0),
        ("specular", "Highlight", specular, 0.0..=1.0),
        ("specular-power", "Sharpness", power, 1.0..=100.0),
    ];
    for (key, text, mut value, range) in sliders {
        if ui.add(Slider::new(&mut value, range).text(text)).changed() {
            model.gesture(|session| session.adjust(Edit::set(format!("settings.{key}"), value)));
        }
    }
    if let Some(direction) = settings.light {
        direction_of_light(ui, model, direction);
    }
}

/// The direction to the light as angles: to the right and up from the camera.
fn direction_of_light(ui: &mut Ui, model: &mut Model, [x, y, z]: [f64; 3]) {
    let mut right = libm::atan2(x, -z).to_degrees();
    let mut up = libm::atan2(-y, libm::hypot(x, z)).to_degrees();
    let slider = |value, text| Slider::new(value, -90.0..=90.0).suffix("°").text(text);
    let first = ui.add(slider(&mut right, "From the right"));
    let second = ui.add(slider(&mut up, "From above"));
    if first.changed() || second.changed() {
        let (right, up) = (right.to_radians(), up.to_radians());
        let direction = [
            libm::sin(right) * libm::cos(up),
            -libm::sin(up),
            -libm::cos(right) * libm::cos(up),
        ];
        let value: Vec<Value> = direction.into_iter().map(Value::from).collect();
        model.gesture(|session| session.adjust(Edit::set("settings.light", value)));
    }
}

fn picture(ui: &mut Ui, model: &mut Model) {
    let size = model.document().size.map(|PictureSize(size)| size);
    let mut follows = size.is_none();
    let shown = model.shown().map(|shown| shown.view_size);
    if ui.checkbox(&mut follows, "As large as the window").changed() {
        match shown.filter(|_| !follows) {
            Some(size) => model.edit(Edit::set("size", PictureSize(size).to_string())),
            None => model.edit(Edit::unset("size")),
        }
        return;
    }
    if let Some(size) = size {
        let mut sides = [size.width(), size.height()];
        ui.horizontal(|ui| {
            let mut changed = false;
            for (side, name) in sides.iter_mut().zip(["Width", "Height"]) {
                let label = ui.label(name);
                changed |= ui
                    .add(DragValue::new(side).range(1..=16_384))
                    .labelled_by(label.id)
                    .changed();
            }
            if let (true, Ok(size)) = (changed, ImageSize::new(sides[0], sides[1])) {
                let size = PictureSize(size).to_string();
                model.gesture(|session| session.adjust(Edit::set("size", size)));
            }
        });
    }
    let background = model.document().background;
    let name = match background {
        Some(known) => serde_json::to_value(known).map_or_else(
            |_| String::new(),
            |value| match value {
                Value::String(name) => name,
                other => other.to_string(),
            },
        ),
        None => String::new(),
    };
    ComboBox::from_label("Background")
        .selected_text(name)
        .show_ui(ui, |ui| {
            for name in BACKGROUNDS {
                let is_set = name.parse::<Background>().ok() == background;
                if ui.selectable_label(is_set, name).clicked() {
                    model.edit(Edit::set("background", name));
                }
            }
        });
    let mut deep = model.document().bits == Some(16);
    if ui.checkbox(&mut deep, "16 bits per channel").changed() {
        model.edit(Edit::set("bits", if deep { 16 } else { 8 }));
    }
}
