//! Picture: what the tiles of a frame show, of all modes, and the work of one tile.

use std::sync::atomic::AtomicBool;

use fearless_simd::prelude::*;

use super::analytic::Analytic;
use super::canvas::Canvas;
use super::cloud::mode::CloudMode;
use super::cloud::values::MeshValues;
use super::compose::Compose;
use super::exact_intensity::ExactIntensity;
use super::extremum::{Largest, Smallest};
use super::integral::Integral;
use super::intensity::{Extreme, Intensity, Mean};
use super::layers::Layers;
use super::shaded::Shaded;
use super::tile::{SheetScratch, SheetWork};
use super::tiles::{Both, Single, Tiles};

/// What tiles show.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Picture<'a> {
    /// A volume, post-classified.
    Shaded(Single<'a, Shaded<'a>, 1>),
    /// Two levels of it.
    ShadedLevels(Both<'a, Shaded<'a>, 1>),
    /// A volume, pre-classified.
    Composed(Single<'a, Compose<'a>, 4>),
    /// Two levels of it.
    ComposedLevels(Both<'a, Compose<'a>, 4>),
    /// A volume, post-classified with analytic gradients.
    Analytic(Single<'a, Analytic<'a>, 4>),
    /// The X-ray of a volume.
    Integral(Single<'a, Integral<'a>, 1>),
    /// The largest value of each ray.
    Largest(Values<'a, Extreme<Largest>>),
    /// The smallest.
    Smallest(Values<'a, Extreme<Smallest>>),
    /// The mean.
    Mean(Values<'a, Mean>),
    /// Several things.
    Layers(&'a Layers<'a>),
}

/// One value of each ray.
#[derive(Debug)]
pub(crate) enum Values<'a, K> {
    /// Of a volume, from values on planes.
    OnPlanes(Single<'a, Intensity<'a, K>, 1>),
    /// Of a volume, from values and slopes on planes.
    WithSlopes(Single<'a, ExactIntensity<'a, K>, 2>),
    /// Of a mesh.
    OfMesh(Single<'a, CloudMode<'a, MeshValues<'a, K>>, 2>),
}

impl<K> Clone for Values<'_, K> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<K> Copy for Values<'_, K> {}

/// Evaluates an expression with the tiles of any picture.
macro_rules! with_tiles {
    ($picture:expr, $tiles:ident => $result:expr) => {
        match $picture {
            Picture::Shaded($tiles) => $result,
            Picture::ShadedLevels($tiles) => $result,
            Picture::Composed($tiles) => $result,
            Picture::ComposedLevels($tiles) => $result,
            Picture::Analytic($tiles) => $result,
            Picture::Integral($tiles) => $result,
            Picture::Largest(values) => with_values!(values, $tiles => $result),
            Picture::Smallest(values) => with_values!(values, $tiles => $result),
            Picture::Mean(values) => with_values!(values, $tiles => $result),
            Picture::Layers(layers) => {
                let $tiles = *layers;
                $result
            }
        }
    };
}

macro_rules! with_values {
    ($values:expr, $tiles:ident => $result:expr) => {
        match $values {
            Values::OnPlanes($tiles) => $result,
            Values::WithSlopes($tiles) => $result,
            Values::OfMesh($tiles) => $result,
        }
    };
}

impl Picture<'_> {
    /// Its frame and counts.
    pub(crate) fn tiles(&self) -> &dyn Tiles {
        with_tiles!(self, tiles => tiles)
    }
}

/// A tile to render.
#[derive(Debug)]
pub(crate) struct TileWork<'a> {
    pub picture: &'a Picture<'a>,
    pub tile: usize,
    /// Set when the picture is cancelled.
    pub stop: &'a AtomicBool,
    pub canvas: &'a mut Canvas,
    pub scratch: &'a mut Vec<SheetScratch>,
    /// Counts of what was done.
    pub done: &'a mut SheetWork,
}

impl TileWork<'_> {
    /// Renders the tile.
    #[inline(always)]
    pub(crate) fn run<S: Simd>(self, simd: S) {
        let Self {
            picture,
            tile,
            stop,
            canvas,
            scratch,
            done,
        } = self;
        *done = with_tiles!(picture, tiles => tiles.render(simd, (tile, stop), canvas, scratch));
    }
}
