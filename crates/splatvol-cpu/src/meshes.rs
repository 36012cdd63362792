//! Post-classified meshes: clouds of their samples, kept between frames for each mesh and width of kernels.
//!
//! A sample carries its mass, and its value times its mass. Colours, opacities and the place of a mesh may change
//! without making another kernel.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use splatvol_core::irregular::{self, MeshKernels};
use splatvol_core::splats::{Gather, Splat, SplatCloud};
use splatvol_scene::{Mesh, RenderSettings, SheetSettings};

use crate::prepare::Patience;
use crate::route::MeshScene;
use crate::run::Run;

/// The clouds of the meshes of a scene.
#[derive(Debug, Default)]
pub(crate) struct MeshStore {
    kept: Vec<Kept>,
}

/// Cache key of a mesh's kernels.
#[derive(Debug, Clone, Copy, PartialEq)]
struct KernelKey {
    /// Standard deviation, samples.
    sigma: f64,
    /// Whether the field interpolates the samples' values.
    prefilter: bool,
}

#[derive(Debug)]
struct Kept {
    mesh: Arc<Mesh>,
    made_for: KernelKey,
    cloud: SplatCloud,
}

impl MeshStore {
    /// Prepares the clouds of these meshes, in their order; `None` if the picture is cancelled while one is being
    /// made.
    pub(crate) fn update(
        &mut self,
        run: Run<'_>,
        meshes: &[MeshScene<'_>],
        settings: &RenderSettings<SheetSettings>,
    ) -> Option<()> {
        let key = KernelKey {
            sigma: settings.method.kernel.sigma,
            prefilter: settings.method.prefilter,
        };
        let mut kept = std::mem::take(&mut self.kept);
        let of =
            |kept: &Kept, mesh: &MeshScene<'_>| Arc::ptr_eq(&kept.mesh, mesh.mesh) && kept.made_for == key;
        // First, so that the memory of both is never needed.
        kept.retain(|kept| meshes.iter().any(|mesh| of(kept, mesh)));
        for mesh in meshes {
            let mut own = match kept.iter().position(|kept| of(kept, mesh)) {
                Some(at) => kept.swap_remove(at),
                None => {
                    let own = Arc::clone(mesh.mesh);
                    run.pool
                        .prepare(run.task.stop, move |patience| Kept::new(own, key, patience))?
                }
            };
            own.cloud.world_from_local = mesh.world_from_local;
            own.cloud.mass = mesh.world_from_local.matrix3.determinant().abs();
            own.cloud.spacing = mesh.spacing;
            self.kept.push(own);
        }
        Some(())
    }

    /// Memory held, bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.clouds().map(SplatCloud::bytes).sum()
    }

    /// The prepared clouds.
    pub(crate) fn clouds(&self) -> impl ExactSizeIterator<Item = &SplatCloud> {
        self.kept.iter().map(|kept| &kept.cloud)
    }
}

impl Kept {
    fn new(mesh: Arc<Mesh>, made_for: KernelKey, patience: &Patience) -> Option<Self> {
        let mut kernels = irregular::kernels(&mesh, made_for.sigma);
        patience.go_on()?;
        if made_for.prefilter {
            kernels.values = kernels.coefficients();
            patience.go_on()?;
        }
        let cloud = cloud(&kernels, mesh.value_range().map(f64::from), patience)?;
        Some(Self {
            mesh,
            made_for,
            cloud,
        })
    }
}

/// The cloud of kernels in their space; 0 and 1 become the ends of a range of values.
fn cloud(kernels: &MeshKernels, [low, high]: [f64; 2], patience: &Patience) -> Option<SplatCloud> {
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
    let mut cloud = gather.finish_while(|| patience.go_on().is_some())?.cloud;
    // Light sees the gradient of the field.
    cloud.gradients = Vec::new();
    Some(cloud)
}
