//! The transfer function of values and gradients by hand: soft rectangles over the histogram of both.

use eframe::egui::{
    Color32, ColorImage, Context, DragValue, Grid, Pos2, Rect, Response, RichText, Role, Sense, Slider,
    Stroke, StrokeKind, TextureHandle, TextureOptions, Ui, Vec2, WidgetInfo,
};
use splatvol::{Region, TransferFunction};
use splatvol_document::keys::ItemKeys;

use super::color;
use super::curve::deletes;
use super::look::length_slider;
use super::status::number;
use super::style;
use crate::model::gradients::{Gradients, SIZE};
use crate::model::regions::{Extent, Part, Side, begun, between, dragged, ordered};
use crate::model::shown_volume::ShownVolume;
use crate::model::{Model, Values};

/// Height of the histogram, points.
const HEIGHT: f32 = 190.0;
/// Distance at which a side is met.
const REACH: f32 = 6.0;
/// Opacity of a region's colour over the histogram.
const VEIL: f32 = 0.35;

/// Which region is selected, what is dragged, and the histogram.
#[derive(Default)]
pub(super) struct RegionsState {
    selected: usize,
    held: Option<Held>,
    histogram: Option<(ItemKeys, Gradients, TextureHandle)>,
    /// The item and its transfer function of values, before one of both took its place.
    before: Option<(ItemKeys, TransferFunction)>,
}

/// What is dragged from where.
#[derive(Clone, Copy)]
enum Held {
    /// A part of a region, as it was.
    Region(usize, Part, Region, Pos2),
    /// A new region, from its first corner.
    New(Pos2),
}

/// From values and gradients to the screen.
#[derive(Clone, Copy)]
struct Axes {
    rect: Rect,
    extent: Extent,
}

impl Axes {
    fn at(&self, [value, gradient]: [f64; 2]) -> Pos2 {
        let [low, high] = self.extent.values;
        let x = (value - low) / (high - low);
        let y = gradient / self.extent.steepest;
        Pos2::new(
            self.rect.left() + x as f32 * self.rect.width(),
            self.rect.bottom() - y as f32 * self.rect.height(),
        )
    }

    fn of(&self, region: &Region) -> Rect {
        let [low, high] = [0, 1].map(|end| self.at([region.value[end], region.gradient[end]]));
        Rect::from_two_pos(low, high)
    }

    /// Value and gradient of a way on the screen.
    fn way(&self, way: Vec2) -> [f64; 2] {
        let [low, high] = self.extent.values;
        [
            f64::from(way.x / self.rect.width()) * (high - low),
            -f64::from(way.y / self.rect.height()) * self.extent.steepest,
        ]
    }

    fn place(&self, at: Pos2) -> [f64; 2] {
        let [x, y] = self.way(at - self.rect.left_bottom());
        [self.extent.values[0] + x, y.max(0.0)]
    }
}

/// Whether the look is a function of values, or of values and gradients: shows which, and changes it. Returns whether it is of
/// both.
pub(super) fn choice(
    ui: &mut Ui,
    model: &mut Model,
    (selected, item): (usize, &ItemKeys),
    state: &mut RegionsState,
) -> bool {
    let effects = &model.document().effects;
    let of_both = effects.regions.is_some() || effects.tf2d.is_some();
    let mut asked = None;
    ui.horizontal(|ui| {
        ui.label("Of");
        for (both, name, about) in [
            (false, "values", "colour and opacity of values"),
            (
                true,
                "values and gradients",
                "boundaries apart from what they bound",
            ),
        ] {
            let label = ui.selectable_label(of_both == both, name).on_hover_text(about);
            if label.clicked() && of_both != both {
                asked = Some(both);
            }
        }
    });
    match asked {
        Some(true) => begin(ui.ctx(), model, (selected, item), state),
        Some(false) => end(model, (selected, item), state),
        None => {}
    }
    of_both
}

/// Begins with one region that shows about what is shown.
fn begin(
    context: &Context,
    model: &mut Model,
    (selected, item): (usize, &ItemKeys),
    state: &mut RegionsState,
) {
    let Some(function) = item.transfer_function.clone() else {
        return;
    };
    let Some(extent) = state.extent(context, ShownVolume::of(model, selected)) else {
        return;
    };
    let mut document = model.document().clone();
    document.effects.regions = Some(vec![begun(&function, extent)]);
    if let Some(item) = document.items.get_mut(selected) {
        item.unit_distance = function.unit_distance.or(item.unit_distance);
    }
    state.before = Some((item.clone(), function));
    state.selected = 0;
    model.change(document);
}

/// Returns to the function of values that there was, or to the one that the data suggest.
fn end(model: &mut Model, (selected, item): (usize, &ItemKeys), state: &mut RegionsState) {
    let before = state.before.take().filter(|(of, _)| of.file == item.file);
    let mut document = model.document().clone();
    document.effects.regions = None;
    document.effects.tf2d = None;
    if let Some(item) = document.items.get_mut(selected) {
        let known = before.map(|(item, function)| (item.unit_distance, function));
        (item.unit_distance, item.transfer_function) =
            known.map_or((None, None), |(length, function)| (length, Some(function)));
    }
    model.change(document);
}

/// Shows the regions, and takes edits of them.
pub(super) fn show(
    ui: &mut Ui,
    model: &mut Model,
    (selected, item, values): (usize, &ItemKeys, Option<&Values>),
    state: &mut RegionsState,
) {
    let Some(regions) = model.document().effects.regions.clone() else {
        let file = model.document().effects.tf2d.clone().unwrap_or_default();
        ui.label(format!("It is a file: {file}"));
        return;
    };
    let Some(extent) = state.extent(ui.ctx(), ShownVolume::of(model, selected)) else {
        ui.label("The selected item is no volume that is shown.");
        return;
    };
    state.selected = state.selected.min(regions.len().saturating_sub(1));
    let mut edited = regions.clone();
    plot(ui, extent, (&mut edited, state));
    list(ui, (&mut edited, extent), state);
    if edited != regions && !edited.is_empty() {
        model.gesture(|session| session.adjust_regions(&edited));
    }
    unit_distance(ui, model, (selected, item, values));
}

impl RegionsState {
    /// The axes of the histogram, which is counted if the data are others.
    fn extent(&mut self, context: &Context, shown: Option<ShownVolume<'_>>) -> Option<Extent> {
        let gradients = self.gradients(context, shown)?;
        Some(Extent {
            values: gradients.values,
            steepest: gradients.steepest,
        })
    }

    /// The histogram, counted if the data are others.
    pub(super) fn gradients(
        &mut self,
        context: &Context,
        shown: Option<ShownVolume<'_>>,
    ) -> Option<&Gradients> {
        let shown = shown?;
        let source = shown.source();
        if self.histogram.as_ref().is_none_or(|(of, ..)| *of != source) {
            let gradients = Gradients::of(shown.volume, &shown.world_from_voxel());
            let texture = context.load_texture("gradients", image(&gradients), TextureOptions::LINEAR);
            self.histogram = Some((source, gradients, texture));
        }
        self.histogram.as_ref().map(|(_, gradients, _)| gradients)
    }
}

/// The histogram with logarithmic counts, the steepest row first.
fn image(gradients: &Gradients) -> ColorImage {
    let most = gradients.counts.iter().copied().max().unwrap_or(0);
    let most = libm::log1p(f64::from(most)).max(f64::MIN_POSITIVE);
    let rows = gradients.counts.chunks_exact(SIZE[0]).rev().flatten();
    let codes: Vec<u8> = rows
        .flat_map(|count| {
            let share = libm::sqrt(libm::log1p(f64::from(*count)) / most);
            [18.0, 19.0, 23.0].map(|dark| (dark + share * (190.0 - dark)) as u8)
        })
        .collect();
    ColorImage::from_rgb(SIZE, &codes)
}

fn plot(ui: &mut Ui, extent: Extent, (regions, state): (&mut Vec<Region>, &mut RegionsState)) {
    let size = Vec2::new(ui.available_width(), HEIGHT);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    let axes = Axes { rect, extent };
    response.widget_info(|| {
        let about = format!(
            "Values and gradients with {} regions; the list of regions has the same by keyboard",
            regions.len()
        );
        WidgetInfo::labeled(Role::Canvas, true, about)
    });
    edit(ui, (&response, axes), (regions, state));
    paint(ui, axes, (regions, state));
    ui.horizontal(|ui| {
        ui.label(RichText::new(number(extent.values[0])).small());
        ui.label(
            RichText::new(format!("gradients up to {}", number(extent.steepest)))
                .small()
                .weak(),
        );
        ui.with_layout(
            eframe::egui::Layout::right_to_left(eframe::egui::Align::Center),
            |ui| ui.label(RichText::new(number(extent.values[1])).small()),
        );
    });
}

/// Takes clicks, drags and keys.
fn edit(
    ui: &Ui,
    (response, axes): (&Response, Axes),
    (regions, state): (&mut Vec<Region>, &mut RegionsState),
) {
    let pressed = ui
        .input(|input| input.pointer.press_origin())
        .or(response.interact_pointer_pos());
    if let Some(at) = pressed
        && (response.drag_started() || response.clicked() || response.secondary_clicked())
    {
        response.request_focus();
        let met = met(axes, regions, (at, state.selected));
        if let Some((index, _)) = met {
            state.selected = index;
        }
        state.held = response.drag_started().then(|| match met {
            Some((index, part)) => Held::Region(index, part, regions[index], at),
            None => Held::New(at),
        });
        if response.secondary_clicked() && met.is_some() && regions.len() > 1 {
            regions.remove(state.selected);
        }
    }
    let now = response.interact_pointer_pos();
    match (state.held, now) {
        (Some(Held::Region(index, part, from, start)), Some(at)) if response.dragged() => {
            if let Some(region) = regions.get_mut(index) {
                *region = dragged(&from, part, axes.way(at - start), axes.extent);
            }
        }
        (Some(Held::New(start)), Some(at)) if response.drag_stopped() => {
            let corners = [start, axes.rect.clamp(at)].map(|corner| axes.place(corner));
            if let Some(region) = ordered(between(corners, regions.get(state.selected))) {
                regions.push(region);
                state.selected = regions.len() - 1;
            }
        }
        _ => {}
    }
    if response.drag_stopped() {
        state.held = None;
    }
    if deletes(ui, response) && regions.len() > 1 {
        regions.remove(state.selected);
    }
}

/// The region under a place, and its part; the selected one before others, and later ones before earlier ones.
fn met(axes: Axes, regions: &[Region], (at, selected): (Pos2, usize)) -> Option<(usize, Part)> {
    let order = std::iter::once(selected).chain((0..regions.len()).rev());
    order.into_iter().find_map(|index| {
        let rect = axes.of(regions.get(index)?);
        if !rect.expand(REACH).contains(at) {
            return None;
        }
        let side =
            |low: f32, high: f32, at: f32| match ((at - low).abs() <= REACH, (at - high).abs() <= REACH) {
                // Of a narrow region the nearer side is meant.
                (true, true) if (at - low).abs() > (at - high).abs() => Some(Side::High),
                (true, _) => Some(Side::Low),
                (false, true) => Some(Side::High),
                (false, false) => None,
            };
        let part = Part([
            side(rect.left(), rect.right(), at.x),
            side(rect.bottom(), rect.top(), at.y),
        ]);
        Some((index, part))
    })
}

fn paint(ui: &Ui, axes: Axes, (regions, state): (&[Region], &RegionsState)) {
    let painter = ui.painter_at(axes.rect);
    if let Some((_, _, texture)) = &state.histogram {
        let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
        painter.image(texture.id(), axes.rect, whole, Color32::WHITE);
    }
    for (index, region) in regions.iter().enumerate() {
        let [r, g, b] = region.rgb.map(|channel| (255.0 * channel).round() as u8);
        let color = Color32::from_rgb(r, g, b);
        let rect = axes.of(region);
        painter.rect_filled(rect, 2.0, color.gamma_multiply(VEIL));
        // Where it is full.
        let full = rect.shrink2(0.5 * region.softness as f32 * rect.size());
        painter.rect_filled(full, 2.0, color.gamma_multiply(VEIL));
        let stroke = match index == state.selected {
            true => Stroke::new(2.5, style::ACCENT),
            false => Stroke::new(1.0, style::TEXT),
        };
        painter.rect_stroke(rect, 2.0, stroke, StrokeKind::Middle);
    }
    if let (Some(Held::New(start)), Some(at)) = (state.held, ui.input(|input| input.pointer.interact_pos())) {
        let stroke = Stroke::new(1.5, style::ACCENT);
        painter.rect_stroke(Rect::from_two_pos(start, at), 0.0, stroke, StrokeKind::Middle);
    }
}

/// The regions as a list, and the selected one in numbers.
fn list(ui: &mut Ui, (regions, extent): (&mut Vec<Region>, Extent), state: &mut RegionsState) {
    let mut removed = None;
    let count = regions.len();
    for (index, region) in regions.iter_mut().enumerate() {
        ui.horizontal(|ui| {
            color::button(ui, &mut region.rgb, format!("Colour of region {}", index + 1));
            let name = format!("Region {}", index + 1);
            if ui.selectable_label(state.selected == index, name).clicked() {
                state.selected = index;
            }
            let button = ui.add_enabled(count > 1, eframe::egui::Button::new("Remove").small());
            button.widget_info(|| {
                WidgetInfo::labeled(Role::Button, count > 1, format!("Remove region {}", index + 1))
            });
            if button.clicked() {
                removed = Some(index);
            }
        });
    }
    if let Some(region) = regions.get_mut(state.selected) {
        numbers(ui, region, extent);
    }
    if let Some(index) = removed {
        regions.remove(index);
    }
    if ui.button("Add a region").clicked() {
        let [low, high] = extent.values;
        let corners = [0.4, 0.6].map(|share| [low + share * (high - low), share * extent.steepest]);
        regions.push(between(corners, regions.get(state.selected)));
        state.selected = regions.len() - 1;
    }
}

/// The sides, opacity and softness of a region.
fn numbers(ui: &mut Ui, region: &mut Region, extent: Extent) {
    let mut typed = *region;
    let speeds = [
        (extent.values[1] - extent.values[0]) / 300.0,
        extent.steepest / 300.0,
    ];
    Grid::new("region").show(ui, |ui| {
        let sides = [
            ("Value from", &mut typed.value, speeds[0]),
            ("Gradient from", &mut typed.gradient, speeds[1]),
        ];
        for (name, [low, high], speed) in sides {
            for (name, number) in [(name, low), ("to", high)] {
                let label = ui.label(name);
                ui.add(DragValue::new(number).speed(speed)).labelled_by(label.id);
            }
            ui.end_row();
        }
    });
    ui.add(Slider::new(&mut typed.opacity, 0.0..=1.0).text("Opacity of the region"));
    ui.add(Slider::new(&mut typed.softness, 0.0..=1.0).text("Softness"));
    *region = ordered(typed).unwrap_or(*region);
}

/// The length to which the regions' opacities refer.
fn unit_distance(
    ui: &mut Ui,
    model: &mut Model,
    (selected, item, values): (usize, &ItemKeys, Option<&Values>),
) {
    let spacing = values.map_or(1.0, |values| values.spacing);
    let unit = values.map_or("", |values| values.unit);
    let mut length = item.unit_distance.unwrap_or(spacing);
    if length_slider(ui, &mut length, (spacing, unit)) {
        model.gesture(|session| session.adjust_item(selected, "unit-distance", &length));
    }
}
