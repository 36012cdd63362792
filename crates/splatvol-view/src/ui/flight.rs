//! Flying: six keys, by their place on the keyboard, move the eye, and a drag turns it around itself.

use eframe::egui::{Event, Key, Ui};
use splatvol::glam::DVec3;

use crate::model::{Model, navigate};

/// Heights of the picture at the pivot that are flown in a second, and the factor of Shift.
const SPEED: f64 = 0.5;
const FASTER: f64 = 4.0;
/// Longest time of a step, seconds: after a pause, nobody leaps.
const LONGEST_STEP: f64 = 0.1;

/// The keys of a keyboard from the United States, and their ways: right, up, forward.
const WAYS: [(Key, DVec3); 6] = [
    (Key::W, DVec3::Z),
    (Key::S, DVec3::NEG_Z),
    (Key::D, DVec3::X),
    (Key::A, DVec3::NEG_X),
    (Key::E, DVec3::Y),
    (Key::Q, DVec3::NEG_Y),
];

/// Whether the eye flies, and the keys that are held.
#[derive(Debug, Default)]
pub(super) struct Flight {
    flies: bool,
    held: [bool; WAYS.len()],
}

impl Flight {
    pub(super) fn flies(&self) -> bool {
        self.flies
    }

    pub(super) fn toggle(&mut self) {
        self.flies = !self.flies;
        self.held = Default::default();
    }

    pub(super) fn end(&mut self) {
        *self = Self::default();
    }

    /// Takes the keys of flying, which do something else otherwise, and moves the eye by those that are held.
    pub(super) fn show(&mut self, ui: &Ui, model: &mut Model) {
        if !self.flies {
            return;
        }
        ui.input_mut(|input| {
            if !input.focused {
                self.held = Default::default();
            }
            input.events.retain(|event| !self.takes(event));
        });
        let held = WAYS.iter().zip(self.held).filter(|(_, held)| *held);
        let way: DVec3 = held.map(|((_, way), _)| *way).sum();
        if way == DVec3::ZERO {
            return;
        }
        let (seconds, shift) = ui.input(|input| (f64::from(input.stable_dt), input.modifiers.shift));
        let speed = if shift { FASTER * SPEED } else { SPEED };
        let step = speed * seconds.min(LONGEST_STEP) * way;
        model.move_camera(|camera| navigate::fly(camera, step));
        ui.request_repaint();
    }

    /// Whether an event is one of a key that moves the eye.
    fn takes(&mut self, event: &Event) -> bool {
        let Event::Key {
            key,
            physical_key,
            pressed,
            modifiers,
            ..
        } = event
        else {
            return false;
        };
        let place = physical_key.unwrap_or(*key);
        let Some(index) = WAYS.iter().position(|(key, _)| *key == place) else {
            return false;
        };
        // Ctrl+S is another matter; but a key that is released moves nothing any more.
        let is_own = !modifiers.command && !modifiers.ctrl && !modifiers.alt;
        self.held[index] = *pressed && is_own;
        is_own
    }
}
