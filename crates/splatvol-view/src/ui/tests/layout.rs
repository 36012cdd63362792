//! The picture's share of small windows and of windows with large text, and what fits into them.

use eframe::egui::Rect;

use super::*;

/// The smallest window, with text of a size, and the head in it.
fn smallest(zoom: f32) -> Window<'static> {
    let mut window = window(&["sample:head:16"]);
    window.set_size(Vec2::new(640.0, 420.0) / zoom);
    wait(&mut window, "a small picture", |model| model.is_final());
    window
}

fn whole(window: &Window<'_>) -> Rect {
    window.ctx.content_rect()
}

fn picture(window: &Window<'_>) -> Rect {
    window.state().as_ref().unwrap().picture.rect().unwrap()
}

#[test]
fn the_picture_has_half_of_every_window() {
    for zoom in [1.0, 1.5, 2.0] {
        let mut window = smallest(zoom);
        let [own, all] = [picture(&window), whole(&window)].map(|rect| rect.width());
        // The tests' window has a margin.
        assert!(own >= 0.5 * (all - 16.0) - 1.0, "{own} of {all} points");
        // All that the panels hold is there, in one.
        window.get_by_label("Scene");
        window.get_by_label("Kind of picture");
        press(&mut window, Key::F9);
        assert!(window.query_by_label("Kind of picture").is_none());
    }
}

#[test]
fn panels_are_as_wide_whatever_is_open_in_them() {
    let mut window = window(&["sample:head:16"]);
    let before = picture(&window);
    for section in ["Place", "Animation", "Light", "Picture", "Clip", "Points"] {
        click(&mut window, section);
        assert_eq!(picture(&window), before, "{section}");
    }
}

#[test]
fn the_first_picture_has_the_size_that_panels_leave() {
    let start = start(&["sample:head:16"]);
    let mut window = Harness::builder()
        .with_size(Vec2::new(1100.0, 900.0))
        .build_ui_state(
            move |ui, viewer: &mut Option<Viewer>| {
                let viewer = viewer.get_or_insert_with(|| Viewer::new(ui.ctx(), start.clone()).unwrap());
                viewer.show(ui);
            },
            None,
        );
    wait(&mut window, "the first picture", |model| {
        if let Some(shown) = model.shown() {
            assert!(shown.view_size.width() < 700, "{:?}", shown.view_size);
        }
        model.is_final()
    });
}

#[test]
fn dialogs_and_menus_fit_into_the_smallest_window_with_large_text() {
    for zoom in [1.0, 2.0] {
        let mut window = smallest(zoom);
        let all = whole(&window);
        press(&mut window, Key::F1);
        window.step();
        for close in window.get_all_by_label("Close") {
            assert!(all.contains_rect(close.rect()), "{:?} in {all:?}", close.rect());
        }
        press(&mut window, Key::Escape);
        window.key_press_modifiers(Modifiers::COMMAND, Key::P);
        (0..4).for_each(|_| window.step());
        window.get_by_label("Cancel").scroll_to_me();
        (0..60).for_each(|_| window.step());
        let cancel = window.get_by_label("Cancel").rect();
        assert!(all.contains_rect(cancel), "{cancel:?} in {all:?}");
        press(&mut window, Key::Escape);
        click(&mut window, "View");
        (0..4).for_each(|_| window.step());
        window.get_by_label("Text size").scroll_to_me();
        (0..60).for_each(|_| window.step());
        let last = window.get_by_label("Text size").rect();
        assert!(all.contains_rect(last), "{last:?} in {all:?}");
    }
}

#[test]
fn messages_leave_the_picture_its_size_and_go_unless_they_are_errors() {
    let mut window = window(&["sample:head:16"]);
    let before = picture(&window);
    let say = |window: &mut Window<'_>, is_error: bool| {
        let model = &mut window.state_mut().as_mut().unwrap().model;
        model.say("something that is long ".repeat(30), is_error);
        window.step();
        window.step();
        window.get_by_label_contains("something that is long");
        assert_eq!(picture(window), before);
    };
    say(&mut window, false);
    // A step is a quarter of a second.
    (0..8).for_each(|_| window.step());
    assert!(model(&window).message().is_some());
    (0..400).for_each(|_| window.step());
    assert!(model(&window).message().is_none());
    say(&mut window, true);
    (0..400).for_each(|_| window.step());
    assert!(model(&window).message().is_some());
    click(&mut window, "Dismiss");
    assert!(model(&window).message().is_none());
}
