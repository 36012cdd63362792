//! Sorting and running sums on the device against the standard library's.

use splatvol_testing::random::Random;

use super::{device, read};
use crate::pass::numbers;
use crate::sort::{Pairs, Scanner, Sorter};

#[test]
fn keys_are_sorted_as_the_standard_library_sorts_them() {
    let Some(gpu) = device() else { return };
    let sorter = Sorter::new(&gpu);
    let mut random = Random::new(18);
    // Few different keys: equal ones must stay in order.
    for (count, bits) in [
        (0, 32),
        (1, 32),
        (1023, 6),
        (1024, 32),
        (1025, 9),
        (70_000, 3),
        (3_000_000, 32),
    ] {
        let mask = if bits == 32 { u32::MAX } else { (1 << bits) - 1 };
        let keys: Vec<u32> = (0..count).map(|_| random.bits() as u32 & mask).collect();
        let values: Vec<u32> = (0..count).map(|_| random.bits() as u32).collect();
        let mut pairs = Pairs::new(&gpu, count);
        let mut commands = gpu.commands();
        gpu.queue
            .write_buffer(&pairs.keys, 0, bytemuck::cast_slice(&keys));
        gpu.queue
            .write_buffer(&pairs.values, 0, bytemuck::cast_slice(&values));
        gpu.scoped(|gpu| sorter.run(gpu, &mut commands, (&mut pairs, bits)))
            .unwrap();
        gpu.queue.submit([commands.finish()]);
        let mut wanted: Vec<(u32, u32)> = keys.into_iter().zip(values).collect();
        wanted.sort_by_key(|(key, _)| *key);
        let (wanted_keys, wanted_values): (Vec<u32>, Vec<u32>) = wanted.into_iter().unzip();
        let count = count as usize;
        assert!(
            read::<u32>(&gpu, &pairs.keys, count) == wanted_keys,
            "{count} keys"
        );
        assert!(
            read::<u32>(&gpu, &pairs.values, count) == wanted_values,
            "{count} values"
        );
    }
}

#[test]
fn running_sums_leave_out_their_own_number() {
    let Some(gpu) = device() else { return };
    let scanner = Scanner::new(&gpu);
    let mut random = Random::new(5);
    for count in [1usize, 1024, 1025, 1_100_000] {
        let own: Vec<u32> = (0..count).map(|_| random.bits() as u32 % 3000).collect();
        let buffer = numbers(&gpu, "numbers", count as u32);
        gpu.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&own));
        let mut commands = gpu.commands();
        gpu.scoped(|gpu| scanner.run(gpu, &mut commands, (&buffer, count as u32)))
            .unwrap();
        gpu.queue.submit([commands.finish()]);
        let wanted: Vec<u32> = own
            .iter()
            .scan(0, |sum, number| {
                *sum += number;
                Some(*sum - number)
            })
            .collect();
        assert!(read::<u32>(&gpu, &buffer, count) == wanted, "{count}");
    }
}
