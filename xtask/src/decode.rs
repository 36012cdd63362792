//! Analysis of a function's machine code.

use iced_x86::{Decoder, DecoderOptions, Mnemonic, OpKind, Register};

/// Vector instructions of a function, and where it calls or jumps to.
#[derive(Debug, Default)]
pub(crate) struct Found {
    /// Fused multiply-adds of sixteen floats.
    pub(crate) fused_512: usize,
    /// Fused multiply-adds of eight floats.
    pub(crate) fused_256: usize,
    /// Packed multiplications of four floats, with addition or without.
    pub(crate) packed_128: usize,
    pub(crate) targets: Vec<u64>,
}

/// Reads x86-64 code.
pub(crate) fn x86(code: &[u8], address: u64) -> Found {
    let mut found = Found::default();
    for instruction in Decoder::with_ip(64, code, address, DecoderOptions::NONE) {
        let register = instruction.op0_register();
        match instruction.mnemonic() {
            Mnemonic::Call | Mnemonic::Jmp if instruction.op0_kind() == OpKind::NearBranch64 => {
                found.targets.push(instruction.near_branch_target());
            }
            Mnemonic::Vfmadd132ps | Mnemonic::Vfmadd213ps | Mnemonic::Vfmadd231ps => {
                found.fused_512 += usize::from(is_within(register, Register::ZMM0, Register::ZMM31));
                found.fused_256 += usize::from(is_within(register, Register::YMM0, Register::YMM31));
            }
            Mnemonic::Mulps => found.packed_128 += 1,
            _ => {}
        }
    }
    found
}

fn is_within(register: Register, first: Register, last: Register) -> bool {
    (first as usize..=last as usize).contains(&(register as usize))
}

/// Reads aarch64 code: `fmla` of vectors, and branches (Arm Architecture Reference Manual, C4.1).
pub(crate) fn arm(code: &[u8], address: u64) -> Found {
    const FMLA: (u32, u32) = (0xbfa0_fc00, 0x0e20_cc00);
    const FMLA_BY_ELEMENT: (u32, u32) = (0xbf80_f400, 0x0f80_1000);
    const BRANCH: (u32, u32) = (0x7c00_0000, 0x1400_0000);
    let mut found = Found::default();
    for (i, word) in code.chunks_exact(4).enumerate() {
        let word = word
            .iter()
            .rev()
            .fold(0, |word, byte| word << 8 | u32::from(*byte));
        let is = |(mask, value): (u32, u32)| word & mask == value;
        if is(FMLA) || is(FMLA_BY_ELEMENT) {
            found.packed_128 += 1;
        } else if is(BRANCH) {
            // Twenty-six signed bits, of four bytes each.
            let offset = i64::from((word << 6) as i32 >> 4);
            let from = address + 4 * i as u64;
            found.targets.push(from.wrapping_add_signed(offset));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn x86_fused_multiply_adds_are_told_apart_by_width() {
        let code = [
            0x62, 0xf2, 0x75, 0x48, 0xb8, 0xc2, // vfmadd231ps zmm0, zmm1, zmm2
            0xc4, 0xe2, 0x75, 0xb8, 0xc2, // vfmadd231ps ymm0, ymm1, ymm2
            0xc4, 0xe2, 0x71, 0xb8, 0xc2, // vfmadd231ps xmm0, xmm1, xmm2
            0xc4, 0xe2, 0x71, 0xb9, 0xc2, // vfmadd231ss xmm0, xmm1, xmm2
            0x0f, 0x59, 0xc1, // mulps xmm0, xmm1
            0xe8, 0x10, 0x00, 0x00, 0x00, // call +16
        ];
        let found = x86(&code, 0x1000);
        assert_eq!((found.fused_512, found.fused_256, found.packed_128), (1, 1, 1));
        assert_eq!(found.targets, [0x1000 + code.len() as u64 + 16]);
    }

    #[test]
    fn arm_fused_multiply_adds_and_branches_are_found() {
        let words: [u32; 5] = [
            0x4e22_cc20, // fmla v0.4s, v1.4s, v2.4s
            0x4f82_1020, // fmla v0.4s, v1.4s, v2.s[0]
            0x1e22_0820, // fmul s0, s1, s2
            0x97ff_fffd, // bl -12
            0x1400_0004, // b +16
        ];
        let code: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        let found = arm(&code, 0x1000);
        assert_eq!(found.packed_128, 2);
        assert_eq!(found.targets, [0x1000, 0x1020]);
    }
}
