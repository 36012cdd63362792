//! Volumes that are read in chunks, on the GPU: the pixels of the same volume in memory.

use std::sync::Arc;

use splatvol::glam::{DAffine3, DVec3};
use splatvol::samples::{Sample, SampleSize};
use splatvol::{
    Budget, Camera, ChunkedVolume, Compositing, FlatSettings, Frame, Item, LengthUnit, Projection,
    RenderSettings, Scene, SceneError, TransferFunction, Volume,
};
use splatvol_gpu::GpuConfig;
use splatvol_testing::{Fault, Pieces, checked};

use crate::common::{gpu, gpu_of, sized};

/// Bytes that are enough for all of them.
const ENOUGH: u64 = 1 << 27;

/// A volume in chunks of 22 x 25 x 30 samples.
fn in_chunks(volume: &Arc<Volume>, memory: u64, fault: Fault) -> Arc<Volume> {
    let source = Arc::new(Pieces::new(Arc::clone(volume), [22, 25, 30], true, fault));
    let budget = (Budget::new(memory), false);
    let chunked = ChunkedVolume::new(source, LengthUnit::Unknown, budget).unwrap();
    Arc::new(Volume::clone(volume).over_chunks(chunked))
}

fn volume(sample: Sample, edge: usize) -> Arc<Volume> {
    Arc::new(sample.generate(Some(SampleSize::Longest(edge))).unwrap())
}

fn look(sample: Sample) -> TransferFunction {
    sample.default_transfer_function().unwrap()
}

fn camera(volume: &Volume, from: [f64; 3], distance: f64) -> Camera {
    wide(volume, from, (distance, 30.0))
}

fn wide(volume: &Volume, from: [f64; 3], (distance, fov_degrees): (f64, f64)) -> Camera {
    let bounds = volume.grid().bounds();
    let position = bounds.centre() + DVec3::from_array(from).normalize() * distance * bounds.diagonal();
    let perspective = Projection::Perspective { fov_degrees };
    Camera::new(position, bounds.centre(), DVec3::Z, perspective).unwrap()
}

fn settings(pixels: u32) -> FlatSettings {
    sized(RenderSettings::fast(), pixels).into()
}

fn assert_same(what: &str, a: &Frame, b: &Frame) {
    let seen = a.image.pixels.iter().any(|pixel| pixel[3] > 0.1);
    assert!(seen, "{what}");
    let bits = |frame: &Frame| {
        let colors = frame.image.pixels.iter().flatten();
        let all = colors.chain(&frame.depth).chain(&frame.optical_depth);
        all.map(|value| value.to_bits()).collect::<Vec<_>>()
    };
    assert_eq!(bits(a), bits(b), "{what}");
}

/// One scene or another with its volumes where they are put.
fn scene(of: &[(Arc<Volume>, Sample)], put: impl Fn(&Arc<Volume>) -> Arc<Volume>) -> Scene {
    let items = of
        .iter()
        .map(|(volume, sample)| Item::volume(put(volume), look(*sample)));
    Scene::of_items(items.collect()).unwrap()
}

#[test]
fn pictures_from_chunks_are_those_from_memory() {
    let Some(mut whole) = gpu() else {
        return;
    };
    let shells = (volume(Sample::Shells, 72), Sample::Shells);
    let ball = (volume(Sample::Ball, 60), Sample::Ball);
    let mut slices = Volume::clone(&volume(Sample::Shells, 32));
    let apart = DVec3::new(1.0, 1.0, 3.0);
    slices.transform(DAffine3::from_scale(apart)).unwrap();
    let slices = (Arc::new(slices), Sample::Shells);
    let seen = camera(&slices.0, [0.7, 1.0, 0.5], 1.3);
    let one = vec![shells.clone()];
    let near = camera(&shells.0, [0.3, 1.0, 0.2], 0.45);
    let far = camera(&shells.0, [0.7, 1.0, 0.5], 1.3);
    let cases = [
        ("a surface", one.clone(), far, settings(64)),
        // Most of the volume lies outside the picture.
        ("from near", one.clone(), near, settings(48)),
        (
            "levels behind each other",
            one.clone(),
            camera(&shells.0, [0.2, 1.0, 0.1], 0.2),
            FlatSettings {
                level_bias: 2.0,
                ..settings(48)
            },
        ),
        (
            "maxima",
            one,
            far,
            FlatSettings {
                compositing: Compositing::Mip,
                ..settings(48)
            },
        ),
        ("two volumes", vec![shells, ball], far, settings(48)),
        // Long voxels are refined.
        ("slices", vec![slices], seen, settings(48)),
    ];
    for (what, volumes, camera, flat) in cases {
        let settings = checked(flat);
        let expected = whole
            .render(&scene(&volumes, Arc::clone), &camera, &settings)
            .unwrap();
        let chunked = scene(&volumes, |volume| in_chunks(volume, ENOUGH, Fault::None));
        let mut own = gpu().unwrap();
        let found = own.render(&chunked, &camera, &settings).unwrap();
        assert_same(what, &expected, &found);
        let chunks = own.statistics().chunks;
        assert!(
            chunks.touched > 0 && chunks.planned_bytes <= ENOUGH,
            "{what}: {chunks:?}"
        );
        // Again, and by a budget of the device that has no room for all pages.
        let found = own.render(&chunked, &camera, &settings).unwrap();
        assert_same(what, &expected, &found);
        assert_eq!(own.statistics().chunks.reads, 0, "{what}");
        // Both have one budget.
        drop(own);
        let mut small = gpu_of(&GpuConfig {
            budget: Some(80 * 19usize.pow(3) * 4),
            ..GpuConfig::default()
        })
        .unwrap();
        let found = small.render(&chunked, &camera, &settings).unwrap();
        assert_same(what, &expected, &found);
    }
}

/// What another camera or look needs is brought, and nothing else is read.
#[test]
fn a_turned_camera_reads_what_it_lacks() {
    let (Some(mut whole), Some(mut own)) = (gpu(), gpu()) else {
        return;
    };
    let volume = volume(Sample::Shells, 192);
    let chunked = in_chunks(&volume, ENOUGH, Fault::None);
    let settings = checked(settings(48));
    let translucent = Sample::Ball.default_transfer_function().unwrap();
    let mut reads = Vec::new();
    for (from, look) in [
        ([0.3, 1.0, 0.2], look(Sample::Shells)),
        ([0.9, 1.0, 0.2], look(Sample::Shells)),
        ([0.9, 1.0, 0.2], translucent),
        ([0.3, 1.0, 0.2], look(Sample::Shells)),
    ] {
        let camera = wide(&volume, from, (1.0, 8.0));
        let of = |volume: &Arc<Volume>| Scene::new(Arc::clone(volume), look.clone());
        let expected = whole.render(&of(&volume), &camera, &settings).unwrap();
        let found = own.render(&of(&chunked), &camera, &settings).unwrap();
        assert_same("a turned camera", &expected, &found);
        reads.push(own.statistics().chunks.reads);
    }
    assert!(reads[0] > 0 && reads[1] > 0 && reads[1] < reads[0], "{reads:?}");
}

/// What this engine does not draw from chunks is refused, and what cannot be read is an error, by name.
#[test]
fn what_cannot_be_drawn_or_read_is_named() {
    let Some(mut own) = gpu() else {
        return;
    };
    let volume = volume(Sample::Shells, 72);
    let camera = camera(&volume, [0.7, 1.0, 0.5], 1.3);
    let mut of = |memory, fault, flat| -> SceneError {
        let scene = Scene::new(in_chunks(&volume, memory, fault), look(Sample::Shells));
        own.render(&scene, &camera, &checked(flat)).unwrap_err()
    };
    let xray = FlatSettings {
        compositing: Compositing::Xray,
        ..settings(16)
    };
    let error = of(ENOUGH, Fault::None, xray).to_string();
    assert!(error.contains("classified first"), "{error}");
    let error = of(ENOUGH, Fault::Lost, settings(16)).to_string();
    assert!(error.contains("c/2/2/2"), "{error}");
    let error = of(1 << 20, Fault::None, settings(16)).to_string();
    assert!(error.contains("too few for this picture: it takes "), "{error}");
    // The engine is as it was.
    let scene = Scene::new(in_chunks(&volume, ENOUGH, Fault::None), look(Sample::Shells));
    own.render(&scene, &camera, &checked(settings(16))).unwrap();
}
