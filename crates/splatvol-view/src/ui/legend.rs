//! The colour bar: which values have which colours.

use eframe::egui::{Align2, Color32, Id, Rect, Role, Sense, Stroke, StrokeKind, Ui, Vec2, WidgetInfo};

use super::picture::{PicturePanel, plated, round_length};
use super::status::{aligned, number};
use super::style;
use crate::model::{Model, curve};

/// Width and longest height of the bar, points.
const WIDTH: f32 = 14.0;
const HEIGHT: f32 = 220.0;
/// Shortest height at which it is shown.
const LEAST: f32 = 60.0;
/// Intervals between labels, about.
const INTERVALS: f64 = 4.0;

/// Shows the bar of an item at the right of the picture, if its values have colours that a bar can show: not those of labels, and
/// not those that depend on gradients, too.
pub(super) fn show(ui: &Ui, (model, selected): (&Model, usize), picture: &PicturePanel) {
    let document = model.document();
    let item = document
        .items
        .get(selected)
        .filter(|item| item.is_visible() && item.labels != Some(true) && document.effects.regions.is_none());
    let function = item.and_then(|item| item.transfer_function.as_ref());
    let (Some(function), Some(rect)) = (function, picture.rect()) else {
        return;
    };
    let [low, high] = curve::span(function);
    let height = HEIGHT.min(0.4 * rect.height());
    if height < LEAST {
        return;
    }
    let size = Vec2::new(WIDTH, height);
    let middle = rect.right_center() - Vec2::new(20.0 + 0.5 * WIDTH, 0.0);
    let bar = Rect::from_center_size(middle, size);
    let painter = ui.painter_at(rect);
    let steps = height.ceil() as usize;
    for step in 0..steps {
        let share = (step as f32 + 0.5) / steps as f32;
        let [red, green, blue] = function
            .color(high - f64::from(share) * (high - low))
            .map(|channel| (255.0 * channel).round() as u8);
        let top = bar.top() + step as f32 * height / steps as f32;
        let line = Rect::from_min_size([bar.left(), top].into(), Vec2::new(WIDTH, 1.5));
        painter.rect_filled(line.intersect(bar), 0.0, Color32::from_rgb(red, green, blue));
    }
    painter.rect_stroke(bar, 0.0, Stroke::new(1.0, style::TEXT), StrokeKind::Outside);
    let step = step([low, high]);
    for value in ticks([low, high], step) {
        let share = ((high - value) / (high - low)) as f32;
        let at = bar.left_top() + Vec2::new(-4.0, share * height);
        painter.line_segment([at, at + Vec2::new(4.0, 0.0)], Stroke::new(1.0, style::TEXT));
        let text = aligned(value, step);
        let label = (Align2::RIGHT_CENTER, text.as_str(), style::TEXT);
        plated(ui, rect, at - Vec2::new(4.0, 0.0), label);
    }
    let response = ui.interact(bar, Id::unique("colour bar"), Sense::hover());
    let about = format!("Colour bar from {} to {}", number(low), number(high));
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &about));
}

/// The round distance of labels over a range.
fn step([low, high]: [f64; 2]) -> f64 {
    round_length((high - low) / INTERVALS)
}

/// Round values in a range.
fn ticks([low, high]: [f64; 2], step: f64) -> impl Iterator<Item = f64> {
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    (first..=last).map(move |index| index as f64 * step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_round_and_within_the_range() {
        for (range, expected) in [
            ([0.0, 255.0], vec![0.0, 50.0, 100.0, 150.0, 200.0, 250.0]),
            ([-1.0, 1.0], vec![-1.0, -0.5, 0.0, 0.5, 1.0]),
            ([1003.0, 1007.0], vec![1003.0, 1004.0, 1005.0, 1006.0, 1007.0]),
        ] {
            assert_eq!(ticks(range, step(range)).collect::<Vec<_>>(), expected);
        }
    }
}
