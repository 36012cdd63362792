//! Control of a running render: cancellation, progress, finished tiles; or a part of the picture only.

use std::fmt::{self, Debug, Formatter};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use splatvol_scene::{Frame, ImageSize, SceneError};

use super::{Edges, Share};
use crate::bin::TileRect;

/// Callback for the finished share of a picture.
pub type OnProgress<'a> = &'a (dyn Fn(f64) + Sync);
/// Callback for finished pixels: their rectangle, and their linear premultiplied colours row by row.
pub type OnTile<'a> = &'a (dyn Fn(&TileRect, &[[f32; 4]]) + Sync);

/// The picture while its sheets are composited (swan1997 section 3.1: "partial images").
#[derive(Clone, Copy)]
pub struct Partial<'a> {
    /// Sheets between two pictures: image sheets, slices of the grid, or ranges of depth of splats that are composited one by
    /// one. At least 1.
    pub every: usize,
    /// Called by the rendering thread with the number of sheets so far and all pixels' linear premultiplied colours, row by
    /// row; the last time with all sheets.
    pub picture: &'a (dyn Fn(usize, &[[f32; 4]]) + Sync),
}

impl Debug for Partial<'_> {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}", self.every)
    }
}

/// Asked between the steps of a preparation: whether it goes on.
pub type GoOn<'a> = &'a (dyn Fn() -> bool + Sync);

/// Columns and rows at whose multiples the windows begin that engines are given: no engine has to cut its tiles there.
pub const WINDOW_STEP: usize = 32;

/// Control of a picture: cancellation, progress callbacks and the wanted part.
#[derive(Clone, Copy, Default)]
pub struct Control<'a> {
    /// Cancellation flag: any thread may set it at any time, and the result is [`SceneError::Stopped`]. It is
    /// checked once per sheet of a tile, or every few thousand splats: after some milliseconds at most, once an
    /// engine has prepared the scene's data.
    pub stop: Option<&'a AtomicBool>,
    /// Called by any thread, one at a time, with shares that increase from 0 to 1 once per picture.
    pub progress: Option<OnProgress<'a>>,
    /// Called by any thread as soon as pixels are finished. Later calls replace the pixels of earlier ones (where
    /// two levels of detail are blended, edges are sampled again, or several moments of a shutter are averaged);
    /// the last ones are the picture's.
    pub tile: Option<OnTile<'a>>,
    /// The wanted pixels, `None` for all; the others stay empty. A part has the whole picture's pixels, to the bit.
    pub part: Option<TileRect>,
    /// The wanted share of the picture, `None` for all; the others stay empty, as outside a part.
    pub share: Option<Share>,
    /// The pixels that the frame holds, `None` for all: the frame has their size, and of the picture only they are
    /// made and take memory. They have the whole picture's values, to the bit.
    pub window: Option<TileRect>,
    /// Pictures after every so many sheets, `None` for none: of whole pictures at one moment, by the papers' methods.
    pub partial: Option<Partial<'a>>,
}

impl Debug for Control<'_> {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        let Self {
            stop,
            progress,
            tile,
            part,
            share,
            window,
            partial,
        } = self;
        formatter
            .debug_struct("Control")
            .field("stop", stop)
            .field("progress", &progress.is_some())
            .field("tile", &tile.is_some())
            .field("part", part)
            .field("share", share)
            .field("window", window)
            .field("partial", partial)
            .finish()
    }
}

static NEVER: AtomicBool = AtomicBool::new(false);

/// Progress that only increases, whichever thread reports it.
pub struct Progress<'a> {
    told: Option<OnProgress<'a>>,
    last: Mutex<f64>,
}

impl<'a> Progress<'a> {
    /// Progress that is passed to the caller's callback.
    pub fn new(control: &Control<'a>) -> Self {
        Self {
            told: control.progress,
            last: Mutex::new(-1.0),
        }
    }

    /// Reports a share, unless a larger one has been reported.
    pub fn report(&self, share: f64) {
        let Some(told) = self.told else { return };
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if share > *last {
            *last = share;
            told(share);
        }
    }
}

/// The rendering of a picture, or of one of several that are combined into a picture.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    /// Cancellation flag.
    pub stop: &'a AtomicBool,
    /// Callback for the finished share of this picture.
    pub progress: OnProgress<'a>,
    /// Callback for finished pixels.
    pub tile: Option<OnTile<'a>>,
    /// The wanted pixels, `None` for all.
    pub part: Option<TileRect>,
    /// The wanted share of the picture, `None` for all.
    pub share: Option<Share>,
    /// The pixels that the frame holds, `None` for all; their first column and row are multiples of [`WINDOW_STEP`].
    pub window: Option<TileRect>,
    /// Pictures after every so many sheets.
    pub partial: Option<Partial<'a>>,
    /// Tiles without any of these are left out.
    pub edges: Option<&'a Edges>,
}

impl<'a> Task<'a> {
    /// Creates a task from the caller's [`Control`].
    pub fn new(control: &Control<'a>, progress: OnProgress<'a>) -> Self {
        Self {
            stop: control.stop.unwrap_or(&NEVER),
            progress,
            tile: control.tile,
            part: control.part,
            share: control.share,
            window: control.window,
            partial: control.partial,
            edges: None,
        }
    }

    /// A task for an intermediate picture, whose pixels are not those of the final one: its tiles are not reported.
    pub fn unseen(self, progress: OnProgress<'a>) -> Self {
        Self {
            progress,
            tile: None,
            partial: None,
            ..self
        }
    }

    /// Whether the picture has been cancelled.
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Returns an error once the picture has been cancelled.
    ///
    /// # Errors
    /// [`SceneError::Stopped`].
    pub fn go_on(&self) -> Result<(), SceneError> {
        if self.is_stopped() {
            return Err(SceneError::Stopped);
        }
        Ok(())
    }

    /// Refuses pictures between sheets, for engines and methods that do not composite whole pictures sheet by sheet.
    ///
    /// # Errors
    /// `partial`, if it is asked for.
    pub fn refuse_partial(&self) -> Result<(), SceneError> {
        match self.partial {
            None => Ok(()),
            Some(partial) => Err(SceneError::invalid(
                "partial",
                partial,
                "the CPU and one volume by a method of the papers, which composites the whole picture sheet by sheet \
                 (such as --preset fastsplats2000)",
            )),
        }
    }

    /// Reports the finished share, unless the picture has been cancelled.
    pub fn report(&self, share: f64) {
        if !self.is_stopped() {
            (self.progress)(share);
        }
    }

    /// Whether pixels of a rectangle are wanted.
    pub fn wants(&self, rect: &TileRect) -> bool {
        self.part.is_none_or(|part| part.meets(rect))
            && self.window.is_none_or(|window| window.meets(rect))
            && self.share.is_none_or(|share| share.meets(rect))
            && self.edges.is_none_or(|edges| edges.meets(rect))
    }

    /// The pixels of a picture that the frame holds.
    pub fn held(&self, size: ImageSize) -> TileRect {
        self.window.unwrap_or_else(|| TileRect::of(size))
    }

    /// Reports all pixels of a frame.
    pub fn show_all(&self, frame: &Frame) {
        if let Some(tile) = self.tile {
            tile(&self.held(frame.image.size()), &frame.image.pixels);
        }
    }

    /// Reports finished pixels.
    pub fn show(&self, rect: &TileRect, colors: impl FnOnce() -> Vec<[f32; 4]>) {
        if let Some(tile) = self.tile {
            tile(rect, &colors());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_only_grows() {
        let heard = Mutex::new(Vec::new());
        let hear = |share: f64| heard.lock().unwrap().push(share);
        let control = Control {
            progress: Some(&hear),
            ..Control::default()
        };
        let progress = Progress::new(&control);
        [0.0, 0.3, 0.2, 0.3, 1.0, 1.0]
            .iter()
            .for_each(|&share| progress.report(share));
        assert_eq!(*heard.lock().unwrap(), [0.0, 0.3, 1.0]);
    }

    #[test]
    fn parts_want_the_tiles_that_they_meet() {
        let rect = |x0, y0, x1, y1| TileRect { x0, y0, x1, y1 };
        let control = Control {
            part: Some(rect(10, 10, 20, 20)),
            ..Control::default()
        };
        let task = Task::new(&control, &|_| {});
        assert!(task.wants(&rect(0, 0, 11, 11)) && task.wants(&rect(19, 19, 40, 40)));
        assert!(!task.wants(&rect(0, 0, 10, 40)) && !task.wants(&rect(12, 20, 14, 22)));
    }
}
