//! Work: what threads do with vectors of splats, of all sources and blends.

use std::ops::Range;
use std::sync::atomic::AtomicU32;

use fearless_simd::prelude::*;
use splatvol_scene::Gaussians;

use super::blend::{Blend, Integral, Light, Published};
use super::composite::{Place, Scratch, composite};
use super::kernels::LitKernels;
use super::project::{ProjectedSplat, Target, project};
use super::resolve::{TileRows, resolve};
use super::view::CloudView;

/// A blend.
#[derive(Debug, Clone, Copy)]
pub(crate) enum AnyBlend {
    Published(Published),
    Light(Light),
    Integral(Integral),
}

/// Evaluates an expression with any blend.
macro_rules! with_blend {
    ($any:expr, $blend:ident => $result:expr) => {
        match $any {
            AnyBlend::Published($blend) => $result,
            AnyBlend::Light($blend) => $result,
            AnyBlend::Integral($blend) => $result,
        }
    };
}

impl AnyBlend {
    /// The pixel of an empty tile.
    pub(crate) fn empty(self) -> [f32; 4] {
        with_blend!(self, blend => blend.empty())
    }
}

/// A cloud before a camera.
pub(crate) struct SeenCloud<'a> {
    pub view: CloudView,
    pub content: Content<'a>,
}

/// What a cloud holds.
pub(crate) enum Content<'a> {
    /// 3-D Gaussians.
    Gaussians(&'a Gaussians),
    /// Kernels that are classified and lit.
    Kernels(LitKernels<'a>),
}

/// Splats of a range of a cloud.
pub(crate) struct Projection<'a, 't> {
    pub blend: AnyBlend,
    pub cloud: &'a SeenCloud<'a>,
    pub range: Range<usize>,
    pub target: &'a mut Target<'t>,
    /// Number of splats that are visible on wanted tiles.
    pub visible: &'a mut usize,
}

/// Pixels of a tile.
pub(crate) struct Composition<'a, 't> {
    pub blend: AnyBlend,
    pub splats: &'a [ProjectedSplat],
    /// Indices of the tile's splats, the nearest first.
    pub entries: &'a [AtomicU32],
    pub place: Place<'a>,
    pub scratch: &'a mut Scratch,
    pub rows: &'a mut TileRows<'t>,
}

/// Work on splats.
pub(crate) enum SplatWork<'a, 't> {
    Project(Projection<'a, 't>),
    Composite(Composition<'a, 't>),
}

impl SplatWork<'_, '_> {
    /// Does the work.
    #[inline(always)]
    pub(crate) fn run<S: Simd>(self, simd: S) {
        match self {
            Self::Project(work) => with_blend!(work.blend, blend => work.run(simd, blend)),
            Self::Composite(work) => with_blend!(work.blend, blend => work.run(simd, blend)),
        }
    }
}

impl Projection<'_, '_> {
    fn run<S: Simd>(self, simd: S, blend: impl Blend) {
        let Self {
            cloud: SeenCloud { view, content },
            range,
            target,
            visible,
            ..
        } = self;
        *visible = simd.vectorize(
            #[inline(always)]
            || match content {
                Content::Gaussians(gaussians) => project(simd, blend, (view, *gaussians), range, target),
                Content::Kernels(kernels) => project(simd, blend, (view, kernels), range, target),
            },
        );
    }
}

impl Composition<'_, '_> {
    fn run<S: Simd>(self, simd: S, blend: impl Blend) {
        let Self {
            splats,
            entries,
            place,
            scratch,
            rows,
            ..
        } = self;
        simd.vectorize(
            #[inline(always)]
            || {
                composite(simd, blend, splats, entries, place, scratch);
                resolve(simd, blend, &scratch.blocks, rows);
            },
        );
    }
}
