//! Dialogs: opening, saving, and the table of keys. Paths are typed; files can be dropped instead.

use std::path::PathBuf;

use eframe::egui::{Align2, Context, DragValue, Grid, Key, RichText, ScrollArea, TextEdit, Ui, Vec2, Window};
use splatvol::ImageSize;
use splatvol_document::keys::{ItemKeys, PictureSize};

use super::bindings::{CURVE_GESTURES, GESTURES, KEYS, names};
use super::scene::short_name;
use super::{rooms, style};
use crate::model::Model;

/// What is open.
#[derive(Debug, Default)]
enum Open {
    #[default]
    Nothing,
    /// A path to open, or to add.
    File(FileForm),
    /// A picture to save.
    Picture(PictureForm),
    Help,
}

/// What is said of a file to open.
#[derive(Debug, Clone)]
struct FileForm {
    path: String,
    /// Whether it is added to what is shown.
    adds: bool,
    /// Why it could not be opened.
    error: Option<String>,
}

/// What is said of a picture to save.
#[derive(Debug, Clone)]
struct PictureForm {
    path: String,
    size: [u32; 2],
    overwrite: bool,
    /// Why it could not be saved.
    error: Option<String>,
}

#[derive(Debug, Default)]
pub(super) struct Dialogs {
    open: Open,
    /// What is being opened, and what is being saved: shown again if that fails.
    opening: Option<FileForm>,
    saving: Option<PictureForm>,
    /// Whether the text field gets the keys next.
    focuses: bool,
}

impl Dialogs {
    pub(super) fn open_file(&mut self, adds: bool) {
        self.focuses = true;
        self.open = Open::File(FileForm {
            path: String::new(),
            adds,
            error: None,
        });
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
        self.open = Open::Picture(PictureForm {
            path: format!("{stem}.png"),
            size: [size.width(), size.height()],
            overwrite: false,
            error: None,
        });
    }

    pub(super) fn help(&mut self) {
        self.open = Open::Help;
    }

    pub(super) fn close(&mut self) {
        self.open = Open::Nothing;
    }

    /// Shows again what was typed for a file that could not be opened, unless something else is open by now.
    fn return_unopened(&mut self, model: &mut Model) {
        let Some(asked) = self.opening.take_if(|_| model.asked_since().is_none()) else {
            return;
        };
        let error = model.message().filter(|message| message.is_error);
        let error = error.map(|message| message.text.clone());
        if error.is_some() && matches!(self.open, Open::Nothing) {
            model.dismiss();
            self.focuses = true;
            self.open = Open::File(FileForm { error, ..asked });
        }
    }

    /// The same of a picture that could not be saved.
    fn return_unsaved(&mut self, model: &mut Model) {
        let Some(asked) = self.saving.take_if(|_| model.writing().is_none()) else {
            return;
        };
        let error = model.refused().map(str::to_owned);
        if error.is_some() && matches!(self.open, Open::Nothing) {
            model.dismiss();
            self.open = Open::Picture(PictureForm { error, ..asked });
        }
    }

    pub(super) fn show(&mut self, context: &Context, model: &mut Model) {
        self.return_unopened(model);
        self.return_unsaved(model);
        let focuses = std::mem::take(&mut self.focuses);
        let stays = match &mut self.open {
            Open::Nothing => true,
            Open::File(asked) => {
                let title = if asked.adds { "Add a file" } else { "Open a file" };
                let mut opens = false;
                let stays = dialog(context, (title, FORM), |ui| {
                    form(ui, |ui| file(ui, (asked, focuses, &mut opens), model))
                });
                if opens {
                    self.opening = Some(asked.clone());
                }
                stays
            }
            Open::Picture(asked) => {
                let stays = dialog(context, ("Save a picture or the scene", FORM), |ui| {
                    form(ui, |ui| picture(ui, (asked, focuses), model))
                });
                if model.writing().is_some() && !stays {
                    self.saving = Some(asked.clone());
                }
                stays
            }
            Open::Help => dialog(context, ("Keys and gestures", HELP), help),
        };
        if !stays {
            self.close();
        }
    }
}

/// Most sizes of the contents of forms, and of the table of keys, points.
const FORM: Vec2 = Vec2::new(460.0, 520.0);
const HELP: Vec2 = Vec2::new(900.0, 560.0);

/// A window in the middle, as large as there is room for; returns whether it stays open.
fn dialog(context: &Context, (title, size): (&str, Vec2), add: impl FnOnce(&mut Ui) -> bool) -> bool {
    let mut open = true;
    let size = size.min(rooms::of_dialog(context));
    let shown = Window::new(title)
        .collapsible(false)
        .resizable(false)
        .anchor(Align2::CENTER_CENTER, [0.0, 0.0])
        .open(&mut open)
        .show(context, |ui| {
            ui.set_max_size(size);
            add(ui)
        });
    open && shown.and_then(|shown| shown.inner).unwrap_or(true)
}

/// Fields and buttons, which scroll where they have no room.
fn form(ui: &mut Ui, add: impl FnOnce(&mut Ui) -> bool) -> bool {
    ScrollArea::both().show(ui, add).inner
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

/// `opens`: set where the file is asked for.
fn file(ui: &mut Ui, (asked, focuses, opens): (&mut FileForm, bool, &mut bool), model: &mut Model) -> bool {
    let entered = path_field(ui, "File or folder, or sample:NAME", &mut asked.path, focuses);
    ui.label(RichText::new("A scene, or a picture that splatvol made, restores everything.").weak());
    say_error(ui, asked.error.as_deref());
    let mut stays = true;
    ui.horizontal(|ui| {
        let go = ui.button(if asked.adds { "Add" } else { "Open" }).clicked();
        if (go || entered) && !asked.path.trim().is_empty() {
            let path = asked.path.trim().to_owned();
            model.dismiss();
            match asked.adds {
                true => model.add(ItemKeys::of_file(path)),
                false => model.open(&[path]),
            }
            *opens = true;
            stays = false;
        }
        if ui.button("Cancel").clicked() {
            stays = false;
        }
    });
    stays
}

/// Why what was asked for last failed.
fn say_error(ui: &mut Ui, error: Option<&str>) {
    if let Some(error) = error {
        ui.label(RichText::new(format!("Error: {error}")).color(style::WARNING));
    }
}

fn picture(ui: &mut Ui, (asked, focuses): (&mut PictureForm, bool), model: &mut Model) -> bool {
    let label = "Picture, .png or .exr; or scene, .toml";
    let entered = path_field(ui, label, &mut asked.path, focuses);
    ui.horizontal_wrapped(|ui| {
        for (side, name) in asked.size.iter_mut().zip(["Width", "Height"]) {
            let label = ui.label(name);
            ui.add(DragValue::new(side).range(1..=16_384))
                .labelled_by(label.id);
        }
        ui.checkbox(&mut asked.overwrite, "Replace an existing file");
    });
    ui.label(
        RichText::new(
            "A picture is rendered at this size and carries its settings: dropped here, it restores everything. A scene is the document \
             alone, with its animation.",
        )
        .weak(),
    );
    say_error(ui, asked.error.as_deref());
    let mut stays = true;
    ui.horizontal(|ui| {
        let go = ui.button("Save").clicked();
        if (go || entered) && !asked.path.trim().is_empty() {
            asked.error = save(asked, model).err();
            stays = asked.error.is_some();
        }
        if ui.button("Cancel").clicked() {
            stays = false;
        }
    });
    stays
}

/// Begins to save a picture, or says why not: in the dialog, not in the status line.
fn save(asked: &PictureForm, model: &mut Model) -> Result<(), String> {
    let [width, height] = asked.size;
    let size = ImageSize::new(width, height).map_err(|error| error.to_string())?;
    model.save(PathBuf::from(asked.path.trim()), Some(size), asked.overwrite);
    match model.refused().map(str::to_owned) {
        Some(error) => {
            model.dismiss();
            Err(error)
        }
        None => Ok(()),
    }
}

fn help(ui: &mut Ui) -> bool {
    let most = ui.available_height() - ui.spacing().interact_size.y - 2.0 * ui.spacing().item_spacing.y;
    ScrollArea::both().max_height(most).show(ui, |ui| {
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
