//! Assemble: bricks as the host keeps them, to pages in slots.

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;
use splatvol_core::brick::BRICK;
use splatvol_core::engine::Task;
use splatvol_core::field::{FieldStore, PACKED};
use splatvol_scene::SceneError;

use super::{Atlas, AtlasLayout};
use crate::device::GpuDevice;
use crate::pass::{Pass, uniform};

/// The text of `assemble`.
pub(crate) const ASSEMBLE: &str = include_str!("../../shaders/assemble.wgsl");

/// Bricks around a page along an axis, at most; and of all axes.
const AROUND: usize = 4;
const ALL_AROUND: usize = AROUND * AROUND * AROUND;
/// Of these, how many a page meets at most: three along each axis.
const MET: u64 = 27;
/// Words of a page: slot, first lattice point, bricks.
const OF_PAGE: usize = 6 + ALL_AROUND;
/// Where there is no brick.
const NO_BRICK: u32 = u32::MAX;
/// Groups of a dispatch along x: `PAGES_ACROSS` in its shader.
const PAGES_ACROSS: u32 = 32_768;
/// Most bytes of bricks that are brought together.
const TOGETHER: u64 = 96 << 20;
/// The same of volumes in chunks, where these bytes are part of a budget, and bricks may take long.
pub(crate) const CHUNKS_TOGETHER: u64 = 8 << 20;

/// What puts pages together, and the task that it is for.
#[derive(Clone, Copy)]
pub(crate) struct Assembler<'a> {
    pub gpu: &'a GpuDevice,
    /// The compiled `assemble`.
    pub pass: &'a Pass,
    pub task: Task<'a>,
}

/// What to assemble: `Assembly` in WGSL.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct AssemblyData {
    pub pages: u32,
    pub edge: u32,
    pub channels: u32,
    pub channel_layers: u32,
}

/// Bricks, and the pages that are made of them.
struct Parts {
    bricks: Vec<[u32; PACKED]>,
    pages: Vec<[u32; OF_PAGE]>,
}

impl Parts {
    /// Those of some needed pages, each with its slot.
    fn new(layout: &AtlasLayout, store: &FieldStore, pages: &[(usize, usize)]) -> Self {
        let mut numbers: Vec<u32> = pages
            .iter()
            .flat_map(|&(needed, _)| layout.bricks_of(needed).iter().copied())
            .collect();
        numbers.par_sort_unstable();
        numbers.dedup();
        let pack = |&brick: &u32| {
            let mut packed = [0; PACKED];
            store.pack(brick as usize, &mut packed);
            packed
        };
        let page = |&(needed, slot): &(usize, usize)| layout.page(store, (needed, slot), &numbers);
        Self {
            bricks: numbers.par_iter().map(pack).collect(),
            pages: pages.par_iter().map(page).collect(),
        }
    }
}

impl AtlasLayout {
    /// Needed bricks that meet a needed page.
    pub(super) fn bricks_of(&self, needed: usize) -> &[u32] {
        let start = needed.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.bricks[start..self.ends[needed]]
    }

    /// A needed page as shaders read it; `numbers`: the bricks that are brought, ascending.
    fn page(&self, store: &FieldStore, (needed, slot): (usize, usize), numbers: &[u32]) -> [u32; OF_PAGE] {
        let mut words = [NO_BRICK; OF_PAGE];
        let [column, row, stack] = self.place_of(slot);
        let first = self.first_of(self.needed[needed]);
        let place = [column, row, stack].map(|at| at * self.edge());
        let head = place.into_iter().chain(first.map(i32::cast_unsigned));
        for (word, value) in words.iter_mut().zip(head) {
            *word = value;
        }
        for brick in self.bricks_of(needed) {
            let of_brick = store.first(*brick as usize);
            let [x, y, z] = [0, 1, 2].map(|axis| {
                let edge = BRICK as i32;
                (of_brick[axis] as i32).div_euclid(edge) - first[axis].div_euclid(edge)
            });
            let at = OF_PAGE - ALL_AROUND + ((z * AROUND as i32 + y) * AROUND as i32 + x) as usize;
            words[at] = numbers.partition_point(|number| number < brick) as u32;
        }
        words
    }
}

impl Atlas {
    /// Brings needed pages, each to its slot.
    ///
    /// # Errors
    /// A stopped picture, samples that cannot be read, or a device that fails.
    pub(crate) fn assemble(
        &self,
        assembler: Assembler<'_>,
        store: &FieldStore,
        pages: &[(usize, usize)],
    ) -> Result<(), SceneError> {
        let Assembler { gpu, task, .. } = assembler;
        let together = match store.is_lazy() {
            true => CHUNKS_TOGETHER,
            false => TOGETHER,
        };
        let room = together.min(gpu.device.limits().max_storage_buffer_binding_size);
        let most = (room / (MET * (PACKED * size_of::<u32>()) as u64)).max(1) as usize;
        let mut before = None;
        for (at, part) in pages.chunks(most).enumerate() {
            task.go_on()?;
            let parts = Parts::new(&self.layout, store, part);
            store.failure().map_or(Ok(()), Err)?;
            let submitted = self.assemble_together(assembler, &parts);
            // Of a volume in chunks no more is on its way than its budget knows of.
            if store.is_lazy()
                && let Some(before) = before.replace(submitted)
            {
                gpu.wait(Some(before))?;
                task.report((at * most) as f64 / pages.len() as f64);
            }
        }
        Ok(())
    }

    fn assemble_together(
        &self,
        Assembler { gpu, pass, .. }: Assembler<'_>,
        parts: &Parts,
    ) -> wgpu::SubmissionIndex {
        let count = parts.pages.len() as u32;
        let edge = self.layout.edge();
        let data = AssemblyData {
            pages: count,
            edge,
            channels: self.layout.channels,
            channel_layers: self.layout.channel_layers(),
        };
        let (data, bricks, pages) = (
            uniform(gpu, &data),
            gpu.buffer_of("bricks", &parts.bricks),
            gpu.buffer_of("pages to assemble", &parts.pages),
        );
        let bindings = [
            (0, data.as_entire_binding()),
            (1, bricks.as_entire_binding()),
            (2, pages.as_entire_binding()),
            (3, wgpu::BindingResource::TextureView(&self.view)),
        ];
        let groups = [
            count.min(PAGES_ACROSS),
            edge.pow(3).div_ceil(64),
            count.div_ceil(PAGES_ACROSS),
        ];
        let mut commands = gpu.commands();
        pass.dispatch(gpu, &mut commands, &bindings, groups);
        gpu.queue.submit([commands.finish()])
    }
}
