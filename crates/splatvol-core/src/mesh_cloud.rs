//! Post-classified meshes: clouds of their samples, which engines keep between frames.
//!
//! A sample carries its mass, and its value times its mass. Colours, opacities and the place of a mesh may change
//! without making another kernel.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};
use splatvol_scene::{Mesh, RenderSettings, SheetSettings};

use crate::engine::GoOn;
use crate::irregular::{self, MeshKernels};
use crate::splats::{Gather, Splat, SplatCloud};

/// What the kernels of a mesh's samples depend on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KernelKey {
    /// Standard deviation, samples.
    sigma: f64,
    /// Whether the field interpolates the samples' values.
    prefilter: bool,
}

impl KernelKey {
    /// That of these settings.
    pub fn new(settings: &RenderSettings<SheetSettings>) -> Self {
        Self {
            sigma: settings.method.kernel.sigma,
            prefilter: settings.method.prefilter,
        }
    }
}

/// The samples of a mesh.
#[derive(Debug)]
pub struct MeshCloud {
    mesh: Arc<Mesh>,
    made_for: KernelKey,
    cloud: SplatCloud,
}

impl MeshCloud {
    /// The samples of a mesh, in its own space; `None` if they are given up meanwhile.
    pub fn new(mesh: Arc<Mesh>, made_for: KernelKey, go_on: GoOn<'_>) -> Option<Self> {
        let mut kernels = irregular::kernels(&mesh, made_for.sigma);
        go_on().then_some(())?;
        if made_for.prefilter {
            kernels.values = kernels.coefficients();
            go_on().then_some(())?;
        }
        let cloud = cloud(&kernels, mesh.value_range().map(f64::from), go_on)?;
        Some(Self {
            mesh,
            made_for,
            cloud,
        })
    }

    /// Whether they are those of a mesh.
    pub fn is_of(&self, mesh: &Arc<Mesh>, key: KernelKey) -> bool {
        Arc::ptr_eq(&self.mesh, mesh) && self.made_for == key
    }

    /// Moves them to a place. `spacing`: of neighbouring samples, world length.
    pub fn place(&mut self, world_from_local: DAffine3, spacing: f64) {
        self.cloud.world_from_local = world_from_local;
        self.cloud.mass = world_from_local.matrix3.determinant().abs();
        self.cloud.spacing = spacing;
    }

    /// The splats. Their payloads are mass, and mass times normalised value.
    pub fn cloud(&self) -> &SplatCloud {
        &self.cloud
    }
}

/// The cloud of kernels in their space; 0 and 1 become the ends of a range of values.
fn cloud(kernels: &MeshKernels, [low, high]: [f64; 2], go_on: GoOn<'_>) -> Option<SplatCloud> {
    let width = if high > low { high - low } else { 1.0 };
    let mut gather = Gather::around(DVec3::ZERO, 1.0);
    gather.add_splats(kernels.len(), |index| {
        let [xx, xy, xz, yy, yz, zz] = kernels.covariances[index].map(f64::from);
        let value = (f64::from(kernels.values[index]) - low) / width;
        let mass = kernels.masses[index];
        Splat {
            centre: DVec3::from_array(kernels.positions[index].map(f64::from)),
            covariance: DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]),
            payload: [mass, (f64::from(mass) * value) as f32, 0.0, 0.0],
            gradient: DVec3::ZERO,
        }
    });
    let mut cloud = gather.finish_while(go_on)?.cloud;
    // Light sees the gradient of the field.
    cloud.gradients = Vec::new();
    Some(cloud)
}
