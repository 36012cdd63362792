//! Room: how the window is divided between picture and panels, and what dialogs and menus may take of it.

use eframe::egui::{Context, Vec2};

/// Widths of the panel of the scene: the usual one, and its bounds, points.
const SCENE: [f32; 3] = [180.0, 230.0, 420.0];
/// The same of the panel of the look.
const LOOK: [f32; 3] = [300.0, 330.0, 520.0];
/// What stands around the contents of a dialog: its title, margins, and a gap to the window's sides.
const AROUND: Vec2 = Vec2::new(36.0, 72.0);
/// What stands around a menu: the bar above it, and margins.
const AROUND_MENU: f32 = 56.0;

/// The panels beside the picture. It keeps at least half of the width.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Panels {
    /// One at each side, of which the scene's may take so much.
    Two {
        /// Most width of the panel of the scene.
        scene: f32,
    },
    /// One for everything, of this width.
    One {
        /// Its width.
        width: f32,
    },
}

impl Panels {
    /// Panels of a window of some width, points.
    pub(super) fn of(width: f32) -> Self {
        let room = 0.5 * width;
        match room >= SCENE[0] + LOOK[0] {
            true => Self::Two {
                scene: (room - LOOK[0]).min(SCENE[2]),
            },
            false => Self::One {
                width: room.min(LOOK[1]),
            },
        }
    }
}

/// Usual width of the panel of the scene, and its bounds.
pub(super) fn scene(most: f32) -> (f32, [f32; 2]) {
    (SCENE[1].min(most), [SCENE[0], most])
}

/// Usual width of the panel of the look, and its bounds, beside one of the scene in a window of some width.
pub(super) fn look(width: f32, scene: f32) -> (f32, [f32; 2]) {
    let most = (0.5 * width - scene).clamp(LOOK[0], LOOK[2]);
    (LOOK[1].min(most), [LOOK[0], most])
}

/// Most size of the contents of a dialog.
pub(super) fn of_dialog(context: &Context) -> Vec2 {
    (context.content_rect().size() - AROUND).max(Vec2::splat(60.0))
}

/// Most height of a menu.
pub(super) fn of_menu(context: &Context) -> f32 {
    (context.content_rect().height() - AROUND_MENU).max(60.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_picture_keeps_half_of_any_window() {
        for width in (300..3000).step_by(7).map(|width| width as f32) {
            let panels = match Panels::of(width) {
                Panels::Two { scene: most } => {
                    let (usual, [_, last]) = scene(most);
                    assert!(usual <= last);
                    let beside = |scene: f32| scene + look(width, scene).1[1];
                    beside(usual).max(beside(last))
                }
                Panels::One { width } => width,
            };
            assert!(panels <= 0.5 * width + 1e-3, "{panels} of {width}");
        }
        assert_eq!(scene(420.0).0 + look(1280.0, 230.0).0, 560.0);
    }
}
