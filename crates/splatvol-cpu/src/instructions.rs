//! Instruction sets: the loops over SIMD vectors, which are generic over the instruction set, and the crates that compile them.
//!
//! A loop is compiled once for each instruction set. That is most of what a build of splatvol does, so each set has a crate of its
//! own (`splatvol-cpu-baseline`, `splatvol-cpu-avx2`, `splatvol-cpu-avx512`); cargo builds them beside each other. Such a crate
//! only instantiates [`Work::run`]. The engine calls it through a pointer, once per tile or chunk of splats.

use fearless_simd::{Level, Simd};

use crate::sheets::picture::TileWork;
use crate::splats::SplatWork;

/// A part of a picture for one thread.
pub struct Work<'a, 't>(pub(crate) Part<'a, 't>);

/// The parts.
pub(crate) enum Part<'a, 't> {
    /// A tile of sheets.
    Sheets(TileWork<'a>),
    /// A chunk or a tile of whole splats.
    Splats(SplatWork<'a, 't>),
}

impl Work<'_, '_> {
    /// Does the work. To be called where the instructions of `simd` are enabled, and compiled nowhere else.
    #[inline(always)]
    pub fn run<S: Simd>(self, simd: S) {
        match self.0 {
            Part::Sheets(tile) => tile.run(simd),
            Part::Splats(splats) => splats.run(simd),
        }
    }
}

/// An instruction set that the processor has, and the loops that were compiled for it.
#[derive(Debug, Clone, Copy)]
pub struct InstructionSet {
    /// The instruction set.
    pub level: Level,
    /// Does work by it.
    pub run: fn(Level, Work<'_, '_>),
}

impl InstructionSet {
    /// Renders a tile of sheets.
    pub(crate) fn sheets(&self, tile: TileWork<'_>) {
        (self.run)(self.level, Work(Part::Sheets(tile)));
    }

    /// Projects or composites splats.
    pub(crate) fn splats(&self, splats: SplatWork<'_, '_>) {
        (self.run)(self.level, Work(Part::Splats(splats)));
    }

    /// Its name, for people.
    pub(crate) fn name(&self) -> &'static str {
        match self.level {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Avx512(_) => "AVX-512",
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Avx2(_) => "AVX2",
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Sse4_2(_) => "SSE4.2",
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Sse2(_) => "SSE2",
            #[cfg(target_arch = "aarch64")]
            Level::Neon(_) => "NEON",
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            Level::WasmSimd128(_) => "simd128",
            _ => "scalar",
        }
    }
}
