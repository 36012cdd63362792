//! The CPU engine's loops, compiled for the vectors that every processor of an architecture other than x86 has: NEON on 64-bit
//! ARM, simd128 in browsers, none elsewhere. The only code of this crate is [`splatvol_cpu::Work`]'s.
#![forbid(unsafe_code)]

use fearless_simd::{Level, dispatch};
use splatvol_cpu::{InstructionSet, Work};

/// The instruction set.
pub fn instruction_set() -> InstructionSet {
    InstructionSet {
        level: Level::baseline(),
        run,
    }
}

fn run(level: Level, work: Work<'_, '_>) {
    dispatch!(level, simd => work.run(simd));
}
