//! Samples that lie uncompressed in one file, read box by box: those of the same file in memory.

mod cases;
mod packed;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use cases::{Case, DIMS, bytes, cases, vector_cases, write};
use packed::packed_cases;
use splatvol_io::{Opened, PyramidOptions, ReadOptions, open_volume, read_volume, write_pyramid};
use splatvol_scene::{ChunkBuffer, ChunkSource, Samples, SourceError, VoxelBox};

#[test]
fn boxes_hold_what_the_file_holds_in_memory() {
    let folder = tempfile::tempdir().unwrap();
    let all = cases(folder.path())
        .into_iter()
        .chain(vector_cases(folder.path()));
    for Case { path, options } in all {
        let name = path.display();
        let memory = read_volume(&path, &options).unwrap_or_else(|error| panic!("{name}: {error}"));
        let opened = open_volume(&path, &options)
            .unwrap()
            .unwrap_or_else(|| panic!("{name} is not opened"));
        assert_eq!(opened.description, memory.description, "{name}");
        assert_eq!(opened.unit, memory.volume.unit(), "{name}");
        let layout = opened.source.levels()[0].clone();
        assert_eq!(layout.grid, *memory.volume.grid(), "{name}");
        assert_eq!(layout.rescale, memory.volume.rescale(), "{name}");
        let (mut buffer, mut found) = (ChunkBuffer::default(), Samples::U8(Vec::new().into()));
        let whole = VoxelBox::whole(&layout.grid);
        splatvol_scene::chunks::read_by_chunks(&*opened.source, 0, whole, &mut found, &mut buffer).unwrap();
        assert!(found == *memory.volume.samples(), "{name}: chunks");
        opened
            .source
            .read_region(0, whole, &mut found, &mut buffer)
            .unwrap();
        assert!(found == *memory.volume.samples(), "{name}: whole");
        let part = VoxelBox {
            first: [3, 5, 30],
            size: [290, 7, 5],
        };
        opened
            .source
            .read_region(0, part, &mut found, &mut buffer)
            .unwrap();
        let mut expected = layout.element.filled(part.len(), 0.0);
        splatvol_scene::chunks::copy_box(memory.volume.samples(), whole, &mut expected, part);
        assert!(found == expected, "{name}: part");
    }
}

/// The files of a folder and of those in it, with their bytes.
fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut all = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            match path.is_dir() {
                true => folders.push(path),
                false => all.push((
                    path.strip_prefix(folder).unwrap().to_owned(),
                    std::fs::read(&path).unwrap(),
                )),
            }
        }
    }
    all.sort();
    all
}

#[test]
fn pyramids_of_flat_files_are_those_of_volumes_in_memory() {
    let folder = tempfile::tempdir().unwrap();
    for (n, Case { path, options }) in cases(folder.path()).into_iter().enumerate() {
        let opened = open_volume(&path, &options).unwrap().unwrap();
        let loaded = read_volume(&path, &options).unwrap();
        let in_memory = Opened {
            unit: loaded.volume.unit(),
            is_divided: false,
            description: loaded.description,
            source: Box::<dyn ChunkSource>::from(Arc::new(loaded.volume)).into(),
        };
        let write = |volume: &Opened, name: &str, memory: u64| {
            let output = folder.path().join(format!("{n}-{name}.ome.zarr"));
            let pyramid = PyramidOptions {
                chunk: 16,
                memory,
                ..PyramidOptions::default()
            };
            write_pyramid(volume, &output, &pyramid, &|_| ()).unwrap();
            files(&output)
        };
        let expected = write(&in_memory, "memory", 1 << 30);
        assert!(write(&opened, "flat", 16 << 20) == expected, "{}", path.display());
    }
}

#[test]
fn short_files_are_refused_and_those_that_shrink_are_named() {
    let folder = tempfile::tempdir().unwrap();
    for Case { path, options } in cases(folder.path()) {
        let file = match path.extension().and_then(|extension| extension.to_str()) {
            Some("nhdr") => folder.path().join("detached.raw"),
            Some("mhd") => folder.path().join("detached.zraw"),
            _ => path.clone(),
        };
        let whole = std::fs::read(&file).unwrap();
        let opened = open_volume(&path, &options).unwrap().unwrap();
        std::fs::write(&file, &whole[..whole.len() - 1000]).unwrap();
        let layout = opened.source.levels()[0].clone();
        let last = layout.counts().map(|count| count - 1);
        let error = opened
            .source
            .read(0, last, &mut ChunkBuffer::default())
            .unwrap_err();
        assert!(matches!(error, SourceError::Corrupt(_)), "{error}");
        let text = error.to_string();
        let name = file.file_name().unwrap().to_str().unwrap();
        assert!(text.contains(name) && text.contains("from byte"), "{text}");
        let error = open_volume(&path, &options).unwrap_err().to_string();
        assert!(error.contains(&*path.display().to_string()), "{error}");
        std::fs::write(&file, whole).unwrap();
    }
}

#[test]
fn texts_of_other_lengths_are_told_when_they_are_unpacked() {
    let folder = tempfile::tempdir().unwrap();
    let options = ReadOptions {
        unpack_in: Some(folder.path().to_owned()),
        ..ReadOptions::default()
    };
    let header = "NRRD0004\ntype: int16\ndimension: 3\nsizes: 2 2 2\nencoding: ascii\n\n";
    let of = |numbers: &str| write(folder.path(), "a.nrrd", &[header.as_bytes(), numbers.as_bytes()]);
    for (numbers, words) in [("1 2 3 4 5 6 7", "8 numbers"), ("1 2 3 4 5 6 7 x", "i16")] {
        let error = open_volume(of(numbers), &options).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    let path = of("1 2 3 4 5 6 7 8 9");
    let opened = open_volume(&path, &options).unwrap().unwrap();
    assert_eq!(
        opened.description,
        read_volume(&path, &options).unwrap().description
    );
    assert!(!opened.description.warnings.is_empty());
}

#[test]
fn integers_of_64_bits_become_floats() {
    let folder = tempfile::tempdir().unwrap();
    let [nx, ny, nz] = DIMS;
    let longs = bytes(nx * ny * nz, 8, true);
    let header = format!("NRRD0004\ntype: int64\ndimension: 3\nsizes: {nx} {ny} {nz}\n");
    let endian = "encoding: raw\nendian: little\n\n";
    let path = write(
        folder.path(),
        "a.nrrd",
        &[header.as_bytes(), endian.as_bytes(), &longs],
    );
    let memory = read_volume(&path, &ReadOptions::default()).unwrap();
    let opened = open_volume(&path, &ReadOptions::default()).unwrap().unwrap();
    let (mut buffer, mut found) = (ChunkBuffer::default(), Samples::U8(Vec::new().into()));
    let whole = VoxelBox::whole(memory.volume.grid());
    opened
        .source
        .read_region(0, whole, &mut found, &mut buffer)
        .unwrap();
    assert!(found == *memory.volume.samples());
    let strict = ReadOptions {
        strict: true,
        ..ReadOptions::default()
    };
    assert!(open_volume(&path, &strict).unwrap().is_none());
    for description in [&opened.description, &memory.description] {
        let warnings = &description.warnings;
        assert!(
            warnings.iter().any(|warning| warning.contains("2^53")),
            "{warnings:?}"
        );
    }
}

#[test]
fn compressed_files_are_read_whole() {
    let folder = tempfile::tempdir().unwrap();
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: gzip\n\n";
    let path = write(folder.path(), "a.nrrd", &[header.as_bytes(), b"none"]);
    assert!(open_volume(&path, &ReadOptions::default()).unwrap().is_none());
}

#[test]
fn packed_samples_are_unpacked_where_that_is_allowed() {
    let folder = tempfile::tempdir().unwrap();
    let other = tempfile::tempdir().unwrap();
    for Case { path, options } in packed_cases(folder.path()) {
        let name = path.display();
        assert!(open_volume(&path, &options).unwrap().is_none(), "{name}");
        let allowed = ReadOptions {
            unpack_in: Some(other.path().to_owned()),
            // What is read box by box need not fit.
            max_bytes: 1000,
            ..options.clone()
        };
        let opened = open_volume(&path, &allowed).unwrap();
        let opened = opened.unwrap_or_else(|| panic!("{name} is not unpacked"));
        let loaded = read_volume(&path, &options).unwrap();
        assert_eq!(opened.description, loaded.description, "{name}");
        let layout = &opened.source.levels()[0];
        assert_eq!(&layout.grid, loaded.volume.grid(), "{name}");
        let whole = VoxelBox::whole(&layout.grid);
        let mut found = Samples::U8(Vec::new().into());
        opened
            .source
            .read_region(0, whole, &mut found, &mut ChunkBuffer::default())
            .unwrap();
        assert!(found == *loaded.volume.samples(), "{name}");
        drop(opened);
        assert_eq!(std::fs::read_dir(other.path()).unwrap().count(), 0, "{name}");
    }
}

#[test]
fn packed_samples_that_are_damaged_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for Case { path, options } in packed_cases(folder.path()) {
        let allowed = ReadOptions {
            unpack_in: Some(folder.path().to_owned()),
            ..options
        };
        let mut damaged = path.clone();
        if path.extension().unwrap() == "nhdr" {
            let header = std::fs::read_to_string(&path).unwrap();
            damaged = folder.path().join(header.lines().nth_back(1).unwrap());
        }
        match damaged.extension().unwrap() == "gz" {
            true => std::fs::remove_file(damaged).unwrap(),
            false => {
                let whole = std::fs::read(&damaged).unwrap();
                // Some have other arrays first, or volumes behind.
                let eighths = if damaged.ends_with("far.vtk") { 5 } else { 4 };
                std::fs::write(&damaged, &whole[..whole.len() / 8 * eighths]).unwrap();
            }
        }
        let error = open_volume(&path, &allowed).err().map(|error| error.to_string());
        assert!(error.is_some_and(|error| !error.is_empty()), "{}", path.display());
    }
}
