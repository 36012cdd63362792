//! Voxels that are classified before they are splatted: their samples on the device, and the pass that makes classes of
//! them.
//!
//! Samples of a level lie in a texture of three dimensions. They are classified and lit for each picture, since light
//! changes with the camera, and an edit of the transfer function uploads nothing but its table.

use std::sync::{Arc, Weak};

use rayon::prelude::*;
use splatvol_core::brick::BRICK;
use splatvol_core::field::{FieldStore, Neighbourhood};
use splatvol_core::level::{ClassifiedMeans, Level};
use splatvol_core::visibility::BRICK_VOXELS;
use splatvol_scene::{SceneError, Volume};

use crate::atlas::Atlas;
use crate::device::GpuDevice;
use crate::pass::Pass;

/// Value of a missing sample: `MISSING` in WGSL.
const MISSING: f32 = -1e30;
/// Slots along x of a dispatch: `SLOTS_ACROSS` in WGSL.
const SLOTS_ACROSS: u32 = 32_768;

/// Samples of levels of volumes, kept on the device.
#[derive(Debug, Default)]
pub(crate) struct KeptSamples(Vec<(Weak<Volume>, usize, wgpu::Texture)>);

impl KeptSamples {
    /// Samples of a level.
    ///
    /// # Errors
    /// A volume too large for the device or its budget, and samples that cannot be read.
    pub(crate) fn of(
        &mut self,
        gpu: &GpuDevice,
        volume: &Weak<Volume>,
        (level, field): (usize, &FieldStore),
    ) -> Result<wgpu::Texture, SceneError> {
        let is_it = |(of, at, _): &&(Weak<Volume>, usize, _)| Weak::ptr_eq(of, volume) && *at == level;
        if let Some((_, _, known)) = self.0.iter().find(is_it) {
            return Ok(known.clone());
        }
        let made = samples(gpu, field)?;
        self.0.push((Weak::clone(volume), level, made.clone()));
        Ok(made)
    }

    /// Forgets those of all volumes but these.
    pub(crate) fn retain<'v>(&mut self, volumes: impl Iterator<Item = &'v Arc<Volume>> + Clone) {
        self.0.retain(|(of, ..)| {
            volumes
                .clone()
                .any(|volume| std::ptr::addr_eq(of.as_ptr(), Arc::as_ptr(volume)))
        });
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        let textures = self.0.iter().map(|(_, _, texture)| texture.size());
        textures
            .map(|size| {
                u64::from(size.width) * u64::from(size.height) * u64::from(size.depth_or_array_layers) * 4
            })
            .sum()
    }
}

/// Classes of a level's visible voxels, and what they are made from.
#[derive(Debug)]
pub(crate) struct Voxels {
    samples: wgpu::TextureView,
    means: wgpu::TextureView,
    has_means: bool,
    surfaces: wgpu::TextureView,
    classes: wgpu::TextureView,
    resident: wgpu::Buffer,
    slots: u32,
    texels: u32,
}

impl Voxels {
    /// Room for the classes of a level's visible bricks.
    ///
    /// # Errors
    /// More of them than the budget or the device has room for.
    pub(crate) fn new(
        gpu: &GpuDevice,
        level: &Level,
        samples: &wgpu::Texture,
        taps: i32,
    ) -> Result<(Atlas, Self), SceneError> {
        let field = &level.field;
        let firsts = level.visible.iter().map(|&brick| field.brick_first(brick));
        let atlas = Atlas::empty(gpu, (field.dims(), firsts.collect()), (taps, 4))?;
        if atlas.is_paged() {
            return Err(gpu.failed(&format!(
                "the visible voxels, which are classified first, need {} pages, the budget of {} MiB has room for {}",
                atlas.layout.needed.len(),
                gpu.budget >> 20,
                atlas.layout.capacity()
            )));
        }
        let empty = || gpu.scoped(|gpu| volume_texture(gpu, [1; 3], wgpu::TextureFormat::Rgba32Float));
        let [means, surfaces] = match &level.means {
            Some(of) => [
                means(gpu, level, of)?,
                surfaces(gpu, level, of)?.map_or_else(empty, Ok)?,
            ],
            None => [empty()?, empty()?],
        };
        let resident = gpu.scoped(|gpu| gpu.buffer_of("resident", &atlas.layout.needed))?;
        let voxels = Self {
            samples: samples.create_view(&wgpu::TextureViewDescriptor::default()),
            means: means.create_view(&wgpu::TextureViewDescriptor::default()),
            has_means: level.means.is_some(),
            surfaces: surfaces.create_view(&wgpu::TextureViewDescriptor::default()),
            classes: atlas.view.clone(),
            resident,
            slots: atlas.layout.needed.len() as u32,
            texels: atlas.layout.edge().pow(3),
        };
        Ok((atlas, voxels))
    }

    /// Whether classes are means of those of a finer level.
    pub(crate) fn has_means(&self) -> bool {
        self.has_means
    }

    /// Adds the pass to commands. `shared`: the frame, the table and the clips.
    pub(crate) fn classify(
        &self,
        gpu: &GpuDevice,
        pass: &Pass,
        commands: &mut wgpu::CommandEncoder,
        [frame, table, effects]: [&wgpu::Buffer; 3],
    ) {
        if self.slots == 0 {
            return;
        }
        let texture = |binding, view| (binding, wgpu::BindingResource::TextureView(view));
        let groups = [
            self.slots.min(SLOTS_ACROSS),
            self.texels.div_ceil(64),
            self.slots.div_ceil(SLOTS_ACROSS),
        ];
        let bindings = [
            whole(0, frame),
            whole(3, &self.resident),
            texture(4, &self.samples),
            texture(5, &self.means),
            whole(6, table),
            texture(7, &self.classes),
            texture(8, &self.surfaces),
            whole(9, effects),
        ];
        pass.dispatch(gpu, commands, &bindings, groups);
    }
}

fn whole(binding: u32, buffer: &wgpu::Buffer) -> (u32, wgpu::BindingResource<'_>) {
    (binding, buffer.as_entire_binding())
}

fn volume_texture(gpu: &GpuDevice, dims: [usize; 3], format: wgpu::TextureFormat) -> wgpu::Texture {
    let [width, height, depth_or_array_layers] = dims.map(|n| n as u32);
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("samples"),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D3,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

/// Normalised samples of a level.
fn samples(gpu: &GpuDevice, field: &FieldStore) -> Result<wgpu::Texture, SceneError> {
    let read = |brick: u32, put: &mut dyn FnMut(usize, f32)| {
        let mut around = Neighbourhood::default();
        field.read(brick, &mut around);
        for voxel in 0..BRICK_VOXELS {
            let [x, y, z] = place_of(voxel);
            let value = around.values[z + 1][y + 1][x + 1];
            put(voxel, if value.is_nan() { MISSING } else { value });
        }
    };
    let texture = filled(gpu, field, wgpu::TextureFormat::R32Float, read)?;
    field.failure().map_or(Ok(texture), Err)
}

/// Classes of a level that are means.
fn means(gpu: &GpuDevice, level: &Level, means: &ClassifiedMeans) -> Result<wgpu::Texture, SceneError> {
    let read = |brick: u32, put: &mut dyn FnMut(usize, [f32; 4])| {
        let Ok(at) = level.visible.binary_search(&brick) else {
            return;
        };
        let mut classes = [[0.0; 4]; BRICK_VOXELS];
        means.decode(at, &mut classes);
        for (voxel, class) in classes.into_iter().enumerate() {
            put(voxel, class);
        }
    };
    filled(gpu, &level.field, wgpu::TextureFormat::Rgba32Float, read)
}

/// Surfaces of a level's labels, where classes are means; nothing of other values.
fn surfaces(
    gpu: &GpuDevice,
    level: &Level,
    means: &ClassifiedMeans,
) -> Result<Option<wgpu::Texture>, SceneError> {
    if !means.are_of_labels() {
        return Ok(None);
    }
    let read = |brick: u32, put: &mut dyn FnMut(usize, [f32; 4])| {
        let Ok(at) = level.visible.binary_search(&brick) else {
            return;
        };
        let mut surfaces = [[0.0; 4]; BRICK_VOXELS];
        means.decode_surfaces(at, &mut surfaces);
        for (voxel, surface) in surfaces.into_iter().enumerate() {
            put(voxel, surface);
        }
    };
    filled(gpu, &level.field, wgpu::TextureFormat::Rgba32Float, read).map(Some)
}

/// A texture of a level's grid; `read` puts the voxels of a brick.
fn filled<T: bytemuck::Pod + Send>(
    gpu: &GpuDevice,
    field: &FieldStore,
    format: wgpu::TextureFormat,
    read: impl Fn(u32, &mut dyn FnMut(usize, T)) + Sync,
) -> Result<wgpu::Texture, SceneError> {
    let dims = field.source().grid().dims();
    let most = gpu.device.limits().max_texture_dimension_3d as usize;
    if let Some(&n) = dims.iter().find(|&&n| n > most) {
        return Err(gpu.failed(&format!(
            "voxels that are classified first lie in a texture of at most {most} samples along an axis, not {n}"
        )));
    }
    let bytes = dims.iter().product::<usize>() * size_of::<T>();
    gpu.afford("the volume's samples", bytes as u64)?;
    let texture = gpu.scoped(|gpu| volume_texture(gpu, dims, format))?;
    let rows = BrickRows::new(field);
    for z in 0..rows.bricks[2] {
        let row = |y| (y, rows.row([y, z], &read));
        let layer: Vec<(usize, Vec<T>)> = (0..rows.bricks[1]).into_par_iter().map(row).collect();
        gpu.scoped(|gpu| {
            for (y, voxels) in &layer {
                rows.write(gpu, &texture, [*y, z], bytemuck::cast_slice(voxels));
            }
            gpu.queue.submit([]);
        })?;
    }
    Ok(texture)
}

/// Rows of a lattice's bricks along x.
struct BrickRows {
    bricks: [usize; 3],
    margin: [usize; 3],
    dims: [usize; 3],
}

impl BrickRows {
    fn new(field: &FieldStore) -> Self {
        Self {
            bricks: field.dims().map(|n| n.div_ceil(BRICK)),
            margin: field.margin(),
            dims: field.source().grid().dims(),
        }
    }

    /// Samples along an axis that a brick holds.
    fn along(&self, axis: usize, brick: usize) -> std::ops::Range<usize> {
        let sample = |point: usize| point.saturating_sub(self.margin[axis]).min(self.dims[axis]);
        sample(brick * BRICK)..sample((brick + 1) * BRICK)
    }

    /// Voxels of a row.
    fn row<T: bytemuck::Pod>(
        &self,
        [y, z]: [usize; 2],
        read: impl Fn(u32, &mut dyn FnMut(usize, T)),
    ) -> Vec<T> {
        let (ys, zs) = (self.along(1, y), self.along(2, z));
        let mut voxels = vec![T::zeroed(); self.dims[0] * ys.len() * zs.len()];
        for x in 0..self.bricks[0] {
            let brick = (z * self.bricks[1] + y) * self.bricks[0] + x;
            let first = [x, y, z].map(|at| at * BRICK);
            read(brick as u32, &mut |voxel, value| {
                let place = place_of(voxel);
                let [x, y, z] =
                    [0, 1, 2].map(|axis| (first[axis] + place[axis]).wrapping_sub(self.margin[axis]));
                if x < self.dims[0] && ys.contains(&y) && zs.contains(&z) {
                    voxels[((z - zs.start) * ys.len() + y - ys.start) * self.dims[0] + x] = value;
                }
            });
        }
        voxels
    }

    fn write(&self, gpu: &GpuDevice, texture: &wgpu::Texture, [y, z]: [usize; 2], voxels: &[u8]) {
        let (ys, zs) = (self.along(1, y), self.along(2, z));
        if ys.is_empty() || zs.is_empty() {
            return;
        }
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture,
                mip_level: 0,
                origin: wgpu::Origin3d {
                    x: 0,
                    y: ys.start as u32,
                    z: zs.start as u32,
                },
                aspect: wgpu::TextureAspect::All,
            },
            voxels,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some((voxels.len() / ys.len() / zs.len()) as u32),
                rows_per_image: Some(ys.len() as u32),
            },
            wgpu::Extent3d {
                width: self.dims[0] as u32,
                height: ys.len() as u32,
                depth_or_array_layers: zs.len() as u32,
            },
        );
    }
}

fn place_of(voxel: usize) -> [usize; 3] {
    [voxel % BRICK, voxel / BRICK % BRICK, voxel / (BRICK * BRICK)]
}
