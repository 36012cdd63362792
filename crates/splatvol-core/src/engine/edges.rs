//! Coverage: edges are rendered with several samples per pixel.
//!
//! A frame is first rendered with one sample per pixel. Pixels that differ from a neighbour are edges. Then the
//! tiles with edges, and no others, are rendered in a picture several times as large. An edge becomes the mean of
//! its samples there:
//!
//! ```text
//! C = 1/n^2 sum_i C_i,   T = 1/n^2 sum_i exp(-tau_i)
//! ```
//!
//! Footprints are filtered for the pixels of the larger picture, so the low-pass of an edge is the square pixel
//! plus a small part of the filter itself.

use splatvol_scene::{Coverage, Frame, ImageSize, RenderSettings, SceneError};

use super::Task;
use crate::bin::TileRect;

/// The edges of a picture.
#[derive(Debug)]
pub struct Edges {
    /// The first pixel, in the picture.
    first: [usize; 2],
    size: [usize; 2],
    /// Samples per pixel and axis.
    samples: usize,
    /// Row by row.
    edge: Vec<bool>,
    count: usize,
}

impl Edges {
    /// The pixels of a frame that differ from a neighbour; `None` where none does, or without supersampling of
    /// edges. `first` is the frame's first pixel in the picture.
    pub fn of(frame: &Frame, first: [usize; 2], coverage: Coverage) -> Option<Self> {
        let Coverage::Adaptive { samples, contrast } = coverage else {
            return None;
        };
        let size = <[u32; 2]>::from(frame.image.size()).map(|side| side as usize);
        let mut edges = Self {
            first,
            size,
            samples: samples as usize,
            edge: vec![false; size[0] * size[1]],
            count: 0,
        };
        for y in 0..size[1] {
            for x in 0..size[0] {
                let differs = edges.differs(frame, [x, y], contrast as f32);
                edges.edge[y * size[0] + x] = differs;
                edges.count += usize::from(differs);
            }
        }
        (edges.count > 0).then_some(edges)
    }

    fn differs(&self, frame: &Frame, [x, y]: [usize; 2], contrast: f32) -> bool {
        let [width, height] = self.size;
        let pixels = &frame.image.pixels;
        let here = pixels[y * width + x];
        (y.saturating_sub(1)..(y + 2).min(height)).any(|row| {
            pixels[row * width + x.saturating_sub(1)..row * width + (x + 2).min(width)]
                .iter()
                .any(|there| (0..4).any(|c| (there[c] - here[c]).abs() > contrast))
        })
    }

    /// Number of edge pixels.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Settings of the larger picture.
    ///
    /// # Errors
    /// A picture that would be too large.
    pub fn settings(&self, settings: &RenderSettings) -> Result<RenderSettings, SceneError> {
        let samples = self.samples as u32;
        let [width, height] = <[u32; 2]>::from(settings.size).map(|side| side.saturating_mul(samples));
        let size = ImageSize::new(width, height).map_err(|_| SceneError::Combination {
            what: "coverage",
            why: "the picture times its samples per axis is too large, ask for fewer samples",
        })?;
        Ok(RenderSettings {
            size,
            coverage: Coverage::Off,
            ..*settings
        })
    }

    /// Task for the larger picture: the same part, share and window, without the tiles that have no edges.
    pub fn task<'a>(&'a self, task: Task<'a>) -> Task<'a> {
        let larger = |TileRect { x0, y0, x1, y1 }| TileRect {
            x0: x0 * self.samples,
            y0: y0 * self.samples,
            x1: x1.saturating_mul(self.samples),
            y1: y1.saturating_mul(self.samples),
        };
        Task {
            part: task.part.map(larger),
            window: task.window.map(larger),
            share: task.share.map(|share| share.enlarged(self.samples)),
            edges: Some(self),
            ..task
        }
    }

    /// Whether a rectangle of the larger picture has samples of an edge.
    pub fn meets(&self, rect: &TileRect) -> bool {
        let own = |from: usize, to: usize, axis: usize| {
            let place = |at: usize| at.saturating_sub(self.first[axis]).min(self.size[axis]);
            place(from / self.samples)..place(to.div_ceil(self.samples))
        };
        let (columns, width) = (own(rect.x0, rect.x1, 0), self.size[0]);
        own(rect.y0, rect.y1, 1)
            .any(|y| self.edge[y * width + columns.start..y * width + columns.end].contains(&true))
    }

    /// Replaces the edges of a frame by the means of their samples.
    pub fn refine(&self, frame: &mut Frame, fine: &Frame) {
        let width = self.size[0];
        for (pixel, _) in self.edge.iter().enumerate().filter(|(_, edge)| **edge) {
            let corner = [pixel % width, pixel / width].map(|at| at * self.samples);
            self.mean(fine, corner).store(frame, pixel);
        }
    }

    fn mean(&self, fine: &Frame, [x0, y0]: [usize; 2]) -> Mean {
        let stride = self.size[0] * self.samples;
        let mut mean = Mean::default();
        for y in y0..y0 + self.samples {
            for at in y * stride + x0..y * stride + x0 + self.samples {
                mean.add(fine, at);
            }
        }
        mean
    }
}

/// Sums over the samples of a pixel.
#[derive(Debug, Default)]
struct Mean {
    count: f64,
    color: [f64; 4],
    transmittance: f64,
    /// Depth, weighted by alpha.
    depth: f64,
}

impl Mean {
    fn add(&mut self, fine: &Frame, at: usize) {
        let color = fine.image.pixels[at].map(f64::from);
        self.count += 1.0;
        self.color = std::array::from_fn(|c| self.color[c] + color[c]);
        self.transmittance += libm::exp(-f64::from(fine.optical_depth[at]));
        if color[3] > 0.0 {
            self.depth += color[3] * f64::from(fine.depth[at]);
        }
    }

    fn store(&self, frame: &mut Frame, pixel: usize) {
        frame.image.pixels[pixel] = self.color.map(|sum| (sum / self.count) as f32);
        frame.optical_depth[pixel] = -libm::log(self.transmittance / self.count) as f32;
        frame.depth[pixel] = if self.color[3] > 0.0 {
            (self.depth / self.color[3]) as f32
        } else {
            f32::INFINITY
        };
    }
}
