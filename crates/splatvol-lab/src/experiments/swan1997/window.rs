//! Parts of a picture: beyond the distance k and before it, and the black line between them.

use std::ops::Range;

use splatvol::{Frame, Image};

use crate::LabError;
use crate::measure::luminance;

/// Columns and rows of a picture.
#[derive(Debug, Clone)]
pub(super) struct Window {
    pub(super) columns: Range<usize>,
    pub(super) rows: Range<usize>,
}

impl Window {
    /// The whole picture.
    pub(super) fn whole(image: &Image) -> Self {
        let [width, height] = <[u32; 2]>::from(image.size());
        Self {
            columns: 0..width as usize,
            rows: 0..height as usize,
        }
    }

    /// The longest run of rows whose middle half is opaque and lies at depths that a test accepts.
    ///
    /// # Errors
    /// Fewer than eight such rows.
    pub(super) fn at_depths(frame: &Frame, takes: impl Fn(f64) -> bool) -> Result<Self, LabError> {
        let [width, height] = <[u32; 2]>::from(frame.image.size()).map(|side| side as usize);
        let columns = width / 4..width * 3 / 4;
        let fits = |row: usize| {
            columns.clone().all(|column| {
                frame.image.pixel(column, row)[3] > 0.5 && takes(f64::from(frame.depth[row * width + column]))
            })
        };
        let mut best = 0..0;
        let mut start = 0;
        for row in 0..=height {
            if row == height || !fits(row) {
                if row - start > best.len() {
                    best = start..row;
                }
                start = row + 1;
            }
        }
        if best.len() < 8 {
            return Err(LabError::Measurement(format!(
                "only {} rows of the picture lie where they are to be measured",
                best.len()
            )));
        }
        Ok(Self { columns, rows: best })
    }

    /// This window without its outermost pixels.
    pub(super) fn inside(&self, margin: usize) -> Self {
        let narrow = |range: &Range<usize>| range.start + margin..range.end.saturating_sub(margin);
        Self {
            columns: narrow(&self.columns),
            rows: narrow(&self.rows),
        }
    }

    /// Luminances of a picture within this window.
    pub(super) fn luminance(&self, image: &Image) -> Vec<f64> {
        let light = luminance(image);
        let width = image.size().width() as usize;
        self.rows
            .clone()
            .flat_map(|row| light[row * width..][self.columns.clone()].to_vec())
            .collect()
    }

    /// Mean opacity of a picture within this window.
    pub(super) fn opacity(&self, image: &Image) -> f64 {
        let pixels = self
            .rows
            .clone()
            .flat_map(|row| self.columns.clone().map(move |column| (column, row)));
        let sum: f64 = pixels
            .map(|(column, row)| f64::from(image.pixel(column, row)[3]))
            .sum();
        sum / (self.rows.len() * self.columns.len()).max(1) as f64
    }
}

/// The picture over white with a black line where it passes a depth from below, as in Fig. 7 (a) and (c).
pub(super) fn with_line_at(frame: &Frame, depth: f64) -> Image {
    let mut image = over_white(&frame.image);
    let [width, height] = <[u32; 2]>::from(frame.image.size()).map(|side| side as usize);
    for at in 0..width * (height - 1) {
        let below = at + width;
        let opaque = frame.image.pixels[at][3] > 0.5 && frame.image.pixels[below][3] > 0.5;
        if opaque && f64::from(frame.depth[at]) >= depth && f64::from(frame.depth[below]) < depth {
            image.pixels[at] = [0.0, 0.0, 0.0, 1.0];
        }
    }
    image
}

/// The picture over white paper.
pub(super) fn over_white(image: &Image) -> Image {
    image.over([1.0; 4])
}
