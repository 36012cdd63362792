//! Sort: keys with values, stably, by digits of seven bits; and running sums.
//!
//! Counts of digits per block of 1,024 keys, their running sums, and a scatter: three dispatches that wait for nothing but
//! the one before. So the result does not depend on the order in which a device runs workgroups.

use bytemuck::{Pod, Zeroable};

use crate::device::GpuDevice;
use crate::pass::{Pass, groups, numbers, uniform};

pub(crate) const RADIX: &str = include_str!("../shaders/sort/radix.wgsl");
pub(crate) const SCAN: &str = include_str!("../shaders/sort/scan.wgsl");
/// Lists of pairs; passes that make them add their own entry points.
pub(crate) const LISTS: &str = include_str!("../shaders/sort/lists.wgsl");

/// Keys, or numbers, of a workgroup.
const BLOCK: u32 = 1024;
/// Bits of a digit: `DIGIT_BITS` in WGSL.
const DIGIT: u32 = 7;

/// A digit to sort by: `Digit` in WGSL.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct DigitData {
    pub count: u32,
    pub shift: u32,
    pub blocks: u32,
    pub unused: u32,
}

/// Sizes of lists: `Lists` in WGSL.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct ListsData {
    pub splats: u32,
    pub pairs: u32,
    pub columns: u32,
    pub per_tile: u32,
}

/// Numbers to add up: `Scan` in WGSL.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct ScanData {
    pub count: u32,
    pub unused: [u32; 3],
}

/// Running sums, each without its own number.
#[derive(Debug)]
pub(crate) struct Scanner {
    scan_blocks: Pass,
    add_blocks: Pass,
}

impl Scanner {
    pub(crate) fn new(gpu: &GpuDevice) -> Self {
        Self {
            scan_blocks: Pass::new(gpu, ("scan_blocks", SCAN), &[]),
            add_blocks: Pass::new(gpu, ("add_blocks", SCAN), &[]),
        }
    }

    /// Replaces each of the first `count` numbers of a buffer by the sum of those before it.
    pub(crate) fn run(
        &self,
        gpu: &GpuDevice,
        commands: &mut wgpu::CommandEncoder,
        (buffer, count): (&wgpu::Buffer, u32),
    ) {
        let blocks = count.div_ceil(BLOCK);
        let sums = numbers(gpu, "sums of blocks", blocks);
        let data = uniform(
            gpu,
            &ScanData {
                count,
                unused: [0; 3],
            },
        );
        let bound = [(0, &data), (1, buffer), (2, &sums)];
        self.scan_blocks.run(gpu, commands, &bound, groups(count, BLOCK));
        if blocks > 1 {
            self.run(gpu, commands, (&sums, blocks));
            self.add_blocks.run(gpu, commands, &bound, groups(count, BLOCK));
        }
    }
}

/// Keys and their values, with room to sort them.
#[derive(Debug)]
pub(crate) struct Pairs {
    pub keys: wgpu::Buffer,
    pub values: wgpu::Buffer,
    other: [wgpu::Buffer; 2],
    pub count: u32,
}

impl Pairs {
    pub(crate) fn new(gpu: &GpuDevice, count: u32) -> Self {
        let [keys, values, a, b] =
            ["keys", "values", "sorted keys", "sorted values"].map(|label| numbers(gpu, label, count));
        Self {
            keys,
            values,
            other: [a, b],
            count,
        }
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> usize {
        16 * self.count as usize
    }
}

/// Sorts pairs.
#[derive(Debug)]
pub(crate) struct Sorter {
    count: Pass,
    scatter: Pass,
    pub scanner: Scanner,
}

impl Sorter {
    pub(crate) fn new(gpu: &GpuDevice) -> Self {
        Self {
            count: Pass::new(gpu, ("count", RADIX), &[]),
            scatter: Pass::new(gpu, ("scatter", RADIX), &[]),
            scanner: Scanner::new(gpu),
        }
    }

    /// Sorts by the lowest `bits` of the keys; equal keys stay in their order.
    pub(crate) fn run(
        &self,
        gpu: &GpuDevice,
        commands: &mut wgpu::CommandEncoder,
        (pairs, bits): (&mut Pairs, u32),
    ) {
        let blocks = pairs.count.div_ceil(BLOCK);
        if blocks == 0 {
            return;
        }
        let counts = numbers(gpu, "counts of digits", blocks << DIGIT);
        for shift in (0..bits).step_by(DIGIT as usize) {
            let data = uniform(
                gpu,
                &DigitData {
                    count: pairs.count,
                    shift,
                    blocks,
                    unused: 0,
                },
            );
            let dispatched = groups(pairs.count, BLOCK);
            let [other_keys, other_values] = &pairs.other;
            let read = [(0, &data), (1, &pairs.keys), (3, &counts)];
            self.count.run(gpu, commands, &read, dispatched);
            self.scanner.run(gpu, commands, (&counts, blocks << DIGIT));
            let all = [
                (0, &data),
                (1, &pairs.keys),
                (2, &pairs.values),
                (3, &counts),
                (4, other_keys),
                (5, other_values),
            ];
            self.scatter.run(gpu, commands, &all, dispatched);
            let [other_keys, other_values] = &mut pairs.other;
            std::mem::swap(&mut pairs.keys, other_keys);
            std::mem::swap(&mut pairs.values, other_values);
        }
    }
}
