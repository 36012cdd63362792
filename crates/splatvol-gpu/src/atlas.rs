//! Atlas: a volume's coefficients on the device, in pages of 16^3 cells with the voxels around them.
//!
//! A page has a slot of `(15 + taps)^3` texels, if any of these voxels is needed. So every sum of a cell reads one slot.
//! Slots lie side by side in a texture of layers; a table says which slot a page has. Channels, where voxels have several
//! numbers, lie behind each other.
//!
//! Voxels come as the bricks that the host keeps, a sixth of the texels' bytes; the device puts them together (`assemble`).

mod assemble;
mod renew;

#[cfg(test)]
pub(crate) use assemble::AssemblyData;
pub(crate) use assemble::{ASSEMBLE, Assembler, CHUNKS_TOGETHER};
use renew::Contents;

use rayon::prelude::*;
use splatvol_core::brick::BRICK;
use splatvol_core::field::FieldStore;
use splatvol_scene::SceneError;

use crate::device::GpuDevice;

/// Cells of a page along each axis, and cells before the lattice's first point that pages begin with.
const PAGE: i32 = 16;
const BEFORE: i32 = 4;
/// Cells behind the last lattice point that pages end with.
const BEHIND: i32 = 3;

/// Bits of a slot's column and of its row, and those before the octants', as `shaders/frame.wgsl` has them.
const SLOT_BITS: u32 = 9;
const OCTANTS_FROM: u32 = 23;
/// Most slots along x and y, and stacks.
const MOST_SLOTS: [u32; 2] = [1 << SLOT_BITS, 1 << (OCTANTS_FROM - 2 * SLOT_BITS)];

/// One in so many slots is left for pages that the next transfer functions need.
const SPARE: usize = 16;

/// Coefficients on the device.
#[derive(Debug)]
pub(crate) struct Atlas {
    pub view: wgpu::TextureView,
    pub pages: wgpu::Buffer,
    pub layout: AtlasLayout,
    /// Slot of each needed page, where all have one.
    slots: Vec<usize>,
    /// What they were made of, where it is a field.
    contents: Option<Contents>,
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
    /// For each of these a bit per octant of its cells, set where a needed voxel is in their sums.
    octants: Vec<u8>,
    /// For each of these the end of its part of `bricks`.
    ends: Vec<usize>,
    /// Needed bricks that meet each page, page by page.
    bricks: Vec<u32>,
}

impl AtlasLayout {
    /// Pages for the voxels of bricks, without slots. `firsts`: their first lattice points.
    fn of_bricks((dims, firsts): ([usize; 3], Vec<[u32; 3]>), (taps, channels): (i32, u32)) -> Self {
        let pages = dims.map(|n| (n as i32 + BEFORE + BEHIND + PAGE - 1) / PAGE);
        let bricks = firsts.into_par_iter().enumerate().with_min_len(256);
        let mut met: Vec<[u32; 3]> = bricks
            .flat_map_iter(|(brick, first)| {
                let first = first.map(|at| at as i32);
                pages_of(first, taps, pages)
                    .map(move |(page, octants)| [page, brick as u32, u32::from(octants)])
            })
            .collect();
        met.par_sort_unstable();
        let mut layout = Self {
            taps,
            channels,
            pages,
            slots: [1; 3],
            needed: Vec::new(),
            octants: Vec::new(),
            ends: Vec::new(),
            bricks: met.iter().map(|&[_, brick, _]| brick).collect(),
        };
        for group in met.chunk_by(|[a, ..], [b, ..]| a == b) {
            layout.needed.push(group[0][0]);
            let octants = group.iter().fold(0, |all, &[_, _, octants]| all | octants);
            layout.octants.push(octants as u8);
            let start = layout.ends.last().copied().unwrap_or(0);
            layout.ends.push(start + group.len());
        }
        layout
    }

    /// The same with slots. `most`: texels of a texture along an axis, layers, and bytes.
    fn new(
        (dims, firsts): ([usize; 3], Vec<[u32; 3]>),
        (taps, channels): (i32, u32),
        (most, bytes): ([u32; 2], u64),
    ) -> Self {
        let mut layout = Self::of_bricks((dims, firsts), (taps, channels));
        let edge = layout.edge();
        let room = bytes / (u64::from(edge).pow(3) * u64::from(channels) * size_of::<f32>() as u64);
        let needed = layout.needed.len();
        let needed = (needed + needed / SPARE).min(room as usize).max(1);
        let across = (most[0] / edge).min(MOST_SLOTS[0]) as usize;
        let stacks = (most[1] / channels / edge).min(MOST_SLOTS[1]) as usize;
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

    /// Column, row and stack of a slot.
    fn place_of(&self, slot: usize) -> [u32; 3] {
        let ([across, down, _], slot) = (self.slots, slot as u32);
        [slot % across, slot / across % down, slot / (across * down)]
    }

    /// Slots of pages as shaders read them (`shaders/frame.wgsl`), given slots and the needed page in each; zero where there
    /// is none.
    fn table(&self, slots: impl Iterator<Item = (usize, usize)>) -> Vec<u32> {
        let mut table = vec![0; self.page_count()];
        for (slot, needed) in slots {
            let [column, row, stack] = self.place_of(slot);
            let octants = u32::from(self.octants[needed]) << OCTANTS_FROM;
            table[self.needed[needed] as usize] =
                octants | stack << (2 * SLOT_BITS) | row << SLOT_BITS | column;
        }
        table
    }

    /// The same, each needed page in a slot of its own.
    fn table_of_needed(&self) -> Vec<u32> {
        self.table((0..self.needed.len()).map(|needed| (needed, needed)))
    }

    /// First lattice point of a page's slot.
    fn first_of(&self, page: u32) -> [i32; 3] {
        let [nx, ny, _] = self.pages;
        let page = page as i32;
        [page % nx, page / nx % ny, page / (nx * ny)].map(|at| first_texel(at, self.taps))
    }
}

/// First lattice point of the slot of a page at a position along an axis.
fn first_texel(page: i32, taps: i32) -> i32 {
    page * PAGE - BEFORE - (taps / 2 - 1)
}

/// Pages in whose sums voxels of a brick are, and the octants of their cells in which they are.
fn pages_of(first: [i32; 3], taps: i32, pages: [i32; 3]) -> impl Iterator<Item = (u32, u8)> {
    let along = [0, 1, 2].map(|axis| {
        let near = first[axis] / PAGE - 1;
        let candidates = near.max(0)..(near + 4).min(pages[axis]);
        candidates
            .map(move |page| (page, halves_of(page, taps, first[axis])))
            .filter(|&(_, halves)| halves != [false; 2])
            .collect::<Vec<_>>()
    });
    let [x, y, z] = along;
    z.into_iter().flat_map(move |z| {
        let (x, y) = (x.clone(), y.clone());
        y.into_iter()
            .flat_map(move |y| x.clone().into_iter().map(move |x| [x, y, z]))
            .map(move |[x, y, z]| {
                let page = ((z.0 * pages[1] + y.0) * pages[0] + x.0) as u32;
                let meets = |octant: &usize| x.1[octant & 1] && y.1[octant >> 1 & 1] && z.1[octant >> 2];
                let octants = (0..8).filter(meets).fold(0, |all, octant| all | 1 << octant);
                (page, octants)
            })
    })
}

/// Whether each half of a page's cells along an axis has voxels from `first` on in its sums.
fn halves_of(page: i32, taps: i32, first: i32) -> [bool; 2] {
    [0, PAGE / 2].map(|half| {
        let from = first_texel(page, taps) + half;
        from < first + BRICK as i32 && from + PAGE / 2 + taps - 1 > first
    })
}

impl Atlas {
    /// Brings a field's needed coefficients to the device. `pass`: `assemble`.
    ///
    /// # Errors
    /// Memory that the device refuses, a stopped picture, and samples that cannot be read.
    pub(crate) fn new(assembler: Assembler<'_>, store: &FieldStore, taps: i32) -> Result<Self, SceneError> {
        let firsts = (0..store.len()).map(|brick| store.first(brick));
        let channels = 1 + u32::from(store.any_missing());
        let gpu = assembler.gpu;
        let mut atlas = Self::empty(gpu, (store.dims(), firsts.collect()), (taps, channels))?;
        if !atlas.is_paged() {
            let all: Vec<_> = (0..atlas.layout.needed.len()).map(|at| (at, at)).collect();
            gpu.scoped(|_| atlas.assemble(assembler, store, &all))??;
            atlas.contents = Some(Contents::of(store));
        }
        Ok(atlas)
    }

    /// Whether only some pages are on the device at a time.
    pub(crate) fn is_paged(&self) -> bool {
        self.layout.needed.len() > self.layout.capacity()
    }

    /// Says which needed pages are in slots.
    pub(crate) fn set_slots(&self, gpu: &GpuDevice, in_slots: &[Option<usize>]) {
        let filled = in_slots.iter().enumerate();
        let filled = filled.filter_map(|(slot, needed)| Some((slot, (*needed)?)));
        let table = self.layout.table(filled);
        gpu.queue
            .write_buffer(&self.pages, 0, bytemuck::cast_slice(&table));
    }

    /// Says that all needed pages hold something, wherever they are.
    pub(crate) fn set_needed(&self, gpu: &GpuDevice) {
        gpu.queue.write_buffer(
            &self.pages,
            0,
            bytemuck::cast_slice(&self.layout.table_of_needed()),
        );
    }

    /// Slots for the voxels of bricks, as many as the budget and the device have room for. `firsts`: their first lattice
    /// points.
    ///
    /// # Errors
    /// Memory that the device refuses.
    pub(crate) fn empty(
        gpu: &GpuDevice,
        bricks: ([usize; 3], Vec<[u32; 3]>),
        shape: (i32, u32),
    ) -> Result<Self, SceneError> {
        let limits = gpu.device.limits();
        let most = [limits.max_texture_dimension_2d, limits.max_texture_array_layers];
        let layout = AtlasLayout::new(bricks, shape, (most, gpu.budget));
        gpu.afford("a page of the volume", layout.bytes())?;
        let texture = gpu.scoped(|gpu| texture_of(gpu, &layout))?;
        let table = layout.table_of_needed();
        let pages = gpu.scoped(|gpu| gpu.buffer_of("pages", &table))?;
        Ok(Self {
            view: texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2Array),
                ..wgpu::TextureViewDescriptor::default()
            }),
            pages,
            slots: (0..layout.needed.len()).collect(),
            contents: None,
            layout,
        })
    }
}

fn texture_of(gpu: &GpuDevice, layout: &AtlasLayout) -> wgpu::Texture {
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
        usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    })
}
