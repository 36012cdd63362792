//! Parts of a picture: several workers can render one frame, each some of its pixels.

use splatvol_core::bin::TileRect;
use splatvol_core::engine::{Control, WINDOW_STEP};
use splatvol_scene::{Coverage, Frame, MotionBlur, RenderSettings, SceneError};

/// A part and the pixels next to it.
pub(crate) fn with_neighbors(part: TileRect) -> TileRect {
    TileRect {
        x0: part.x0.saturating_sub(1),
        y0: part.y0.saturating_sub(1),
        x1: part.x1.saturating_add(1),
        y1: part.y1.saturating_add(1),
    }
}

/// The window in which engines make the pixels of a window: with the neighbours from which edges differ, and from a
/// whole step on.
///
/// # Errors
/// A window that is not within the picture.
pub(crate) fn around(window: TileRect, settings: &RenderSettings) -> Result<TileRect, SceneError> {
    let whole = TileRect::of(settings.size);
    let [width, height] = window.sides();
    if width == 0 || height == 0 || window.overlap(&whole) != window {
        let found = [window.x0, window.y0, window.x1, window.y1];
        return Err(SceneError::invalid(
            "window",
            found,
            "a rectangle within the picture",
        ));
    }
    let wide = match settings.coverage {
        Coverage::Off => window,
        Coverage::Adaptive { .. } => with_neighbors(window).overlap(&whole),
    };
    let step = |first: usize| first / WINDOW_STEP * WINDOW_STEP;
    Ok(TileRect {
        x0: step(wide.x0),
        y0: step(wide.y0),
        ..wide
    })
}

/// Refuses pictures between sheets where they are not those of one whole picture.
///
/// # Errors
/// [`Control::partial`] with a part, a window, or what is the mean of several pictures.
pub(crate) fn check_partial(control: &Control<'_>, settings: &RenderSettings) -> Result<(), SceneError> {
    let Some(partial) = control.partial else {
        return Ok(());
    };
    let reason = if control.window.is_some() || control.part.is_some() || control.share.is_some() {
        "a whole picture"
    } else if matches!(settings.motion_blur, MotionBlur::Subframes { .. }) {
        "a picture of one moment, or motion blur exact or capsule"
    } else if settings.coverage != Coverage::Off {
        "coverage off: edges are sampled again once all sheets are there"
    } else if partial.every == 0 {
        "at least 1 sheet between two pictures"
    } else {
        return Ok(());
    };
    Err(SceneError::invalid("partial", partial, reason))
}

/// Clears a frame except for a part.
pub(crate) fn keep(frame: &mut Frame, (held, part): (&TileRect, &TileRect)) {
    let width = frame.image.size().width() as usize;
    let is_outside = |i: usize| {
        let (x, y) = (held.x0 + i % width, held.y0 + i / width);
        !(part.x0..part.x1).contains(&x) || !(part.y0..part.y1).contains(&y)
    };
    for i in (0..frame.depth.len()).filter(|&i| is_outside(i)) {
        frame.image.pixels[i] = [0.0; 4];
        frame.depth[i] = f32::INFINITY;
        frame.optical_depth[i] = 0.0;
    }
}
