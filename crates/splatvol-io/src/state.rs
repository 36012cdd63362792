//! State of files: what tells one version of a file from another, without reading all of it.

use std::io;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::files::{self, File, read_at};
use crate::key_store::{ByteRange, KeyStore};
use crate::{IoError, remote};

/// Bytes of a piece of a file, and how many pieces count.
const PIECE: u64 = 4096;
const PIECES: u64 = 16;
/// Files of a folder of which pieces count; of others only names and lengths do.
const MOST_IN_FOLDER: usize = 64;

/// Most bytes of metadata in a store.
const STORED: u64 = 64 << 20;

/// SHA-256 of the lengths of files and of sixteen pieces of each, from its first bytes to its last; of folders, of the names and
/// lengths of the files in them, and of pieces of the first ones; of stores at addresses, of their metadata. Neither places nor times count, so that a copy has the state of
/// its original.
///
/// # Errors
/// Files that cannot be read.
pub fn state_of_files(files: &[PathBuf]) -> Result<String, IoError> {
    let mut hash = Sha256::new();
    for path in files {
        let added = match remote::address(path) {
            Some(address) => add_store(&mut hash, &*remote::open(address)?),
            None if files::is_dir(path) => add_folder(&mut hash, path),
            None => add_file(&mut hash, path),
        };
        added.map_err(|source| IoError::Open {
            source,
            path: path.clone(),
        })?;
    }
    Ok(hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}

fn add_file(hash: &mut Sha256, path: &Path) -> io::Result<()> {
    let file = File::open(path)?;
    let length = file.metadata()?.len();
    hash.update(length.to_le_bytes());
    let size = length.min(PIECE);
    let mut bytes = vec![0; size as usize];
    let pieces = PIECES.min(length.div_ceil(PIECE));
    for piece in 0..pieces {
        let position = (length - size) * piece / (pieces - 1).max(1);
        read_at(&file, &mut bytes, position)?;
        hash.update(&bytes);
    }
    Ok(())
}

/// The metadata at the root of a store.
fn add_store(hash: &mut Sha256, store: &dyn KeyStore) -> io::Result<()> {
    for name in [".zattrs", ".zarray", "zarr.json"] {
        if let Some(bytes) = store.read(name, ByteRange::All, STORED)? {
            hash.update(name);
            hash.update(&bytes);
        }
    }
    Ok(())
}

fn add_folder(hash: &mut Sha256, folder: &Path) -> io::Result<()> {
    let mut entries = files::read_dir(folder)?.collect::<io::Result<Vec<_>>>()?;
    entries.sort_by_key(files::DirEntry::file_name);
    for (number, entry) in entries.into_iter().enumerate() {
        hash.update(entry.file_name().as_encoded_bytes());
        let metadata = files::metadata(entry.path())?;
        match metadata.is_file() {
            true if number < MOST_IN_FOLDER => add_file(hash, &entry.path())?,
            true => hash.update(metadata.len().to_le_bytes()),
            false => (),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_follow_contents() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.raw");
        let state = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            state_of_files(std::slice::from_ref(&path)).unwrap()
        };
        let large: Vec<u8> = (0..200_000u32).map(|i| (i % 251) as u8).collect();
        let first = state(&large);
        assert_eq!(state(&large), first);
        for at in [0, 199_999] {
            let mut other = large.clone();
            other[at] ^= 1;
            assert_ne!(state(&other), first, "{at}");
        }
        assert_ne!(state(&large[1..]), first);
        for short in [&b""[..], b"1", b"2", b"12"] {
            assert_eq!(state(short), state(short));
        }
        assert_ne!(state(b"1"), state(b"2"));
        let whole = state_of_files(&[folder.path().to_owned()]).unwrap();
        std::fs::write(folder.path().join("b"), b"more").unwrap();
        assert_ne!(state_of_files(&[folder.path().to_owned()]).unwrap(), whole);
        let error = state_of_files(&[folder.path().join("none")])
            .unwrap_err()
            .to_string();
        assert!(error.contains("none"), "{error}");
    }
}
