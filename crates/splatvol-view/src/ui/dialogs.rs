//! Dialogs: opening, saving, and the table of keys. Paths are typed; files can be dropped instead.

use std::path::PathBuf;

use eframe::egui::{Align2, Context, DragValue, Grid, Key, RichText, ScrollArea, TextEdit, Ui, Window};
use splatvol::ImageSize;
use splatvol_document::keys::{ItemKeys, PictureSize};

use super::bindings::{CURVE_GESTURES, GESTURES, KEYS, names};
use super::scene::short_name;
use crate::model::Model;

/// What is open.
#[derive(Debug, Default)]
enum Open {
    #[default]
    Nothing,
    /// A path to open, or to add.
    File {
        path: String,
        adds: bool,
    },
    /// A picture to save.
    Picture {
        path: String,
        size: [u32; 2],
        overwrite: bool,
    },
    Help,
}

#[derive(Debug, Default)]
pub(super) struct Dialogs {
    open: Open,
    /// Whether the text field gets the keys next.
    focuses: bool,
}

impl Dialogs {
    pub(super) fn open_file(&mut self, adds: bool) {
        self.focuses = true;
        self.open = Open::File {
            path: String::new(),
            adds,
        };
    }

    pub(super) fn save_picture(&mut self, model: &Model) {
        let Some(shown) = model.shown() else {
            return;
        };
        let name = model
            .session()
            .items()
            .first()
            .map_or_else(|| "picture".to_owned(), short_name);
        let stem = name
            .rsplit(':')
            .next_back()
            .unwrap_or("picture")
            .replace("sample:", "");
        let stem = stem.split('.').next().unwrap_or("picture");
        let stem = if stem == "sample" {
            name.split(':').nth(1).unwrap_or(stem)
        } else {
            stem
        };
        let size = model
            .document()
            .size
            .map_or(shown.view_size, |PictureSize(size)| size);
        self.focuses = true;
        self.open = Open::Picture {
            path: format!("{stem}.png"),
            size: [size.width(), size.height()],
            overwrite: false,
        };
    }

    pub(super) fn help(&mut self) {
        self.open = Open::Help;
    }

    pub(super) fn close(&mut self) {
        self.open = Open::Nothing;
    }

    pub(super) fn show(&mut self, context: &Context, model: &mut Model) {
        let focuses = std::mem::take(&mut self.focuses);
        let stays = match &mut self.open {
            Open::Nothing => true,
            Open::File { path, adds } => {
                let title = if *adds { "Add a file" } else { "Open a file" };
                dialog(context, title, |ui| file(ui, (path, *adds, focuses), model))
            }
            Open::Picture {
                path,
                size,
                overwrite,
            } => dialog(context, "Save a picture or the scene", |ui| {
                picture(ui, (path, focuses), (size, overwrite), model)
            }),
            Open::Help => dialog(context, "Keys and gestures", help),
        };
        if !stays {
            self.close();
        }
    }
}

/// A window in the middle; returns whether it stays open.
fn dialog(context: &Context, title: &str, add: impl FnOnce(&mut Ui) -> bool) -> bool {
    let mut open = true;
    let shown = Window::new(title)
        .collapsible(false)
        .resizable(false)
        .anchor(Align2::CENTER_CENTER, [0.0, 0.0])
        .open(&mut open)
        .show(context, add);
    open && shown.and_then(|shown| shown.inner).unwrap_or(true)
}

/// A path; returns whether Enter was pressed in it.
fn path_field(ui: &mut Ui, label: &str, path: &mut String, focuses: bool) -> bool {
    let label = ui.label(label);
    let field = ui
        .add(TextEdit::singleline(path).desired_width(420.0))
        .labelled_by(label.id);
    if focuses {
        field.request_focus();
    }
    field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter))
}

fn file(ui: &mut Ui, (path, adds, focuses): (&mut String, bool, bool), model: &mut Model) -> bool {
    let entered = path_field(ui, "File or folder, or sample:NAME", path, focuses);
    ui.label(RichText::new("A scene, or a picture that splatvol made, restores everything.").weak());
    let mut stays = true;
    ui.horizontal(|ui| {
        let go = ui.button(if adds { "Add" } else { "Open" }).clicked();
        if (go || entered) && !path.trim().is_empty() {
            let path = path.trim().to_owned();
            match adds {
                true => model.add(ItemKeys::of_file(path)),
                false => model.open(&[path]),
            }
            stays = false;
        }
        if ui.button("Cancel").clicked() {
            stays = false;
        }
    });
    stays
}

fn picture(
    ui: &mut Ui,
    (path, focuses): (&mut String, bool),
    (size, overwrite): (&mut [u32; 2], &mut bool),
    model: &mut Model,
) -> bool {
    let entered = path_field(ui, "Picture, .png or .exr; or scene, .toml", path, focuses);
    ui.horizontal(|ui| {
        for (side, name) in size.iter_mut().zip(["Width", "Height"]) {
            let label = ui.label(name);
            ui.add(DragValue::new(side).range(1..=16_384))
                .labelled_by(label.id);
        }
        ui.checkbox(overwrite, "Replace an existing file");
    });
    ui.label(
        RichText::new(
            "A picture is rendered at this size and carries its settings: dropped here, it restores everything. A scene is the document \
             alone, with its animation.",
        )
        .weak(),
    );
    let mut stays = true;
    ui.horizontal(|ui| {
        let go = ui.button("Save").clicked();
        if (go || entered) && !path.trim().is_empty() {
            match ImageSize::new(size[0], size[1]) {
                Ok(size) => model.save(PathBuf::from(path.trim()), Some(size), *overwrite),
                Err(error) => model.say(error.to_string(), true),
            }
            stays = false;
        }
        if ui.button("Cancel").clicked() {
            stays = false;
        }
    });
    stays
}

fn help(ui: &mut Ui) -> bool {
    ScrollArea::vertical().max_height(520.0).show(ui, |ui| {
        let section = |ui: &mut Ui, title: &str, lines: Vec<(String, &str)>| {
            ui.heading(title);
            Grid::new(title).num_columns(2).striped(true).show(ui, |ui| {
                for (key, about) in lines {
                    ui.monospace(key);
                    ui.label(about);
                    ui.end_row();
                }
            });
            ui.add_space(8.0);
        };
        let owned = |lines: &[(&str, &'static str)]| {
            lines
                .iter()
                .map(|(gesture, about)| ((*gesture).to_owned(), *about))
                .collect()
        };
        section(ui, "In the picture", owned(GESTURES));
        section(ui, "In the transfer function", owned(CURVE_GESTURES));
        section(
            ui,
            "Keys",
            KEYS.iter().map(|line| (names(line), line.about)).collect(),
        );
    });
    !ui.button("Close").clicked()
}
