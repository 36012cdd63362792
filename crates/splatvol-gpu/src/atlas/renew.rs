//! Renew: an atlas for another transfer function, or of a volume in chunks for another camera. Pages whose voxels are the same
//! stay where they are, and only the bricks of the others are brought.

use splatvol_core::brick::BRICK;
use splatvol_core::field::FieldStore;
use splatvol_core::visibility::VisibleLevels;
use splatvol_scene::SceneError;

use super::{Assembler, Atlas, AtlasLayout};

/// What pages are made of. Coefficients depend on the samples alone.
#[derive(Debug, PartialEq)]
pub(super) struct Contents {
    background: f32,
    /// Of a volume in chunks: which voxels of its bricks are needed follows from the visible levels alone.
    levels: Option<VisibleLevels>,
    bricks: Vec<Brick>,
}

/// A needed brick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Brick {
    first: [u32; 3],
    needed: [u64; BRICK],
}

impl Contents {
    /// Those of a field.
    pub(super) fn of(store: &FieldStore) -> Self {
        let brick = |index| Brick {
            first: store.first(index),
            needed: store.needed_in(index),
        };
        Self {
            background: store.background(),
            levels: store.levels().filter(|_| store.is_lazy()).cloned(),
            bricks: (0..store.len()).map(brick).collect(),
        }
    }

    fn of_page<'a>(&'a self, layout: &'a AtlasLayout, needed: usize) -> impl Iterator<Item = &'a Brick> {
        let numbers = layout.bricks_of(needed).iter();
        numbers.map(|&number| &self.bricks[number as usize])
    }
}

/// Where needed pages go.
struct Places {
    /// The slot of each.
    slots: Vec<usize>,
    /// Needed pages that have to be brought, with their slots.
    brought: Vec<(usize, usize)>,
}

impl Atlas {
    /// Brings what a field of the same volume, kernel and level needs, and the atlas lacks.
    /// `false` where it cannot, since all voxels are others or the pages have no room: then nothing is changed.
    ///
    /// # Errors
    /// Memory that the device refuses, a stopped picture, and samples that cannot be read; the atlas is of no use then.
    pub(crate) fn renew(&mut self, assembler: Assembler<'_>, store: &FieldStore) -> Result<bool, SceneError> {
        let contents = Contents::of(store);
        let Some(before) = self.contents.as_ref() else {
            return Ok(false);
        };
        if before.background != contents.background || before.levels != contents.levels {
            return Ok(false);
        }
        let firsts = contents.bricks.iter().map(|brick| brick.first);
        let mut layout = AtlasLayout::of_bricks(
            (store.dims(), firsts.collect()),
            (self.layout.taps, self.layout.channels),
        );
        layout.slots = self.layout.slots;
        if layout.needed.len() > layout.capacity() {
            return Ok(false);
        }
        let places = self.places(before, (&layout, &contents));
        let table = layout.table(
            places
                .slots
                .iter()
                .enumerate()
                .map(|(needed, &slot)| (slot, needed)),
        );
        self.layout = layout;
        self.contents = Some(contents);
        self.slots = places.slots;
        assembler.gpu.scoped(|gpu| {
            gpu.queue
                .write_buffer(&self.pages, 0, bytemuck::cast_slice(&table));
            self.assemble(assembler, store, &places.brought)
        })??;
        Ok(true)
    }

    /// Pages stay in their slots; others take those that are left.
    fn places(&self, before: &Contents, (layout, contents): (&AtlasLayout, &Contents)) -> Places {
        let known = |page: u32| {
            let needed = self.layout.needed.binary_search(&page).ok()?;
            Some((needed, self.slots[needed]))
        };
        let mut is_free = vec![true; layout.capacity()];
        for (_, slot) in layout.needed.iter().filter_map(|&page| known(page)) {
            is_free[slot] = false;
        }
        let mut free = (0..is_free.len()).filter(|&slot| is_free[slot]);
        let mut places = Places {
            slots: Vec::with_capacity(layout.needed.len()),
            brought: Vec::new(),
        };
        for (needed, &page) in layout.needed.iter().enumerate() {
            let known = known(page);
            let same = known.is_some_and(|(was, _)| {
                before
                    .of_page(&self.layout, was)
                    .eq(contents.of_page(layout, needed))
            });
            // There are as many slots as needed pages at least.
            let slot = known.map(|(_, slot)| slot).or_else(|| free.next()).unwrap_or(0);
            places.slots.push(slot);
            if !same {
                places.brought.push((needed, slot));
            }
        }
        places
    }
}
