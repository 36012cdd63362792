//! What was wrong once: dialogs, menus, errors, and what is offered.

use eframe::egui::Role;

use super::*;

#[test]
fn what_was_typed_stays_until_the_picture_is_saved() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    std::fs::write(&path, "mine").unwrap();
    let mut window = window(&["sample:head:16"]);
    window.key_press_modifiers(Modifiers::COMMAND, Key::P);
    (0..3).for_each(|_| window.step());
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.step();
    let typed = path.to_str().unwrap();
    window.get_by_role(Role::TextInput).type_text(typed);
    window.step();
    click(&mut window, "Save");
    window.get_by_label_contains("already exists");
    let field = window.get_by_role(Role::TextInput);
    assert_eq!(field.value().as_deref(), Some(typed));
    assert!(model(&window).message().is_none(), "it is said twice");
    click(&mut window, "Replace an existing file");
    click(&mut window, "Save");
    assert!(window.query_by_label("Save").is_none());
    wait(&mut window, "the file", |model| model.writing().is_none());
    assert!(std::fs::read(&path).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn what_was_typed_stays_until_the_file_is_open() {
    let mut window = window(&["sample:head:16"]);
    window.key_press_modifiers(Modifiers::COMMAND, Key::O);
    (0..3).for_each(|_| window.step());
    window.get_by_role(Role::TextInput).type_text("sample:hea");
    window.step();
    click(&mut window, "Open");
    wait(&mut window, "an answer", |model| model.asked_since().is_none());
    (0..2).for_each(|_| window.step());
    window.get_by_label_contains("Error: ");
    let field = window.get_by_role(Role::TextInput);
    assert_eq!(field.value().as_deref(), Some("sample:hea"));
    assert!(model(&window).message().is_none(), "it is said twice");
    window.get_by_role(Role::TextInput).type_text("d:8");
    window.step();
    click(&mut window, "Open");
    wait(&mut window, "the other head", |model| {
        model.document().items[0].file == "sample:head:8"
    });
    (0..2).for_each(|_| window.step());
    assert!(window.query_by_label("Cancel").is_none());
}

#[test]
fn escape_closes_menus_and_keys_do_nothing_behind_them() {
    let mut window = window(&["sample:head:16"]);
    let camera = |window: &Window<'_>| model(window).session().camera().unwrap();
    let before = camera(&window);
    click(&mut window, "View");
    window.get_by_label_contains("Perspective or parallel");
    for key in [Key::ArrowLeft, Key::Num5, Key::Plus] {
        press(&mut window, key);
    }
    assert_eq!(camera(&window), before);
    press(&mut window, Key::Escape);
    assert!(
        window
            .query_by_label_contains("Perspective or parallel")
            .is_none()
    );
    click(&mut window, "Kind of picture");
    window.get_by_label("X-ray");
    press(&mut window, Key::Escape);
    assert!(window.query_by_label("X-ray").is_none());
}

#[test]
fn values_are_shown_where_the_pointer_is() {
    let mut window = window(&["sample:head:16"]);
    let hovered = |window: &Window<'_>| window.state().as_ref().unwrap().picture.hovered.is_some();
    window.hover_at(Pos2::new(550.0, 430.0));
    window.step();
    assert!(hovered(&window));
    window.hover_at(Pos2::new(60.0, 430.0));
    window.step();
    window.step();
    assert!(!hovered(&window));
}

#[test]
fn the_button_that_adds_views_stays_where_it_is() {
    let mut window = window(&["sample:head:16"]);
    click(&mut window, "Animation");
    (0..60).for_each(|_| window.step());
    let at = |window: &Window<'_>| window.get_by_label("Add this view").rect();
    let before = at(&window);
    click(&mut window, "Add this view");
    assert_eq!(at(&window), before);
}

#[test]
fn labels_have_no_surface_of_a_value() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("labels.nrrd");
    let mut bytes = b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 12 12 12\nencoding: raw\n\n".to_vec();
    bytes.extend((0..12 * 12 * 12).map(|index| if index % 12 < 6 { 3u8 } else { 7 }));
    std::fs::write(&path, bytes).unwrap();
    let labels = window(&[path.to_str().unwrap()]);
    assert_eq!(model(&labels).document().items[0].labels, Some(true));
    assert!(labels.query_by_label("Surface of").is_none());
    labels.get_by_label("Automatic");
    window(&["sample:head:16"]).get_by_label("Surface of");
}

/// The samples fit into the memory, and the picture does not.
#[test]
fn the_error_of_a_picture_stands_where_it_should_be() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("head.ome.zarr").to_string_lossy().into_owned();
    let words = ["splatvol", "convert", "sample:head:64", &path, "--chunk", "16"];
    assert_eq!(splatvol_cli::run(words.map(std::ffi::OsString::from)), 0);
    let start = Start {
        rules: splatvol_document::ReadRules {
            chunks: Some(splatvol_document::ChunkRules {
                memory: 4 << 20,
                holes: false,
                whole_if_it_fits: false,
            }),
            ..Default::default()
        },
        threads: Some(2),
        ..start(&[&path])
    };
    let mut window = Harness::builder()
        .with_size(Vec2::new(1100.0, 900.0))
        .build_ui_state(
            move |ui, viewer: &mut Option<Viewer>| {
                let viewer = viewer.get_or_insert_with(|| Viewer::new(ui.ctx(), start.clone()).unwrap());
                viewer.show(ui);
            },
            None,
        );
    wait(&mut window, "an error", |model| model.message().is_some());
    assert!(
        !model(&window).session().items().is_empty(),
        "{:?}",
        model(&window).message()
    );
    window.get_by_label_contains("Picture: none");
    assert!(model(&window).message().unwrap().text.contains("--memory"));
}
