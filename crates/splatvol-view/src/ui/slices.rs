//! Three slices of the selected volume, and a cross where they meet.

use eframe::egui::{
    Checkbox, Color32, ColorImage, Context, LayerId, Pos2, Rect, Role, ScrollArea, Sense, Slider, Stroke,
    TextureHandle, TextureOptions, Ui, Vec2, WidgetInfo, Window,
};
use splatvol::glam::DVec3;
use splatvol_document::keys::ItemKeys;

use super::picture::PicturePanel;
use super::status::number;
use super::{rooms, style};
use crate::model::Model;
use crate::model::probe::Probe;
use crate::model::shown_volume::ShownVolume;
use crate::model::slice::{Palette, SIDES, slice};

/// Length of the longest side of the box in a slice, points.
const LONGEST: f64 = 190.0;
/// Length of a slider, points: it and its name are no wider than a slice.
const SLIDER: f32 = 80.0;
/// Half of the cross in the picture, points.
const CROSS: f32 = 7.0;

/// What a slice's texture shows.
#[derive(Debug, PartialEq)]
struct Key {
    source: ItemKeys,
    dims: [usize; 3],
    index: usize,
    palette: Palette,
}

/// The slices.
#[derive(Default)]
pub(super) struct Slices {
    open: bool,
    /// The voxel where they meet, and the grid whose voxel it is.
    at: [usize; 3],
    dims: [usize; 3],
    in_colors: bool,
    textures: [Option<(Key, TextureHandle)>; 3],
}

/// Points on the screen per voxel along each axis of the grid.
fn points_per_voxel(shown: ShownVolume<'_>) -> [f64; 3] {
    let grid = shown.volume.grid();
    let (dims, spacing) = (grid.dims(), grid.spacing());
    let longest = (0..3).map(|axis| dims[axis] as f64 * spacing[axis]);
    let scale = LONGEST / longest.fold(f64::MIN_POSITIVE, f64::max);
    [0, 1, 2].map(|axis| spacing[axis] * scale)
}

impl Slices {
    /// Shows or hides them.
    pub(super) fn toggle(&mut self) {
        self.open = !self.open;
    }

    /// Moves the slices to a place that is pinned.
    pub(super) fn follow(&mut self, probe: Option<&Probe>, (model, selected): (&Model, usize)) {
        let (Some(probe), Some(field)) = (probe, ShownVolume::of(model, selected)) else {
            return;
        };
        let voxel = field
            .world_from_voxel()
            .inverse()
            .transform_point3(probe.place)
            .round();
        let dims = field.volume.grid().dims();
        self.begin(dims);
        if (0..3).all(|axis| voxel[axis] >= 0.0 && voxel[axis] < dims[axis] as f64) {
            self.at = [voxel.x, voxel.y, voxel.z].map(|at| at as usize);
        }
    }

    /// Meets in the middle of another grid.
    fn begin(&mut self, dims: [usize; 3]) {
        if self.dims != dims {
            self.dims = dims;
            self.at = dims.map(|side| side / 2);
        }
    }

    pub(super) fn show(
        &mut self,
        context: &Context,
        (model, selected): (&Model, usize),
        picture: &PicturePanel,
    ) {
        if !self.open {
            return;
        }
        let field = ShownVolume::of(model, selected);
        if let Some(field) = field {
            self.begin(field.volume.grid().dims());
            self.mark(context, (model, field), picture);
        }
        let mut open = true;
        Window::new("Slices")
            .open(&mut open)
            .resizable(false)
            .default_pos([250.0, 60.0])
            .show(context, |ui| {
                ui.set_max_size(rooms::of_dialog(context));
                ScrollArea::both().show(ui, |ui| match field {
                    Some(field) => self.inside(ui, field),
                    None => {
                        ui.label("The selected item is no volume that is shown.");
                    }
                });
            });
        self.open = open;
    }

    fn inside(&mut self, ui: &mut Ui, field: ShownVolume<'_>) {
        let palette = Palette::new(field.function, self.in_colors);
        ui.horizontal_top(|ui| {
            ui.spacing_mut().slider_width = SLIDER;
            for across in [2, 1, 0] {
                ui.vertical(|ui| {
                    let (name, ..) = style::AXES[across];
                    let last = self.dims[across] - 1;
                    let slider = Slider::new(&mut self.at[across], 0..=last).text(format!("Across {name}"));
                    ui.add(slider);
                    self.slice(ui, (field, &palette), across);
                });
            }
        });
        ui.horizontal(|ui| {
            let [x, y, z] = self.at;
            ui.label(format!(
                "Value {} at voxel {x}, {y}, {z}",
                number(field.value(self.at))
            ));
            ui.separator();
            ui.add(Checkbox::new(&mut self.in_colors, "In the colours of the look"));
        });
    }

    /// A slice with the others' places in it; a click or a drag moves them.
    fn slice(&mut self, ui: &mut Ui, (field, palette): (ShownVolume<'_>, &Palette), across: usize) {
        let sides = SIDES[across];
        let points = points_per_voxel(field);
        let size = sides.map(|side| (self.dims[side] as f64 * points[side]).max(1.0) as f32);
        let (rect, response) = ui.allocate_exact_size(Vec2::from(size), Sense::click_and_drag());
        let (name, ..) = style::AXES[across];
        let about = format!("Slice across {name} at {}", self.at[across]);
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &about));
        if let Some(at) = response.interact_pointer_pos() {
            let share = (at - rect.min) / rect.size();
            for (side, share) in sides.into_iter().zip([share.x, 1.0 - share.y]) {
                let count = self.dims[side];
                self.at[side] = ((share * count as f32).max(0.0) as usize).min(count - 1);
            }
        }
        let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
        let texture = self.texture(ui.ctx(), (field, palette), across);
        let painter = ui.painter_at(rect);
        painter.image(texture, rect, whole, Color32::WHITE);
        let middle = |side: usize| (self.at[side] as f32 + 0.5) / self.dims[side] as f32;
        let (x, y) = (
            rect.left() + middle(sides[0]) * rect.width(),
            rect.bottom() - middle(sides[1]) * rect.height(),
        );
        let stroke = |side: usize| Stroke::new(1.0, style::AXES[side].2);
        painter.vline(x, rect.y_range(), stroke(sides[0]));
        painter.hline(rect.x_range(), y, stroke(sides[1]));
    }

    fn texture(
        &mut self,
        context: &Context,
        (field, palette): (ShownVolume<'_>, &Palette),
        across: usize,
    ) -> eframe::egui::TextureId {
        let index = self.at[across];
        let key = Key {
            source: field.source(),
            dims: self.dims,
            index,
            palette: palette.clone(),
        };
        let kept = self.textures[across].take_if(|(of, _)| *of == key);
        let (key, texture) = kept.unwrap_or_else(|| {
            let [right, up] = SIDES[across];
            let codes = slice(field.volume, (across, index), palette);
            let image = ColorImage::from_rgb([self.dims[right], self.dims[up]], codes.as_flattened());
            (key, context.load_texture("slice", image, TextureOptions::NEAREST))
        });
        let id = texture.id();
        self.textures[across] = Some((key, texture));
        id
    }

    /// A cross in the picture, where the slices meet.
    fn mark(&self, context: &Context, (model, field): (&Model, ShownVolume<'_>), picture: &PicturePanel) {
        let Some(shown) = model.shown() else {
            return;
        };
        let voxel = DVec3::from_array(self.at.map(|at| at as f64));
        let place = field.world_from_voxel().transform_point3(voxel);
        if let Some(at) = picture.position(&shown.camera, shown.view_size, place) {
            let painter = context.layer_painter(LayerId::background());
            for (width, color) in [(3.5, style::BACKDROP), (1.5, style::WARNING)] {
                let stroke = Stroke::new(width, color);
                painter.hline(at.x - CROSS..=at.x + CROSS, at.y, stroke);
                painter.vline(at.x, at.y - CROSS..=at.y + CROSS, stroke);
            }
        }
    }
}
