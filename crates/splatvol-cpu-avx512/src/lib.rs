//! The CPU engine's loops, compiled for AVX-512: the only code of this crate is [`splatvol_cpu::Work`]'s.
#![forbid(unsafe_code)]

use fearless_simd::{Level, Simd};
use splatvol_cpu::{InstructionSet, Work};

/// AVX-512; `None` where the processor lacks it.
pub fn instruction_set() -> Option<InstructionSet> {
    let level = Level::new().as_avx512()?.level();
    Some(InstructionSet { level, run })
}

fn run(level: Level, work: Work<'_, '_>) {
    if let Some(simd) = level.as_avx512() {
        simd.vectorize(
            #[inline(always)]
            || work.run(simd),
        );
    }
}
