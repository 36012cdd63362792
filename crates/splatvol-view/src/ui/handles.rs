//! Handles of clips in the picture: the box's edges and sides, planes and their normals.

use eframe::egui::{Color32, CursorIcon, Pos2, Rect, Role, Sense, Shape, Stroke, Ui, Vec2, WidgetInfo};
use splatvol::glam::{DVec2, DVec3};
use splatvol::{Bounds, Camera, ImageSize};
use splatvol_document::keys::EffectKeys;

use super::picture::PicturePanel;
use super::style;
use crate::model::Model;
use crate::model::handles::{Handle, Seen, drag, edges, handles, outline, pivot};

/// Radius of a handle, and how far it is met, points.
const RADIUS: f32 = 6.0;
const REACH: f32 = 9.0;

/// A handle that is dragged: the clips and the pixel where it began.
struct Grabbed {
    handle: Handle,
    effects: EffectKeys,
    from: DVec2,
}

/// The handles.
#[derive(Default)]
pub(super) struct ClipHandles {
    hidden: bool,
    grabbed: Option<Grabbed>,
}

/// A view, and where it is on the screen.
struct View<'a> {
    picture: &'a PicturePanel,
    camera: Camera,
    size: ImageSize,
    bounds: Bounds,
}

impl View<'_> {
    fn at(&self, place: DVec3) -> Option<Pos2> {
        self.picture.position(&self.camera, self.size, place)
    }
}

impl ClipHandles {
    /// Shows or hides them.
    pub(super) fn toggle(&mut self) {
        self.hidden = !self.hidden;
    }

    /// Whether they are shown where there are clips.
    pub(super) fn are_shown(&self) -> bool {
        !self.hidden
    }

    /// Shows the handles over the picture, and obeys drags.
    pub(super) fn show(&mut self, ui: &mut Ui, model: &mut Model, picture: &PicturePanel) {
        let effects = model.document().effects.clone();
        let has_clips = effects.clip_box.is_some() || effects.clip_plane.is_some();
        let (Some(shown), Some(rect)) = (model.shown(), picture.rect()) else {
            return;
        };
        let Some(bounds) = shown.scene.bounds().ok().filter(|_| has_clips && !self.hidden) else {
            return;
        };
        let view = View {
            picture,
            camera: shown.camera,
            size: shown.view_size,
            bounds,
        };
        lines(ui, (&view, rect), &effects);
        let pointer = ui.input(|input| (input.pointer.any_down(), input.pointer.interact_pos()));
        if !pointer.0 {
            self.grabbed = None;
        }
        for (handle, place) in handles(&effects, &bounds) {
            let is_grabbed = self
                .grabbed
                .as_ref()
                .is_some_and(|grabbed| grabbed.handle == handle);
            if let Some(at) = view.at(place).filter(|at| is_grabbed || rect.contains(*at)) {
                self.handle(ui, (handle, at), (&view, &effects));
            }
        }
        let (Some(grabbed), Some(to)) = (&self.grabbed, pointer.1) else {
            return;
        };
        let seen = Seen {
            camera: &view.camera,
            size: view.size,
            bounds: &bounds,
        };
        let Some(to) = picture.pixel(to, view.size) else {
            return;
        };
        let after = drag(&grabbed.effects, grabbed.handle, seen, [grabbed.from, to]);
        if to != grabbed.from && after != effects {
            model.gesture(|session| session.adjust_effects(&after));
        }
    }

    /// Paints a handle, and hears whether it is grabbed.
    fn handle(&mut self, ui: &Ui, (handle, at): (Handle, Pos2), (view, effects): (&View<'_>, &EffectKeys)) {
        let area = Rect::from_center_size(at, Vec2::splat(2.0 * REACH));
        let id = ui.scope_id().with(("clip handle", handle.name()));
        let response = ui.interact(area, id, Sense::drag());
        response.widget_info(|| WidgetInfo::labeled(Role::Slider, true, handle.name()));
        if response.drag_started() {
            let from = ui.input(|input| input.pointer.press_origin());
            self.grabbed = from
                .and_then(|from| view.picture.pixel(from, view.size))
                .map(|from| Grabbed {
                    handle,
                    effects: effects.clone(),
                    from,
                });
        }
        let is_met = response.hovered() || response.dragged();
        if is_met {
            ui.set_cursor_icon(CursorIcon::Grab);
        }
        let ring = match is_met {
            true => Stroke::new(2.5, style::ACCENT),
            false => Stroke::new(1.5, Color32::BLACK),
        };
        ui.painter_at(view.picture.rect().unwrap_or(Rect::EVERYTHING))
            .circle(at, RADIUS, color(handle), ring);
        response.on_hover_text(handle.name());
    }
}

fn color(handle: Handle) -> Color32 {
    match handle {
        Handle::Side(side) => style::AXES[side / 2].2,
        Handle::Depth(_) => style::TEXT,
        Handle::Normal(_) => style::WARNING,
    }
}

/// The edges of the box, outlines of planes, and their normals.
fn lines(ui: &Ui, (view, rect): (&View<'_>, Rect), effects: &EffectKeys) {
    let painter = ui.painter_at(rect);
    let line = |[from, to]: [DVec3; 2], color: Color32| {
        if let (Some(from), Some(to)) = (view.at(from), view.at(to)) {
            for stroke in [
                Stroke::new(3.0, Color32::from_black_alpha(120)),
                Stroke::new(1.2, color),
            ] {
                painter.add(Shape::line_segment([from, to], stroke));
            }
        }
    };
    if let Some([x0, x1, y0, y1, z0, z1]) = effects.clip_box {
        let (min, max) = (DVec3::new(x0, y0, z0), DVec3::new(x1, y1, z1));
        edges(&min, &max).for_each(|edge| line(edge, style::TEXT));
    }
    let ends = handles(effects, &view.bounds);
    for (index, plane) in effects.clip_plane.iter().flatten().enumerate() {
        let polygon = outline(plane, &view.bounds);
        for (corner, &from) in polygon.iter().enumerate() {
            line([from, polygon[(corner + 1) % polygon.len()]], style::TEXT);
        }
        let end = ends.iter().find(|(handle, _)| *handle == Handle::Normal(index));
        if let Some((_, end)) = end {
            line([pivot(plane, &view.bounds), *end], style::WARNING);
        }
    }
}
