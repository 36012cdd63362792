//! Writing pictures, in the background: each at its document's size and quality, with its document in its text, so that
//! `splatvol render --like` makes the same bytes; and scene files, which are the document alone.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};

use splatvol::{EngineConfig, Frame, ImageSize, Renderer};
use splatvol_document::resolve::laid_over;
use splatvol_document::{Document, Picture, ReadRules, Record};
use splatvol_io::{ImageFormat, encode_image};

use super::engine::{News, Reporter, Warnings, lock, render, resolve};
use super::store::Store;
use super::trouble;

/// A picture that is to be written.
#[derive(Debug, Clone)]
pub(super) struct Saving {
    pub(super) document: Document,
    /// Its size, where the document has none.
    pub(super) size: ImageSize,
    pub(super) path: PathBuf,
    pub(super) overwrite: bool,
    /// The record of the picture that was opened, if one was.
    pub(super) earlier: Option<Record>,
    /// The command line that the picture carries.
    pub(super) command: String,
    pub(super) rules: ReadRules,
}

/// Starts a thread that writes a picture, with an engine of its own.
///
/// # Errors
/// Threads that the system refuses.
pub(super) fn start(
    saving: Saving,
    store: Arc<Mutex<Store>>,
    (stop, reporter): (Arc<AtomicBool>, Reporter),
) -> Result<(), std::io::Error> {
    std::thread::Builder::new()
        .name("picture".to_owned())
        .spawn(move || {
            let progress = |share| reporter.tell(News::Writing(share));
            let written = save(&saving, &store, (&stop, &progress));
            let written = written.map(|()| format!("wrote {}", saving.path.display()));
            reporter.tell(News::Written(written.map_err(trouble::of_saving)));
        })
        .map(drop)
}

impl Saving {
    /// Refuses paths to which nothing can be written, before anything is rendered.
    ///
    /// # Errors
    /// Names of no format, files that exist already, folders that do not.
    pub(super) fn check(&self) -> Result<(), String> {
        let path = &self.path;
        let is_scene = path
            .extension()
            .is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
        if ImageFormat::from_path(path).is_none() && !is_scene {
            return Err(format!(
                "{}: no picture format has this extension (.png and .exr), and .toml is a scene's",
                path.display()
            ));
        }
        if path.exists() && !self.overwrite {
            return Err(format!("{} already exists", path.display()));
        }
        match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
                Err(format!("{}: there is no such folder", folder.display()))
            }
            _ => Ok(()),
        }
    }
}

/// Renders and writes.
fn save(
    saving: &Saving,
    store: &Mutex<Store>,
    (stop, progress): (&AtomicBool, &(dyn Fn(f64) + Sync)),
) -> Result<(), String> {
    let path = &saving.path;
    let Some(format) = ImageFormat::from_path(path) else {
        return save_scene(saving);
    };
    let of = (&saving.document, saving.size);
    let own = Mutex::new(lock(store).without_chunks());
    let mut picture = resolve(&own, of, (saving.rules, &Warnings::default())).map_err(|e| e.to_string())?;
    if format == ImageFormat::Exr {
        // An EXR keeps its alpha, whatever the background.
        picture.scene.background = [0.0; 4];
    }
    let mut renderer = Renderer::new(EngineConfig::default()).map_err(|error| error.to_string())?;
    let frame = render(
        &mut renderer,
        &picture,
        &picture.settings,
        (&picture.sub_frames, stop),
        progress,
    );
    let frame = frame.map_err(|error| error.to_string())?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let record = record(
        &picture.document,
        (saving.earlier.as_ref(), &saving.command),
        folder,
    );
    let bytes = encode(&frame, &picture, (format, &record))?;
    write(path, &bytes, saving.overwrite)
}

/// Writes the document as a scene file, with its animation: at the size that it asks for, and with paths from the file's folder.
fn save_scene(saving: &Saving) -> Result<(), String> {
    let path = &saving.path;
    let record = Record {
        document: saving.document.clone(),
        command: String::new(),
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    let text = record.shortened(folder).document.to_toml();
    write(
        path,
        text.map_err(|error| error.to_string())?.as_bytes(),
        saving.overwrite,
    )
}

/// The record of a picture; one that is made as it was opened keeps its own.
fn record(document: &Document, (earlier, command): (Option<&Record>, &str), folder: &Path) -> Record {
    match earlier.filter(|earlier| earlier.document == *document) {
        Some(earlier) => earlier.clone(),
        None => Record {
            document: document.clone(),
            command: command.to_owned(),
        }
        .shortened(folder),
    }
}

fn encode(
    frame: &Frame,
    picture: &Picture,
    (format, record): (ImageFormat, &Record),
) -> Result<Vec<u8>, String> {
    let metadata = record.metadata().map_err(|error| error.to_string())?;
    let format = match format {
        ImageFormat::Png8 if picture.bits() == 16 => ImageFormat::Png16,
        format => format,
    };
    let encoded = match (format, picture.background()) {
        (ImageFormat::Exr, _) => encode_image(&frame.image, Some(&frame.depth), format, &metadata),
        (_, None) => encode_image(&frame.image, None, format, &metadata),
        (_, Some(background)) => encode_image(&laid_over(&frame.image, background), None, format, &metadata),
    };
    encoded.map_err(|error| error.to_string())
}

/// Writes all bytes, or leaves what was there.
fn write(path: &Path, bytes: &[u8], overwrite: bool) -> Result<(), String> {
    let failed = |error: std::io::Error| format!("cannot write {}: {error}", path.display());
    if path.exists() && !path.is_file() {
        return Err(format!("{} is no regular file", path.display()));
    }
    if !overwrite {
        // Claims the name, so that a file that appeared meanwhile survives.
        File::create_new(path).map_err(failed)?;
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let scratch = path.with_file_name(format!(".{}.{name}", std::process::id()));
    let filled = File::create_new(&scratch).and_then(|mut file| {
        file.write_all(bytes)?;
        file.sync_all()
    });
    let moved = filled.and_then(|()| std::fs::rename(&scratch, path));
    if moved.is_err() {
        // Whatever is left of them, nobody wants.
        let _ = std::fs::remove_file(&scratch);
        if !overwrite {
            let _ = std::fs::remove_file(path);
        }
    }
    moved.map_err(failed)
}
