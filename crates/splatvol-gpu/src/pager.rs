//! Pager: which pages are in slots, while a picture is made of more voxels than the budget has room for.
//!
//! Intervals are marched front to back, and a few of them meet few pages. So these are brought to the device by turns: the
//! picture is the same, and takes longer.

use std::ops::Range;

use glam::DVec3;
use splatvol_core::field::FieldStore;
use splatvol_scene::SceneError;

use crate::atlas::{Assembler, Atlas};
use crate::layout::Picture;

/// Planes around an interval from which its values come, before and behind.
const AROUND: i64 = 1;

/// Pages in slots.
pub(crate) struct Pager<'a> {
    assembler: Assembler<'a>,
    atlas: &'a Atlas,
    store: &'a FieldStore,
    /// Smallest and largest plane number that each needed page may meet.
    planes: Vec<[i64; 2]>,
    /// Number of the first plane of all.
    first: i64,
    /// The needed page in each slot, by its place among them.
    in_slots: Vec<Option<usize>>,
}

impl<'a> Pager<'a> {
    /// The pager of a picture; `None` if all pages are on the device.
    pub(crate) fn new(assembler: Assembler<'a>, atlas: &'a Atlas, picture: &Picture<'a>) -> Option<Self> {
        if !atlas.is_paged() {
            return None;
        }
        let camera_from_lattice = picture.view.camera_from_lattice();
        let spacing = picture.view.spacing();
        let planes = |page: &u32| {
            let [low, high] = atlas.layout.cells_of(*page);
            let depths = (0..8).map(|corner| {
                let of = |axis: usize| {
                    if corner >> axis & 1 == 0 {
                        low[axis]
                    } else {
                        high[axis]
                    }
                };
                let corner = DVec3::new(f64::from(of(0)), f64::from(of(1)), f64::from(of(2)));
                camera_from_lattice.transform_point3(corner).z / spacing
            });
            let [near, far] = depths.fold([f64::INFINITY, f64::NEG_INFINITY], |[near, far], depth| {
                [near.min(depth), far.max(depth)]
            });
            [near.floor() as i64, far.ceil() as i64]
        };
        Some(Self {
            assembler,
            planes: atlas.layout.needed.iter().map(planes).collect(),
            first: picture.first_plane(),
            in_slots: vec![None; atlas.layout.capacity()],
            store: &picture.level.field,
            atlas,
        })
    }

    /// Places of the needed pages that some intervals meet.
    fn met(&self, intervals: &Range<u32>) -> Vec<usize> {
        let near = self.first + i64::from(intervals.start) - AROUND;
        let far = self.first + i64::from(intervals.end) + AROUND;
        let meets = |[first, last]: &[i64; 2]| *first <= far && *last >= near;
        let places = self.planes.iter().enumerate();
        places
            .filter(|(_, planes)| meets(planes))
            .map(|(at, _)| at)
            .collect()
    }

    /// Brings the pages of as many intervals as have room, at most these; returns how many.
    ///
    /// # Errors
    /// A single interval that has no room, a stopped picture, and samples that cannot be read.
    pub(crate) fn load(&mut self, intervals: Range<u32>) -> Result<u32, SceneError> {
        let mut count = intervals.end - intervals.start;
        loop {
            let met = self.met(&(intervals.start..intervals.start + count));
            if met.len() <= self.in_slots.len() {
                self.exchange(&met)?;
                return Ok(count);
            }
            if count <= 1 {
                return Err(self.assembler.gpu.failed(&format!(
                    "one interval of the volume meets {} pages, the budget of {} MiB has room for {}",
                    met.len(),
                    self.assembler.gpu.budget >> 20,
                    self.in_slots.len()
                )));
            }
            count /= 2;
        }
    }

    /// Puts pages, which have room, into slots that hold none of them.
    fn exchange(&mut self, met: &[usize]) -> Result<(), SceneError> {
        let is_met = |page: &Option<usize>| page.is_some_and(|page| met.binary_search(&page).is_ok());
        for slot in &mut self.in_slots {
            if !is_met(slot) {
                *slot = None;
            }
        }
        let mut there: Vec<usize> = self.in_slots.iter().flatten().copied().collect();
        there.sort_unstable();
        let mut missing = met.iter().filter(|page| there.binary_search(page).is_err());
        let mut brought = Vec::new();
        for (slot, holds) in self.in_slots.iter_mut().enumerate() {
            if holds.is_none() {
                let Some(&page) = missing.next() else {
                    break;
                };
                brought.push((page, slot));
                *holds = Some(page);
            }
        }
        self.atlas.assemble(self.assembler, self.store, &brought)?;
        self.atlas.set_slots(self.assembler.gpu, &self.in_slots);
        Ok(())
    }
}
