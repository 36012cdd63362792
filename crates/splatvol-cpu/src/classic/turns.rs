//! Turns: opened chunks, with their splats in lists per turn.

use splatvol_core::splats::{Profile, SplatCloud};

use super::plan::Plan;

/// Lists of splats per turn, as linked lists in one memory.
#[derive(Debug, Default)]
pub(crate) struct Turns {
    /// First entry of each turn's list, plus one.
    heads: Vec<u32>,
    /// Splat, and the next entry plus one.
    entries: Vec<[u32; 2]>,
    /// The splats of one turn, with their sort keys.
    sorted: Vec<(u32, u32)>,
}

impl Turns {
    /// Empty lists for so many turns.
    pub(crate) fn reset(&mut self, count: usize) {
        self.heads.clear();
        self.heads.resize(count, 0);
        self.entries.clear();
    }

    /// Adds a chunk's splats. Rounding can make a splat miss its turn; such splats are drawn now.
    pub(crate) fn open<P: Profile>(&mut self, plan: &Plan<'_, P>, chunk: usize, now: usize) -> usize {
        let SplatCloud {
            chunks, positions, ..
        } = plan.cloud;
        let chunk = &chunks[chunk];
        for splat in chunk.first..chunk.end {
            let index = splat as usize;
            let reach = plan.projection.reach_of(index);
            let turn = plan
                .order
                .turn(plan.projection.centre(index), positions[index], reach);
            let Some(head) = self.heads.get_mut(turn.max(now)) else {
                continue;
            };
            self.entries.push([splat, *head]);
            *head = self.entries.len() as u32;
        }
        (chunk.end - chunk.first) as usize
    }

    /// The splats of a turn by their key, then by index.
    pub(crate) fn take(&mut self, turn: usize, key: impl Fn(u32) -> u32) -> &[(u32, u32)] {
        self.sorted.clear();
        let mut next = self.heads.get_mut(turn).map_or(0, std::mem::take);
        while let Some(&[splat, after]) = (next as usize).checked_sub(1).and_then(|at| self.entries.get(at)) {
            self.sorted.push((key(splat), splat));
            next = after;
        }
        self.sorted.sort_unstable();
        &self.sorted
    }

    /// Splats of the turns that are still to come.
    pub(crate) fn waiting(&self) -> usize {
        let mut count = 0;
        for &head in &self.heads {
            let mut next = head;
            while let Some(&[_, after]) = (next as usize).checked_sub(1).and_then(|at| self.entries.get(at)) {
                count += 1;
                next = after;
            }
        }
        count
    }

    /// True where a turn has splats.
    pub(crate) fn has(&self, turn: usize) -> bool {
        self.heads.get(turn).is_some_and(|&head| head != 0)
    }
}

/// A float's bits, in the order of the floats.
#[inline(always)]
pub(crate) fn ordered(value: f32) -> u32 {
    let bits = value.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}
