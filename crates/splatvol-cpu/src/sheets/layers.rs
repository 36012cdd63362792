//! Layers: the parts of a scene that are rendered together, each by its own mode, on planes that all of them share.
//!
//! A volume is a layer of its own, whatever its classification; what is classified already shares one, the cloud. A layer has
//! its own raster, kernel, filter and table; common are the planes, the tiles and what pixels have in the end.

use std::sync::atomic::AtomicBool;

use fearless_simd::prelude::*;

use super::analytic::Analytic;
use super::canvas::Canvas;
use super::cloud::emission::CloudEmission;
use super::compose::Compose;
use super::engine::Tiles;
use super::layer::{ModeLayer, TileLayer, render};
use super::shaded::Shaded;
use super::tile::{SheetFrame, SheetScratch, SheetWork};

/// A part of a scene, and its frame.
#[derive(Debug)]
pub(crate) enum Layer<'a> {
    /// A volume, post-classified.
    Shaded(SheetFrame<'a>, Shaded<'a>),
    /// A volume, post-classified with analytic gradients.
    Analytic(SheetFrame<'a>, Analytic<'a>),
    /// A volume, pre-classified.
    Compose(SheetFrame<'a>, Compose<'a>),
    /// A cloud of classified splats.
    Cloud(SheetFrame<'a>, CloudEmission<'a>),
}

impl Layer<'_> {
    fn frame(&self) -> &SheetFrame<'_> {
        match self {
            Self::Shaded(frame, _)
            | Self::Analytic(frame, _)
            | Self::Compose(frame, _)
            | Self::Cloud(frame, _) => frame,
        }
    }

    /// The layer at the beginning of a tile.
    fn begin<'t, S: Simd>(
        &'t self,
        tile: usize,
        scratch: &'t mut SheetScratch,
    ) -> Box<dyn TileLayer<S> + 't> {
        match self {
            Self::Shaded(frame, mode) => Box::new(ModeLayer::new((frame, mode), tile, scratch)),
            Self::Analytic(frame, mode) => Box::new(ModeLayer::new((frame, mode), tile, scratch)),
            Self::Compose(frame, mode) => Box::new(ModeLayer::new((frame, mode), tile, scratch)),
            Self::Cloud(frame, mode) => Box::new(ModeLayer::new((frame, mode), tile, scratch)),
        }
    }
}

/// Layers of one scene; at least one.
#[derive(Debug)]
pub(crate) struct Layers<'a>(pub Vec<Layer<'a>>);

impl Tiles for Layers<'_> {
    fn frame(&self) -> &SheetFrame<'_> {
        self.0[0].frame()
    }

    fn bricks(&self) -> usize {
        self.0.iter().map(|layer| layer.frame().bricks.len()).sum()
    }

    fn render<S: Simd>(
        &self,
        simd: S,
        (tile, stop): (usize, &AtomicBool),
        canvas: &mut Canvas,
        scratch: &mut Vec<SheetScratch>,
    ) -> SheetWork {
        if scratch.len() < self.0.len() {
            scratch.resize_with(self.0.len(), SheetScratch::default);
        }
        let mut layers: Vec<_> = self
            .0
            .iter()
            .zip(scratch)
            .map(|(layer, scratch)| layer.begin::<S>(tile, scratch))
            .collect();
        let mut layers: Vec<&mut dyn TileLayer<S>> =
            layers.iter_mut().map(|layer| &mut **layer as _).collect();
        render(simd, (self.frame().termination, stop), &mut layers, canvas)
    }
}
