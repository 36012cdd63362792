//! Volumes that are read in chunks: the pixels of the same volume in memory, whatever memory, blocks and threads.

use std::sync::Arc;

use glam::DVec3;
use splatvol::{
    Budget, Camera, ChunkedVolume, ColorPoint, Compositing, EngineConfig, FlatSettings, Frame, ImageSize,
    Item, LengthUnit, OpacityPoint, Projection, RenderSettings, RenderStatistics, Renderer, Scene,
    SceneError, TransferFunction, Volume,
};
use splatvol_samples::{Sample, SampleSize};
use splatvol_testing::{Fault, Pieces, checked};

/// Volumes, looks, a camera and settings.
struct Case {
    name: &'static str,
    volumes: Vec<(Arc<Volume>, TransferFunction)>,
    camera: Camera,
    settings: RenderSettings,
}

fn shells() -> Arc<Volume> {
    Arc::new(Sample::Shells.generate(Some(SampleSize::Longest(72))).unwrap())
}

/// Slices three times as far apart as samples within them: their long voxels are refined.
fn slices() -> Arc<Volume> {
    let mut volume = Sample::Shells.generate(Some(SampleSize::Longest(40))).unwrap();
    let apart = DVec3::new(1.0, 1.0, 3.0);
    volume.transform(glam::DAffine3::from_scale(apart)).unwrap();
    Arc::new(volume)
}

/// A ramp of opacity between shares of the values' range.
fn look(volume: &Volume, ends: [f64; 2], opacity: f64) -> TransferFunction {
    let [low, high] = volume.value_range();
    let at = |share: f64| low + share * (high - low);
    let colors = vec![
        ColorPoint::new(at(0.2), [0.2, 0.5, 0.9]),
        ColorPoint::new(at(0.8), [1.0, 0.8, 0.4]),
    ];
    let opacities = vec![
        OpacityPoint::new(at(ends[0]), 0.0),
        OpacityPoint::new(at(ends[1]), opacity),
    ];
    TransferFunction::new(colors, opacities, None).unwrap()
}

fn camera(volume: &Volume, from: DVec3, distance: f64, projection: Projection) -> Camera {
    let bounds = volume.grid().bounds();
    let position = bounds.centre() + from.normalize() * distance * bounds.diagonal();
    Camera::new(position, bounds.centre(), DVec3::Z, projection).unwrap()
}

const PERSPECTIVE: Projection = Projection::Perspective { fov_degrees: 30.0 };

/// Eight scenes: opaque, translucent, maxima, X-ray, that of two volumes, two volumes, from close by, slices.
fn cases() -> Vec<Case> {
    let (volume, slices) = (shells(), slices());
    let other = Arc::new(Sample::Ball.generate(Some(SampleSize::Longest(60))).unwrap());
    let base = RenderSettings {
        size: ImageSize::new(176, 144).unwrap(),
        ..RenderSettings::fast()
    };
    let composited = |compositing| {
        checked(FlatSettings {
            compositing,
            ..base.into()
        })
    };
    let whole = |projection| camera(&volume, DVec3::new(0.7, 1.0, 0.5), 1.3, projection);
    let height = volume.grid().bounds().diagonal();
    let one = |ends, opacity| vec![(Arc::clone(&volume), look(&volume, ends, opacity))];
    let two = vec![
        (Arc::clone(&volume), look(&volume, [0.5, 0.9], 0.1)),
        (Arc::clone(&other), look(&other, [0.4, 0.9], 0.2)),
    ];
    let case = |name, volumes, camera, settings| Case {
        name,
        volumes,
        camera,
        settings,
    };
    vec![
        case("opaque", one([0.3, 0.4], 0.98), whole(PERSPECTIVE), base),
        case(
            "translucent",
            one([0.2, 0.9], 0.05),
            whole(Projection::Orthographic { height }),
            base,
        ),
        case(
            "maxima",
            one([0.2, 0.9], 0.5),
            whole(PERSPECTIVE),
            composited(Compositing::Mip),
        ),
        case(
            "X-ray",
            one([0.3, 0.9], 0.1),
            whole(PERSPECTIVE),
            composited(Compositing::Xray),
        ),
        case(
            "X-ray of two volumes",
            two.clone(),
            whole(PERSPECTIVE),
            composited(Compositing::Xray),
        ),
        case("two volumes", two, whole(PERSPECTIVE), base),
        case(
            "close",
            one([0.4, 0.8], 0.3),
            camera(
                &volume,
                DVec3::new(0.2, 1.0, 0.1),
                0.2,
                Projection::Perspective { fov_degrees: 70.0 },
            ),
            // Three levels behind each other, as in a picture of a quarter of the size.
            checked(FlatSettings {
                level_bias: 2.0,
                ..base.into()
            }),
        ),
        case(
            "slices",
            vec![(Arc::clone(&slices), look(&slices, [0.3, 0.6], 0.4))],
            camera(&slices, DVec3::new(0.7, 1.0, 0.5), 1.3, PERSPECTIVE),
            base,
        ),
    ]
}

impl Case {
    fn scene(&self, place: impl Fn(&Arc<Volume>) -> Arc<Volume>) -> Scene {
        let item =
            |(volume, look): &(Arc<Volume>, TransferFunction)| Item::volume(place(volume), look.clone());
        Scene::of_items(self.volumes.iter().map(item).collect()).unwrap()
    }

    /// The picture from memory.
    fn expected(&self) -> Frame {
        let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
        renderer
            .render(&self.scene(Arc::clone), &self.camera, &self.settings)
            .unwrap()
    }

    /// The picture from chunks.
    fn chunked(&self, memory: u64, with: With) -> Result<(Frame, RenderStatistics), SceneError> {
        let scene = self.scene(|volume| in_chunks(volume, memory, with));
        let config = EngineConfig {
            threads: Some(with.threads),
            tile_edge: Some(with.tile_edge),
            ..EngineConfig::default()
        };
        let mut renderer = Renderer::new(config).unwrap();
        let frame = renderer.render(&scene, &self.camera, &self.settings)?;
        Ok((frame, renderer.statistics().clone()))
    }

    /// The least memory that is enough for each volume, and the picture by it.
    fn smallest(&self, with: With) -> (u64, Frame, RenderStatistics) {
        let mut memory = 1 << 15;
        loop {
            match self.chunked(memory, with) {
                Ok((frame, statistics)) => return (memory, frame, statistics),
                Err(error) => {
                    let error = error.to_string();
                    let (_, says) = error.split_once("it takes ").expect("says what it takes");
                    let takes = says.split_whitespace().next().unwrap().parse().unwrap();
                    assert!(takes > memory, "{error}");
                    memory = takes;
                }
            }
        }
    }
}

#[derive(Clone, Copy)]
struct With {
    threads: usize,
    tile_edge: usize,
    chunk: [usize; 3],
    /// Whether bounds and spread samples are known without reading.
    index: bool,
    /// Whether the overview is a few of the samples, not all.
    thinned: bool,
    fault: Fault,
}

const USUAL: With = With {
    threads: 2,
    tile_edge: 32,
    chunk: [16; 3],
    index: true,
    thinned: false,
    fault: Fault::None,
};

/// A volume that is read in chunks, within so many bytes.
fn in_chunks(volume: &Arc<Volume>, memory: u64, with: With) -> Arc<Volume> {
    let source = Pieces::new(Arc::clone(volume), with.chunk, with.index, with.fault);
    let holes = with.fault == Fault::Hole;
    let chunked = ChunkedVolume::new(
        Arc::new(source),
        LengthUnit::Unknown,
        (Budget::new(memory), holes),
    )
    .unwrap();
    Arc::new(match with.thinned {
        true => chunked.over(0, 4096).unwrap(),
        false => Volume::clone(volume).over_chunks(chunked),
    })
}

fn assert_same(name: &str, a: &Frame, b: &Frame) {
    let differing = a.image.pixels.iter().zip(&b.image.pixels).filter(|(a, b)| a != b);
    assert_eq!(differing.count(), 0, "{name}");
    assert!(
        a.depth
            .iter()
            .zip(&b.depth)
            .all(|(a, b)| a.to_bits() == b.to_bits()),
        "{name}"
    );
    assert_eq!(a.optical_depth, b.optical_depth, "{name}");
}

#[test]
fn pixels_depend_on_neither_memory_blocks_nor_threads() {
    for case in cases() {
        let expected = case.expected();
        assert!(
            expected.image.pixels.iter().any(|pixel| pixel[3] > 0.1),
            "{}",
            case.name
        );
        let check = |memory: u64, with: With, (found, statistics): (&Frame, &RenderStatistics)| {
            let With {
                threads, tile_edge, ..
            } = with;
            let name = format!(
                "{}, {memory} bytes, {threads} threads, tiles of {tile_edge}",
                case.name
            );
            assert_same(&name, &expected, found);
            let chunks = statistics.chunks;
            assert!(
                chunks.touched > 0 && chunks.touched <= chunks.all,
                "{name}: {chunks:?}"
            );
            assert!(chunks.planned_bytes <= memory, "{name}: {chunks:?}");
        };
        let (least, found, statistics) = case.smallest(USUAL);
        check(least, USUAL, (&found, &statistics));
        for (memory, threads, tile_edge) in [(2 * least, 1, 16), (10 * least, 7, 64), (10 * least, 2, 128)] {
            let with = With {
                threads,
                tile_edge,
                ..USUAL
            };
            let (found, statistics) = case.chunked(memory, with).unwrap();
            check(memory, with, (&found, &statistics));
        }
    }
}

#[test]
fn pixels_do_not_depend_on_chunks_or_on_what_is_known_of_them() {
    let cases = cases();
    for (case, chunk, index) in [
        (&cases[0], [72, 8, 1], false),
        (&cases[1], [31, 17, 23], false),
        (&cases[2], [9, 72, 40], true),
        (&cases[3], [31, 17, 23], true),
        (&cases[5], [64; 3], false),
        (&cases[7], [40, 17, 1], false),
        (&cases[7], [31, 17, 23], true),
    ] {
        let with = With {
            chunk,
            index,
            ..USUAL
        };
        let (found, _) = case.chunked(1 << 28, with).unwrap();
        assert_same(case.name, &case.expected(), &found);
    }
}

/// A larger volume, since a chunk of the field reads samples around it; seen small.
fn large(ends: [f64; 2], opacity: f64, part: Option<splatvol::TileRect>) -> (Frame, RenderStatistics) {
    let volume = Arc::new(Sample::Ball.generate(Some(SampleSize::Longest(176))).unwrap());
    let settings = RenderSettings {
        size: ImageSize::new(224, 224).unwrap(),
        ..RenderSettings::fast()
    };
    let with = With {
        chunk: [22; 3],
        ..USUAL
    };
    let scene = Scene::new(in_chunks(&volume, 1 << 30, with), look(&volume, ends, opacity));
    let camera = camera(&volume, DVec3::new(0.1, 1.0, 0.1), 1.0, PERSPECTIVE);
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    let control = splatvol::Control {
        part,
        ..splatvol::Control::default()
    };
    let mut frame = Frame::empty(settings.size);
    renderer
        .render_with(&scene, &camera, &settings, &mut frame, &control)
        .unwrap();
    (frame, renderer.statistics().clone())
}

/// Levels that a source lacks are made of its own: in memory where they are small, else chunk by chunk.
#[test]
fn levels_are_made_as_pictures_need_them() {
    let volume = Arc::new(Sample::Ball.generate(Some(SampleSize::Longest(259))).unwrap());
    let base = RenderSettings {
        size: ImageSize::new(256, 160).unwrap(),
        ..RenderSettings::fast()
    };
    let biased = |compositing, level_bias| {
        checked(FlatSettings {
            compositing,
            level_bias,
            ..base.into()
        })
    };
    for (compositing, level_bias, level) in [
        (Compositing::ImageSheets, 0.0, 1),
        (Compositing::Mip, 0.0, 1),
        (Compositing::ImageSheets, 1.0, 2),
    ] {
        let case = Case {
            name: "made",
            volumes: vec![(Arc::clone(&volume), look(&volume, [0.2, 0.7], 0.2))],
            camera: camera(&volume, DVec3::new(0.7, 1.0, 0.5), 1.5, PERSPECTIVE),
            settings: biased(compositing, level_bias),
        };
        let expected = case.expected();
        let with = With {
            chunk: [22, 25, 30],
            thinned: true,
            ..USUAL
        };
        let (least, found, statistics) = case.smallest(with);
        assert_eq!(statistics.level, level);
        // A quarter of the memory holds no half of it, with its coefficients.
        assert!(least / 4 < 130 * 130 * 130 * 6, "{least}");
        assert_same("made in chunks", &expected, &found);
        let (found, _) = case.chunked(1 << 30, with).unwrap();
        assert_same("made in memory", &expected, &found);
    }
    // Classes are made in memory, or not at all.
    let case = Case {
        name: "classes",
        volumes: vec![(Arc::clone(&volume), look(&volume, [0.2, 0.7], 0.2))],
        camera: camera(&volume, DVec3::new(0.7, 1.0, 0.5), 1.5, PERSPECTIVE),
        settings: biased(Compositing::Xray, 0.0),
    };
    let with = With {
        thinned: true,
        ..USUAL
    };
    let error = case.chunked(40 << 20, with).unwrap_err().to_string();
    assert!(error.contains("classified first"), "{error}");
}

#[test]
fn hidden_chunks_and_those_of_other_parts_are_not_read() {
    let share = |statistics: &RenderStatistics| {
        let chunks = statistics.chunks;
        assert_eq!(chunks.most_reads, 1, "{chunks:?}");
        chunks.touched as f64 / chunks.all as f64
    };
    let (_, opaque) = large([0.1, 0.15], 0.99, None);
    let (whole, translucent) = large([0.1, 0.9], 0.01, None);
    let [hidden, all] = [&opaque, &translucent].map(share);
    assert!(hidden < 0.9 * all, "{hidden} of {all}");
    let part = splatvol::TileRect {
        x0: 50,
        y0: 40,
        x1: 70,
        y1: 61,
    };
    let (frame, statistics) = large([0.1, 0.9], 0.01, Some(part));
    assert!(share(&statistics) < 0.8, "{:?}", statistics.chunks);
    let width = frame.image.size().width() as usize;
    for (i, (pixel, whole)) in frame.image.pixels.iter().zip(&whole.image.pixels).enumerate() {
        let (x, y) = (i % width, i / width);
        let inside = (part.x0..part.x1).contains(&x) && (part.y0..part.y1).contains(&y);
        assert_eq!(*pixel, if inside { *whole } else { [0.0; 4] }, "{x} {y}");
    }
}

#[test]
fn looks_and_cameras_change_without_traces() {
    let case = &cases()[0];
    let (volume, first) = &case.volumes[0];
    let second = look(volume, [0.5, 0.9], 0.2);
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    let mut expected = Renderer::new(EngineConfig::default()).unwrap();
    let chunked = in_chunks(volume, 1 << 25, USUAL);
    let turned = camera(volume, DVec3::new(1.0, 0.2, 0.6), 1.4, PERSPECTIVE);
    for (look, camera) in [
        (first, &case.camera),
        (&second, &case.camera),
        (&second, &turned),
        (first, &turned),
    ] {
        let [found, expected] =
            [(&mut renderer, &chunked), (&mut expected, volume)].map(|(renderer, volume)| {
                let scene = Scene::new(Arc::clone(volume), look.clone());
                renderer.render(&scene, camera, &case.settings).unwrap()
            });
        assert_same("look and camera", &expected, &found);
    }
}

#[test]
fn a_picture_that_is_made_again_solves_nothing() {
    let mut blended = 0;
    for case in cases() {
        let scene = case.scene(|volume| in_chunks(volume, 1 << 27, USUAL));
        for size in [[176, 144], [90, 70], [61, 50]] {
            let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
            let settings = RenderSettings {
                size: ImageSize::new(size[0], size[1]).unwrap(),
                ..case.settings
            };
            let mut solved = || {
                renderer.render(&scene, &case.camera, &settings).unwrap();
                let statistics = renderer.statistics();
                (statistics.solved_bricks, statistics.levels)
            };
            let (first, levels) = solved();
            blended += usize::from(levels == 2 && first > 0);
            // More levels than two need not have room beside each other.
            if levels <= 2 {
                assert_eq!(solved(), (0, levels), "{} at {size:?}", case.name);
            }
        }
    }
    assert!(blended > 2, "levels are blended somewhere");
}

#[test]
fn faults_name_their_place_and_holes_are_counted() {
    let case = &cases()[1];
    let with = |fault| With { fault, ..USUAL };
    let error = case.chunked(1 << 30, with(Fault::Lost)).unwrap_err().to_string();
    for part in [
        "level 0",
        "chunk 2,2,2",
        "key c/2/2/2",
        "from byte 96",
        "codec blosc",
        "gone",
    ] {
        assert!(error.contains(part), "{part}: {error}");
    }
    let (frame, statistics) = case.chunked(1 << 30, with(Fault::Hole)).unwrap();
    assert_eq!(statistics.chunks.holes, 1);
    assert_ne!(frame.image.pixels, case.expected().image.pixels);
    let error = case.chunked(1 << 16, USUAL).unwrap_err().to_string();
    assert!(error.contains("too few") && error.contains("it takes"), "{error}");
}

#[test]
fn methods_that_need_all_samples_refuse_chunks_and_take_them_in_memory() {
    let case = &cases()[0];
    let scene = case.scene(|volume| in_chunks(volume, 1 << 30, USUAL));
    let footprints = checked(FlatSettings {
        compositing: Compositing::PerSplat,
        classification: splatvol::Classification::Pre,
        ..case.settings.into()
    });
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    let error = renderer.render(&scene, &case.camera, &footprints).unwrap_err();
    assert!(error.to_string().contains("read in chunks"), "{error}");
    assert!(scene.reads_chunks());
    let scene = scene.in_memory().unwrap();
    assert!(!scene.reads_chunks());
    let found = renderer.render(&scene, &case.camera, &footprints).unwrap();
    let expected = renderer
        .render(&case.scene(Arc::clone), &case.camera, &footprints)
        .unwrap();
    assert_same("in memory", &expected, &found);
}
