//! The transfer function by hand: the opacity curve over the histogram, and the colours below it.

use eframe::egui::{
    Color32, DragValue, Event, Grid, Key, Pos2, Rect, Response, RichText, Role, Sense, Shape, Stroke,
    StrokeKind, Ui, Vec2, WidgetInfo,
};
use splatvol::TransferFunction;

use super::look::Changed;
use super::status::number;
use super::style;
use crate::model::{Values, curve as edits};

/// Height of the curve and of the colours, points.
const HEIGHT: f32 = 150.0;
const LANE: f32 = 18.0;
/// Distance at which a point is met.
const REACH: f32 = 10.0;
/// Decades of a logarithmic axis of opacities.
const DECADES: f64 = 4.0;

/// How the curve is shown, and which point is selected.
#[derive(Debug, Clone, Copy)]
pub(super) struct CurveState {
    selected: Option<usize>,
    log_counts: bool,
    log_opacity: bool,
}

impl Default for CurveState {
    fn default() -> Self {
        Self {
            selected: None,
            log_counts: true,
            log_opacity: false,
        }
    }
}

/// From values and opacities to the screen.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axes {
    rect: Rect,
    range: [f64; 2],
    log: bool,
}

impl Axes {
    fn x(&self, value: f64) -> f32 {
        let [low, high] = self.range;
        self.rect.left() + ((value - low) / (high - low)) as f32 * self.rect.width()
    }

    fn y(&self, opacity: f64) -> f32 {
        let share = match self.log {
            false => opacity,
            true => (1.0 + libm::log10(opacity.max(1e-12)) / DECADES).max(0.0),
        };
        self.rect.bottom() - share as f32 * self.rect.height()
    }

    fn at(&self, value: f64, opacity: f64) -> Pos2 {
        Pos2::new(self.x(value), self.y(opacity))
    }

    fn value(&self, x: f32) -> f64 {
        let [low, high] = self.range;
        low + f64::from((x - self.rect.left()) / self.rect.width()) * (high - low)
    }

    fn opacity(&self, y: f32) -> f64 {
        let share = f64::from((self.rect.bottom() - y) / self.rect.height()).clamp(0.0, 1.0);
        match (self.log, share > 0.0) {
            (false, _) => share,
            (true, true) => libm::pow(10.0, DECADES * (share - 1.0)),
            (true, false) => 0.0,
        }
    }
}

/// What the points of a curve are called.
#[derive(Debug, Clone, Copy)]
pub(super) struct Names {
    pub value: &'static str,
    pub opacity: &'static str,
    pub point: &'static str,
}

impl Names {
    /// Those of a transfer function.
    pub(super) const LOOK: Self = Self {
        value: "Value",
        opacity: "Opacity",
        point: "point",
    };
}

/// Shows the curve and its colours, and takes edits of it.
pub(super) fn show(
    ui: &mut Ui,
    (function, values): (&TransferFunction, Option<&Values>),
    (state, changed): (&mut CurveState, &mut Changed),
) {
    let axes = plot(ui, (function, values), Names::LOOK, (state, changed));
    lane(ui, axes, function);
    ends(ui, axes.range);
    ui.horizontal(|ui| {
        ui.checkbox(&mut state.log_counts, "Log counts")
            .on_hover_text("logarithmic heights of the histogram");
        ui.checkbox(&mut state.log_opacity, "Log opacity")
            .on_hover_text("logarithmic axis of opacities, from 0.0001 to 1");
    });
}

/// Shows the curve over the histogram, and takes edits of it.
pub(super) fn plot(
    ui: &mut Ui,
    (function, values): (&TransferFunction, Option<&Values>),
    names: Names,
    (state, changed): (&mut CurveState, &mut Changed),
) -> Axes {
    let width = ui.available_width();
    let (rect, response) = ui.allocate_exact_size(Vec2::new(width, HEIGHT), Sense::click_and_drag());
    let axes = Axes {
        rect: rect.shrink2(Vec2::new(7.0, 7.0)),
        range: shown_range(function, values),
        log: state.log_opacity,
    };
    let count = function.opacities().len();
    response.widget_info(|| {
        let Names { opacity, point, .. } = names;
        let about =
            format!("{opacity} curve of {count} {point}s; the list of {point}s has the same by keyboard");
        WidgetInfo::labeled(Role::Canvas, true, about)
    });
    paint(ui, (axes, rect), (function, values), state);
    edit(ui, (&response, axes), function, (state, changed));
    axes
}

/// The range of the data, and of the curve where it reaches farther.
fn shown_range(function: &TransferFunction, values: Option<&Values>) -> [f64; 2] {
    let [low, high] = edits::span(function);
    match values.map(|values| values.range) {
        Some([min, max]) if max > min => [low.min(min), high.max(max)],
        _ => [low, high],
    }
}

fn paint(
    ui: &Ui,
    (axes, rect): (Axes, Rect),
    (function, values): (&TransferFunction, Option<&Values>),
    state: &CurveState,
) {
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 3.0, ui.visuals().extreme_bg_color);
    if let Some(values) = values {
        histogram(ui, axes, values, state.log_counts);
    }
    for share in [0.25, 0.5, 0.75] {
        let y = axes.rect.bottom() - share * axes.rect.height();
        let line = [Pos2::new(axes.rect.left(), y), Pos2::new(axes.rect.right(), y)];
        painter.line_segment(line, Stroke::new(0.5, style::FAINT.gamma_multiply(0.5)));
    }
    // One sample per point of the screen, and the points themselves, where a curve can jump.
    let samples = (0..=axes.rect.width() as usize).map(|x| axes.value(axes.rect.left() + x as f32));
    let mut line: Vec<Pos2> = samples
        .map(|value| axes.at(value, function.opacity(value)))
        .collect();
    line.extend(
        function
            .opacities()
            .iter()
            .map(|point| axes.at(point.value, point.opacity)),
    );
    line.sort_by(|a, b| a.x.total_cmp(&b.x));
    painter.add(Shape::line(line, Stroke::new(1.8, style::TEXT)));
    for (index, point) in function.opacities().iter().enumerate() {
        let at = axes.at(point.value, point.opacity);
        let [r, g, b] = function.color(point.value).map(|channel| (255.0 * channel) as u8);
        let is_selected = state.selected == Some(index);
        let (radius, ring) = match is_selected {
            true => (6.5, Stroke::new(2.5, style::ACCENT)),
            false => (5.0, Stroke::new(1.5, style::TEXT)),
        };
        painter.circle(at, radius, Color32::from_rgb(r, g, b), ring);
    }
}

fn histogram(ui: &Ui, axes: Axes, values: &Values, log: bool) {
    let height = |count: u64| match log {
        true => libm::log1p(count as f64),
        false => count as f64,
    };
    let most = values
        .histogram
        .iter()
        .map(|&count| height(count))
        .fold(1.0, f64::max);
    let [low, high] = values.range;
    let bins = values.histogram.len() as f64;
    let painter = ui.painter_at(axes.rect);
    for (bin, &count) in values.histogram.iter().enumerate() {
        let value = |bin: f64| low + bin / bins * (high - low);
        let share = (height(count) / most) as f32;
        let bar = Rect::from_min_max(
            Pos2::new(
                axes.x(value(bin as f64)),
                axes.rect.bottom() - share * axes.rect.height(),
            ),
            Pos2::new(axes.x(value(bin as f64 + 1.0)) + 0.5, axes.rect.bottom()),
        );
        painter.rect_filled(bar, 0.0, style::BARS);
    }
}

/// The colours over the values.
fn lane(ui: &mut Ui, axes: Axes, function: &TransferFunction) {
    let (rect, response) = ui.allocate_exact_size(Vec2::new(ui.available_width(), LANE), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Colours over the values"));
    let painter = ui.painter_at(rect);
    let columns = axes.rect.width() as usize;
    for column in 0..columns {
        let x = axes.rect.left() + column as f32;
        let [r, g, b] = function
            .color(axes.value(x + 0.5))
            .map(|channel| (255.0 * channel).round() as u8);
        let bar = Rect::from_min_max(Pos2::new(x, rect.top()), Pos2::new(x + 1.0, rect.bottom()));
        painter.rect_filled(bar, 0.0, Color32::from_rgb(r, g, b));
    }
    let frame = Rect::from_x_y_ranges(axes.rect.x_range(), rect.y_range());
    painter.rect_stroke(frame, 0.0, Stroke::new(1.0, style::FAINT), StrokeKind::Inside);
}

/// The ends of an axis.
fn ends(ui: &mut Ui, range: [f64; 2]) {
    ui.horizontal(|ui| {
        ui.label(RichText::new(number(range[0])).small());
        ui.with_layout(
            eframe::egui::Layout::right_to_left(eframe::egui::Align::Center),
            |ui| {
                ui.label(RichText::new(number(range[1])).small());
            },
        );
    });
}

/// Takes clicks, drags and keys.
fn edit(
    ui: &Ui,
    (response, axes): (&Response, Axes),
    function: &TransferFunction,
    (state, changed): (&mut CurveState, &mut Changed),
) {
    let nearest = |at: Pos2| {
        let distances = function.opacities().iter().enumerate();
        let distances =
            distances.map(|(index, point)| (index, axes.at(point.value, point.opacity).distance(at)));
        distances
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .filter(|(_, distance)| *distance <= REACH)
            .map(|(index, _)| index)
    };
    let pressed = ui.input(|input| input.pointer.press_origin());
    if response.drag_started() || response.clicked() || response.secondary_clicked() {
        response.request_focus();
        state.selected = pressed.or(response.interact_pointer_pos()).and_then(nearest);
    }
    if let Some(at) = response.interact_pointer_pos() {
        let place = [axes.value(at.x), axes.opacity(at.y)];
        match state.selected {
            None if response.clicked() || response.drag_started() => {
                let added = edits::add_point(function, place);
                state.selected = added.as_ref().ok().map(|(_, index)| *index);
                *changed = Some(added.map(|(function, _)| function));
            }
            Some(index) if response.dragged() && response.drag_delta() != Vec2::ZERO => {
                let keeps_value = ui.input(|input| input.modifiers.shift);
                let value = match function.opacities().get(index).filter(|_| keeps_value) {
                    Some(point) => point.value,
                    None => place[0],
                };
                *changed = Some(edits::move_point(function, index, [value, place[1]]));
            }
            _ => {}
        }
    }
    let deletes = deletes(ui, response);
    if let Some(index) = state.selected.filter(|_| deletes || response.secondary_clicked()) {
        *changed = Some(edits::remove_point(function, index));
        state.selected = None;
    }
}

/// Whether what is selected in a widget that has the keys is to be deleted.
pub(super) fn deletes(ui: &Ui, response: &Response) -> bool {
    let is_delete = |event: &Event| {
        matches!(
            event,
            Event::Key {
                key: Key::Delete | Key::Backspace,
                pressed: true,
                ..
            }
        )
    };
    response.has_focus() && ui.input(|input| input.events.iter().any(is_delete))
}

/// The points as a list: values and opacities by keyboard.
pub(super) fn table(
    ui: &mut Ui,
    function: &TransferFunction,
    names: Names,
    (state, changed): (&mut CurveState, &mut Changed),
) {
    let [low, high] = edits::span(function);
    let speed = (high - low) / 300.0;
    Grid::new(names.point).striped(true).show(ui, |ui| {
        ui.label(names.value);
        ui.label(names.opacity);
        ui.end_row();
        for (index, point) in function.opacities().iter().enumerate() {
            let (mut value, mut opacity) = (point.value, point.opacity);
            let first = ui.add(DragValue::new(&mut value).speed(speed));
            first.widget_info(|| labelled(value, format!("{} of point {}", names.value, index + 1)));
            let second = ui.add(
                DragValue::new(&mut opacity)
                    .speed(0.002)
                    .range(0.0..=1.0)
                    .max_decimals(5),
            );
            second.widget_info(|| labelled(opacity, format!("{} of point {}", names.opacity, index + 1)));
            if first.changed() || second.changed() {
                *changed = Some(edits::move_point(function, index, [value, opacity]));
            }
            if first.has_focus() || second.has_focus() {
                state.selected = Some(index);
            }
            let button = ui.small_button("Remove");
            button.widget_info(|| {
                WidgetInfo::labeled(
                    Role::Button,
                    true,
                    format!("Remove {} {}", names.point, index + 1),
                )
            });
            if button.clicked() {
                *changed = Some(edits::remove_point(function, index));
            }
            ui.end_row();
        }
    });
    if ui.button(format!("Add a {}", names.point)).clicked() {
        let value = 0.5 * (low + high);
        let added = edits::add_point(function, [value, function.opacity(value)]);
        *changed = Some(added.map(|(function, _)| function));
    }
}

fn labelled(value: f64, label: String) -> WidgetInfo {
    WidgetInfo {
        label: Some(label),
        ..WidgetInfo::drag_value(true, value)
    }
}
