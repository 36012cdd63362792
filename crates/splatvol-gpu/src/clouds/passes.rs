//! Passes of clouds, compiled when a cloud is first drawn.

use splatvol_core::cloud_planes::{CUT, DEPTH_CUT, DEPTH_EDGE, DEPTH_INTEGRAL, LEAST_WIDTH};
use splatvol_scene::SceneError;

use crate::device::GpuDevice;
use crate::mode::{CloudMode, cloud_shaders};
use crate::pass::Pass;
use crate::sort::Sorter;

/// Passes over a cloud's planes.
#[derive(Debug)]
pub(crate) struct CloudMarch {
    pub march: Pass,
    /// From what rays kept to colours.
    pub settle: Option<Pass>,
}

impl CloudMarch {
    /// Compiles the passes of a mode. `operators`: the function `operate` of a mesh with effects.
    ///
    /// # Errors
    /// A driver that refuses a shader.
    pub(crate) fn new(gpu: &GpuDevice, mode: CloudMode, operators: &str) -> Result<Self, SceneError> {
        let (text, constants) = (mode.text(operators), mode.constants());
        let entry = |name| Pass::new(gpu, (name, &text), &constants);
        gpu.scoped(|_| Self {
            march: entry("march"),
            settle: mode.settles().then(|| entry("settle")),
        })
    }
}

/// Compiled passes.
#[derive(Debug)]
pub(crate) struct CloudPasses {
    pub open: Pass,
    pub count_pairs: Pass,
    pub emit_pairs: Pass,
    pub find_ranges: Pass,
    pub mark: Pass,
    planes_of_colors: Pass,
    planes_of_values: Pass,
    pub sorter: Sorter,
}

impl CloudPasses {
    /// Compiles the passes that all clouds have.
    ///
    /// # Errors
    /// A driver that refuses a shader.
    pub(crate) fn new(gpu: &GpuDevice) -> Result<Self, SceneError> {
        gpu.scoped(|gpu| {
            let [open, pairs, colors, values] = cloud_shaders();
            let of_kernels = [
                ("LEAST_WIDTH", LEAST_WIDTH),
                ("DEPTH_INTEGRAL", DEPTH_INTEGRAL),
                ("DEPTH_CUT", DEPTH_CUT),
                ("CUT", CUT),
            ];
            let edge = [("DEPTH_EDGE", f64::from(DEPTH_EDGE))];
            let pair = |entry| Pass::new(gpu, (entry, &pairs), &[]);
            Self {
                open: Pass::new(gpu, ("open", &open), &of_kernels),
                count_pairs: pair("count_pairs"),
                emit_pairs: pair("emit_pairs"),
                find_ranges: pair("find_ranges"),
                mark: pair("mark"),
                planes_of_colors: Pass::new(gpu, ("make_planes", &colors), &edge),
                planes_of_values: Pass::new(gpu, ("make_planes", &values), &edge),
                sorter: Sorter::new(gpu),
            }
        })
    }

    /// The pass that makes planes for a mode.
    pub(crate) fn planes(&self, mode: CloudMode) -> &Pass {
        match mode {
            CloudMode::Colors => &self.planes_of_colors,
            CloudMode::Field | CloudMode::FieldEffects | CloudMode::Values(_) => &self.planes_of_values,
        }
    }
}
