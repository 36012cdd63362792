//! Store: the clouds of a scene, kept on the host and on the device.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::DAffine3;
use rayon::prelude::*;
use splatvol_core::cloud_planes::own_spacing;
use splatvol_core::engine::Task;
use splatvol_core::mesh_cloud::{KernelKey, MeshCloud};
use splatvol_core::scene_cloud::SceneCloud;
use splatvol_core::splats::SplatCloud;
use splatvol_scene::{Camera, Mesh, RenderSettings, Scene, SceneError, SheetSettings};

use crate::device::GpuDevice;

/// Kernels of a page: 64 MiB at most, less than any device binds.
const PAGE: usize = 1 << 20;

/// A kernel: `Kernel` in WGSL.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct KernelData {
    position: [f32; 3],
    covariance: [f32; 6],
    gradient: [f32; 3],
}

/// Kernels of a cloud on the device.
#[derive(Debug)]
pub(crate) struct Kernels {
    pub pages: Vec<Page>,
}

/// Some of them.
#[derive(Debug)]
pub(crate) struct Page {
    pub kernels: wgpu::Buffer,
    pub payloads: wgpu::Buffer,
    pub count: u32,
}

impl Kernels {
    fn new(gpu: &GpuDevice, cloud: &SplatCloud) -> Result<Self, SceneError> {
        let firsts = (0..cloud.len()).step_by(PAGE);
        let page = |first: usize| {
            let range = first..(first + PAGE).min(cloud.len());
            let kernels: Vec<KernelData> = range
                .clone()
                .into_par_iter()
                .map(|index| KernelData {
                    position: cloud.positions[index],
                    covariance: cloud.covariances[index],
                    gradient: cloud.gradients.get(index).copied().unwrap_or_default(),
                })
                .collect();
            Page {
                kernels: gpu.buffer_of("kernels", &kernels),
                payloads: gpu.buffer_of("payloads", &cloud.payloads[range.clone()]),
                count: range.len() as u32,
            }
        };
        let pages = gpu.scoped(|_| firsts.map(page).collect())?;
        Ok(Self { pages })
    }

    /// Replaces the payloads by those of the cloud.
    fn write_payloads(&self, gpu: &GpuDevice, cloud: &SplatCloud) -> Result<(), SceneError> {
        gpu.scoped(|gpu| {
            for (page, payloads) in self.pages.iter().zip(cloud.payloads.chunks(PAGE)) {
                gpu.queue
                    .write_buffer(&page.payloads, 0, bytemuck::cast_slice(payloads));
            }
            gpu.queue.submit([]);
        })
    }

    fn bytes(&self) -> u64 {
        let pages = self.pages.iter();
        pages.map(|page| page.kernels.size() + page.payloads.size()).sum()
    }
}

/// A cloud on the host, and on the device once it is drawn.
#[derive(Debug)]
struct Kept<C> {
    cloud: C,
    kernels: Kernels,
}

/// The clouds of the last scene.
#[derive(Debug, Default)]
pub(crate) struct CloudStore {
    rest: Option<Kept<SceneCloud>>,
    meshes: Vec<Kept<MeshCloud>>,
}

/// A post-classified mesh in its place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OfMesh<'a> {
    pub mesh: &'a Arc<Mesh>,
    pub world_from_local: DAffine3,
    /// Distance of neighbouring samples, world length.
    pub spacing: f64,
}

/// A cloud that is on the device.
pub(crate) type Ready<'a> = (&'a SplatCloud, &'a Kernels);

impl CloudStore {
    /// Brings the clouds of a scene, and forgets those of others. `rest`: everything that is classified before it is
    /// splatted.
    ///
    /// # Errors
    /// A stopped picture, or memory that the device refuses.
    pub(crate) fn update(
        &mut self,
        gpu: &GpuDevice,
        (rest, meshes): (&Scene, &[OfMesh<'_>]),
        (camera, settings, sheets): (&Camera, &RenderSettings, &RenderSettings<SheetSettings>),
        task: Task<'_>,
    ) -> Result<(), SceneError> {
        let go_on = || !task.is_stopped();
        // First, so that the memory of old and new clouds is never needed together.
        let is_kept = |kept: &Kept<SceneCloud>| !rest.items.is_empty() && kept.cloud.is_of(rest, settings);
        self.rest.take_if(|kept| !is_kept(kept));
        let key = KernelKey::new(sheets);
        let mut kept = std::mem::take(&mut self.meshes);
        kept.retain(|kept| meshes.iter().any(|own| kept.cloud.is_of(own.mesh, key)));
        for own in meshes {
            let known = kept.iter().position(|kept| kept.cloud.is_of(own.mesh, key));
            let mut made = match known {
                Some(at) => kept.swap_remove(at),
                None => {
                    let cloud = MeshCloud::new(Arc::clone(own.mesh), key, &go_on);
                    let cloud = cloud.ok_or(SceneError::Stopped)?;
                    let kernels = Kernels::new(gpu, cloud.cloud())?;
                    Kept { cloud, kernels }
                }
            };
            made.cloud.place(own.world_from_local, own.spacing);
            self.meshes.push(made);
        }
        if rest.items.is_empty() {
            return Ok(());
        }
        match &mut self.rest {
            Some(Kept { cloud, kernels }) => {
                if cloud.color(camera) {
                    kernels.write_payloads(gpu, cloud.cloud())?;
                }
            }
            none => {
                let mut cloud = SceneCloud::new(rest.clone(), settings, &go_on).ok_or(SceneError::Stopped)?;
                cloud.color(camera);
                let kernels = Kernels::new(gpu, cloud.cloud())?;
                *none = Some(Kept { cloud, kernels });
            }
        }
        Ok(())
    }

    /// The cloud of everything that is classified before it is splatted.
    pub(crate) fn rest(&self) -> Option<Ready<'_>> {
        self.rest.as_ref().map(|kept| (kept.cloud.cloud(), &kept.kernels))
    }

    /// The clouds of the meshes, in their order.
    pub(crate) fn meshes(&self) -> impl Iterator<Item = Ready<'_>> {
        self.meshes.iter().map(|kept| (kept.cloud.cloud(), &kept.kernels))
    }

    /// Distance of planes that suits the finest cloud.
    pub(crate) fn spacing(&self, view: (&Camera, &RenderSettings<SheetSettings>)) -> Option<f64> {
        let all = self.meshes().chain(self.rest());
        all.map(|(cloud, _)| own_spacing(cloud, view)).reduce(f64::min)
    }

    /// Bytes on the host, and on the device.
    pub(crate) fn bytes(&self) -> [usize; 2] {
        let rest = self
            .rest
            .iter()
            .map(|kept| (kept.cloud.bytes(), kept.kernels.bytes()));
        let meshes = self
            .meshes
            .iter()
            .map(|kept| (kept.cloud.cloud().bytes(), kept.kernels.bytes()));
        rest.chain(meshes)
            .fold([0; 2], |[host, device], (a, b)| [host + a, device + b as usize])
    }
}
