//! The menu: everything that keys do, for the pointer and for screen readers.

use eframe::egui::{Button, MenuBar, ScrollArea, Ui};
use splatvol_document::keys::names::ViewName;

use super::bindings::{Action, key_of};
use super::rooms;
use crate::model::Model;

const VIEWS: [(&str, Action); 10] = [
    ("Front", Action::Look(ViewName::Front)),
    ("Back", Action::Look(ViewName::Back)),
    ("Left", Action::Look(ViewName::Left)),
    ("Right", Action::Look(ViewName::Right)),
    ("Top", Action::Look(ViewName::Top)),
    ("Bottom", Action::Look(ViewName::Bottom)),
    ("Corner", Action::Look(ViewName::Iso)),
    ("Show everything", Action::Fit),
    ("Perspective or parallel", Action::Projection),
    ("Fly", Action::Fly),
];

/// Sizes of text, shares of the usual.
const TEXT_SIZES: [f32; 5] = [1.0, 1.25, 1.5, 1.75, 2.0];

/// Width of the buttons beside the menus, points.
const SHORTCUTS: f32 = 310.0;

/// Shows the menu; returns what was chosen.
pub(super) fn show(ui: &mut Ui, model: &Model) -> Option<Action> {
    let mut chosen = None;
    let has_items = !model.session().items().is_empty();
    MenuBar::new().ui(ui, |ui| {
        menu(ui, "File", |ui| {
            entry(ui, ("Open ...", Action::Open), (true, &mut chosen));
            entry(ui, ("Save picture ...", Action::Save), (has_items, &mut chosen));
            ui.separator();
            entry(ui, ("Quit", Action::Quit), (true, &mut chosen));
        });
        menu(ui, "Edit", |ui| {
            let session = model.session();
            entry(ui, ("Undo", Action::Undo), (session.can_undo(), &mut chosen));
            entry(ui, ("Redo", Action::Redo), (session.can_redo(), &mut chosen));
            ui.separator();
            entry(
                ui,
                ("Other look (A, B)", Action::OtherLook),
                (has_items, &mut chosen),
            );
        });
        menu(ui, "View", |ui| {
            for view in VIEWS {
                entry(ui, view, (has_items, &mut chosen));
            }
            ui.separator();
            entry(ui, ("Slices", Action::Slices), (has_items, &mut chosen));
            entry(ui, ("Box of clips", Action::ClipBox), (has_items, &mut chosen));
            entry(
                ui,
                ("Add a plane of clips", Action::ClipPlane),
                (has_items, &mut chosen),
            );
            entry(
                ui,
                ("Handles of clips", Action::Handles),
                (has_items, &mut chosen),
            );
            entry(ui, ("Colour bar", Action::Legend), (has_items, &mut chosen));
            entry(ui, ("Panels", Action::Panels), (has_items, &mut chosen));
            menu(ui, "Text size", |ui| {
                for size in TEXT_SIZES {
                    let is_set = (ui.ctx().zoom_factor() - size).abs() < 0.01;
                    if ui.radio(is_set, format!("{:.0} %", 100.0 * size)).clicked() {
                        ui.ctx().set_zoom_factor(size);
                    }
                }
            });
        });
        menu(ui, "Help", |ui| {
            entry(ui, ("Keys and gestures", Action::Help), (true, &mut chosen));
        });
        // The menus have the same.
        if ui.available_width() < SHORTCUTS {
            return;
        }
        ui.separator();
        let session = model.session();
        for (name, action, enabled) in [
            ("Undo", Action::Undo, session.can_undo()),
            ("Redo", Action::Redo, session.can_redo()),
            ("Show everything", Action::Fit, has_items),
            ("Save picture", Action::Save, has_items),
        ] {
            let button = ui.add_enabled(enabled, Button::new(name).frame(false));
            if button.on_hover_text(key_of(action)).clicked() {
                chosen = Some(action);
            }
        }
    });
    chosen
}

/// A menu, which scrolls where it is higher than the window.
fn menu(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui)) {
    ui.menu_button(name, |ui| {
        let most = rooms::of_menu(ui.ctx());
        ScrollArea::vertical().max_height(most).show(ui, add);
    });
}

fn entry(ui: &mut Ui, (name, action): (&str, Action), (enabled, chosen): (bool, &mut Option<Action>)) {
    let button = Button::new(name).shortcut_text(key_of(action));
    if ui.add_enabled(enabled, button).clicked() {
        *chosen = Some(action);
        ui.close();
    }
}
