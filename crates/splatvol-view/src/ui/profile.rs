//! Pinned places: a mark in the picture, and the profile of the ray that met it.

use eframe::egui::{
    Align2, Context, Pos2, Rect, Role, ScrollArea, Sense, Shape, Stroke, Ui, Vec2, WidgetInfo, Window,
};

use super::picture::PicturePanel;
use super::status::number;
use super::{rooms, style};
use crate::model::Model;
use crate::model::probe::Probe;

/// Size of the plot, points.
const PLOT: Vec2 = Vec2::new(280.0, 110.0);

/// The place that is pinned; two pinned places in a row have a distance.
#[derive(Debug, Default)]
pub(super) struct Pins {
    last: Option<Probe>,
    before: Option<Probe>,
}

impl Pins {
    /// Pins what is under the pointer.
    pub(super) fn pin(&mut self, hovered: Option<&Probe>, model: &mut Model) {
        match hovered {
            Some(probe) => self.before = self.last.replace(probe.clone()),
            None => model.say("there is nothing under the pointer", false),
        }
    }

    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    pub(super) fn show(&mut self, context: &Context, model: &Model, picture: &PicturePanel) {
        let (Some(probe), Some(shown)) = (&self.last, model.shown()) else {
            return;
        };
        let painter = context.layer_painter(eframe::egui::LayerId::background());
        let place = |probe: &Probe| picture.position(&shown.camera, shown.view_size, probe.place);
        let ends = [self.before.as_ref().and_then(place), place(probe)];
        if let [Some(from), Some(to)] = ends {
            painter.line_segment([from, to], Stroke::new(1.5, style::ACCENT));
        }
        for at in ends.into_iter().flatten() {
            painter.circle_stroke(at, 6.0, Stroke::new(3.5, style::BACKDROP));
            painter.circle_stroke(at, 6.0, Stroke::new(2.0, style::ACCENT));
        }
        let mut open = true;
        Window::new("Profile along the ray")
            .open(&mut open)
            .resizable(false)
            .anchor(Align2::CENTER_BOTTOM, [0.0, -60.0])
            .show(context, |ui| {
                ui.set_max_size(rooms::of_dialog(context));
                ScrollArea::both().show(ui, |ui| self.describe(ui, probe));
            });
        if !open {
            self.clear();
        }
    }

    /// The value at a place, its distance from the one before, and the plot.
    fn describe(&self, ui: &mut Ui, probe: &Probe) {
        let at = probe.place;
        ui.label(format!(
            "Value {} at x {:.2}, y {:.2}, z {:.2}",
            number(probe.value),
            at.x,
            at.y,
            at.z
        ));
        if let Some(before) = &self.before {
            let distance = number(before.place.distance(at));
            ui.label(format!("{distance} from the place that was pinned before"));
        }
        plot(ui, probe);
        ui.label("White: the value, over its range. Blue: the opacity that is reached, 0 to 1.");
    }
}

fn plot(ui: &mut Ui, probe: &Probe) {
    let (rect, response) = ui.allocate_exact_size(PLOT, Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Value and opacity along the ray"));
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 3.0, ui.visuals().extreme_bg_color);
    let inner: Rect = rect.shrink(6.0);
    let values = probe
        .profile
        .iter()
        .map(|sample| sample.value)
        .filter(|value| value.is_finite());
    let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
        [low.min(value), high.max(value)]
    });
    let last = (probe.profile.len().max(2) - 1) as f32;
    let at = |index: usize, share: f64| {
        Pos2::new(
            inner.left() + index as f32 / last * inner.width(),
            inner.bottom() - share as f32 * inner.height(),
        )
    };
    let samples = || probe.profile.iter().enumerate();
    let range = (high - low).max(f64::MIN_POSITIVE);
    let value = samples()
        .filter(|(_, sample)| sample.value.is_finite())
        .map(|(index, sample)| at(index, (sample.value - low) / range));
    painter.add(Shape::line(value.collect(), Stroke::new(1.3, style::TEXT)));
    let opacity = samples().map(|(index, sample)| at(index, sample.opacity));
    painter.add(Shape::line(opacity.collect(), Stroke::new(1.8, style::ACCENT)));
    let line = [at(probe.at, 0.0), at(probe.at, 1.0)];
    painter.line_segment(line, Stroke::new(1.0, style::WARNING));
}
