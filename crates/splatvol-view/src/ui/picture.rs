//! The picture: what the engine drew, and gestures on it.

use eframe::egui::{
    Align2, Color32, ColorImage, Context, FontId, Id, Modifiers, PointerButton, Pos2, Rect, Response, Role,
    Sense, Shape, Stroke, StrokeKind, TextureHandle, TextureOptions, Ui, Vec2, WidgetInfo,
};
use splatvol::glam::{DVec2, DVec3};
use splatvol::{Camera, ImageSize, Projection};

use super::style;
use crate::model::probe::{Probe, probe};
use crate::model::{Model, navigate};

/// Degrees that a drag across the picture's height turns.
const TURN: f64 = 180.0;
/// Degrees that it turns the eye around itself.
const LOOK: f64 = 60.0;
/// Logarithm of the factor of a drag across the picture's height, and of a point of the wheel.
const DRAG_ZOOM: f64 = 4.0;
const WHEEL_ZOOM: f64 = 0.004;

/// The picture's panel.
#[derive(Default)]
pub(super) struct PicturePanel {
    texture: Option<TextureHandle>,
    /// Number of the picture in the texture.
    number: u64,
    /// Where the picture is on the screen.
    rect: Option<Rect>,
    /// The picture as something that can have the keys.
    pub(super) id: Option<Id>,
    /// What is under the pointer.
    pub(super) hovered: Option<Probe>,
    /// The pointer and the picture for which that was found.
    probed: Option<(Pos2, u64)>,
}

impl PicturePanel {
    /// Shows the picture, and obeys gestures on it; `flies`: a drag turns the eye around itself.
    pub(super) fn show(&mut self, ui: &mut Ui, model: &mut Model, flies: bool) {
        let pane = ui.available_size();
        let scale = ui.pixels_per_point();
        let pixels = [pane.x, pane.y].map(|side| ((side * scale).floor() as u32).max(1));
        if let Some(after) = model.send(pixels) {
            ui.request_repaint_after(after);
        }
        let (outer, response) = ui.allocate_exact_size(pane, Sense::click_and_drag());
        self.id = Some(response.id);
        let about = describe(model);
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &about));
        self.upload(ui.ctx(), model);
        let Some(shown) = model.shown() else {
            self.hovered = None;
            empty(ui, outer, model);
            return;
        };
        let size = Vec2::new(shown.view_size.width() as f32, shown.view_size.height() as f32) / scale;
        // Whole pixels: otherwise the picture is resampled.
        let corner = ((outer.center() - 0.5 * size).to_vec2() * scale).round() / scale;
        let rect = Rect::from_min_size(corner.to_pos2(), size);
        self.rect = Some(rect);
        let painter = ui.painter_at(outer);
        painter.rect_filled(outer, 0.0, style::BACKDROP);
        if let Some(texture) = &self.texture {
            let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
            painter.image(texture.id(), rect, whole, Color32::WHITE);
        }
        if (outer.size() - size).max_elem() > 2.0 {
            painter.rect_stroke(rect, 0.0, Stroke::new(1.0, style::FAINT), StrokeKind::Outside);
        }
        let camera = shown.camera;
        axes(ui, outer, &camera);
        scale_bar(ui, outer, (&camera, rect), unit(model));
        self.probe(ui, model, &response);
        self.obey(ui, model, (&response, rect, flies));
        if response.has_focus() {
            ui.painter_at(outer)
                .rect_stroke(outer, 0.0, Stroke::new(2.0, style::ACCENT), StrokeKind::Inside);
        }
    }

    fn upload(&mut self, context: &Context, model: &Model) {
        let Some(shown) = model.shown().filter(|_| model.pictures() != self.number) else {
            return;
        };
        let size = [shown.size.width() as usize, shown.size.height() as usize];
        let image = ColorImage::from_rgba_unmultiplied(size, shown.codes.as_flattened());
        let options = match shown.draft_step {
            None => TextureOptions::NEAREST,
            Some(_) => TextureOptions::LINEAR,
        };
        match &mut self.texture {
            Some(texture) => texture.set(image, options),
            None => self.texture = Some(context.load_texture("picture", image, options)),
        }
        self.number = model.pictures();
    }

    fn obey(&self, ui: &Ui, model: &mut Model, (response, rect, flies): (&Response, Rect, bool)) {
        let height = f64::from(rect.height().max(1.0));
        let fraction = |way: Vec2| DVec2::new(f64::from(way.x), f64::from(way.y)) / height;
        let modifiers = ui.input(|input| input.modifiers);
        let way = fraction(response.drag_delta());
        if response.drag_started() || response.clicked() {
            response.request_focus();
        }
        if way != DVec2::ZERO {
            let at = response
                .interact_pointer_pos()
                .map(|at| fraction(at - rect.center()));
            if flies && response.dragged_by(PointerButton::Primary) && modifiers.is_none() {
                model.move_camera(|camera| navigate::look_around(camera, LOOK * way.x, -LOOK * way.y));
            } else {
                drag(model, (response, modifiers), way, at.unwrap_or_default());
            }
        }
        if response.hovered() {
            let (wheel, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
            let factor = libm::exp(WHEEL_ZOOM * f64::from(wheel)) * f64::from(pinch);
            let at = ui.input(|input| input.pointer.hover_pos());
            if let Some(at) = at.filter(|_| (factor - 1.0).abs() > 1e-6) {
                let at = fraction(at - rect.center());
                model.move_camera(|camera| navigate::zoom(camera, factor, at));
            }
        }
        if response.double_clicked() {
            self.pivot(model);
        }
    }

    /// Turns around what is under the pointer from now on.
    pub(super) fn pivot(&self, model: &mut Model) {
        match &self.hovered {
            Some(hovered) => model.move_camera(|camera| navigate::look_at(camera, hovered.place)),
            None => model.say("there is nothing under the pointer", false),
        }
    }

    fn probe(&mut self, ui: &Ui, model: &Model, response: &Response) {
        if ui.input(|input| input.pointer.any_down()) {
            return;
        }
        let (Some(at), Some(shown)) = (response.hover_pos(), model.shown()) else {
            (self.hovered, self.probed) = (None, None);
            return;
        };
        if self.probed == Some((at, self.number)) {
            return;
        }
        self.probed = Some((at, self.number));
        let pixel = self.pixel(at, shown.view_size);
        self.hovered = pixel.and_then(|pixel| probe(&shown.scene, &shown.camera, shown.view_size, pixel));
    }

    /// Where the picture is on the screen.
    pub(super) fn rect(&self) -> Option<Rect> {
        self.rect
    }

    /// The pixel of the picture, from its upper left corner, at a place on the screen.
    pub(super) fn pixel(&self, at: Pos2, size: ImageSize) -> Option<DVec2> {
        let rect = self.rect?;
        let share = (at - rect.min) / rect.size();
        let [width, height] = [size.width(), size.height()].map(f64::from);
        Some(DVec2::new(
            f64::from(share.x) * width,
            f64::from(share.y) * height,
        ))
    }

    /// Where a place is on the screen.
    pub(super) fn position(&self, camera: &Camera, size: ImageSize, place: DVec3) -> Option<Pos2> {
        let local = camera.camera_from_world().transform_point3(place);
        let pixel = camera.screen_from_camera(size).project(local);
        let share = Vec2::new(
            (pixel.x / f64::from(size.width())) as f32,
            (pixel.y / f64::from(size.height())) as f32,
        );
        let rect = self.rect?;
        (local.z > 0.0).then(|| rect.min + share * rect.size())
    }
}

fn drag(model: &mut Model, (response, modifiers): (&Response, Modifiers), way: DVec2, at: DVec2) {
    let pans = response.dragged_by(PointerButton::Middle)
        || (response.dragged_by(PointerButton::Primary) && modifiers.shift);
    if pans {
        model.move_camera(|camera| navigate::pan(camera, way));
    } else if response.dragged_by(PointerButton::Secondary) {
        model.move_camera(|camera| navigate::zoom(camera, libm::exp(-DRAG_ZOOM * way.y), DVec2::ZERO));
    } else if modifiers.command {
        // The angle between the pointer's last two places, seen from the middle.
        let before = at - way;
        let turned = libm::atan2(before.perp_dot(at), before.dot(at)).to_degrees();
        model.move_camera(|camera| navigate::roll(camera, turned));
    } else {
        model.move_camera(|camera| navigate::orbit(camera, -TURN * way.x, TURN * way.y));
    }
}

/// A sentence about the picture, for screen readers.
fn describe(model: &Model) -> String {
    let Some(shown) = model.shown() else {
        let error = model.message().filter(|message| message.is_error);
        return match (model.session().items().is_empty(), error) {
            (_, Some(error)) => format!("Picture: none, {}", error.text),
            (true, None) => "Picture: nothing is open".to_owned(),
            (false, None) => "Picture: not there yet".to_owned(),
        };
    };
    let names: Vec<&str> = model
        .document()
        .items
        .iter()
        .filter(|item| item.is_visible())
        .map(|item| item.file.as_str())
        .collect();
    let state = if model.is_final() { "final" } else { "draft" };
    let toward = shown.camera.position() - shown.camera.target();
    let direction = toward.normalize_or_zero();
    format!(
        "Picture of {}, seen from ({:.2}, {:.2}, {:.2}), {state}",
        names.join(", "),
        direction.x,
        direction.y,
        direction.z
    )
}

fn empty(ui: &Ui, rect: Rect, model: &Model) {
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 0.0, style::BACKDROP);
    let error = model.message().filter(|message| message.is_error);
    let has_items = !model.session().items().is_empty();
    let (text, points, color) = match (model.asked_since(), error) {
        (Some(_), _) => ("Reading ...", 20.0, style::TEXT),
        (None, Some(error)) => (error.text.as_str(), 16.0, style::WARNING),
        (None, None) if has_items => ("Drawing ...", 20.0, style::TEXT),
        (None, None) => ("Drop a file here, or press Ctrl+O", 20.0, style::TEXT),
    };
    let width = (rect.width() - 40.0).max(60.0);
    let galley = painter.layout(text.to_owned(), FontId::proportional(points), color, width);
    let at = Align2::CENTER_CENTER.anchor_size(rect.center(), galley.size());
    painter.galley(at.min, galley, color);
}

/// Symbol of the unit of lengths: that of the first volume that has one.
pub(super) fn unit(model: &Model) -> &'static str {
    let items = model.document().items.iter();
    let units = items.filter_map(|item| model.facts(item)?.values.as_ref().map(|values| values.unit));
    units.into_iter().find(|unit| !unit.is_empty()).unwrap_or("")
}

/// The world's axes in the lower left corner.
fn axes(ui: &Ui, outer: Rect, camera: &Camera) {
    const LENGTH: f32 = 28.0;
    let painter = ui.painter_at(outer);
    let middle = outer.left_bottom() + Vec2::new(52.0, -52.0);
    let rotation = camera.camera_from_world().matrix3;
    let mut ends = style::AXES.map(|(name, axis, color)| (rotation * axis, name, color));
    // What points away is drawn first.
    ends.sort_by(|a, b| b.0.z.total_cmp(&a.0.z));
    for (axis, name, color) in ends {
        let way = Vec2::new(axis.x as f32, axis.y as f32);
        let end = middle + LENGTH * way;
        painter.add(Shape::line_segment(
            [middle, end],
            Stroke::new(4.0, Color32::from_black_alpha(160)),
        ));
        painter.add(Shape::line_segment([middle, end], Stroke::new(2.0, color)));
        plated(
            ui,
            outer,
            middle + (LENGTH + 9.0) * way,
            (Align2::CENTER_CENTER, name, color),
        );
    }
}

/// Text that can be read over any picture: on a dark plate.
pub(super) fn plated(ui: &Ui, clip: Rect, at: Pos2, (align, text, color): (Align2, &str, Color32)) {
    let painter = ui.painter_at(clip);
    let galley = painter.layout_no_wrap(text.to_owned(), FontId::proportional(13.0), color);
    let rect = align.anchor_size(at, galley.size());
    painter.rect_filled(
        rect.expand2(Vec2::new(3.0, 0.0)),
        3.0,
        Color32::from_black_alpha(150),
    );
    painter.galley(rect.min, galley, color);
}

/// A bar of a round length. In perspective lengths are those at the target's distance, and the bar says so.
fn scale_bar(ui: &Ui, outer: Rect, (camera, rect): (&Camera, Rect), unit: &str) {
    let world_per_point = navigate::height_at_target(camera) / f64::from(rect.height().max(1.0));
    let length = round_length(100.0 * world_per_point);
    if !(length.is_finite() && length > 0.0) {
        return;
    }
    let width = (length / world_per_point) as f32;
    let right = outer.right_bottom() + Vec2::new(-20.0, -24.0);
    let left = right - Vec2::new(width, 0.0);
    let painter = ui.painter_at(outer);
    for (stroke, color) in [(5.0, Color32::from_black_alpha(190)), (2.0, style::TEXT)] {
        painter.line_segment([left, right], Stroke::new(stroke, color));
    }
    let text = length_text(length, unit, camera.projection());
    plated(
        ui,
        outer,
        right + Vec2::new(0.0, -6.0),
        (Align2::RIGHT_BOTTOM, &text, style::TEXT),
    );
}

/// What stands at a scale bar.
fn length_text(length: f64, unit: &str, projection: Projection) -> String {
    let mut text = length.to_string();
    for word in [unit, at_the_pivot(projection)] {
        if !word.is_empty() {
            text = format!("{text} {word}");
        }
    }
    text
}

fn at_the_pivot(projection: Projection) -> &'static str {
    match projection {
        Projection::Orthographic { .. } => "",
        Projection::Perspective { .. } => "at the pivot",
    }
}

/// The largest of 1, 2 and 5 times a power of ten that is not above a length.
pub(super) fn round_length(length: f64) -> f64 {
    let power = libm::pow(10.0, libm::floor(libm::log10(length)));
    let factor = [5.0, 2.0, 1.0]
        .into_iter()
        .find(|factor| factor * power <= length);
    factor.unwrap_or(1.0) * power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_say_their_length_with_single_spaces() {
        let perspective = Projection::Perspective { fov_degrees: 30.0 };
        assert_eq!(length_text(50.0, "", perspective), "50 at the pivot");
        assert_eq!(length_text(50.0, "mm", perspective), "50 mm at the pivot");
        let parallel = Projection::Orthographic { height: 1.0 };
        assert_eq!(length_text(0.2, "", parallel), "0.2");
    }

    #[test]
    fn bars_have_round_lengths() {
        for (length, round) in [(1.0, 1.0), (1.9, 1.0), (2.1, 2.0), (77.0, 50.0), (0.03, 0.02)] {
            assert!((round_length(length) - round).abs() < 1e-12 * round, "{length}");
        }
    }
}
