//! The CPU engine's loops, compiled for SSE2: the only code of this crate is [`splatvol_cpu::Work`]'s.
#![forbid(unsafe_code)]

use fearless_simd::{Level, Simd};
use splatvol_cpu::{InstructionSet, Work};

/// SSE2, which every processor of x86-64 has.
pub fn instruction_set() -> InstructionSet {
    let best = Level::baseline();
    let level = best.as_sse2().map_or(best, |simd| simd.level());
    InstructionSet { level, run }
}

fn run(level: Level, work: Work<'_, '_>) {
    if let Some(simd) = level.as_sse2() {
        simd.vectorize(
            #[inline(always)]
            || work.run(simd),
        );
    }
}
