//! Files of a SOG: in a zip or in a folder; and the pictures among them.

use std::io::{BufReader, Cursor};
use std::path::{Path, PathBuf};

use image_webp::WebPDecoder;
use zip::ZipArchive;

use crate::IoError;
use crate::error::Context;
use crate::files::{self, File};
use crate::source::{Source, companion, read_file};

/// Pixels that any picture may have, however few its bytes.
const FREE_PIXELS: usize = 1 << 20;
/// Pixels per byte beyond that: attributes of Gaussians hardly compress.
const PIXELS_PER_BYTE: usize = 1024;

/// True for a folder with a `meta.json`, and for such a file itself, if it has means and quaternions.
pub(in super::super) fn is_folder_or_meta(path: &Path) -> bool {
    let Some(meta) = meta_path(path) else {
        return false;
    };
    let context = Context::new("SOG", &meta);
    let small = files::metadata(&meta).is_ok_and(|metadata| metadata.is_file() && metadata.len() < 1 << 24);
    small
        && read_file(&meta, &context)
            .and_then(|bytes| crate::json::parse(&bytes, &context))
            .is_ok_and(|document| document.get("means").is_some() && document.get("quats").is_some())
}

fn meta_path(path: &Path) -> Option<PathBuf> {
    if files::is_dir(path) {
        return Some(path.join("meta.json"));
    }
    let name = path.file_name()?.to_str()?;
    name.ends_with("meta.json").then(|| path.to_owned())
}

/// True for a zip with a `meta.json` in it.
pub(in super::super) fn is_archive(path: &Path) -> bool {
    let archive = File::open(path).ok().map(BufReader::new).map(ZipArchive::new);
    matches!(archive, Some(Ok(archive)) if folder_of_meta(&archive).is_some())
}

/// Path prefix of `meta.json` among the names of a zip's files.
fn folder_of_meta(archive: &ZipArchive<BufReader<File>>) -> Option<String> {
    archive
        .file_names()
        .filter_map(Result::ok)
        .find_map(|name| name.strip_suffix("meta.json").map(str::to_owned))
        .filter(|folder| folder.is_empty() || folder.ends_with('/'))
}

/// Location of the files.
pub(super) enum Files {
    Archive {
        archive: ZipArchive<BufReader<File>>,
        folder: String,
    },
    Folder {
        meta: PathBuf,
        read: Vec<PathBuf>,
    },
}

impl Files {
    /// The files beside the `meta.json` at `path`, in the folder or in the zip.
    pub(super) fn open(path: &Path, context: &Context<'_>) -> Result<Self, IoError> {
        if let Some(meta) = meta_path(path) {
            let read = Vec::new();
            return Ok(Self::Folder { meta, read });
        }
        let source = |source| IoError::Open {
            source,
            path: path.to_owned(),
        };
        let file = File::open(path).map_err(source)?;
        let archive = ZipArchive::new(BufReader::new(file))
            .map_err(|error| context.field("archive", error, None, "a zip with a meta.json"))?;
        let folder = folder_of_meta(&archive)
            .ok_or_else(|| context.field("archive", "no meta.json", None, "a zip with a meta.json"))?;
        Ok(Self::Archive { archive, folder })
    }

    /// Description of the location, for people.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Archive { .. } => "zip",
            Self::Folder { .. } => "folder",
        }
    }

    /// Bytes of the archive, or of all files in the folder.
    pub(super) fn bytes(&self, context: &Context<'_>) -> u64 {
        let length = |path: &Path| files::metadata(path).map_or(0, |metadata| metadata.len());
        match self {
            Self::Archive { .. } => length(context.path),
            Self::Folder { meta, .. } => {
                let folder = meta.parent().filter(|folder| !folder.as_os_str().is_empty());
                let entries = files::read_dir(folder.unwrap_or(Path::new(".")));
                let paths = entries.into_iter().flatten().flatten().map(|entry| entry.path());
                paths
                    .filter(|path| files::is_file(path))
                    .map(|path| length(&path))
                    .sum()
            }
        }
    }

    /// The files that were read, besides an archive itself.
    pub(super) fn paths(&self) -> Vec<PathBuf> {
        match self {
            Self::Archive { .. } => Vec::new(),
            Self::Folder { read, .. } => read.clone(),
        }
    }

    /// The bytes of a file.
    pub(super) fn read(&mut self, name: &str, context: &Context<'_>) -> Result<Vec<u8>, IoError> {
        match self {
            Self::Folder { meta, read } => {
                let path = if name == "meta.json" {
                    meta.clone()
                } else {
                    let context = Context {
                        path: meta,
                        ..*context
                    };
                    companion(name, "files", None, &context)?
                };
                let bytes = read_file(&path, context)?;
                read.push(path);
                Ok(bytes)
            }
            Self::Archive { archive, folder } => {
                let name = format!("{folder}{name}");
                let entry = archive
                    .by_name(&name)
                    .map_err(|error| context.field("file in the archive", &name, None, error.to_string()))?;
                let (compressed, size) = (entry.compressed_size(), entry.size());
                let length = files::metadata(context.path).map_or(0, |metadata| metadata.len());
                let mut source = Source::from_decoder(entry, compressed.min(length), size);
                source.read_bytes("file in the archive", size, context)
            }
        }
    }

    /// A picture with at least `count` pixels.
    pub(super) fn picture(
        &mut self,
        name: &str,
        count: usize,
        context: &Context<'_>,
    ) -> Result<Picture, IoError> {
        let bytes = self.read(name, context)?;
        let wrong =
            |value: String, expected: &str| context.field(format!("picture {name}"), value, None, expected);
        let length = bytes.len();
        let mut decoder = WebPDecoder::new(Cursor::new(bytes))
            .map_err(|error| wrong(error.to_string(), "a lossless WebP picture"))?;
        let (width, height) = decoder.dimensions();
        let pixels = (width as usize).saturating_mul(height as usize);
        let size = format!("{width} x {height}");
        if pixels < count {
            return Err(wrong(size, &format!("at least {count} pixels")));
        }
        if pixels > FREE_PIXELS + PIXELS_PER_BYTE.saturating_mul(length) {
            return Err(wrong(size, &format!("fewer pixels in {length} bytes")));
        }
        if decoder.is_lossy() || decoder.is_animated() {
            return Err(wrong("lossy or animated".to_owned(), "a lossless WebP picture"));
        }
        let channels = if decoder.has_alpha() { 4 } else { 3 };
        decoder.set_memory_limit(16 * pixels + FREE_PIXELS);
        let mut samples = vec![0; pixels * channels];
        decoder
            .read_image(&mut samples)
            .map_err(|error| wrong(error.to_string(), "a lossless WebP picture"))?;
        Ok(Picture {
            width: width as usize,
            height: height as usize,
            channels,
            samples,
        })
    }
}

/// Pixels of red, green, blue and, if the picture has it, alpha.
pub(super) struct Picture {
    width: usize,
    height: usize,
    channels: usize,
    samples: Vec<u8>,
}

impl Picture {
    pub(super) fn width(&self) -> usize {
        self.width
    }

    pub(super) fn height(&self) -> usize {
        self.height
    }

    /// A pixel, counted row by row; alpha is 255 where the picture has none.
    #[inline]
    pub(super) fn pixel(&self, index: usize) -> [u8; 4] {
        let mut pixel = [255; 4];
        let start = index * self.channels;
        pixel[..self.channels].copy_from_slice(&self.samples[start..start + self.channels]);
        pixel
    }
}
