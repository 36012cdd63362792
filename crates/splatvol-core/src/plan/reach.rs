//! Bricks that a part of a picture can show: for pictures whose plan is made part by part.

use glam::DVec3;

use super::project::BrickProjection;
use super::view::GridView;
use super::zone_plan::ZonePlan;
use crate::bin::TileRect;
use crate::brick::BRICK;

/// Voxels around the eye within which all bricks are kept: more than any kernel reaches.
const AROUND_EYE: f64 = 16.0;

/// The bricks whose footprints can touch a rectangle of whole tiles.
#[derive(Debug)]
pub struct Reach<'a> {
    zones: Vec<BrickProjection<'a>>,
    rect: TileRect,
    /// The eye, lattice, where planes there are made from the bricks around it.
    eye: Option<DVec3>,
}

impl<'a> Reach<'a> {
    /// Of a picture with this view.
    pub fn new(view: &'a GridView, rect: TileRect) -> Self {
        let mut zones = Vec::new();
        let mut begins_at_eye = false;
        view.cutting().cut(|zone| {
            begins_at_eye |= zone.begins_at_eye();
            let mut plan = ZonePlan {
                zone,
                ..ZonePlan::default()
            };
            plan.project(view);
            zones.push(plan.projection(view));
        });
        Self {
            zones,
            rect,
            eye: begins_at_eye.then(|| view.camera_from_lattice().inverse().translation),
        }
    }

    /// The same for kernels that may end farther from their voxel, by this world length at most.
    #[must_use]
    pub fn beyond(mut self, length: f64) -> Self {
        for zone in &mut self.zones {
            let scale = zone.screen.scale_at(zone.nearest);
            // At the eye no margin is too large.
            let scale = if scale > 0.0 { scale } else { f64::MAX };
            zone.margin = (zone.margin + length * scale).min(f64::MAX);
            zone.reach += length;
        }
        self
    }

    /// Whether the brick that begins at a lattice point is needed.
    pub fn meets(&self, first: [u32; 3]) -> bool {
        let low = DVec3::from_array(first.map(f64::from));
        let holds_eye = |eye: DVec3| {
            eye.cmpge(low - AROUND_EYE).all() && eye.cmple(low + (AROUND_EYE + BRICK as f64)).all()
        };
        self.eye.is_some_and(holds_eye)
            || self.zones.iter().any(|zone| {
                zone.project(first, 0).is_some_and(|brick| {
                    let [x0, y0, x1, y1] = brick.rect;
                    x1 >= self.rect.x0 as f32
                        && x0 < self.rect.x1 as f32
                        && y1 >= self.rect.y0 as f32
                        && y0 < self.rect.y1 as f32
                })
            })
    }
}
