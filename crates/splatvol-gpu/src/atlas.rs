//! Atlas: a volume's coefficients on the device, in pages of 16^3 cells with the voxels around them.
//!
//! A page has a slot of `(15 + taps)^3` texels, if any of these voxels is needed. So every sum of a cell reads one slot.
//! Slots lie side by side in a texture of layers; a table says which slot a page has. Channels, where voxels have several
//! numbers, lie behind each other.

use rayon::prelude::*;
use splatvol_core::brick::BRICK;
use splatvol_core::field::FieldStore;
use splatvol_core::visibility::BRICK_VOXELS;
use splatvol_scene::SceneError;

use crate::device::GpuDevice;

/// Cells of a page along each axis, and cells before the lattice's first point that pages begin with.
const PAGE: i32 = 16;
const BEFORE: i32 = 4;
/// Cells behind the last lattice point that pages end with.
const BEHIND: i32 = 3;

/// Channel of a field that marks missing samples.
const MISSING: u32 = 1;

/// Coefficients on the device.
#[derive(Debug)]
pub(crate) struct Atlas {
    pub view: wgpu::TextureView,
    texture: wgpu::Texture,
    pub pages: wgpu::Buffer,
    pub layout: AtlasLayout,
}

/// Places of pages and slots.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct AtlasLayout {
    /// Voxels along an axis that a kernel meets.
    pub taps: i32,
    /// Numbers of a voxel.
    channels: u32,
    /// Pages along x, y, z.
    pub pages: [i32; 3],
    /// Slots along x and y of a layer, and stacks of slots.
    pub slots: [u32; 3],
    /// Pages that hold a needed voxel, ascending; at most as many as there are slots, or some at a time are in these.
    pub needed: Vec<u32>,
    /// For each of these the end of its part of `bricks`.
    ends: Vec<usize>,
    /// Needed bricks that meet each page, page by page.
    bricks: Vec<u32>,
}

impl AtlasLayout {
    /// Pages and slots for the voxels of bricks. `firsts`: their first lattice points; `most`: texels of a texture along
    /// an axis, layers, and bytes.
    fn new(
        (dims, firsts): ([usize; 3], impl Iterator<Item = [u32; 3]>),
        (taps, channels): (i32, u32),
        (most, bytes): ([u32; 2], u64),
    ) -> Self {
        let edge = (PAGE + taps - 1) as u32;
        let pages = dims.map(|n| (n as i32 + BEFORE + BEHIND + PAGE - 1) / PAGE);
        let mut met: Vec<[u32; 2]> = firsts
            .enumerate()
            .flat_map(|(brick, first)| {
                let first = first.map(|at| at as i32);
                pages_of(first, taps, pages).map(move |page| [page, brick as u32])
            })
            .collect();
        met.par_sort_unstable();
        let mut layout = Self {
            taps,
            channels,
            pages,
            slots: [1; 3],
            needed: Vec::new(),
            ends: Vec::new(),
            bricks: met.iter().map(|&[_, brick]| brick).collect(),
        };
        for group in met.chunk_by(|[a, _], [b, _]| a == b) {
            layout.needed.push(group[0][0]);
            let start = layout.ends.last().copied().unwrap_or(0);
            layout.ends.push(start + group.len());
        }
        let room = bytes / (u64::from(edge).pow(3) * u64::from(channels) * size_of::<f32>() as u64);
        let needed = layout.needed.len().min(room as usize).max(1);
        let (across, stacks) = ((most[0] / edge) as usize, (most[1] / channels / edge) as usize);
        let x = needed.div_ceil(stacks).isqrt().max(1).min(across);
        let y = needed.div_ceil(stacks * x).max(1).min(across);
        // Not more slots than the bytes have room for.
        let y = y.min((room as usize / x).max(1));
        let z = needed
            .div_ceil(x * y)
            .min(stacks)
            .min((room as usize / (x * y)).max(1));
        layout.slots = [x, y, z].map(|n| n as u32);
        layout
    }

    /// Texels of a slot along each axis.
    pub(crate) fn edge(&self) -> u32 {
        (PAGE + self.taps - 1) as u32
    }

    /// Bytes of the texture.
    pub(crate) fn bytes(&self) -> u64 {
        let slots: u64 = self.slots.iter().map(|&n| u64::from(n)).product();
        slots * u64::from(self.edge()).pow(3) * u64::from(self.channels) * size_of::<f32>() as u64
    }

    /// Slots.
    pub(crate) fn capacity(&self) -> usize {
        self.slots.iter().map(|&n| n as usize).product()
    }

    /// First cell of a page, and one past its last, lattice points.
    pub(crate) fn cells_of(&self, page: u32) -> [[i32; 3]; 2] {
        let [nx, ny, _] = self.pages;
        let page = page as i32;
        let first = [page % nx, page / nx % ny, page / (nx * ny)].map(|at| at * PAGE - BEFORE);
        [first, first.map(|at| at + PAGE)]
    }

    /// Layers of a channel.
    pub(crate) fn channel_layers(&self) -> u32 {
        self.slots[2] * self.edge()
    }

    /// Width and height, texels.
    pub(crate) fn size(&self) -> [u32; 2] {
        [self.slots[0] * self.edge(), self.slots[1] * self.edge()]
    }

    fn page_count(&self) -> usize {
        self.pages.iter().map(|&n| n as usize).product()
    }

    /// Slot of each page plus one; zero where there is none.
    fn table(&self) -> Vec<u32> {
        let mut table = vec![0; self.page_count()];
        for (slot, &page) in self.needed.iter().enumerate() {
            table[page as usize] = slot as u32 + 1;
        }
        table
    }

    /// First lattice point of a page's slot.
    fn first_of(&self, page: u32) -> [i32; 3] {
        let [nx, ny, _] = self.pages;
        let page = page as i32;
        [page % nx, page / nx % ny, page / (nx * ny)].map(|at| first_texel(at, self.taps))
    }

    /// Writes the voxels of the slot of a needed page into a row of slots of this pitch, from an offset on: coefficients,
    /// or ones where samples are missing.
    fn fill(
        &self,
        (needed, channel): (usize, u32),
        store: &FieldStore,
        (row, pitch, offset): (&mut [f32], usize, usize),
    ) {
        let edge = self.edge() as usize;
        let from = self.first_of(self.needed[needed]);
        let start = needed.checked_sub(1).map_or(0, |before| self.ends[before]);
        let mut values = [0.0; BRICK_VOXELS];
        for &brick in &self.bricks[start..self.ends[needed]] {
            store.decode(brick as usize, &mut values);
            let first = store.first(brick as usize).map(|at| at as i32);
            let shared = [0, 1, 2].map(|axis| {
                let low = from[axis].max(first[axis]);
                let high = (from[axis] + edge as i32).min(first[axis] + BRICK as i32);
                low..high
            });
            for z in shared[2].clone() {
                for y in shared[1].clone() {
                    let line = ((z - from[2]) as usize * edge + (y - from[1]) as usize) * pitch + offset;
                    let own = ((z - first[2]) as usize * BRICK + (y - first[1]) as usize) * BRICK;
                    for x in shared[0].clone() {
                        let value = values[own + (x - first[0]) as usize];
                        let number = if channel == MISSING {
                            f32::from(u8::from(value == f32::INFINITY))
                        } else {
                            value
                        };
                        if number.is_finite() {
                            row[line + (x - from[0]) as usize] = number;
                        }
                    }
                }
            }
        }
    }
}

impl AtlasLayout {
    /// Texels of a row of slots.
    fn row(&self, (row, channel): (usize, u32), store: &FieldStore) -> Vec<f32> {
        let (per_row, pitch) = (self.slots[0] as usize, self.size()[0] as usize);
        let mut texels = vec![0.0; pitch * self.edge().pow(2) as usize];
        for slot in row * per_row..((row + 1) * per_row).min(self.needed.len()) {
            let offset = slot % per_row * self.edge() as usize;
            self.fill((slot, channel), store, (&mut texels, pitch, offset));
        }
        texels
    }

    /// Writes slots side by side, from one on.
    fn write(&self, gpu: &GpuDevice, texture: &wgpu::Texture, (slot, channel): (usize, u32), texels: &[f32]) {
        let edge = self.edge();
        let width = texels.len() as u32 / (edge * edge);
        let [across, down, _] = self.slots;
        let slot = slot as u32;
        let (x, y, stack) = (slot % across, slot / across % down, slot / (across * down));
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture,
                mip_level: 0,
                origin: wgpu::Origin3d {
                    x: x * edge,
                    y: y * edge,
                    z: stack * edge + channel * self.channel_layers(),
                },
                aspect: wgpu::TextureAspect::All,
            },
            bytemuck::cast_slice(texels),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(width * size_of::<f32>() as u32),
                rows_per_image: Some(edge),
            },
            wgpu::Extent3d {
                width,
                height: edge,
                depth_or_array_layers: edge,
            },
        );
    }
}

/// First lattice point of the slot of a page at a position along an axis.
fn first_texel(page: i32, taps: i32) -> i32 {
    page * PAGE - BEFORE - (taps / 2 - 1)
}

/// Pages whose slots hold voxels of a brick.
fn pages_of(first: [i32; 3], taps: i32, pages: [i32; 3]) -> impl Iterator<Item = u32> {
    let edge = PAGE + taps - 1;
    let along = [0, 1, 2].map(|axis| {
        let meets = move |&page: &i32| {
            let from = first_texel(page, taps);
            from < first[axis] + BRICK as i32 && from + edge > first[axis]
        };
        let near = first[axis] / PAGE - 1;
        let candidates = near.max(0)..(near + 4).min(pages[axis]);
        candidates.filter(meets).collect::<Vec<_>>()
    });
    let [x, y, z] = along;
    z.into_iter().flat_map(move |z| {
        let (x, y) = (x.clone(), y.clone());
        y.into_iter()
            .flat_map(move |y| x.clone().into_iter().map(move |x| [x, y, z]))
            .map(move |[x, y, z]| ((z * pages[1] + y) * pages[0] + x) as u32)
    })
}

impl Atlas {
    /// Brings a field's needed coefficients to the device.
    ///
    /// # Errors
    /// Memory that the device refuses.
    pub(crate) fn new(gpu: &GpuDevice, store: &FieldStore, taps: i32) -> Result<Self, SceneError> {
        let firsts = (0..store.len()).map(|brick| store.first(brick));
        let usage = wgpu::TextureUsages::COPY_DST;
        let channels = 1 + u32::from(store.any_missing());
        let atlas = Self::empty(gpu, (store.dims(), firsts), (taps, channels), usage)?;
        if !atlas.is_paged() {
            gpu.scoped(|gpu| upload(gpu, &atlas.layout, store, &atlas.texture))?;
        }
        Ok(atlas)
    }

    /// Whether only some pages are on the device at a time.
    pub(crate) fn is_paged(&self) -> bool {
        self.layout.needed.len() > self.layout.capacity()
    }

    /// Brings a needed page to a slot.
    pub(crate) fn bring(&self, gpu: &GpuDevice, store: &FieldStore, (needed, slot): (usize, usize)) {
        let edge = self.layout.edge() as usize;
        for channel in 0..self.layout.channels {
            let mut texels = vec![0.0; edge.pow(3)];
            self.layout.fill((needed, channel), store, (&mut texels, edge, 0));
            self.layout.write(gpu, &self.texture, (slot, channel), &texels);
        }
    }

    /// Says which needed pages are in slots.
    pub(crate) fn set_slots(&self, gpu: &GpuDevice, in_slots: &[Option<usize>]) {
        let mut table = vec![0u32; self.layout.page_count()];
        for (slot, needed) in in_slots.iter().enumerate() {
            if let Some(needed) = needed {
                table[self.layout.needed[*needed] as usize] = slot as u32 + 1;
            }
        }
        gpu.queue
            .write_buffer(&self.pages, 0, bytemuck::cast_slice(&table));
    }

    /// Says that all needed pages hold something, wherever they are.
    pub(crate) fn set_needed(&self, gpu: &GpuDevice) {
        gpu.queue
            .write_buffer(&self.pages, 0, bytemuck::cast_slice(&self.layout.table()));
    }

    /// Slots for the voxels of bricks, as many as the budget and the device have room for. `firsts`: their first lattice
    /// points.
    ///
    /// # Errors
    /// Memory that the device refuses.
    pub(crate) fn empty(
        gpu: &GpuDevice,
        bricks: ([usize; 3], impl Iterator<Item = [u32; 3]>),
        shape: (i32, u32),
        usage: wgpu::TextureUsages,
    ) -> Result<Self, SceneError> {
        let limits = gpu.device.limits();
        let most = [limits.max_texture_dimension_2d, limits.max_texture_array_layers];
        let layout = AtlasLayout::new(bricks, shape, (most, gpu.budget));
        gpu.afford("a page of the volume", layout.bytes())?;
        let texture = gpu.scoped(|gpu| texture_of(gpu, &layout, usage))?;
        let table = layout.table();
        let pages = gpu.scoped(|gpu| gpu.buffer_of("pages", &table))?;
        Ok(Self {
            view: texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2Array),
                ..wgpu::TextureViewDescriptor::default()
            }),
            texture,
            pages,
            layout,
        })
    }
}

fn texture_of(gpu: &GpuDevice, layout: &AtlasLayout, usage: wgpu::TextureUsages) -> wgpu::Texture {
    let [width, height] = layout.size();
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("atlas"),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: layout.channel_layers() * layout.channels,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::R32Float,
        usage: usage | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    })
}

/// Fills the texture, a row of slots at a time.
fn upload(gpu: &GpuDevice, layout: &AtlasLayout, store: &FieldStore, texture: &wgpu::Texture) {
    let rows = layout.needed.len().div_ceil(layout.slots[0] as usize);
    // Some rows at a time, in memory that the driver can free again.
    const TOGETHER: usize = 16;
    for channel in 0..layout.channels {
        for group in (0..rows).step_by(TOGETHER) {
            let filled: Vec<Vec<f32>> = (group..(group + TOGETHER).min(rows))
                .into_par_iter()
                .map(|row| layout.row((row, channel), store))
                .collect();
            for (row, texels) in (group..).zip(&filled) {
                layout.write(gpu, texture, (row * layout.slots[0] as usize, channel), texels);
            }
            gpu.queue.submit([]);
        }
    }
}
