//! The table of keys and gestures: the window obeys it, its help and `docs/viewer.md` show it, and tests walk it.

use eframe::egui::{Key, KeyboardShortcut, Modifiers};
use splatvol_document::keys::names::ViewName;

/// What a key does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Action {
    /// Turns the view: azimuth and elevation, degrees.
    Turn(f64, f64),
    /// Turns the picture, degrees.
    Roll(f64),
    /// Moves what is seen: shares of the picture's height.
    Pan(f64, f64),
    /// Enlarges by a factor.
    Zoom(f64),
    /// Looks from a side.
    Look(ViewName),
    /// Shows everything.
    Fit,
    /// Turns around what is under the pointer.
    Pivot,
    /// Perspective or parallel.
    Projection,
    /// Undoes a step.
    Undo,
    /// Repeats a step.
    Redo,
    /// Adds a place to what is measured.
    Measure,
    /// Shows or hides the colour bar.
    Legend,
    /// Begins or ends flying.
    Fly,
    /// Shows or hides the slices.
    Slices,
    /// Begins or ends the box of clips.
    ClipBox,
    /// Adds a plane of clips across the view.
    ClipPlane,
    /// Shows or hides the handles of clips.
    Handles,
    /// Shows the other of two looks.
    OtherLook,
    /// Opens a file.
    Open,
    /// Saves a picture.
    Save,
    /// Shows what the ray under the pointer meets.
    Pin,
    /// Takes messages, pins and dialogs away; gives the keys back to the picture.
    Escape,
    /// Shows this table.
    Help,
    /// Shows or hides the panels.
    Panels,
    /// Closes the window.
    Quit,
}

/// A line of the table.
#[derive(Debug, Clone, Copy)]
pub struct Binding {
    /// What it does.
    pub action: Action,
    /// The keys that do it, any of them.
    pub keys: &'static [KeyboardShortcut],
    /// What it does, for a person.
    pub about: &'static str,
}

const fn plain(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::NONE, key)
}

const fn shift(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::SHIFT, key)
}

const fn ctrl(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::COMMAND, key)
}

const fn ctrl_shift(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), key)
}

const fn line(action: Action, keys: &'static [KeyboardShortcut], about: &'static str) -> Binding {
    Binding { action, keys, about }
}

/// Degrees of a key press.
const TURN: f64 = 5.0;
/// Share of the picture's height of a key press.
const PAN: f64 = 0.05;
/// Factor of a key press.
const ZOOM: f64 = 1.1;

/// Keys; those with more modifiers come first, because keys with fewer match them too.
pub const KEYS: &[Binding] = &[
    line(
        Action::Redo,
        &[ctrl_shift(Key::Z), ctrl(Key::Y)],
        "repeat the step that was undone",
    ),
    line(Action::Undo, &[ctrl(Key::Z)], "undo a step"),
    line(Action::Open, &[ctrl(Key::O)], "open a file"),
    line(Action::Save, &[ctrl(Key::P), ctrl(Key::S)], "save a picture"),
    line(Action::Quit, &[ctrl(Key::Q)], "quit"),
    line(
        Action::Look(ViewName::Back),
        &[ctrl(Key::Num1)],
        "look from the back",
    ),
    line(
        Action::Look(ViewName::Left),
        &[ctrl(Key::Num3)],
        "look from the left",
    ),
    line(
        Action::Look(ViewName::Bottom),
        &[ctrl(Key::Num7)],
        "look from below",
    ),
    line(
        Action::Pan(-PAN, 0.0),
        &[ctrl(Key::ArrowLeft)],
        "move to the left",
    ),
    line(
        Action::Pan(PAN, 0.0),
        &[ctrl(Key::ArrowRight)],
        "move to the right",
    ),
    line(Action::Pan(0.0, -PAN), &[ctrl(Key::ArrowUp)], "move up"),
    line(Action::Pan(0.0, PAN), &[ctrl(Key::ArrowDown)], "move down"),
    line(Action::Roll(-TURN), &[shift(Key::ArrowLeft)], "roll to the left"),
    line(Action::Roll(TURN), &[shift(Key::ArrowRight)], "roll to the right"),
    line(
        Action::Turn(-TURN, 0.0),
        &[plain(Key::ArrowLeft)],
        "turn to the left",
    ),
    line(
        Action::Turn(TURN, 0.0),
        &[plain(Key::ArrowRight)],
        "turn to the right",
    ),
    line(
        Action::Turn(0.0, TURN),
        &[plain(Key::ArrowUp)],
        "turn over the top",
    ),
    line(
        Action::Turn(0.0, -TURN),
        &[plain(Key::ArrowDown)],
        "turn under the bottom",
    ),
    line(
        Action::Zoom(ZOOM),
        &[plain(Key::Plus), plain(Key::Equals)],
        "enlarge",
    ),
    line(Action::Zoom(1.0 / ZOOM), &[plain(Key::Minus)], "reduce"),
    line(
        Action::Look(ViewName::Front),
        &[plain(Key::Num1)],
        "look from the front",
    ),
    line(
        Action::Look(ViewName::Right),
        &[plain(Key::Num3)],
        "look from the right",
    ),
    line(
        Action::Look(ViewName::Top),
        &[plain(Key::Num7)],
        "look from above",
    ),
    line(
        Action::Look(ViewName::Iso),
        &[plain(Key::Num9)],
        "look from above a corner",
    ),
    line(
        Action::Projection,
        &[plain(Key::Num5)],
        "perspective or parallel projection",
    ),
    line(Action::Fit, &[plain(Key::Home)], "show everything"),
    line(
        Action::Pivot,
        &[plain(Key::F)],
        "turn around what is under the pointer",
    ),
    line(
        Action::Fly,
        &[plain(Key::G), plain(Key::Backtick)],
        "fly, or end it: W S forward and back, A D to the sides, E Q up and down, with Shift faster",
    ),
    line(
        Action::Pin,
        &[plain(Key::P)],
        "pin value and profile of the ray under the pointer",
    ),
    line(
        Action::Measure,
        &[plain(Key::M)],
        "measure from place to place under the pointer: two have a length, three an angle",
    ),
    line(
        Action::Legend,
        &[plain(Key::L)],
        "show or hide the colour bar of the selected item",
    ),
    line(
        Action::Slices,
        &[plain(Key::S)],
        "three slices of the selected volume; a pin moves them",
    ),
    line(Action::ClipBox, &[plain(Key::C)], "a box that is kept, or none"),
    line(
        Action::ClipPlane,
        &[plain(Key::X)],
        "cut by a plane across the view",
    ),
    line(
        Action::Handles,
        &[plain(Key::H)],
        "show or hide the handles of clips",
    ),
    line(
        Action::OtherLook,
        &[plain(Key::B)],
        "from look A to look B, and back: B begins as a copy of A",
    ),
    line(Action::Panels, &[plain(Key::F9)], "show or hide the panels"),
    line(
        Action::Help,
        &[plain(Key::F1), shift(Key::Questionmark), plain(Key::Questionmark)],
        "keys and gestures",
    ),
    line(
        Action::Escape,
        &[plain(Key::Escape)],
        "close what is open; give the keys back to the picture",
    ),
];

/// Gestures with the pointer in the picture, and what they do. The picture's panel has them.
pub const GESTURES: &[(&str, &str)] = &[
    ("left drag", "turn"),
    ("left drag, flying", "look around"),
    ("Ctrl + left drag", "roll"),
    ("Shift + left drag, middle drag", "move"),
    (
        "right drag, wheel, pinch",
        "enlarge (the wheel: where the pointer is)",
    ),
    (
        "drag a handle",
        "move a side of the box, or a plane (white), or turn it (orange)",
    ),
    ("double click", "turn around what is seen there"),
    ("hover", "value and position, in the status line"),
    (
        "drop a file",
        "open it; with Ctrl, add it; a picture that splatvol made restores everything",
    ),
];

/// Gestures in the transfer function.
pub const CURVE_GESTURES: &[(&str, &str)] = &[
    ("click", "add a point, or select one"),
    ("drag", "move a point; with Shift, up and down only"),
    ("right click, Delete", "remove a point"),
    ("Tab, arrows", "the list of points has the same by keyboard"),
];

/// The keys of a line, for a person: `Ctrl+Z`.
pub fn names(binding: &Binding) -> String {
    let names = binding.keys.iter().map(|keys| {
        let modifiers = keys.modifiers;
        let mut name = String::new();
        if modifiers.command {
            name.push_str("Ctrl+");
        }
        if modifiers.shift {
            name.push_str("Shift+");
        }
        name + symbol(keys.logical_key)
    });
    names.collect::<Vec<_>>().join(", ")
}

/// The sign on a key.
fn symbol(key: Key) -> &'static str {
    match key {
        Key::ArrowLeft => "Left",
        Key::ArrowRight => "Right",
        Key::ArrowUp => "Up",
        Key::ArrowDown => "Down",
        Key::Plus => "+",
        Key::Minus => "-",
        Key::Equals => "=",
        Key::Questionmark => "?",
        key => key.name(),
    }
}

/// The key of an action, for a menu.
pub fn key_of(action: Action) -> String {
    let line = KEYS.iter().find(|line| line.action == action);
    line.map_or_else(String::new, |line| {
        let first = Binding {
            keys: &line.keys[..1],
            ..*line
        };
        names(&first)
    })
}

/// The tables in Markdown, as `docs/viewer.md` has them.
pub fn markdown() -> String {
    let mut text = String::from("| keys | |\n|---|---|\n");
    for line in KEYS {
        text.push_str(&format!("| {} | {} |\n", names(line), line.about));
    }
    for (title, lines) in [
        ("in the picture", GESTURES),
        ("in the transfer function", CURVE_GESTURES),
    ] {
        text.push_str(&format!("\n| {title} | |\n|---|---|\n"));
        for (gesture, about) in lines {
            text.push_str(&format!("| {gesture} | {about} |\n"));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_does_two_things() {
        let all: Vec<_> = KEYS.iter().flat_map(|line| line.keys).collect();
        for (index, keys) in all.iter().enumerate() {
            assert!(!all[..index].contains(keys), "{keys:?}");
        }
        assert_eq!(key_of(Action::Undo), "Ctrl+Z");
    }

    #[test]
    fn keys_with_more_modifiers_come_first() {
        let count =
            |keys: &KeyboardShortcut| u32::from(keys.modifiers.command) + u32::from(keys.modifiers.shift);
        let all: Vec<_> = KEYS.iter().flat_map(|line| line.keys).collect();
        for (index, keys) in all.iter().enumerate() {
            let shadows = |earlier: &&&KeyboardShortcut| {
                earlier.logical_key == keys.logical_key && count(earlier) < count(keys)
            };
            assert_eq!(all[..index].iter().find(shadows), None, "{keys:?}");
        }
    }

    #[test]
    fn the_documentation_has_these_tables() {
        let page = include_str!("../../../../docs/viewer.md");
        let tables = markdown();
        assert!(page.contains(&tables), "docs/viewer.md should hold:\n{tables}");
    }
}
