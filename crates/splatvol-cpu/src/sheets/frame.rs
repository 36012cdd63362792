//! A layer's frame: its plan, and view-dependent data for shading its planes.

use glam::{DAffine3, DVec3};
use splatvol_core::bin::TileLists;
use splatvol_core::field::FieldStore;
use splatvol_core::plan::{
    Bricks, DepthOrder, Evaluation, FramePlan, GridView, Rays, Room, SheetShape, SplatConstants, Zone,
    ZonePlan, mass_drawn, room_of,
};
use splatvol_core::sheets::Planes;
use splatvol_scene::{RenderSettings, SheetSettings};

use super::analytic::{AnalyticField, Sums};
use super::eye::Eye;
use super::lattice_weights::LatticeWeights;
use super::ring::BLOCK_EDGE;
use super::shade::PlaneShader;
use crate::phong::Phong;
use splatvol_core::border::Border;
use splatvol_core::shade_table::ShadeTable;

/// A frame's plan; the next frame reuses its memory.
#[derive(Debug, Default)]
pub(crate) struct GridPlan {
    pub plan: FramePlan,
    /// Eyes of the zones that begin there, for their first intervals.
    eyes: Vec<Eye>,
}

impl GridPlan {
    /// Plans a frame of a grid.
    pub(crate) fn update<'a>(
        &'a mut self,
        view: &GridView,
        bricks: &dyn Bricks,
        settings: &RenderSettings<SheetSettings>,
        tile_edge: usize,
    ) -> ZonedFrame<'a> {
        let Self { plan, eyes } = self;
        plan.of_grid(view, bricks, settings, tile_edge);
        eyes.resize_with(plan.zones().len().max(eyes.len()), Eye::default);
        for (ZonePlan { zone, .. }, eye) in plan.zones().iter().zip(&mut *eyes) {
            if zone.begins_at_eye() {
                eye.update(view, zone.raster.peak, bricks);
            }
        }
        ZonedFrame { plan, eyes }
    }
}

/// View data shared by the tiles of a layer's picture, zone by zone.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ZonedFrame<'a> {
    pub plan: &'a FramePlan,
    /// Empty for clouds.
    pub eyes: &'a [Eye],
}

impl<'a> ZonedFrame<'a> {
    /// View data shared by the tiles of a zone.
    pub(crate) fn zone(&self, index: usize) -> Option<SheetFrame<'a>> {
        let plan = self.plan;
        let own = plan.zones().get(index)?;
        let zone = &own.zone;
        Some(SheetFrame {
            corners: &plan.corners,
            order: &plan.order,
            stack: zone.planes,
            zone,
            sheets: &own.sheets,
            lists: &own.lists,
            eye: self.eyes.get(index),
            constants: own.constants,
            rays: plan.rays,
            termination: plan.termination,
            step: zone.raster.step,
            depth_reach: plan.reach,
            cut: zone.cut as f32,
            room: plan.room,
            ellipses: zone.footprints != Evaluation::Round,
            groups: plan.groups,
            size: plan.tiles.size(),
        })
    }
}

/// View data shared by the tiles of a zone.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SheetFrame<'a> {
    /// First voxel of each brick, camera space.
    pub corners: &'a [[f32; 3]],
    pub order: &'a DepthOrder,
    pub stack: Planes,
    pub zone: &'a Zone,
    pub sheets: &'a [SheetShape],
    pub lists: &'a TileLists,
    /// The eye, where the first interval begins there.
    pub eye: Option<&'a Eye>,
    pub constants: SplatConstants,
    pub rays: Rays,
    pub termination: f32,
    /// Pixels from one raster point to the next.
    pub step: usize,
    /// Reach of a voxel in depth, world length.
    pub depth_reach: f32,
    /// Standard deviations at which footprints are cut.
    pub cut: f32,
    /// Room for footprints of neighbouring sheets.
    pub room: Room,
    /// Whether powers count from the middle block.
    pub ellipses: bool,
    pub groups: usize,
    /// The picture's pixels along x and y.
    pub size: [usize; 2],
}

impl SheetFrame<'_> {
    /// Largest distance of footprints of so many blocks from the principal point, raster points.
    pub(crate) fn farthest(&self, blocks: usize) -> [f32; 2] {
        [0, 1].map(|axis| {
            let principal = self.constants.principal[axis];
            let points = self.size[axis] as f32 / self.step as f32;
            principal.max(points - principal) + (BLOCK_EDGE * (blocks + 1)) as f32
        })
    }

    /// Image coordinates of the principal point, from the middle of the picture's first pixel.
    pub(crate) fn principal(&self) -> [f32; 2] {
        self.rays.principal.map(|at| at - 0.5)
    }

    /// Depth at which the square of blocks of a voxel's footprints lies around its centre, given the sheet behind the middle of
    /// those that it meets. Round footprints lie behind each other.
    pub(crate) fn anchor(&self, shape: &SheetShape) -> f32 {
        match self.ellipses {
            true => shape.depth - 0.5 * self.stack.spacing as f32,
            false => shape.depth,
        }
    }

    /// Half extent of footprints on a sheet, raster points.
    pub(crate) fn half_extent(&self, shape: &SheetShape) -> [f32; 2] {
        room_of(shape, self.cut, &self.room)
    }

    /// Share of a footprint's mass that is drawn.
    pub(crate) fn mass_drawn(&self, shape: &SheetShape) -> f32 {
        match self.zone.footprints {
            Evaluation::Direct => 1.0,
            _ => mass_drawn(shape, self.cut, &self.room),
        }
    }
}

/// Camera from the samples of a grid.
fn camera_from_samples(view: &GridView) -> DAffine3 {
    let margin = DVec3::from_array(view.margin().map(|m| m as f64));
    view.camera_from_lattice() * DAffine3::from_translation(margin)
}

/// A field whose coefficients are splatted with their kernels' derivatives, with the shader of its planes.
pub(crate) fn analytic_field<'a>(
    view: &GridView,
    store: &'a FieldStore,
    (shader, sums): (PlaneShader<'a>, Sums),
) -> AnalyticField<'a> {
    let dims = store.source().grid().dims();
    let sigma = view.kernel().sigma;
    AnalyticField {
        store,
        shader,
        sums,
        weights: LatticeWeights::new(camera_from_samples(view), dims, view.margin(), sigma),
    }
}

/// Shader of planes of a field.
pub(crate) fn shader<'a>(
    view: &GridView,
    (store, table): (&'a FieldStore, &'a ShadeTable),
    (settings, mean_spacing): (&RenderSettings<SheetSettings>, f64),
) -> PlaneShader<'a> {
    let dims = store.source().grid().dims();
    let Rays {
        principal,
        per_pixel,
        plane_per_pixel,
    } = view.rays();
    PlaneShader {
        table,
        phong: settings.lighting.as_ref().map(|l| Phong::new(l, mean_spacing)),
        spacing: view.spacing() as f32,
        background: store.background(),
        principal,
        per_pixel,
        plane_per_pixel,
        termination: settings.termination as f32,
        border: Border::new(
            camera_from_samples(view),
            dims,
            view.margin(),
            view.kernel().sigma,
        ),
    }
}
