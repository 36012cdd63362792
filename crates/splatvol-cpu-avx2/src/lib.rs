//! The CPU engine's loops, compiled for AVX2 with FMA: the only code of this crate is [`splatvol_cpu::Work`]'s.
#![forbid(unsafe_code)]

use fearless_simd::{Level, Simd};
use splatvol_cpu::{InstructionSet, Work};

/// AVX2 with FMA; `None` where the processor lacks it.
pub fn instruction_set() -> Option<InstructionSet> {
    let level = Level::new().as_avx2()?.level();
    Some(InstructionSet { level, run })
}

fn run(level: Level, work: Work<'_, '_>) {
    if let Some(simd) = level.as_avx2() {
        simd.vectorize(
            #[inline(always)]
            || work.run(simd),
        );
    }
}
