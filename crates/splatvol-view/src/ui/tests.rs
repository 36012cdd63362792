//! The window's panels, found by the names that screen readers say.

use std::time::{Duration, Instant};

use eframe::egui::{Key, Modifiers, Pos2, Vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use super::*;

mod fading;
mod faults;
mod layout;

type Window<'a> = Harness<'a, Option<Viewer>>;

fn start(files: &[&str]) -> Start {
    Start {
        files: files.iter().map(|&file| file.to_owned()).collect(),
        command: "splatvol view".to_owned(),
        ..Start::default()
    }
}

fn window(files: &[&str]) -> Window<'static> {
    let start = start(files);
    let mut window = Harness::builder()
        .with_size(Vec2::new(1100.0, 900.0))
        .build_ui_state(
            move |ui, viewer: &mut Option<Viewer>| {
                let viewer = viewer.get_or_insert_with(|| Viewer::new(ui.ctx(), start.clone()).unwrap());
                viewer.show(ui);
            },
            None,
        );
    if !files.is_empty() {
        wait(&mut window, "the first picture", |model| model.is_final());
    }
    window
}

fn model<'a>(window: &'a Window<'_>) -> &'a Model {
    window.state().as_ref().unwrap().model()
}

/// Steps until something holds.
fn wait(window: &mut Window<'_>, what: &str, done: impl Fn(&Model) -> bool) {
    let start = Instant::now();
    loop {
        window.step();
        if done(model(window)) {
            // What changed is laid out, and laid out again where it depends on itself.
            window.step();
            window.step();
            return;
        }
        assert!(
            start.elapsed() < Duration::from_secs(120),
            "{what}: {:?}",
            model(window).message()
        );
        std::thread::sleep(Duration::from_millis(3));
    }
}

fn click(window: &mut Window<'_>, label: &str) {
    // As a screen reader does, which reaches what is scrolled away, too.
    window.get_by_label(label).click_accesskit();
    window.step();
    window.step();
}

fn press(window: &mut Window<'_>, key: Key) {
    window.key_press(key);
    window.step();
    window.step();
}

fn drag(window: &mut Window<'_>, from: Pos2, to: Pos2) {
    window.drag_at(from);
    window.step();
    for share in 1..=4 {
        window.hover_at(from + (to - from) * (share as f32 / 4.0));
        window.step();
    }
    window.drop_at(to);
    window.step();
    window.step();
}

#[test]
fn an_empty_window_says_what_to_do() {
    let mut window = window(&[]);
    window.step();
    window.get_by_label("Picture: nothing is open");
    window.key_press_modifiers(Modifiers::COMMAND, Key::O);
    window.step();
    window.step();
    window.get_by_label("File or folder, or sample:NAME");
    window.check_accessibility();
    window.key_press(Key::Escape);
    window.step();
    window.step();
    assert!(window.query_by_label("File or folder, or sample:NAME").is_none());
}

#[test]
fn every_panel_has_names_for_all_that_can_be_changed() {
    let mut window = window(&["sample:head:16"]);
    for section in ["Place", "Light", "Picture", "Clip", "Points"] {
        click(&mut window, section);
    }
    click(&mut window, "Box");
    wait(&mut window, "the box", |model| model.is_final());
    window.check_accessibility();
    for label in [
        "Shift x",
        "Scale",
        "Kind of picture",
        "Smooth edges",
        "Ambient",
        "From above",
        "As large as the window",
        "Background",
        "x from",
        "z to",
        "Cut the inside away",
        "Log counts",
        "Colours over the values",
        "Opacity per",
        "Value of point 1",
        "Opacity of point 1",
        "Remove point 1",
        "Automatic",
    ] {
        assert!(window.query_all_by_label(label).count() > 0, "{label}");
    }
}

#[test]
fn panels_edit_the_document_and_steps_are_undone() {
    let mut window = window(&["sample:head:16"]);
    let start = model(&window).document().clone();
    click(&mut window, "Clip");
    click(&mut window, "Box");
    assert!(model(&window).document().effects.clip_box.is_some());
    click(&mut window, "Cut the inside away");
    assert_eq!(model(&window).document().effects.clip_inside, Some(true));
    click(&mut window, "Smooth edges");
    wait(&mut window, "smooth edges", |model| {
        model.document().settings != start.settings
    });
    click(&mut window, "Points");
    let points = |window: &Window<'_>| {
        let function = model(window).document().items[0].transfer_function.clone();
        function.unwrap().opacities().len()
    };
    let before = points(&window);
    click(&mut window, "Add a point");
    assert_eq!(points(&window), before + 1);
    click(&mut window, "Remove point 1");
    assert_eq!(points(&window), before);
    for _ in 0..5 {
        window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        window.step();
        window.step();
    }
    assert_eq!(model(&window).document(), &start);
}

#[test]
fn keys_and_drags_turn_the_picture() {
    let mut window = window(&["sample:head:16"]);
    let camera = |window: &Window<'_>| model(window).session().camera().unwrap();
    let start = camera(&window);
    window.key_press(Key::ArrowLeft);
    window.step();
    window.step();
    let turned = camera(&window);
    assert!((turned.position() - start.position()).length() > 1.0);
    window.key_press(Key::Num5);
    window.step();
    window.step();
    assert!(matches!(
        camera(&window).projection(),
        splatvol::Projection::Orthographic { .. }
    ));
    let before = camera(&window);
    drag(&mut window, Pos2::new(450.0, 400.0), Pos2::new(520.0, 430.0));
    assert!((camera(&window).position() - before.position()).length() > 1.0);
    // A drag is one step, a key press is one, and a click none.
    for _ in 0..3 {
        window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        window.step();
        window.step();
    }
    assert_eq!(camera(&window), start);
    assert!(!model(&window).session().can_undo());
}

#[test]
fn handles_of_clips_are_dragged_in_the_picture() {
    let mut window = window(&["sample:head:16"]);
    let effects = |window: &Window<'_>| model(window).document().effects.clone();
    let start = model(&window).document().clone();
    press(&mut window, Key::C);
    let whole = effects(&window).clip_box.unwrap();
    wait(&mut window, "the box", |model| model.is_final());
    let handle = window.get_by_label("Upper z side of the box").rect().center();
    drag(&mut window, handle, handle + Vec2::new(0.0, 60.0));
    let cut = effects(&window).clip_box.unwrap();
    assert!(cut[5] < whole[5], "{cut:?}");
    assert_eq!(cut[..5], whole[..5]);
    assert_eq!(model(&window).document().camera, start.camera);
    press(&mut window, Key::X);
    let plane = |window: &Window<'_>| effects(window).clip_plane.unwrap()[0];
    let across = plane(&window);
    wait(&mut window, "the plane", |model| model.is_final());
    window.check_accessibility();
    // It faces the camera: up is away from it.
    let handle = window.get_by_label("Depth of plane 1").rect().center();
    drag(&mut window, handle, handle + Vec2::new(0.0, -30.0));
    let pushed = plane(&window);
    assert_eq!(pushed.normal(), across.normal());
    assert!((pushed.point() - across.point()).dot(across.normal()) > 1.0);
    for _ in 0..6 {
        press(&mut window, Key::ArrowLeft);
    }
    wait(&mut window, "another side", |model| model.is_final());
    let handle = window.get_by_label("Normal of plane 1").rect().center();
    drag(&mut window, handle, handle + Vec2::new(25.0, 0.0));
    assert!(plane(&window).normal().distance(across.normal()) > 0.05);
    press(&mut window, Key::H);
    assert!(window.query_by_label("Normal of plane 1").is_none());
    for _ in 0..11 {
        window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        window.step();
        window.step();
    }
    assert_eq!(model(&window).document(), &start);
}

#[test]
fn a_point_of_the_curve_is_dragged_and_removed() {
    let mut window = window(&["sample:head:16"]);
    let function = |window: &Window<'_>| {
        model(window).document().items[0]
            .transfer_function
            .clone()
            .unwrap()
    };
    let start = function(&window);
    let label = format!(
        "Opacity curve of {} points; the list of points has the same by keyboard",
        start.opacities().len()
    );
    let rect = window.get_by_label(&label).rect();
    // High above every point: a new one.
    let at = Pos2::new(
        rect.left() + 0.63 * rect.width(),
        rect.top() + 0.06 * rect.height(),
    );
    window.drag_at(at);
    window.step();
    window.hover_at(at + Vec2::new(4.0, 10.0));
    window.step();
    window.hover_at(at + Vec2::new(8.0, 30.0));
    window.step();
    window.drop_at(at + Vec2::new(8.0, 30.0));
    window.step();
    window.step();
    let edited = function(&window);
    assert_eq!(edited.opacities().len(), start.opacities().len() + 1);
    window.key_press(Key::Delete);
    window.step();
    window.step();
    assert_eq!(function(&window), start);
}

#[test]
fn the_status_line_names_the_look() {
    let mut window = window(&["sample:head:16"]);
    for look in ["Look B", "Look A"] {
        press(&mut window, Key::B);
        window.get_by_label(look);
    }
}

#[test]
fn slices_meet_where_one_is_clicked_and_follow_pins() {
    let mut window = window(&["sample:head:16"]);
    window.key_press(Key::S);
    window.step();
    window.step();
    let dims = model(&window).shown().unwrap().scene.items[0]
        .as_volume()
        .unwrap()
        .volume
        .grid()
        .dims();
    let rect = window
        .get_by_label(&format!("Slice across z at {}", dims[2] / 2))
        .rect();
    // The lower left corner: the first voxel along x and y.
    let corner = rect.left_bottom() + Vec2::new(2.0, -2.0);
    window.drag_at(corner);
    window.step();
    window.drop_at(corner);
    window.step();
    window.step();
    window.get_by_label("Slice across x at 0");
    window.get_by_label("Slice across y at 0");
    let voxel = format!("at voxel 0, 0, {}", dims[2] / 2);
    window.get_by_label_contains(&voxel);
    window.check_accessibility();
    click(&mut window, "In the colours of the look");
    // What is pinned lies inside.
    window.hover_at(Pos2::new(640.0, 640.0));
    window.step();
    window.key_press(Key::P);
    window.step();
    window.step();
    window.get_by_label("Profile along the ray");
    assert!(window.query_by_label_contains(&voxel).is_none());
    window.key_press(Key::S);
    window.step();
    window.step();
    assert!(window.query_by_label_contains("Slice across").is_none());
}

#[test]
fn views_become_key_frames_and_the_preview_goes_between_them() {
    let mut window = window(&["sample:head:16"]);
    let camera = |window: &Window<'_>| model(window).session().camera().unwrap();
    let keys = |window: &Window<'_>| model(window).document().animation.keys.clone();
    click(&mut window, "Animation");
    window.get_by_label("Two views or more make a way.");
    click(&mut window, "Add this view");
    let first = camera(&window);
    for _ in 0..4 {
        window.key_press(Key::ArrowLeft);
        window.step();
        window.step();
    }
    let second = camera(&window);
    click(&mut window, "Add this view");
    assert_eq!(keys(&window).map(|keys| keys.len()), Some(2));
    window.check_accessibility();
    // Back at the first key, then a frame on.
    click(&mut window, "Go to key 1");
    assert_eq!(camera(&window), first);
    let slider = window.get_all_by_label("Frame").next().unwrap();
    slider.focus();
    window.step();
    for _ in 0..3 {
        window.key_press(Key::ArrowRight);
        window.step();
        window.step();
    }
    let between = camera(&window);
    let [from_first, from_second] = [first, second].map(|end| (between.position() - end.position()).length());
    assert!(
        from_first > 0.0 && from_first < from_second,
        "{from_first} {from_second}"
    );
    // Played to its end, and undone in one step.
    click(&mut window, "Play");
    let start = Instant::now();
    while window.query_by_label("Stop").is_some() {
        assert!(start.elapsed() < Duration::from_secs(60), "it plays on");
        window.step();
    }
    assert!((camera(&window).position() - second.position()).length() < 1e-6);
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    window.step();
    window.step();
    assert_eq!(camera(&window), between);
    click(&mut window, "Set key 2 to this view");
    assert_eq!(keys(&window).unwrap()[1].camera(&first).unwrap(), between);
    click(&mut window, "Remove key 1");
    click(&mut window, "Remove key 1");
    assert!(model(&window).document().animation.is_empty());
}

#[test]
fn the_help_shows_all_keys_and_text_grows() {
    let mut window = window(&["sample:head:16"]);
    press(&mut window, Key::F1);
    window.get_by_label("undo a step");
    window.key_press(Key::Escape);
    window.step();
    window.ctx.set_zoom_factor(2.0);
    wait(&mut window, "a picture for large text", |model| model.is_final());
    window.get_by_label("Save picture");
    window.check_accessibility();
}

#[test]
fn regions_of_values_and_gradients_are_drawn_dragged_and_left() {
    let mut window = window(&["sample:head:16"]);
    let start = model(&window).document().items[0].clone();
    let regions = |window: &Window<'_>| model(window).document().effects.regions.clone().unwrap();
    click(&mut window, "values and gradients");
    wait(&mut window, "the first region", |model| {
        model.document().effects.regions.is_some() && model.is_final()
    });
    assert_eq!(regions(&window).len(), 1);
    let begun = regions(&window)[0];
    window.check_accessibility();
    let plot = window
        .get_by_label_contains("Values and gradients with 1 regions")
        .rect();
    // All of it, by its middle.
    let [low, high] = model(&window)
        .facts(&start)
        .unwrap()
        .values
        .clone()
        .unwrap()
        .range;
    let middle = 0.5 * (begun.value[0] + begun.value[1]);
    let x = plot.left() + ((middle - low) / (high - low)) as f32 * plot.width();
    let at = Pos2::new(x, plot.center().y);
    drag(&mut window, at, at + Vec2::new(-20.0, 8.0));
    let moved = regions(&window)[0];
    assert!(moved.value[0] < begun.value[0] && moved.gradient[0] < begun.gradient[0]);
    assert!((moved.value[1] - moved.value[0] - (begun.value[1] - begun.value[0])).abs() < 1e-6);
    // A new one, in the corner that is empty.
    let corner = plot.left_bottom();
    drag(
        &mut window,
        corner + Vec2::new(1.0, -2.0),
        corner + Vec2::new(30.0, -12.0),
    );
    assert_eq!(regions(&window).len(), 2, "{:?}", regions(&window));
    window.get_by_label("Gradient from");
    click(&mut window, "Remove region 2");
    assert_eq!(regions(&window), [moved]);
    wait(&mut window, "the regions", |model| model.is_final());
    assert!(model(&window).message().is_none());
    click(&mut window, "values");
    wait(&mut window, "the values", |model| {
        model.document().effects.regions.is_none() && model.is_final()
    });
    assert_eq!(model(&window).document().items[0], start);
}

#[test]
fn labels_are_hidden_coloured_and_shown_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("labels.nrrd");
    let mut bytes = b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 12 12 12\nencoding: raw\n\n".to_vec();
    // Halves of a block, in nothing.
    bytes.extend((0..12 * 12 * 12).map(|index| {
        let [x, y, z] = [index % 12, index / 12 % 12, index / 144];
        let inside = [x, y, z].iter().all(|at| (2..10).contains(at));
        u8::from(inside) * if x < 6 { 3 } else { 7 }
    }));
    std::fs::write(&path, bytes).unwrap();
    let mut window = window(&[path.to_str().unwrap()]);
    assert_eq!(model(&window).document().items[0].labels, Some(true));
    window.get_by_label("3 labels");
    window.check_accessibility();
    let opacities = |window: &Window<'_>| {
        let function = model(window).document().items[0]
            .transfer_function
            .clone()
            .unwrap();
        [0.0, 3.0, 7.0].map(|value| function.opacity(value))
    };
    let [nothing, three, seven] = opacities(&window);
    assert!(nothing == 0.0 && three > 0.0 && seven > 0.0);
    click(&mut window, "Only label 7");
    assert_eq!(opacities(&window), [0.0, 0.0, seven]);
    click(&mut window, "Show label 3");
    assert_eq!(opacities(&window), [0.0, three, seven]);
    window.get_by_label("Colour of label 3");
    wait(&mut window, "the labels", |model| model.is_final());
    for _ in 0..2 {
        window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        window.step();
        window.step();
    }
    assert_eq!(opacities(&window), [nothing, three, seven]);
    assert!(!model(&window).session().can_undo());
}

#[test]
fn channels_are_chosen_or_shown_together() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cells.zarr");
    std::fs::create_dir_all(path.join("0")).unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(path.join(name), bytes).unwrap();
    write(".zgroup", br#"{"zarr_format": 2}"#);
    let axes = ["c", "z", "y", "x"].map(|name| {
        let kind = if name == "c" { "channel" } else { "space" };
        format!(r#"{{"name": "{name}", "type": "{kind}"}}"#)
    });
    let scale = r#"[{"type": "scale", "scale": [1, 1, 1, 1]}]"#;
    let levels = format!(r#"[{{"path": "0", "coordinateTransformations": {scale}}}]"#);
    let axes = axes.join(", ");
    let image = format!(r#"{{"version": "0.4", "axes": [{axes}], "datasets": {levels}}}"#);
    write(".zattrs", format!(r#"{{"multiscales": [{image}]}}"#).as_bytes());
    let of = r#""dtype": "|u1", "fill_value": 0, "order": "C", "compressor": null, "filters": null"#;
    let sizes = r#""shape": [2, 8, 8, 8], "chunks": [2, 8, 8, 8]"#;
    write(
        "0/.zarray",
        format!(r#"{{"zarr_format": 2, {sizes}, {of}}}"#).as_bytes(),
    );
    let samples: Vec<u8> = (0..1024u32).map(|index| (index * 37 % 251) as u8).collect();
    write("0/0.0.0.0", &samples);
    let mut window = window(&[path.to_str().unwrap()]);
    let first = model(&window).document().items[0].clone();
    let count = model(&window).facts(&first).unwrap().choices.channels.len();
    assert_eq!(count, 2, "{:?}", model(&window).facts(&first));
    window.check_accessibility();
    click(&mut window, "All channels together");
    wait(&mut window, "both channels", |model| {
        model.document().items.len() == 2 && model.is_final()
    });
    let maps: Vec<_> = model(&window)
        .document()
        .items
        .iter()
        .map(|item| item.cmap.clone())
        .collect();
    assert_eq!(maps, [Some("green".to_owned()), Some("magenta".to_owned())]);
    window.get_all_by_label("cells.zarr, channel 2").next().unwrap();
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    wait(&mut window, "one channel", |model| {
        model.document().items[..] == [first.clone()] && model.is_final()
    });
}

#[test]
fn flying_moves_the_eye_by_keys_that_do_something_else_otherwise() {
    let mut window = window(&["sample:head:16"]);
    let eye = |window: &Window<'_>| model(window).session().camera().unwrap();
    let start = eye(&window);
    press(&mut window, Key::G);
    window.get_by_label_contains("Flying");
    window.key_down(Key::W);
    for _ in 0..6 {
        window.step();
    }
    window.key_up(Key::W);
    window.step();
    let flown = eye(&window);
    let way = flown.position() - start.position();
    let forward = (start.target() - start.position()).normalize();
    assert!(
        way.length() > 0.0 && way.normalize().dot(forward) > 0.999,
        "{way}"
    );
    window.step();
    assert_eq!(eye(&window).position(), flown.position(), "it goes on");
    // S moves back, and shows no slices.
    press(&mut window, Key::S);
    assert!(window.query_by_label_contains("Axial").is_none());
    drag(&mut window, Pos2::new(550.0, 400.0), Pos2::new(650.0, 400.0));
    let turned = eye(&window);
    assert_ne!(turned.target(), flown.target());
    press(&mut window, Key::Escape);
    assert!(window.query_by_label_contains("Flying").is_none());
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    window.step();
    assert_ne!(
        eye(&window).target(),
        turned.target(),
        "a drag is no step of its own"
    );
    while model(&window).session().can_undo() {
        window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        window.step();
    }
    assert_eq!(eye(&window).position(), start.position());
}

#[test]
fn places_are_measured_and_the_colour_bar_comes_and_goes() {
    let mut window = window(&["sample:head:16"]);
    window.get_by_label_contains("Colour bar from");
    press(&mut window, Key::L);
    assert!(window.query_by_label_contains("Colour bar from").is_none());
    let measured = |window: &Window<'_>| window.state().as_ref().unwrap().measure.clone();
    for (count, at) in [(1, 540.0), (2, 560.0), (3, 580.0), (1, 550.0)] {
        window.hover_at(Pos2::new(at, 430.0));
        window.step();
        press(&mut window, Key::M);
        assert_eq!(measured(&window).count(), count, "{:?}", model(&window).message());
    }
    press(&mut window, Key::Escape);
    assert_eq!(measured(&window).count(), 0);
    // Beside the head there is nothing to measure.
    window.hover_at(Pos2::new(270.0, 60.0));
    window.step();
    press(&mut window, Key::M);
    assert_eq!(measured(&window).count(), 0);
}
