//! Attributes of Gaussians on the device, page by page, kept between frames.

use std::sync::{Arc, Weak};

use splatvol_scene::gaussians::harmonics_count;
use splatvol_scene::{Gaussians, SceneError};

use super::Clouds;
use crate::device::GpuDevice;

/// Gaussians of a page: their harmonics take 96 MiB at most, less than any device binds.
const PAGE: usize = 1 << 19;

/// Attributes of the clouds of a scene.
#[derive(Debug, Default)]
pub(super) struct Attributes(Vec<Resident>);

impl Attributes {
    /// Bytes on the device.
    pub(super) fn bytes(&self) -> usize {
        let pages = self.0.iter().flat_map(|resident| &resident.pages);
        pages.map(Page::bytes).sum()
    }

    /// The pages of a cloud that was brought.
    pub(super) fn pages(&self, own: &Arc<Gaussians>) -> &[Page] {
        let resident = self.0.iter().find(|resident| resident.is_of(own));
        resident.map_or(&[], |resident| &resident.pages)
    }

    /// Smallest and largest coordinates of the centres of a cloud that was brought, local.
    pub(super) fn bounds(&self, own: &Arc<Gaussians>) -> Option<[[f32; 3]; 2]> {
        let resident = self.0.iter().find(|resident| resident.is_of(own));
        resident.map(|resident| resident.bounds)
    }

    /// Brings attributes to the device that are not there; frees those of other scenes.
    pub(super) fn upload(&mut self, gpu: &GpuDevice, clouds: &Clouds<'_>) -> Result<(), SceneError> {
        let Self(resident) = self;
        resident.retain(|known| clouds.iter().any(|(own, _)| known.is_of(own)));
        for (own, _) in clouds {
            if !resident.iter().any(|known| known.is_of(own)) {
                let firsts = (0..own.len()).step_by(PAGE);
                let pages = gpu.scoped(|gpu| firsts.map(|from| Page::new(gpu, own, from)).collect())?;
                resident.push(Resident {
                    of: Arc::downgrade(own),
                    bounds: bounds(own),
                    pages,
                });
            }
        }
        Ok(())
    }
}

fn bounds(own: &Gaussians) -> [[f32; 3]; 2] {
    let nothing = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    own.attributes().means.iter().fold(nothing, |[low, high], mean| {
        [
            std::array::from_fn(|axis| low[axis].min(mean[axis])),
            std::array::from_fn(|axis| high[axis].max(mean[axis])),
        ]
    })
}

/// Coefficients, so many for each Gaussian, in vectors of four numbers with zeros behind them: the first vector of all
/// Gaussians, then the second.
fn in_vectors(coefficients: &[[f32; 3]], per_one: usize) -> Vec<[f32; 4]> {
    let numbers = coefficients.as_flattened();
    let vectors = (3 * per_one).div_ceil(4);
    (0..vectors)
        .flat_map(|vector| {
            numbers.chunks(3 * per_one).map(move |own| {
                let number = |i: usize| own.get(4 * vector + i).copied().unwrap_or(0.0);
                std::array::from_fn(number)
            })
        })
        .collect()
}

/// A cloud's attributes on the device.
#[derive(Debug)]
struct Resident {
    of: Weak<Gaussians>,
    /// Smallest and largest coordinates of the centres, local.
    bounds: [[f32; 3]; 2],
    pages: Vec<Page>,
}

impl Resident {
    fn is_of(&self, own: &Arc<Gaussians>) -> bool {
        std::ptr::eq(self.of.as_ptr(), Arc::as_ptr(own))
    }
}

/// So many of its Gaussians.
#[derive(Debug)]
pub(super) struct Page {
    pub means: wgpu::Buffer,
    pub rotations: wgpu::Buffer,
    pub scales: wgpu::Buffer,
    pub harmonics: wgpu::Buffer,
    pub count: u32,
}

impl Page {
    fn new(gpu: &GpuDevice, gaussians: &Gaussians, from: usize) -> Self {
        let all = gaussians.attributes();
        let range = from..(from + PAGE).min(gaussians.len());
        let means: Vec<[f32; 4]> = range
            .clone()
            .map(|i| {
                let [x, y, z] = all.means[i];
                [x, y, z, all.opacities[i]]
            })
            .collect();
        let scales: Vec<[f32; 4]> = all.scales[range.clone()]
            .iter()
            .map(|&[x, y, z]| [x, y, z, 0.0])
            .collect();
        let per_one = harmonics_count(gaussians.degree());
        Self {
            means: gpu.buffer_of("means", &means),
            rotations: gpu.buffer_of("rotations", &all.rotations[range.clone()]),
            scales: gpu.buffer_of("scales", &scales),
            harmonics: gpu.buffer_of(
                "harmonics",
                &in_vectors(
                    &all.harmonics[range.start * per_one..range.end * per_one],
                    per_one,
                ),
            ),
            count: range.len() as u32,
        }
    }

    fn bytes(&self) -> usize {
        let buffers = [&self.means, &self.rotations, &self.scales, &self.harmonics];
        buffers.iter().map(|buffer| buffer.size() as usize).sum()
    }
}
