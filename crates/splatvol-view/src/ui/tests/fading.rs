//! Opacity by gradient, by hand.

use super::*;

#[test]
fn flat_regions_fade_by_a_curve_that_is_dragged_and_removed() {
    let mut window = window(&["sample:head:16"]);
    let start = model(&window).document().clone();
    let points = |window: &Window<'_>| model(window).document().effects.gradient_opacity.clone();
    click(&mut window, "Opacity by gradient");
    click(&mut window, "Fade by gradient");
    wait(&mut window, "the first curve", |model| {
        model.document().effects.gradient_opacity.is_some() && model.is_final()
    });
    let begun = points(&window).unwrap();
    assert_eq!((begun.len(), begun[0].factor, begun[1].factor), (2, 0.0, 1.0));
    assert!(model(&window).message().is_none());
    window.check_accessibility();
    let label = "Factor curve of 2 gradient points; the list of gradient points has the same by keyboard";
    let plot = window.get_by_label(label);
    plot.scroll_to_me();
    // The list opens, and scrolls, little by little.
    (0..60).for_each(|_| window.step());
    let rect = window.get_by_label(label).rect();
    // In the middle, where no point is: a new one, which follows the pointer.
    let at = Pos2::new(rect.left() + 0.6 * rect.width(), rect.top() + 0.4 * rect.height());
    drag(&mut window, at, at + Vec2::new(20.0, 25.0));
    let more = points(&window).unwrap();
    assert_eq!(more.len(), 3, "{more:?}");
    assert!(
        more[2].gradient > begun[1].gradient && (0.1..0.9).contains(&more[2].factor),
        "{more:?} {rect:?}"
    );
    window.get_by_label("Factor of point 3");
    click(&mut window, "Remove gradient point 3");
    assert_eq!(points(&window).unwrap(), begun);
    wait(&mut window, "the curve", |model| model.is_final());
    // It is in the document, and leaves nothing behind.
    click(&mut window, "Fade by gradient");
    wait(&mut window, "the values", |model| {
        model.document().effects.gradient_opacity.is_none() && model.is_final()
    });
    assert_eq!(*model(&window).document(), start);
}
