//! The clouds of post-classified meshes, kept between frames for each mesh and width of kernels.

use splatvol_core::mesh_cloud::{KernelKey, MeshCloud};
use splatvol_core::splats::SplatCloud;
use splatvol_scene::{RenderSettings, SheetSettings};

use crate::route::MeshScene;
use crate::run::Run;

/// The clouds of the meshes of a scene.
#[derive(Debug, Default)]
pub(crate) struct MeshStore {
    kept: Vec<MeshCloud>,
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
        let key = KernelKey::new(settings);
        let mut kept = std::mem::take(&mut self.kept);
        // First, so that the memory of both is never needed.
        kept.retain(|kept| meshes.iter().any(|mesh| kept.is_of(mesh.mesh, key)));
        for mesh in meshes {
            let mut own = match kept.iter().position(|kept| kept.is_of(mesh.mesh, key)) {
                Some(at) => kept.swap_remove(at),
                None => {
                    let own = mesh.mesh.clone();
                    run.pool.prepare(run.task.stop, move |patience| {
                        MeshCloud::new(own, key, &|| patience.go_on().is_some())
                    })?
                }
            };
            own.place(mesh.world_from_local, mesh.spacing);
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
        self.kept.iter().map(MeshCloud::cloud)
    }
}
