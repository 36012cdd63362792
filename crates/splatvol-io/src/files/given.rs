//! The files that a page was given: a table of paths, whose bytes somebody else reads when they are wanted.
//!
//! Paths are relative to one folder, which holds them all and has the path `.`; folders are what their files' paths name. There are no
//! links, and no times.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::{OsStr, OsString};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, PoisonError, RwLock};
use std::time::SystemTime;

/// The bytes of a file.
pub trait GivenBytes: Send + Sync {
    /// Fills bytes from a position on, all of which are in the file.
    ///
    /// # Errors
    /// Files that cannot be read, any more.
    fn read_at(&self, bytes: &mut [u8], position: u64) -> io::Result<()>;
}

/// A file that a page was given.
#[derive(Clone)]
pub struct GivenFile {
    /// Its path, relative: folders and name.
    pub path: PathBuf,
    /// Bytes.
    pub length: u64,
    /// Who reads them.
    pub bytes: Arc<dyn GivenBytes>,
}

static GIVEN: RwLock<Table> = RwLock::new(Table(BTreeMap::new()));

/// Gives files, in place of earlier ones. Paths that lead out of their folder are left out.
pub fn give(files: impl IntoIterator<Item = GivenFile>) {
    *GIVEN.write().unwrap_or_else(PoisonError::into_inner) = Table::new(files);
}

fn given<T>(question: impl FnOnce(&Table) -> T) -> T {
    question(&GIVEN.read().unwrap_or_else(PoisonError::into_inner))
}

/// Files by their path.
struct Table(BTreeMap<PathBuf, GivenFile>);

impl Table {
    fn new(files: impl IntoIterator<Item = GivenFile>) -> Self {
        let named = files.into_iter().filter_map(|file| {
            let path = normal(&file.path).filter(|path| !path.as_os_str().is_empty())?;
            Some((path, file))
        });
        Self(named.collect())
    }

    fn file(&self, path: &Path) -> Option<&GivenFile> {
        self.0.get(&normal(path)?)
    }

    fn metadata(&self, path: &Path) -> io::Result<Metadata> {
        if let Some(file) = self.file(path) {
            return Ok(Metadata {
                length: Some(file.length),
            });
        }
        let folder = normal(path).filter(|folder| self.0.keys().any(|file| file.starts_with(folder)));
        match folder {
            Some(_) => Ok(Metadata { length: None }),
            None => Err(io::ErrorKind::NotFound.into()),
        }
    }

    fn open(&self, path: &Path) -> io::Result<File> {
        let file = self.file(path).ok_or(io::ErrorKind::NotFound)?;
        Ok(File {
            length: file.length,
            bytes: Arc::clone(&file.bytes),
            position: 0,
        })
    }

    /// What is in a folder, by its name.
    fn read_dir(&self, path: &Path) -> io::Result<Vec<DirEntry>> {
        if self.metadata(path)?.is_file() {
            return Err(io::ErrorKind::NotADirectory.into());
        }
        let folder = normal(path).unwrap_or_default();
        let inside = self.0.keys().filter_map(|file| file.strip_prefix(&folder).ok());
        let names: BTreeSet<&OsStr> = inside.filter_map(|rest| rest.iter().next()).collect();
        let entry = |name: &OsStr| {
            Ok(DirEntry {
                metadata: self.metadata(&folder.join(name))?,
                path: path.join(name),
                name: name.to_owned(),
            })
        };
        names.into_iter().map(entry).collect()
    }
}

/// A path without `.` and `..`; nothing if it leads out of the folder.
fn normal(path: &Path) -> Option<PathBuf> {
    let mut normal = PathBuf::new();
    for component in path.components() {
        match component {
            Component::Normal(name) => normal.push(name),
            Component::CurDir => {}
            Component::ParentDir if normal.pop() => {}
            _ => return None,
        }
    }
    Some(normal)
}

/// An open file.
#[derive(Clone)]
pub(crate) struct File {
    length: u64,
    bytes: Arc<dyn GivenBytes>,
    position: u64,
}

impl std::fmt::Debug for File {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut shown = f.debug_struct("File");
        shown.field("length", &self.length).finish_non_exhaustive()
    }
}

impl File {
    pub(crate) fn open(path: impl AsRef<Path>) -> io::Result<Self> {
        given(|table| table.open(path.as_ref()))
    }

    #[expect(clippy::unnecessary_wraps, reason = "as of the system's files")]
    pub(crate) fn metadata(&self) -> io::Result<Metadata> {
        Ok(Metadata {
            length: Some(self.length),
        })
    }
}

impl Read for File {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let left = self.length.saturating_sub(self.position);
        let count = bytes.len().min(usize::try_from(left).unwrap_or(usize::MAX));
        self.bytes.read_at(&mut bytes[..count], self.position)?;
        self.position += count as u64;
        Ok(count)
    }
}

impl Seek for File {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let position = match to {
            SeekFrom::Start(position) => Some(position),
            SeekFrom::End(offset) => self.length.checked_add_signed(offset),
            SeekFrom::Current(offset) => self.position.checked_add_signed(offset),
        };
        self.position = position.ok_or(io::ErrorKind::InvalidInput)?;
        Ok(self.position)
    }
}

/// Fills `bytes` from the position on; an error where the file ends before.
pub(crate) fn read_at(file: &File, bytes: &mut [u8], position: u64) -> io::Result<()> {
    match position.checked_add(bytes.len() as u64) {
        Some(end) if end <= file.length => file.bytes.read_at(bytes, position),
        _ => Err(io::ErrorKind::UnexpectedEof.into()),
    }
}

/// What is known about a file or a folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Metadata {
    /// Of a file.
    length: Option<u64>,
}

impl Metadata {
    pub(crate) fn is_file(self) -> bool {
        self.length.is_some()
    }

    pub(crate) fn is_dir(self) -> bool {
        self.length.is_none()
    }

    pub(crate) fn len(self) -> u64 {
        self.length.unwrap_or_default()
    }

    #[expect(clippy::unused_self, reason = "as of the system's files")]
    pub(crate) fn modified(self) -> io::Result<SystemTime> {
        Err(io::ErrorKind::Unsupported.into())
    }
}

/// What is in a folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct DirEntry {
    path: PathBuf,
    name: OsString,
    metadata: Metadata,
}

impl DirEntry {
    pub(crate) fn path(&self) -> PathBuf {
        self.path.clone()
    }

    pub(crate) fn file_name(&self) -> OsString {
        self.name.clone()
    }

    #[expect(clippy::unnecessary_wraps, reason = "as of the system's files")]
    pub(crate) fn metadata(&self) -> io::Result<Metadata> {
        Ok(self.metadata)
    }

    /// Of which only the kind is asked.
    pub(crate) fn file_type(&self) -> io::Result<Metadata> {
        self.metadata()
    }
}

pub(crate) fn metadata(path: impl AsRef<Path>) -> io::Result<Metadata> {
    given(|table| table.metadata(path.as_ref()))
}

pub(crate) fn read_dir(path: impl AsRef<Path>) -> io::Result<impl Iterator<Item = io::Result<DirEntry>>> {
    let entries = given(|table| table.read_dir(path.as_ref()))?;
    Ok(entries.into_iter().map(Ok))
}

pub(crate) fn exists(path: &Path) -> bool {
    metadata(path).is_ok()
}

pub(crate) fn is_file(path: &Path) -> bool {
    metadata(path).is_ok_and(Metadata::is_file)
}

pub(crate) fn is_dir(path: &Path) -> bool {
    metadata(path).is_ok_and(Metadata::is_dir)
}

pub(crate) fn is_symlink(_path: &Path) -> bool {
    false
}

pub(crate) fn canonicalize(path: &Path) -> io::Result<PathBuf> {
    metadata(path)?;
    normal(path).ok_or_else(|| io::ErrorKind::NotFound.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Digits;

    impl GivenBytes for Digits {
        fn read_at(&self, bytes: &mut [u8], position: u64) -> io::Result<()> {
            for (byte, at) in bytes.iter_mut().zip(position..) {
                *byte = b'0' + (at % 10) as u8;
            }
            Ok(())
        }
    }

    fn table(paths: &[&str]) -> Table {
        Table::new(paths.iter().map(|path| GivenFile {
            path: PathBuf::from(path),
            length: 25,
            bytes: Arc::new(Digits),
        }))
    }

    #[test]
    fn paths_name_files_and_folders_and_lead_nowhere_else() {
        let table = table(&[
            "scan/b.dcm",
            "scan/a.dcm",
            "scan/deep/c.dcm",
            "../out",
            "/abs",
            "x.raw",
            ".",
        ]);
        let kind = |path: &str| table.metadata(Path::new(path)).map(Metadata::is_file).ok();
        for file in ["scan/a.dcm", "./scan/b.dcm", "scan/deep/../a.dcm", "x.raw"] {
            assert_eq!(kind(file), Some(true), "{file}");
        }
        for folder in ["scan", "scan/", "scan/deep", ".", ""] {
            assert_eq!(kind(folder), Some(false), "{folder}");
        }
        for nothing in [
            "out",
            "../out",
            "abs",
            "/abs",
            "sca",
            "scan/a",
            "../x.raw",
            "scan/../../x.raw",
        ] {
            assert_eq!(kind(nothing), None, "{nothing}");
        }
        assert_eq!(normal(Path::new("a/./b/../c")), Some(PathBuf::from("a/c")));
    }

    #[test]
    fn folders_list_what_is_in_them_once() {
        let table = table(&["scan/b.dcm", "scan/a.dcm", "scan/deep/c", "scan/deep/d"]);
        let entries = table.read_dir(Path::new("./scan")).unwrap();
        let named: Vec<(String, bool)> = entries
            .iter()
            .map(|entry| (entry.path().display().to_string(), entry.metadata.is_file()))
            .collect();
        let expected = [
            ("./scan/a.dcm", true),
            ("./scan/b.dcm", true),
            ("./scan/deep", false),
        ];
        assert_eq!(named, expected.map(|(path, is_file)| (path.to_owned(), is_file)));
        let refused = |path: &str| table.read_dir(Path::new(path)).unwrap_err().kind();
        assert_eq!(refused("scan/a.dcm"), io::ErrorKind::NotADirectory);
        assert_eq!(refused("no"), io::ErrorKind::NotFound);
    }

    #[test]
    fn reads_and_positions_end_where_the_file_does() {
        let mut file = table(&["f"]).open(Path::new("f")).unwrap();
        let mut text = String::new();
        file.seek(SeekFrom::End(-4)).unwrap();
        file.read_to_string(&mut text).unwrap();
        assert_eq!(text, "1234");
        assert_eq!(file.seek(SeekFrom::Current(-1)).unwrap(), 24);
        assert!(file.seek(SeekFrom::Current(-25)).is_err());
        assert_eq!(file.seek(SeekFrom::Start(90)).unwrap(), 90);
        assert_eq!(file.read(&mut [0; 3]).unwrap(), 0);
        let mut bytes = [0; 3];
        read_at(&file, &mut bytes, 22).unwrap();
        assert_eq!(&bytes, b"234");
        for position in [23, 1 << 40, u64::MAX] {
            let error = read_at(&file, &mut bytes, position).unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::UnexpectedEof);
        }
    }

    #[test]
    fn what_is_given_takes_the_place_of_what_was() {
        let file = |path: &str| GivenFile {
            path: PathBuf::from(path),
            length: 3,
            bytes: Arc::new(Digits),
        };
        give([file("a/b")]);
        assert!(is_file(Path::new("a/b")) && is_dir(Path::new("a")) && exists(Path::new("a")));
        assert_eq!(canonicalize(Path::new("a/../a/b")).unwrap(), PathBuf::from("a/b"));
        assert_eq!(File::open("a/b").unwrap().metadata().unwrap().len(), 3);
        let names = read_dir("a").unwrap().map(|entry| entry.unwrap().file_name());
        assert_eq!(names.collect::<Vec<_>>(), ["b"]);
        give([file("c")]);
        assert!(!exists(Path::new("a/b")) && !is_symlink(Path::new("c")) && metadata("c").unwrap().is_file());
        assert!(metadata("c").unwrap().modified().is_err() && canonicalize(Path::new("a")).is_err());
        assert!(
            !read_dir(".")
                .unwrap()
                .next()
                .unwrap()
                .unwrap()
                .file_type()
                .unwrap()
                .is_dir()
        );
    }
}
