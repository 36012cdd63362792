//! Memory of levels that are read in chunks: how a budget is divided among a volume's chunks, those made of them, and what is
//! solved of them.

use std::ops::Range;

use splatvol_scene::{ChunkedVolume, OverBudget};

use super::Pyramid;
use crate::field::SourceLevel;

/// Part of the bytes for samples that those get of which a level's own are made.
const MADE_OF: u64 = 4;

impl Pyramid {
    /// Divides bytes for samples among the chunks from which levels are read: their own, and where these are made of finer
    /// ones, those of the volume. Others keep none.
    ///
    /// # Errors
    /// More bytes than the budget has left.
    pub(crate) fn give(&self, levels: Range<usize>, samples: u64) -> Result<(), OverBudget> {
        let chunks_of = |level: &'_ SourceLevel| level.chunks().map(std::ptr::from_ref);
        let volume = chunks_of(&self.own[0]);
        let made = |levels: std::ops::RangeInclusive<usize>| {
            let all = self.sources[levels].iter().filter_map(chunks_of);
            all.filter(|&own| Some(own) != volume).collect::<Vec<_>>()
        };
        let (finest, last) = (self.finest(), levels.end - 1);
        let refined = made(levels.start.min(finest)..=last.min(finest));
        // Halves are made of each other, and only the coarsest is read.
        let (read, between) = match last > finest {
            true => {
                let mut halves = made(finest + 1..=last);
                let read: Vec<_> = halves.pop().into_iter().collect();
                (read, [refined, halves].concat())
            }
            false => (refined, Vec::new()),
        };
        let below = 1 + between.len() as u64;
        let share = |chunks: &ChunkedVolume| {
            let own = std::ptr::from_ref(chunks);
            match () {
                () if read.contains(&own) => (samples - samples / MADE_OF) / read.len() as u64,
                () if Some(own) == volume && read.is_empty() && between.is_empty() => samples,
                () if Some(own) == volume || between.contains(&own) => samples / MADE_OF / below,
                () => 0,
            }
        };
        let own = self.own[0].chunks();
        let all: Vec<_> = own
            .into_iter()
            .chain(self.made().filter_map(SourceLevel::chunks))
            .collect();
        // Those that get less leave room for the others.
        for chunks in &all {
            let _ = chunks.source().resize(share(chunks));
        }
        all.iter()
            .try_for_each(|chunks| chunks.source().resize(share(chunks)))
    }

    /// Bytes of the largest chunk, and of a sample in chunks, of these levels and of what they are made of.
    pub(crate) fn largest_chunk(&self, levels: Range<usize>) -> (u64, u64) {
        let own = self.own[..1].iter().chain(&self.sources[levels]);
        own.filter_map(|level| Some(level.chunks()?.layout(level.of().1)))
            .map(|layout| {
                let element = layout.element.size() as u64;
                let chunk = layout.chunk.iter().map(|&edge| edge as u64).product::<u64>();
                (chunk * element, element)
            })
            .fold((0, 0), |(chunk, element), own| {
                (chunk.max(own.0), element.max(own.1))
            })
    }

    /// Frees all that pictures have left, where samples are read in chunks, but for those themselves: another pyramid of
    /// the same volume may need their memory.
    pub fn rest(&self) {
        self.free_solved();
        for chunks in self.made().filter_map(SourceLevel::chunks) {
            // No bytes are always granted.
            let _ = chunks.source().resize(0);
        }
    }

    /// Frees what all levels have solved, where they are solved as pictures need them.
    pub(crate) fn free_solved(&self) {
        self.lend(0..0, 0);
    }

    /// Lets the levels beside these keep what they have solved, of so many bytes for all of them: the finer one three
    /// quarters of them at most, the coarser one, which has a quarter of its voxels at a surface, one quarter. Others are
    /// freed. The bytes that are kept.
    pub(crate) fn lend(&self, levels: Range<usize>, bytes: u64) -> u64 {
        let mut kept = 0;
        for (at, level) in self.levels.iter().enumerate() {
            let most = match at {
                _ if levels.contains(&at) => continue,
                _ if at + 1 == levels.start => bytes / 4 * 3,
                _ if at == levels.end => bytes / 4,
                _ => 0,
            };
            if let Some(level) = level {
                kept += level.field.keep_at_most(most);
            }
        }
        kept
    }
}
