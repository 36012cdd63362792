//! Volumes in somebody else's memory: nothing is copied, and the picture is the same.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::common;
use crate::counting::BYTES;
use glam::DVec3;
use splatvol::{Camera, Grid, Rescale, Samples, Scene, Storage, TransferFunction, View, Volume};
use splatvol_testing::alone;

const SIDE: usize = 256;

/// Memory such as a map of a file: it can be read, and it reports when it is dropped.
struct Buffer {
    samples: Vec<i16>,
    dropped: Arc<AtomicUsize>,
}

impl AsRef<[i16]> for Buffer {
    fn as_ref(&self) -> &[i16] {
        &self.samples
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        self.dropped.fetch_add(1, Ordering::Relaxed);
    }
}

fn samples(side: usize) -> Vec<i16> {
    let middle = side as i32 / 2;
    (0..side.pow(3))
        .map(|i| {
            let from_middle = |n: usize| (n as i32 - middle).pow(2);
            let squared =
                from_middle(i % side) + from_middle(i / side % side) + from_middle(i / (side * side));
            (1000 - 4 * squared / middle).clamp(-1000, 1000) as i16
        })
        .collect()
}

fn volume(side: usize, samples: Storage<i16>) -> Volume {
    let grid = Grid::centred([side; 3], DVec3::ONE).unwrap();
    Volume::new(
        grid,
        Samples::I16(samples),
        Rescale::default(),
        Default::default(),
    )
    .unwrap()
}

/// Both in one test: the allocator counts for all threads.
#[test]
fn shared_samples_are_neither_copied_nor_changed() {
    alone!();
    let dropped = Arc::new(AtomicUsize::new(0));
    let buffer = Arc::new(Buffer {
        samples: samples(SIDE),
        dropped: Arc::clone(&dropped),
    });
    let bytes = size_of_val(buffer.samples.as_slice());

    let before = BYTES.load(Ordering::Relaxed);
    let shared = volume(SIDE, Storage::shared(buffer.clone()));
    let clone = shared.clone();
    let more = BYTES.load(Ordering::Relaxed) - before;
    println!("a volume of {bytes} bytes of somebody else's memory takes {more} bytes more");
    // 1 GiB: less than 1 MiB.
    assert!(1024 * more < bytes, "{more} bytes allocated");
    assert_eq!(
        shared.statistics(),
        volume(SIDE, samples(SIDE).into()).statistics()
    );

    drop(buffer);
    drop(shared);
    assert_eq!(dropped.load(Ordering::Relaxed), 0, "a clone still reads it");
    drop(clone);
    assert_eq!(dropped.load(Ordering::Relaxed), 1);

    let own = volume(32, samples(32).into());
    let slice: Arc<[i16]> = samples(32).into();
    let shared = volume(32, slice.into());
    assert_eq!(own.samples(), shared.samples());
    let frames = [own, shared].map(|volume| {
        let camera =
            Camera::framing(&volume.grid().bounds(), View::Iso, common::PROJECTIONS[0], 1.0).unwrap();
        let look = TransferFunction::isosurface(400.0, 100.0, [0.9, 0.6, 0.3]).unwrap();
        common::render(&Scene::new(volume, look), &camera, &common::settings(48))
    });
    assert!(frames[0] == frames[1], "the same picture");
}
