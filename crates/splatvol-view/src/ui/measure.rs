//! Lengths and angles between places in the picture.

use eframe::egui::{Align2, Painter, Pos2, Rect, Stroke, Ui};
use splatvol::glam::DVec3;

use super::picture::{PicturePanel, plated, unit};
use super::status::number;
use super::style;
use crate::model::Model;
use crate::model::probe::Probe;

/// Places of a measurement: two have a distance, three an angle as well.
const MOST: usize = 3;

/// The places that are measured, world.
#[derive(Debug, Clone, Default)]
pub(super) struct Measure {
    places: Vec<DVec3>,
}

impl Measure {
    /// Adds what is under the pointer; a fourth place begins anew.
    pub(super) fn add(&mut self, hovered: Option<&Probe>, model: &mut Model) {
        let Some(probe) = hovered else {
            model.say("there is nothing under the pointer", false);
            return;
        };
        if self.places.len() == MOST {
            self.places.clear();
        }
        self.places.push(probe.place);
    }

    pub(super) fn clear(&mut self) {
        self.places.clear();
    }

    /// Draws lines, lengths and the angle over the picture.
    pub(super) fn show(&self, ui: &Ui, model: &Model, picture: &PicturePanel) {
        let (Some(shown), Some(rect)) = (model.shown(), picture.rect()) else {
            return;
        };
        let painter = ui.painter_at(rect);
        let seen = self.places.iter();
        let seen: Vec<_> = seen
            .map(|place| picture.position(&shown.camera, shown.view_size, *place))
            .collect();
        for (places, ends) in self.places.windows(2).zip(seen.windows(2)) {
            if let [Some(from), Some(to)] = ends {
                line(&painter, [*from, *to]);
                let length = number(places[0].distance(places[1]));
                let text = format!("{length} {}", unit(model));
                say(ui, rect, (from.lerp(*to, 0.5), text.trim()));
            }
        }
        for at in seen.iter().flatten() {
            painter.circle_filled(*at, 5.0, style::BACKDROP);
            painter.circle_filled(*at, 3.5, style::ACCENT);
        }
        if let (Some(angle), [Some(a), Some(middle), Some(b)]) = (self.angle(), &seen[..]) {
            // Outside, where the arms are not.
            let within = (*a - *middle).normalized() + (*b - *middle).normalized();
            let at = *middle - 26.0 * within.normalized();
            say(ui, rect, (at, &format!("{angle:.1}°")));
        }
    }

    /// Number of places.
    #[cfg(test)]
    pub(super) fn count(&self) -> usize {
        self.places.len()
    }

    /// The angle at the second of three places, degrees.
    fn angle(&self) -> Option<f64> {
        match self.places[..] {
            [a, middle, b] => Some((a - middle).angle_between(b - middle).to_degrees()),
            _ => None,
        }
    }
}

fn line(painter: &Painter, ends: [Pos2; 2]) {
    painter.line_segment(ends, Stroke::new(4.0, style::BACKDROP));
    painter.line_segment(ends, Stroke::new(2.0, style::ACCENT));
}

fn say(ui: &Ui, rect: Rect, (at, text): (Pos2, &str)) {
    plated(ui, rect, at, (Align2::CENTER_CENTER, text, style::TEXT));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_places_have_an_angle() {
        let mut measure = Measure::default();
        for place in [DVec3::new(3.0, 0.0, 1.0), DVec3::new(0.0, 0.0, 1.0)] {
            measure.places.push(place);
            assert_eq!(measure.angle(), None);
        }
        measure.places.push(DVec3::new(0.0, 0.0, 9.0));
        let angle = measure.angle().unwrap();
        assert!((angle - 90.0).abs() < 1e-9, "{angle}");
    }
}
