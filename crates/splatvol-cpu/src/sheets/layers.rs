//! Layers: parts of a scene that are rendered together on common planes, each in its own mode.
//!
//! A volume is a layer of its own, whatever its classification, and so is a post-classified mesh. All
//! pre-classified items share one layer, the cloud. Each layer has its own raster, kernel, filter and table; the
//! planes, the tiles and the final pixels are common.

use std::sync::atomic::AtomicBool;

use fearless_simd::prelude::*;

use super::analytic::Analytic;
use super::canvas::Canvas;
use super::cloud::emission::EmittedLight;
use super::cloud::field::FieldMaterial;
use super::cloud::mode::CloudMode;
use super::compose::Compose;
use super::frame::ZonedFrame;
use super::layer::{ModeLayer, TileLayer, render};
use super::mode::Mode;
use super::shaded::Shaded;
use super::tile::{SheetScratch, SheetWork};
use super::tiles::Tiles;

/// A part of a scene, and its frame.
#[derive(Debug)]
pub(crate) enum Layer<'a> {
    /// A volume, post-classified.
    Shaded(ZonedFrame<'a>, Shaded<'a>),
    /// A volume, post-classified with analytic gradients.
    Analytic(ZonedFrame<'a>, Analytic<'a>),
    /// A volume, pre-classified.
    Compose(ZonedFrame<'a>, Compose<'a>),
    /// The samples of a mesh, post-classified.
    Mesh(ZonedFrame<'a>, Box<CloudMode<'a, FieldMaterial<'a>>>),
    /// A cloud of classified splats.
    Cloud(ZonedFrame<'a>, CloudMode<'a, EmittedLight>),
}

impl Layer<'_> {
    fn frame(&self) -> &ZonedFrame<'_> {
        match self {
            Self::Shaded(frame, _)
            | Self::Analytic(frame, _)
            | Self::Compose(frame, _)
            | Self::Mesh(frame, _)
            | Self::Cloud(frame, _) => frame,
        }
    }

    /// A layer at the start of a tile; `None` where all of it is behind the camera.
    fn begin<'t, S: Simd>(
        &'t self,
        tile: usize,
        (scratch, canvas): (&'t mut SheetScratch, &mut Canvas),
    ) -> Option<Box<dyn TileLayer<S> + 't>> {
        match self {
            Self::Shaded(frame, mode) => begin((frame, mode), tile, scratch, canvas),
            Self::Analytic(frame, mode) => begin((frame, mode), tile, scratch, canvas),
            Self::Compose(frame, mode) => begin((frame, mode), tile, scratch, canvas),
            Self::Mesh(frame, mode) => begin((frame, &**mode), tile, scratch, canvas),
            Self::Cloud(frame, mode) => begin((frame, mode), tile, scratch, canvas),
        }
    }
}

fn begin<'t, S: Simd, M: Mode<N>, const N: usize>(
    picture: (&'t ZonedFrame<'t>, &'t M),
    tile: usize,
    scratch: &'t mut SheetScratch,
    canvas: &mut Canvas,
) -> Option<Box<dyn TileLayer<S> + 't>> {
    Some(Box::new(ModeLayer::new(picture, tile, scratch, canvas)?))
}

/// Layers of one scene; at least one.
#[derive(Debug)]
pub(crate) struct Layers<'a>(pub Vec<Layer<'a>>);

impl Tiles for Layers<'_> {
    fn frame(&self) -> &ZonedFrame<'_> {
        self.0[0].frame()
    }

    fn bricks(&self) -> usize {
        self.0.iter().map(|layer| layer.frame().plan.corners.len()).sum()
    }

    fn zones(&self) -> usize {
        self.0.iter().map(|layer| layer.frame().plan.zones().len()).sum()
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
            .filter_map(|(layer, scratch)| layer.begin::<S>(tile, (scratch, canvas)))
            .collect();
        let mut layers: Vec<&mut dyn TileLayer<S>> =
            layers.iter_mut().map(|layer| &mut **layer as _).collect();
        render(
            simd,
            (self.frame().plan.termination, None, stop),
            &mut layers,
            canvas,
        )
    }
}
