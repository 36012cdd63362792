//! The files of the system, and reads at positions of them, from several threads at once.

use std::io;
use std::path::{Path, PathBuf};

pub(crate) use std::fs::{DirEntry, File, metadata, read_dir};

pub(crate) fn exists(path: &Path) -> bool {
    path.exists()
}

pub(crate) fn is_file(path: &Path) -> bool {
    path.is_file()
}

pub(crate) fn is_dir(path: &Path) -> bool {
    path.is_dir()
}

pub(crate) fn is_symlink(path: &Path) -> bool {
    path.is_symlink()
}

pub(crate) fn canonicalize(path: &Path) -> io::Result<PathBuf> {
    path.canonicalize()
}

/// Fills `bytes` from the position on; an error where the file ends before.
#[cfg(unix)]
pub(crate) fn read_at(file: &File, bytes: &mut [u8], position: u64) -> io::Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, bytes, position)
}

/// Fills `bytes` from the position on; an error where the file ends before.
#[cfg(windows)]
pub(crate) fn read_at(file: &File, mut bytes: &mut [u8], mut position: u64) -> io::Result<()> {
    use std::os::windows::fs::FileExt;

    while !bytes.is_empty() {
        match file.seek_read(bytes, position) {
            Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
            Ok(read) => {
                bytes = &mut bytes[read..];
                position += read as u64;
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

/// Fills `bytes` from the position on; an error where the file ends before. There is one thread here.
#[cfg(not(any(unix, windows)))]
pub(crate) fn read_at(mut file: &File, bytes: &mut [u8], position: u64) -> io::Result<()> {
    use std::io::{Read, Seek, SeekFrom};

    file.seek(SeekFrom::Start(position))?;
    file.read_exact(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_do_not_disturb_each_other() {
        let path = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(path.path(), (0..200u8).collect::<Vec<u8>>()).unwrap();
        let file = File::open(path.path()).unwrap();
        std::thread::scope(|scope| {
            for start in 0..8u8 {
                let file = &file;
                scope.spawn(move || {
                    for _ in 0..100 {
                        let mut bytes = [0; 3];
                        read_at(file, &mut bytes, u64::from(start)).unwrap();
                        assert_eq!(bytes, [start, start + 1, start + 2]);
                    }
                });
            }
        });
        let error = read_at(&file, &mut [0; 2], 199).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::UnexpectedEof);
    }
}
