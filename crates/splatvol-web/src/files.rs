//! Files that a page was given, read: which of them are data, and these packed as [`Request::Open`] wants them.
//!
//! A folder is read as a whole if it can be, as the command does. Of loose files, slices are one volume; of others each is an item,
//! but those that belong to another one, which its header names.
//!
//! [`Request::Open`]: crate::message::Request::Open

use std::collections::HashSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use splatvol_document::HeldContent;
use splatvol_document::keys::ItemKeys;
use splatvol_io::{DataOptions, Description, IoError, data_kind, read_data};

use crate::message::Described;
use crate::{ItemData, Precision, size_of};

/// Files that a page was given.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FilesGiven {
    /// The files.
    pub files: Vec<FileGiven>,
    /// Keys of how all of them are read, where they leave it open: `component`, `array`, `dims`, ...
    #[serde(default)]
    pub keys: ItemKeys,
}

/// A file that a page was given.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileGiven {
    /// Its path, relative: of a folder that was given, with the folder's name.
    pub path: PathBuf,
    /// Bytes.
    pub length: u64,
}

/// What was read; its bytes are the packed data of all items, one after the other.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct FilesRead {
    /// What is shown.
    pub items: Vec<ItemRead>,
    /// What is odd about the files, and which of them were not read.
    pub warnings: Vec<String>,
}

/// Data of a file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ItemRead {
    /// Its name, without its folder.
    pub name: String,
    /// What the bytes are.
    pub data: ItemData,
    /// What the file says about them.
    pub described: Described,
    /// What they are, and how much of it: `64 × 64 × 40 samples`.
    pub size: String,
}

/// Reads files, given by their paths relative to the folder that has them all; each in the same way.
///
/// # Errors
/// That of the first file, where none can be read.
pub fn read_files(
    root: &Path,
    files: &[PathBuf],
    options: &DataOptions,
) -> Result<(FilesRead, Vec<u8>), IoError> {
    let mut reading = Reading::new(options);
    let is_data = |folder: &Path| data_kind(folder, &DataOptions::default()).is_ok();
    match common_folder(files).map(|folder| root.join(folder)) {
        Some(folder) if is_data(&folder) => reading.add(&folder, &name_of(&folder))?,
        None if files.len() > 1 && is_data(root) => reading.add_loose(root, files)?,
        _ => reading.add_each(root, files)?,
    }
    Ok((reading.read, reading.bytes))
}

/// The first folder of all paths.
fn common_folder(files: &[PathBuf]) -> Option<&OsStr> {
    let first = files.first()?;
    let folder = first.iter().next().filter(|_| first.iter().count() > 1)?;
    files
        .iter()
        .all(|file| file.starts_with(folder))
        .then_some(folder)
}

/// The last part of a path.
fn name_of(path: &Path) -> String {
    path.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

/// Files of which it is said why they were not read.
const MOST_FAILED: usize = 8;

/// What has been read so far.
struct Reading<'a> {
    options: &'a DataOptions,
    read: FilesRead,
    bytes: Vec<u8>,
    /// Files that belong to an item.
    used: HashSet<PathBuf>,
}

impl<'a> Reading<'a> {
    fn new(options: &'a DataOptions) -> Self {
        Self {
            options,
            read: FilesRead::default(),
            bytes: Vec::new(),
            used: HashSet::new(),
        }
    }

    /// Reads loose files as slices of one volume, which has the name of the first; or each, if most of them are none.
    fn add_loose(&mut self, root: &Path, files: &[PathBuf]) -> Result<(), IoError> {
        let here = Path::new(".");
        let folder = if root.as_os_str().is_empty() { here } else { root };
        let name = files.first().map(|first| name_of(first)).unwrap_or_default();
        let slices = self.add(folder, &name).map(|()| {
            let found = files.iter().filter(|file| self.used.contains(&root.join(file)));
            found.count()
        });
        if slices.as_ref().is_ok_and(|slices| 2 * slices > files.len()) {
            return Ok(());
        }
        *self = Self::new(self.options);
        let each = self.add_each(root, files);
        match (each, slices) {
            // Neither: that they are no slices says more than that one of them is no volume.
            (Err(_), Err(error)) => Err(error),
            (each, _) => each,
        }
    }

    /// Reads each file that belongs to no other.
    fn add_each(&mut self, root: &Path, files: &[PathBuf]) -> Result<(), IoError> {
        let mut ordered = files.to_vec();
        ordered.sort();
        let mut failed = Vec::new();
        for path in ordered.iter().map(|file| root.join(file)) {
            if self.used.contains(&path) {
                continue;
            }
            if let Err(error) = self.add(&path, &name_of(&path)) {
                failed.push((path, error));
            }
        }
        // A header may come after what it names.
        failed.retain(|(path, _)| !self.used.contains(path));
        let warnings = failed
            .iter()
            .take(MOST_FAILED)
            .map(|(_, error)| error.to_string());
        self.read.warnings.extend(warnings);
        if failed.len() > MOST_FAILED {
            let more = failed.len() - MOST_FAILED;
            self.read
                .warnings
                .push(format!("{more} more files were not read"));
        }
        match failed.into_iter().next() {
            Some((_, error)) if self.read.items.is_empty() => Err(error),
            _ => Ok(()),
        }
    }

    /// Reads a file or a folder.
    fn add(&mut self, path: &Path, name: &str) -> Result<(), IoError> {
        let loaded = read_data(path, self.options)?;
        let Description {
            format,
            oriented,
            files,
            warnings,
            ..
        } = loaded.description;
        let plain = |path: PathBuf| path.strip_prefix(".").map(Path::to_owned).unwrap_or(path);
        self.used.extend(files.into_iter().map(plain));
        let warnings = warnings.into_iter().map(|warning| format!("{name}: {warning}"));
        self.read.warnings.extend(warnings);
        let content = HeldContent::from(loaded.data);
        let (data, bytes) = ItemData::pack(&content, Precision::OWN);
        self.read.items.push(ItemRead {
            name: name.to_owned(),
            data,
            described: Described { format, oriented },
            size: size_of(&content),
        });
        self.bytes.extend_from_slice(&bytes);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use splatvol_document::{DocumentError, ReadRules, items};

    use super::*;
    use crate::Session;

    const HEADER: &str = "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementSpacing = 1 1 1\nElementDataFile = ";

    /// Reads files that are written to a folder.
    fn read(files: &[(&str, &[u8])]) -> Result<(FilesRead, Vec<u8>), IoError> {
        read_as(files, &DataOptions::default())
    }

    fn read_as(files: &[(&str, &[u8])], options: &DataOptions) -> Result<(FilesRead, Vec<u8>), IoError> {
        let folder = tempfile::tempdir().unwrap();
        for (path, bytes) in files {
            let path = folder.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, bytes).unwrap();
        }
        let paths: Vec<PathBuf> = files.iter().map(|(path, _)| PathBuf::from(path)).collect();
        read_files(folder.path(), &paths, options)
    }

    /// Options of a message with these keys.
    fn said(keys: &str) -> Result<DataOptions, DocumentError> {
        let message = format!(r#"{{ "files": [], "keys": {{ {keys} }} }}"#);
        let given: FilesGiven = serde_json::from_str(&message).unwrap();
        items::options(&given.keys, ReadRules::default())
    }

    fn names(read: &FilesRead) -> Vec<&str> {
        read.items.iter().map(|item| item.name.as_str()).collect()
    }

    #[test]
    fn a_header_and_its_data_are_one_item_whatever_their_order() {
        let header = format!("{HEADER}a.raw\n");
        let points = b"0 0 0\n1 1 1\n0 1 0\n";
        let (read, bytes) = read(&[
            ("a.raw", &[7; 8]),
            ("z.xyz", points),
            ("a.mhd", header.as_bytes()),
        ])
        .unwrap();
        assert_eq!(names(&read), ["a.mhd", "z.xyz"]);
        assert_eq!(read.warnings, Vec::<String>::new());
        assert_eq!(read.items[0].size, "2 × 2 × 2 samples");
        assert_eq!(&bytes[..8], [7; 8]);
        assert!(!read.items[0].described.oriented && read.items[0].described.format.contains("MetaImage"));
    }

    #[test]
    fn what_cannot_be_read_is_said_beside_what_can() {
        let (found, _) = read(&[("b.xyz", b"0 0 0\n1 1 1\n"), ("c.nrrd", b"NRRD0004\n\n")]).unwrap();
        assert_eq!(names(&found), ["b.xyz"]);
        assert!(
            found.warnings.len() == 1 && found.warnings[0].contains("c.nrrd"),
            "{found:?}"
        );
        let error = read(&[("c.nrrd", b"NRRD0004\n\n"), ("lone.raw", &[0; 8])]).unwrap_err();
        assert!(error.to_string().contains("c.nrrd"), "{error}");
        let names: Vec<String> = (0..20).map(|index| format!("{index}.nrrd")).collect();
        let mut many: Vec<(&str, &[u8])> = names
            .iter()
            .map(|name| (name.as_str(), &b"NRRD0004\n\n"[..]))
            .collect();
        many.push(("b.xyz", b"0 0 0\n1 1 1\n"));
        let warnings = read(&many).unwrap().0.warnings;
        assert_eq!(
            (warnings.len(), warnings[8].as_str()),
            (9, "12 more files were not read")
        );
    }

    #[test]
    fn what_a_file_leaves_open_can_be_said() {
        let raw: (&str, &[u8]) = ("a.raw", &[3; 16]);
        assert!(read(&[raw]).is_err());
        let layout = said(r#""dims": [4, 2, 1], "type": "u16", "endian": "big", "kind": "volume""#).unwrap();
        let (found, bytes) = read_as(&[raw], &layout).unwrap();
        assert_eq!(found.items[0].size, "4 × 2 × 1 samples");
        assert_eq!(bytes, [3; 16]);
        assert!(
            said(r#""dims": [4, 2, 1]"#)
                .unwrap_err()
                .to_string()
                .contains("type")
        );
    }

    #[test]
    fn slices_are_one_volume_loose_or_in_their_folder() {
        let mut slice = Vec::new();
        let mut encoder = png::Encoder::new(&mut slice, 4, 3);
        encoder.set_color(png::ColorType::Grayscale);
        encoder
            .write_header()
            .unwrap()
            .write_image_data(&[9; 12])
            .unwrap();
        for (paths, name) in [
            (["scan/2.png", "scan/10.png", "scan/1.png"], "scan"),
            (["2.png", "10.png", "1.png"], "2.png"),
        ] {
            let (found, bytes) = read(&paths.map(|path| (path, &slice[..]))).unwrap();
            assert_eq!(names(&found), [name]);
            assert_eq!(
                (found.items[0].size.as_str(), bytes.len()),
                ("4 × 3 × 3 samples", 36)
            );
        }
        // Why they cannot be read is why the slices cannot.
        let options = said(r#""component": 0"#).unwrap();
        let error = read_as(&[("2.png", &slice[..]), ("1.png", &slice)], &options).unwrap_err();
        assert!(error.to_string().contains("component"), "{error}");
        // Two volumes beside a picture are no slices.
        let header = format!("{HEADER}LOCAL\n");
        let volume = [header.as_bytes(), &[1; 8]].concat();
        let (found, _) = read(&[("a.mha", &volume), ("b.mha", &volume), ("c.png", &slice)]).unwrap();
        assert_eq!(names(&found), ["a.mha", "b.mha"]);
        assert!(
            found.warnings.iter().any(|warning| warning.contains("c.png")),
            "{found:?}"
        );
    }

    #[test]
    fn what_was_read_can_be_opened_as_its_file_describes_it() {
        // A pyramid that stands on y, which its format does not say.
        let places = (0..2000).map(|i| (i / 100, [i % 10, i / 10 % 10].map(|at| f64::from(at) / 4.5 - 1.0)));
        let points: String = places
            .map(|(step, [x, z])| (0.05 * f64::from(step), x, z))
            .map(|(y, x, z)| format!("{} {y} {}\n", x * (1.0 - y), z * (1.0 - y)))
            .collect();
        let (found, bytes) = read(&[("a.xyz", points.as_bytes())]).unwrap();
        let open = |described: serde_json::Value| {
            let header = serde_json::json!({
                "do": "open",
                "document": { "item": [{ "file": "a.xyz" }] },
                "data": found.items.iter().map(|item| &item.data).collect::<Vec<_>>(),
                "described": described,
            });
            Session::new().unwrap().answer(&header.to_string(), &bytes).header
        };
        let opened = open(serde_json::json!([found.items[0].described]));
        assert!(opened.contains("2000 points"), "{opened}");
        let ply = serde_json::json!([{ "format": "PLY", "oriented": false }]);
        assert_ne!(open(ply), opened);
        assert!(open(serde_json::json!([])).contains("error"));
        assert!(open(serde_json::json!([{ "format": "PLY" }])).contains("error"));
    }
}
