//! The window: panels around the picture. All state that matters is the model's document; what is here is which panel
//! is open and what is typed.

pub mod bindings;
mod choices;
mod clip;
mod color;
mod curve;
mod dialogs;
mod fading;
mod flight;
mod handles;
mod labels;
mod legend;
mod look;
mod measure;
mod menu;
mod method;
mod picture;
mod profile;
mod regions;
mod rooms;
mod scene;
mod slices;
mod status;
mod style;
mod timeline;

use std::sync::Arc;

use eframe::egui::{CentralPanel, Context, Frame, Margin, Panel, Popup, ScrollArea, Ui};
use splatvol::glam::DVec2;
use splatvol_document::keys::CameraKeys;

use crate::model::{Model, Start, navigate};
use bindings::{Action, KEYS};
use dialogs::Dialogs;
use flight::Flight;
use handles::ClipHandles;
use look::LookState;
use measure::Measure;
use picture::PicturePanel;
use profile::Pins;
use rooms::Panels;
use slices::Slices;
use status::StatusLine;
use timeline::Timeline;

/// The viewer in a window.
pub struct Viewer {
    model: Model,
    picture: PicturePanel,
    look: LookState,
    dialogs: Dialogs,
    pins: Pins,
    slices: Slices,
    handles: ClipHandles,
    flight: Flight,
    measure: Measure,
    timeline: Timeline,
    status: StatusLine,
    /// Number of the item whose look is edited.
    selected: usize,
    hides_panels: bool,
    hides_legend: bool,
}

impl Viewer {
    /// A viewer in a context that shows windows, or that tests one.
    ///
    /// # Errors
    /// Threads that the system refuses.
    pub fn new(context: &Context, start: Start) -> Result<Self, std::io::Error> {
        style::apply(context);
        let wakes = context.clone();
        let model = Model::new(start, Arc::new(move || wakes.request_repaint()))?;
        Ok(Self {
            model,
            picture: PicturePanel::default(),
            look: LookState::default(),
            dialogs: Dialogs::default(),
            pins: Pins::default(),
            slices: Slices::default(),
            handles: ClipHandles::default(),
            flight: Flight::default(),
            measure: Measure::default(),
            timeline: Timeline::default(),
            status: StatusLine::default(),
            selected: 0,
            hides_panels: false,
            hides_legend: false,
        })
    }

    /// The state.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Shows everything once.
    pub fn show(&mut self, ui: &mut Ui) {
        // News first: they decide which panels there are, and so how large the picture is.
        self.model.listen();
        let items = self.model.session().items().len();
        self.selected = self.selected.min(items.saturating_sub(1));
        // Open menus and lists have the keys; Escape, which they hear, too, closes them.
        if !Popup::is_any_open(ui.ctx()) {
            if !ui.ctx().text_edit_focused() {
                self.flight.show(ui, &mut self.model);
            }
            self.keys(ui);
        }
        self.drops(ui);
        Panel::top("menu").show(ui, |ui| {
            if let Some(action) = menu::show(ui, &self.model) {
                self.act(ui, action);
            }
        });
        Panel::bottom("status").show(ui, |ui| {
            let hovered = self.picture.hovered.as_ref();
            self.status
                .show(ui, &mut self.model, (hovered, self.flight.flies()));
        });
        if !self.hides_panels && items > 0 {
            self.panels(ui);
        } else {
            self.timeline.stop();
        }
        CentralPanel::default().frame(Frame::NONE).show(ui, |ui| {
            self.picture.show(ui, &mut self.model, self.flight.flies());
            self.handles.show(ui, &mut self.model, &self.picture);
            self.measure.show(ui, &self.model, &self.picture);
            if !self.hides_legend {
                legend::show(ui, (&self.model, self.selected), &self.picture);
            }
        });
        self.pins.show(ui.ctx(), &self.model, &self.picture);
        self.slices
            .show(ui.ctx(), (&self.model, self.selected), &self.picture);
        self.dialogs.show(ui.ctx(), &mut self.model);
        let rests = ui.input(|input| !input.pointer.any_down() && input.keys_down.is_empty());
        if rests && !self.timeline.is_playing() {
            self.model.end_gesture();
        }
    }

    /// Panels at both sides, or one where they would take more than half of the window. Their width does not depend on what is in them.
    fn panels(&mut self, ui: &mut Ui) {
        let margin = Frame::side_top_panel(ui.style()).inner_margin(Margin::same(8));
        let width = ui.available_width();
        match Panels::of(width) {
            Panels::Two { scene: most } => {
                let (usual, [least, most]) = rooms::scene(most);
                let panel = Panel::left("scene").default_size(usual);
                let panel = panel.size_range(least..=most).frame(margin);
                let shown = panel.show(ui, |ui| scrolled(ui, |ui| self.scene_panel(ui)));
                let (usual, [least, most]) = rooms::look(width, shown.response.rect.width());
                let panel = Panel::right("look").default_size(usual);
                let panel = panel.size_range(least..=most).frame(margin);
                panel.show(ui, |ui| scrolled(ui, |ui| self.look_panel(ui)));
            }
            Panels::One { width } => {
                let panel = Panel::right("panels").exact_size(width).frame(margin);
                panel.show(ui, |ui| {
                    scrolled(ui, |ui| {
                        self.scene_panel(ui);
                        ui.separator();
                        self.look_panel(ui);
                    });
                });
            }
        }
    }

    fn scene_panel(&mut self, ui: &mut Ui) {
        if scene::show(ui, &mut self.model, &mut self.selected) {
            self.dialogs.open_file(true);
        }
        self.timeline.show(ui, &mut self.model);
    }

    fn look_panel(&mut self, ui: &mut Ui) {
        look::show(ui, &mut self.model, (self.selected, &mut self.look));
        method::show(ui, &mut self.model);
        clip::show(ui, &mut self.model, &mut self.handles);
    }

    /// Obeys keys. Those without Ctrl go to what has the focus, if that is not the picture; while text is typed, all do.
    fn keys(&mut self, ui: &mut Ui) {
        let typing = ui.ctx().text_edit_focused();
        let focused = ui.memory(|memory| memory.focused().is_some()) && !self.picture_has_focus(ui);
        for line in KEYS {
            let is_global = |keys: &eframe::egui::KeyboardShortcut| {
                keys.modifiers.command || line.action == Action::Escape || line.action == Action::Panels
            };
            let pressed = line.keys.iter().any(|keys| {
                let free = !typing && !focused;
                (free || (is_global(keys) && !(typing && line.action != Action::Escape)))
                    && ui.input_mut(|input| input.consume_shortcut(keys))
            });
            if pressed {
                self.act(ui, line.action);
            }
        }
    }

    fn picture_has_focus(&self, ui: &Ui) -> bool {
        let focused = ui.memory(|memory| memory.focused());
        focused.is_some() && focused == self.picture.id
    }

    fn act(&mut self, ui: &Ui, action: Action) {
        let model = &mut self.model;
        match action {
            Action::Turn(azimuth, elevation) => {
                model.move_camera(|camera| navigate::orbit(camera, azimuth, elevation));
            }
            Action::Roll(degrees) => model.move_camera(|camera| navigate::roll(camera, degrees)),
            Action::Pan(x, y) => model.move_camera(|camera| navigate::pan(camera, DVec2::new(x, y))),
            Action::Zoom(factor) => model.move_camera(|camera| navigate::zoom(camera, factor, DVec2::ZERO)),
            Action::Projection => model.move_camera(navigate::other_projection),
            Action::Look(view) => model.change_camera(CameraKeys {
                view: Some(view),
                ..CameraKeys::default()
            }),
            Action::Fit => model.change_camera(CameraKeys {
                fit: Some(splatvol_document::keys::names::Fit::Visible),
                ..CameraKeys::default()
            }),
            Action::Pivot => self.picture.pivot(model),
            Action::Undo => model.undo(),
            Action::Redo => model.redo(),
            Action::OtherLook => model.change_looks(),
            Action::Open => self.dialogs.open_file(false),
            Action::Save => self.dialogs.save_picture(model),
            Action::Pin => {
                let hovered = self.picture.hovered.as_ref();
                self.slices.follow(hovered, (&*model, self.selected));
                self.pins.pin(hovered, model);
            }
            Action::Slices => self.slices.toggle(),
            Action::ClipBox => clip::toggle_box(model),
            Action::ClipPlane => clip::add_plane(model),
            Action::Handles => self.handles.toggle(),
            Action::Fly => self.flight.toggle(),
            Action::Measure => self.measure.add(self.picture.hovered.as_ref(), model),
            Action::Legend => self.hides_legend = !self.hides_legend,
            Action::Escape => {
                self.flight.end();
                self.measure.clear();
                self.dialogs.close();
                self.pins.clear();
                model.dismiss();
                ui.memory_mut(|memory| {
                    if let Some(focused) = memory.focused() {
                        memory.surrender_focus(focused);
                    }
                });
            }
            Action::Help => self.dialogs.help(),
            Action::Panels => self.hides_panels = !self.hides_panels,
            Action::Quit => ui.ctx().send_viewport_cmd(eframe::egui::ViewportCommand::Close),
        }
    }

    fn drops(&mut self, ui: &Ui) {
        let (files, adds) = ui.input(|input| (input.raw.dropped_files.clone(), input.modifiers.command));
        let paths: Vec<String> = files
            .iter()
            .map(|file| file.path().to_string_lossy().into_owned())
            .collect();
        match &paths[..] {
            [] => {}
            [path] => self.model.drop_file(path, (adds, self.selected)),
            several => self.model.open(several),
        }
    }
}

/// What has no room is reached by scrolling, both ways.
fn scrolled(ui: &mut Ui, add: impl FnOnce(&mut Ui)) {
    ScrollArea::both().auto_shrink(false).show(ui, add);
}

impl eframe::App for Viewer {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        self.show(ui);
    }
}

#[cfg(test)]
mod tests;
