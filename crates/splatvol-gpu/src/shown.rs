//! Shown: a volume in its place with its look, and what its data on the device depend on.

use std::sync::{Arc, Weak};

use splatvol_core::level::{Detail, Wanted};
use splatvol_scene::{
    Camera, Gradient, RenderSettings, SheetKernel, SheetSettings, TransferFunction, Volume,
};

use crate::effects::Effects;
use crate::mode::Mode;

/// A volume where it lies, and its look.
#[derive(Debug)]
pub(crate) struct Shown<'a> {
    pub volume: Arc<Volume>,
    pub transfer_function: &'a TransferFunction,
    pub unit_distance: f64,
    pub labels: bool,
    pub settings: RenderSettings<SheetSettings>,
    pub effects: Effects,
}

impl Shown<'_> {
    pub(crate) fn key(&self, level: usize) -> Key {
        Key {
            level,
            volume: Arc::downgrade(&self.volume),
            transfer_function: self.transfer_function.clone(),
            unit_distance: self.unit_distance,
            kernel: self.settings.method.kernel,
            prefilter: self.settings.method.prefilter,
            wanted: Wanted::of(&self.settings),
        }
    }

    /// Voxels along an axis that the kernel meets.
    pub(crate) fn taps(&self) -> i32 {
        if self.settings.method.kernel.radius > 2.0 {
            6
        } else {
            4
        }
    }

    pub(crate) fn mode(&self) -> Mode {
        Mode::of(Wanted::of(&self.settings), &self.settings.method, &self.effects)
    }

    /// Its level of detail. Labels are lit by their own shapes, analytic gradients show the field as it is: both have none.
    pub(crate) fn detail(&self, camera: &Camera) -> Detail {
        let method = &self.settings.method;
        if self.labels || (!self.mode().splats_classes() && method.gradient == Gradient::Analytic) {
            return Detail::FINEST;
        }
        Detail::new(&self.volume, camera, (self.settings.size, method.level_bias))
    }
}

/// What a volume's needed voxels depend on.
#[derive(Debug, Clone)]
pub(crate) struct Key {
    pub level: usize,
    pub volume: Weak<Volume>,
    transfer_function: TransferFunction,
    unit_distance: f64,
    kernel: SheetKernel,
    prefilter: bool,
    wanted: Wanted,
}

impl Key {
    /// Whether another is of the same but for the level.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        Weak::ptr_eq(&self.volume, &other.volume)
            && self.transfer_function == other.transfer_function
            && self.unit_distance == other.unit_distance
            && self.kernel == other.kernel
            && self.prefilter == other.prefilter
            && self.wanted == other.wanted
    }
}
