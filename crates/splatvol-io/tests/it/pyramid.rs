//! OME-Zarr with levels of detail: what is written comes back, whatever the threads, and however often it was stopped.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;

use glam::{DMat3, DVec3};
use splatvol_io::{
    Compression, Description, OmeVersion, Opened, PyramidOptions, ReadOptions, open_volume, read_volume,
    write_pyramid,
};
use splatvol_scene::{ChunkBuffer, ChunkSource, ElementType, Grid, LengthUnit, Rescale, Samples, Volume};

fn options() -> PyramidOptions {
    PyramidOptions {
        chunk: 8,
        memory: 32 << 20,
        threads: 2,
        ..PyramidOptions::default()
    }
}

fn samples(element: ElementType, count: usize) -> Samples {
    let value = |i: usize| (i * 7919 % 253) as f64 / 2.0;
    macro_rules! of {
        ($($variant:ident)*) => {
            match element {
                $(ElementType::$variant => Samples::$variant((0..count).map(|i| value(i) as _).collect()),)*
            }
        };
    }
    of!(U8 I8 U16 I16 U32 I32 F32 F64)
}

fn volume(dims: [usize; 3], element: ElementType, plain: bool) -> Volume {
    let direction = if plain {
        DMat3::IDENTITY
    } else {
        DMat3::from_rotation_z(0.3)
    };
    let grid = Grid::new(
        dims,
        DVec3::new(3.0, -1.0, 0.1),
        DVec3::new(0.5, 1.0, 2.5),
        direction,
    )
    .unwrap();
    let rescale = match plain {
        true => Rescale::default(),
        false => Rescale {
            slope: 0.1,
            intercept: -7.0,
        },
    };
    Volume::new(
        grid,
        samples(element, dims.iter().product()),
        rescale,
        LengthUnit::Micrometre,
    )
    .unwrap()
}

fn opened(volume: &Volume) -> Opened {
    Opened {
        source: Box::<dyn ChunkSource>::from(Arc::new(volume.clone())).into(),
        unit: volume.unit(),
        is_divided: false,
        description: Description::default(),
    }
}

/// All files below a folder, and their bytes.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let name = entry.file_name().into_string().unwrap();
        match entry.file_type().unwrap().is_dir() {
            true => found.extend(
                files(&entry.path())
                    .into_iter()
                    .map(|(key, bytes)| (format!("{name}/{key}"), bytes)),
            ),
            false => drop(found.insert(name, std::fs::read(entry.path()).unwrap())),
        }
    }
    found
}

/// Levels of labels hold labels, and the image says so.
#[test]
fn labels_stay_labels() {
    let dims = [37, 20, 9];
    let labels: Vec<u16> = (0..dims.iter().product::<usize>())
        .map(|i| [0, 7, 1000][i * 7919 % 3])
        .collect();
    let of = volume(dims, ElementType::U16, true);
    let of = Volume::new(
        of.grid().clone(),
        Samples::U16(labels.into()),
        of.rescale(),
        of.unit(),
    )
    .unwrap();
    for version in [OmeVersion::V04, OmeVersion::V05] {
        for labels in [false, true] {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("a.ome.zarr");
            let options = PyramidOptions {
                version,
                labels,
                ..options()
            };
            let written = write_pyramid(&opened(&of), &path, &options, &|_| ()).unwrap();
            let at = |level| {
                let options = ReadOptions {
                    level,
                    ..ReadOptions::default()
                };
                read_volume(&path, &options).unwrap()
            };
            assert_eq!(at(0).volume.samples(), of.samples());
            for level in 1..written.levels.len() {
                let read = at(level);
                assert_eq!(read.description.is_labels, labels, "{version:?}");
                let Samples::U16(values) = read.volume.samples() else {
                    panic!("{:?}", read.volume.samples().type_name());
                };
                let all = values.iter().all(|value| [0, 7, 1000].contains(value));
                assert_eq!(all, labels, "{version:?} {level}");
            }
            let chunks = open_volume(&path, &ReadOptions::default()).unwrap().unwrap();
            assert_eq!(chunks.source.is_of_labels(), labels);
        }
    }
}

#[test]
fn every_type_comes_back_with_its_place() {
    for &element in ElementType::ALL {
        for (dims, plain) in [([37, 20, 9], true), ([1, 5, 40], false), ([16, 16, 16], false)] {
            for version in [OmeVersion::V04, OmeVersion::V05] {
                let folder = tempfile::tempdir().unwrap();
                let path = folder.path().join("a.ome.zarr");
                let before = volume(dims, element, plain);
                let options = PyramidOptions { version, ..options() };
                let written = write_pyramid(&opened(&before), &path, &options, &|_| ()).unwrap();
                assert_eq!(
                    (written.warnings.len(), written.resumed),
                    (if plain { 0 } else { 2 }, false)
                );
                let after = read_volume(&path, &ReadOptions::default()).unwrap();
                assert_eq!(
                    after.volume.samples(),
                    before.samples(),
                    "{element:?} {dims:?} {version:?}"
                );
                assert_eq!(after.volume.grid(), before.grid());
                assert_eq!(
                    (after.volume.rescale(), after.volume.unit()),
                    (before.rescale(), before.unit())
                );
                assert_eq!(after.description.levels, written.levels);
                for level in 1..written.levels.len() {
                    let options = ReadOptions {
                        level,
                        ..ReadOptions::default()
                    };
                    let coarse = read_volume(&path, &options).unwrap().volume;
                    for (a, b) in coarse.grid().corners().iter().zip(before.grid().corners()) {
                        assert!((*a - b).length() < 1e-9, "level {level}: {a} {b}");
                    }
                }
            }
        }
    }
}

#[test]
fn bytes_are_the_same_for_any_threads_memory_and_interruptions() {
    let folder = tempfile::tempdir().unwrap();
    let volume = opened(&volume([150, 37, 34], ElementType::U16, true));
    let write = |name: &str, threads: usize, memory: u64| {
        let path = folder.path().join(name);
        let options = PyramidOptions {
            threads,
            memory,
            ..options()
        };
        write_pyramid(&volume, &path, &options, &|_| ()).unwrap();
        files(&path)
    };
    let expected = write("a.ome.zarr", 1, 8 << 20);
    assert_eq!(write("b.ome.zarr", 7, 1 << 30), expected);
    let path = folder.path().join("c.ome.zarr");
    let one = PyramidOptions {
        threads: 1,
        ..options()
    };
    for stop in [0.1, 0.5, 0.9, 0.97] {
        // The work ends where it is told how far it is.
        let stopped = catch_unwind(AssertUnwindSafe(|| {
            write_pyramid(&volume, &path, &one, &|share| {
                assert!(share < stop, "stopped on purpose");
            })
        }));
        assert!(stopped.is_err() && !path.exists());
    }
    let other = PyramidOptions {
        compression: Compression::None,
        ..one.clone()
    };
    assert!(
        write_pyramid(&volume, &path, &other, &|_| ())
            .unwrap_err()
            .to_string()
            .contains("was begun here")
    );
    assert!(write_pyramid(&volume, &path, &one, &|_| ()).unwrap().resumed);
    assert_eq!(files(&path), expected);
    assert!(!folder.path().join("c.ome.zarr.partial").exists());
    assert!(
        write_pyramid(&volume, &path, &one, &|_| ())
            .unwrap_err()
            .to_string()
            .contains("exists already")
    );
    let again = PyramidOptions {
        overwrite: true,
        ..one.clone()
    };
    write_pyramid(&volume, &path, &again, &|_| ()).unwrap();
    assert_eq!(files(&path), expected);
    // Work that was begun is not continued by whoever overwrites it.
    let stopped = catch_unwind(AssertUnwindSafe(|| {
        write_pyramid(&volume, folder.path().join("d.ome.zarr"), &one, &|share| {
            assert!(share < 0.5, "stopped on purpose");
        })
    }));
    assert!(stopped.is_err());
    assert!(
        !write_pyramid(&volume, folder.path().join("d.ome.zarr"), &again, &|_| ())
            .unwrap()
            .resumed
    );
    let small = PyramidOptions {
        memory: 1 << 20,
        ..again
    };
    let error = write_pyramid(&volume, &path, &small, &|_| ())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("bytes are needed, the limit is 1048576"),
        "{error}"
    );
    // Nothing was done, and nothing is left.
    assert!(!folder.path().join("c.ome.zarr.partial").exists());
}

#[test]
fn chunks_are_read_alone_and_damage_names_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ome.zarr");
    let before = volume([40, 20, 9], ElementType::I16, true);
    write_pyramid(&opened(&before), &path, &options(), &|_| ()).unwrap();
    let source = open_volume(&path, &ReadOptions::default())
        .unwrap()
        .unwrap()
        .source;
    let mut buffer = ChunkBuffer::default();
    for (level, layout) in source.levels().iter().enumerate() {
        let [nx, ny, nz] = layout.counts();
        for i in (0..nx * ny * nz).rev() {
            let chunk = [i % nx, i / nx % ny, i / (nx * ny)];
            source.read(level, chunk, &mut buffer).unwrap();
            let Samples::I16(read) = &buffer.samples else {
                panic!()
            };
            let index = source.index(level).unwrap();
            let [low, high] = index.within(layout.region(chunk)).unwrap().map(f64::from);
            assert!(
                read.iter().all(|&value| (low..=high).contains(&f64::from(value))),
                "{level} {chunk:?}"
            );
        }
    }
    let shard = path.join("0/c/0/0/0");
    let bytes = std::fs::read(&shard).unwrap();
    let error = |damaged: Option<Vec<u8>>| {
        match damaged {
            Some(bytes) => std::fs::write(&shard, bytes).unwrap(),
            None => std::fs::remove_file(&shard).unwrap(),
        }
        let source = open_volume(&path, &ReadOptions::default())
            .unwrap()
            .unwrap()
            .source;
        let error = source
            .read(0, [0, 0, 0], &mut ChunkBuffer::default())
            .unwrap_err()
            .to_string();
        assert!(error.starts_with("level 0, chunk 0,0,0, key c/0/0/0"), "{error}");
        let whole = read_volume(&path, &ReadOptions::default())
            .unwrap_err()
            .to_string();
        assert!(whole.contains("level 0, chunk 0,0,0, key c/0/0/0"), "{whole}");
        error
    };
    let mut flipped = bytes.clone();
    flipped[3] ^= 4;
    assert!(error(Some(flipped)).contains("codec crc32c: a wrong checksum"));
    assert!(error(Some(bytes[..bytes.len() / 2].to_vec())).contains("crc32c"));
    assert!(error(None).contains("gone"));
}
