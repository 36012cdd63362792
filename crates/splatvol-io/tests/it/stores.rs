//! Zarr in stores of keys, and behind servers that are slow, busy or broken: the samples of the same folder, or an error that
//! names the chunk.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::common::images::{chunks, image};
use splatvol_io::{
    ByteRange, KeyStore, OmeVersion, Opened, ReadOptions, open_volume, open_volume_in, too_many_bytes,
};

/// A folder, read by keys.
#[derive(Debug)]
struct Keys(PathBuf);

impl KeyStore for Keys {
    fn name(&self) -> String {
        "keys".to_owned()
    }

    fn read(&self, key: &str, bytes: ByteRange, most: u64) -> io::Result<Option<Vec<u8>>> {
        let path = self.0.join(key);
        if !path.is_file() {
            return Ok(None);
        }
        let all = std::fs::read(path)?;
        let (start, length) = bytes.within(all.len() as u64);
        match length > most {
            true => Err(too_many_bytes(length, most)),
            false => Ok(Some(all[start as usize..(start + length) as usize].to_vec())),
        }
    }
}

fn open(path: &Path) -> Opened {
    open_volume(path, &ReadOptions::default()).unwrap().unwrap()
}

#[test]
fn a_store_has_the_samples_of_its_folder() {
    let folder = tempfile::tempdir().unwrap();
    for version in [OmeVersion::V04, OmeVersion::V05] {
        let path = image(folder.path(), version);
        let (local, options) = (open(&path), ReadOptions::default());
        let stored = open_volume_in(Arc::new(Keys(path)), &options).unwrap();
        assert_eq!(stored.source.identity().name, "keys");
        assert_eq!(stored.description.levels, local.description.levels);
        assert_eq!(stored.source.levels().len(), local.source.levels().len());
        assert_eq!(chunks(&*stored.source).unwrap(), chunks(&*local.source).unwrap());
        for level in 0..local.source.levels().len() {
            assert!(stored.source.index(level).is_some());
            assert_eq!(stored.source.index(level), local.source.index(level));
            assert_eq!(stored.source.spread(level), local.source.spread(level));
        }
        // A series of images lies in folders that are numbered.
        let outer = folder.path().join("series");
        std::fs::create_dir_all(outer.join("OME")).unwrap();
        std::fs::write(outer.join(".zgroup"), "{\"zarr_format\": 2}").unwrap();
        let _ = std::fs::remove_dir_all(outer.join("0"));
        std::fs::rename(folder.path().join("a.ome.zarr"), outer.join("0")).unwrap();
        let series = open_volume_in(Arc::new(Keys(outer)), &options).unwrap();
        assert_eq!(series.description.levels, local.description.levels);
    }
    let nothing = folder.path().join("nothing");
    let error = open_volume_in(Arc::new(Keys(nothing)), &ReadOptions::default()).unwrap_err();
    assert!(
        error.to_string().contains("neither multiscales nor an array"),
        "{error}"
    );
}

#[test]
fn shards_that_lie_are_errors_without_allocations() {
    let folder = tempfile::tempdir().unwrap();
    let path = image(folder.path(), OmeVersion::V05);
    let shard = path.join("0/c/0/0/0");
    let whole = std::fs::read(&shard).unwrap();
    let open = || open_volume_in(Arc::new(Keys(path.clone())), &ReadOptions::default()).unwrap();
    // An index without a right checksum, and a shard that is cut off.
    for damaged in [
        whole[..whole.len() - 1].to_vec(),
        whole[..40].to_vec(),
        [&whole[..whole.len() - 1], &[whole[whole.len() - 1] ^ 1]].concat(),
    ] {
        std::fs::write(&shard, damaged).unwrap();
        let error = chunks(&*open().source).unwrap_err().to_string();
        assert!(error.contains("level 0, chunk 0,0,0, key c/0/0/0"), "{error}");
    }
    // A chunk of an exabyte.
    let text = std::fs::read_to_string(path.join("0/zarr.json")).unwrap();
    let metadata: serde_json::Value = serde_json::from_str(&text).unwrap();
    let shape = metadata["chunk_grid"]["configuration"]["chunk_shape"]
        .as_array()
        .unwrap();
    let inner: u64 = shape.iter().map(|size| size.as_u64().unwrap() / 16).product();
    let start = whole.len() - 16 * inner as usize - 4;
    let mut index = whole[start..whole.len() - 4].to_vec();
    index[8..16].copy_from_slice(&(1u64 << 60).to_le_bytes());
    let sum = crc32c::crc32c(&index).to_le_bytes();
    let lying = [&whole[..start], &index, &sum].concat();
    std::fs::write(&shard, lying).unwrap();
    let error = chunks(&*open().source).unwrap_err().to_string();
    assert!(
        error.contains("level 0, chunk 0,0,0") && error.contains("at most"),
        "{error}"
    );
}
