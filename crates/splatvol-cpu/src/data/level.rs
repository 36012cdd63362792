//! Levels of detail: the volume and its halves, each with what a transfer function needs of it.
//!
//! A level is chosen so that a voxel is 0.8 to 1.6 pixels wide in the middle of the volume; within a quarter of an octave
//! of the change both levels are rendered and blended, so that no change is seen. Minified volumes are anti-aliased by their
//! mips, and cost what their pixels cost.

use std::sync::Arc;

use glam::DVec3;
use splatvol_core::brick::BRICK;
use splatvol_core::classification::ClassificationTable;
use splatvol_core::field::FieldStore;
use splatvol_core::kernel::GaussianKernel;
use splatvol_core::mip;
use splatvol_core::visibility::VisibleLevels;
use splatvol_scene::{Camera, ImageSize, Kernel, TransferFunction, Volume};

use super::shade::ShadeTable;

/// Smallest width of a voxel, pixels.
const FINEST: f64 = 0.8;
/// Octaves over which two levels are blended.
const BLEND: f64 = 0.25;

/// A volume at one resolution.
#[derive(Debug)]
struct Level {
    field: FieldStore,
    table: ShadeTable,
    transfer_function: Option<TransferFunction>,
    unit_distance: f64,
    /// First and last lattice point of the bricks that are needed.
    bounds: [DVec3; 2],
}

impl Level {
    fn new(volume: Arc<Volume>, kernel: Kernel) -> Self {
        Self {
            field: FieldStore::new(volume, &GaussianKernel::new(kernel)),
            table: ShadeTable::default(),
            transfer_function: None,
            unit_distance: 0.0,
            bounds: [DVec3::ZERO; 2],
        }
    }

    fn classify(&mut self, transfer_function: &TransferFunction, unit_distance: f64) {
        if self.transfer_function.as_ref() == Some(transfer_function) && self.unit_distance == unit_distance {
            return;
        }
        let range = self.field.volume().value_range();
        let table = ClassificationTable::new(transfer_function, range, unit_distance);
        let visible = VisibleLevels::new(&table);
        self.field.update(&visible);
        self.table.update(&table, &visible, self.field.background());
        let firsts = (0..self.field.len()).map(|i| DVec3::from_array(self.field.first(i).map(f64::from)));
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for first in firsts {
            (low, high) = (low.min(first), high.max(first + (BRICK as f64 - 1.0)));
        }
        self.bounds = if self.field.is_empty() {
            [DVec3::ZERO; 2]
        } else {
            [low, high]
        };
        self.transfer_function = Some(transfer_function.clone());
        self.unit_distance = unit_distance;
    }
}

/// A volume's levels, made as they are wanted.
#[derive(Debug)]
pub(crate) struct Pyramid {
    kernel: Kernel,
    volumes: Vec<Arc<Volume>>,
    levels: Vec<Option<Level>>,
}

/// Which level is rendered, and how much of the next coarser one is blended in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Detail {
    pub level: usize,
    pub coarser: f32,
}

impl Detail {
    /// Detail for a camera.
    pub(crate) fn new(volume: &Volume, camera: &Camera, size: ImageSize) -> Self {
        let grid = volume.grid();
        let centre = grid.bounds().centre();
        let depth = camera.camera_from_world().transform_point3(centre).z;
        let scale = camera.screen_from_camera(size).scale_at(depth);
        let octaves = (FINEST / (scale * grid.mean_spacing())).log2();
        let most = grid
            .dims()
            .iter()
            .max()
            .map_or(0, |n| n.ilog2().saturating_sub(3)) as f64;
        if !octaves.is_finite() || octaves <= -BLEND {
            return Self {
                level: 0,
                coarser: 0.0,
            };
        }
        let level = octaves.ceil().clamp(0.0, most);
        let into = if level < most {
            (1.0 + (octaves - level) / BLEND).clamp(0.0, 1.0)
        } else {
            0.0
        };
        Self {
            level: level as usize,
            coarser: into as f32,
        }
    }
}

impl Pyramid {
    pub(crate) fn new(volume: Arc<Volume>, kernel: Kernel) -> Self {
        Self {
            kernel,
            volumes: vec![volume],
            levels: vec![None],
        }
    }

    /// Whether the levels are this volume's, for this kernel.
    pub(crate) fn is_of(&self, volume: &Arc<Volume>, kernel: Kernel) -> bool {
        Arc::ptr_eq(&self.volumes[0], volume) && self.kernel == kernel
    }

    /// The volume at a level; the finest where a level cannot be made.
    pub(crate) fn volume(&mut self, level: usize) -> &Arc<Volume> {
        while self.volumes.len() <= level {
            let last = self.volumes.len() - 1;
            let half =
                mip::half(&self.volumes[last]).map_or_else(|_| Arc::clone(&self.volumes[last]), Arc::new);
            self.volumes.push(half);
            self.levels.push(None);
        }
        &self.volumes[level]
    }

    /// Makes a level right for a transfer function.
    pub(crate) fn classify(
        &mut self,
        level: usize,
        transfer_function: &TransferFunction,
        unit_distance: f64,
    ) {
        let volume = Arc::clone(self.volume(level));
        let kernel = self.kernel;
        let level = self.levels[level].get_or_insert_with(|| Level::new(volume, kernel));
        level.classify(transfer_function, unit_distance);
    }

    /// A classified level, with the first and last lattice point that matter.
    pub(crate) fn level(&self, level: usize) -> Option<(&FieldStore, &ShadeTable, [DVec3; 2])> {
        let level = self.levels.get(level)?.as_ref()?;
        Some((&level.field, &level.table, level.bounds))
    }
}
