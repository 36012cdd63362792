//! Clips: a box, and planes, of which one side is kept.

use eframe::egui::{CollapsingHeader, DragValue, Grid, Slider, Ui};
use splatvol::glam::DVec3;
use splatvol::{Bounds, Camera, ClipPlane};
use splatvol_document::keys::EffectKeys;

use super::handles::ClipHandles;
use crate::model::Model;
use crate::model::handles::LEAST_WIDTH;

pub(super) fn show(ui: &mut Ui, model: &mut Model, handles: &mut ClipHandles) {
    CollapsingHeader::new("Clip").show(ui, |ui| {
        let Some(bounds) = bounds(model) else {
            return;
        };
        let old = model.document().effects.clone();
        let mut new = old.clone();
        clip_box(ui, &mut new, &bounds);
        ui.separator();
        planes(ui, &mut new, (&bounds, model));
        let mut are_shown = handles.are_shown();
        if ui.checkbox(&mut are_shown, "Handles in the picture").changed() {
            handles.toggle();
        }
        if new != old {
            model.gesture(|session| session.adjust_effects(&new));
        }
    });
}

/// Bounds of the data that are shown, world.
fn bounds(model: &Model) -> Option<Bounds> {
    model.shown().and_then(|shown| shown.scene.bounds().ok())
}

/// Begins a box around everything, or ends it, as a step.
pub(super) fn toggle_box(model: &mut Model) {
    change(model, |effects, bounds, _| {
        let has_box = effects.clip_box.is_some();
        set_box(effects, bounds, !has_box);
    });
}

/// Adds a plane across the view, as a step.
pub(super) fn add_plane(model: &mut Model) {
    change(model, |effects, bounds, camera| {
        let plane = ClipPlane::new(bounds.centre(), camera.target() - camera.position());
        effects.clip_plane.get_or_insert_default().extend(plane);
    });
}

/// Changes clips as a step; nothing where nothing is shown.
fn change(model: &mut Model, change: impl FnOnce(&mut EffectKeys, &Bounds, &Camera)) {
    let (Some(bounds), Some(camera)) = (bounds(model), model.shown().map(|shown| shown.camera)) else {
        return;
    };
    let mut effects = model.document().effects.clone();
    change(&mut effects, &bounds, &camera);
    model.end_gesture();
    model.gesture(|session| session.adjust_effects(&effects));
    model.end_gesture();
}

fn set_box(effects: &mut EffectKeys, bounds: &Bounds, has_box: bool) {
    let [low, high] = [bounds.min, bounds.max];
    effects.clip_box = has_box.then_some([low.x, high.x, low.y, high.y, low.z, high.z]);
    effects.clip_inside = None;
}

/// A box that is kept, or whose outside is.
fn clip_box(ui: &mut Ui, effects: &mut EffectKeys, bounds: &Bounds) {
    let mut has_box = effects.clip_box.is_some();
    if ui.checkbox(&mut has_box, "Box").changed() {
        set_box(effects, bounds, has_box);
    }
    let Some(sides) = &mut effects.clip_box else {
        return;
    };
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let (min, max) = (bounds.min[axis], bounds.max[axis]);
        // A box without a width is refused.
        let least = LEAST_WIDTH * (max - min).max(f64::MIN_POSITIVE);
        let (mut low, mut high) = (sides[2 * axis], sides[2 * axis + 1]);
        if ui
            .add(Slider::new(&mut low, min..=max).text(format!("{name} from")))
            .changed()
        {
            low = low.min(high - least);
        }
        if ui
            .add(Slider::new(&mut high, min..=max).text(format!("{name} to")))
            .changed()
        {
            high = high.max(low + least);
        }
        [sides[2 * axis], sides[2 * axis + 1]] = [low, high];
    }
    let mut inside = effects.clip_inside == Some(true);
    if ui.checkbox(&mut inside, "Cut the inside away").changed() {
        effects.clip_inside = inside.then_some(true);
    }
}

/// Planes; the side of the normal is kept.
fn planes(ui: &mut Ui, effects: &mut EffectKeys, (bounds, model): (&Bounds, &Model)) {
    let mut planes = effects.clip_plane.clone().unwrap_or_default();
    let mut removed = None;
    for (index, plane) in planes.iter_mut().enumerate() {
        ui.push_id(index, |ui| {
            ui.horizontal(|ui| {
                ui.label(format!("Plane {}", index + 1));
                if ui.button("Flip").on_hover_text("keep the other side").clicked() {
                    replace(plane, plane.point(), -plane.normal());
                }
                if ui.button("Remove").clicked() {
                    removed = Some(index);
                }
            });
            place(ui, plane, bounds);
        });
    }
    if let Some(index) = removed {
        planes.remove(index);
    }
    ui.horizontal_wrapped(|ui| {
        ui.label("Add a plane across");
        let view = model
            .shown()
            .map(|shown| shown.camera.target() - shown.camera.position());
        let sides = [
            ("x", Some(-DVec3::X)),
            ("y", Some(-DVec3::Y)),
            ("z", Some(-DVec3::Z)),
            ("the view", view),
        ];
        for (name, normal) in sides {
            if ui.button(name).clicked()
                && let Some(plane) = normal.and_then(|normal| ClipPlane::new(bounds.centre(), normal).ok())
            {
                planes.push(plane);
            }
        }
    });
    effects.clip_plane = Some(planes).filter(|planes| !planes.is_empty());
}

/// Where a plane lies: its distance from the middle along its normal, and the normal.
fn place(ui: &mut Ui, plane: &mut ClipPlane, bounds: &Bounds) {
    let centre = bounds.centre();
    let normal = plane.normal();
    let mut distance = (plane.point() - centre).dot(normal);
    let reach = 0.5 * bounds.diagonal();
    if ui
        .add(Slider::new(&mut distance, -reach..=reach).text("Depth"))
        .changed()
    {
        replace(plane, centre + distance * normal, normal);
    }
    let mut direction = normal;
    Grid::new("normal").show(ui, |ui| {
        let mut changed = false;
        for (axis, name) in ["Normal x", "y", "z"].into_iter().enumerate() {
            let label = ui.label(name);
            let value = DragValue::new(&mut direction[axis]).speed(0.01).range(-1.0..=1.0);
            changed |= ui.add(value).labelled_by(label.id).changed();
        }
        if changed {
            replace(
                plane,
                centre + distance * direction.normalize_or(normal),
                direction,
            );
        }
    });
}

/// A plane elsewhere; one that is none stays as it was.
fn replace(plane: &mut ClipPlane, point: DVec3, normal: DVec3) {
    if let Ok(other) = ClipPlane::new(point, normal) {
        *plane = other;
    }
}
