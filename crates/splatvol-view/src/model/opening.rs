//! From a path to the document that it asks for: data become items, scenes and pictures are documents, and transfer functions
//! become the look of an item.

use std::path::Path;

use splatvol_document::format::{is_scene, path_outside, read_scene};
use splatvol_document::keys::{ItemKeys, PictureSize};
use splatvol_document::{Document, DocumentError, ReadRules, Record};

/// What a path asks for.
#[derive(Debug, Clone, PartialEq)]
pub enum Opening {
    /// A document: a scene file, or the one in a picture, with the picture's record.
    Document(Box<Document>, Option<Box<Record>>),
    /// Data, which become an item.
    Data(Box<ItemKeys>),
    /// A transfer function.
    Look(String),
}

impl Opening {
    /// Says what a path is, by its name, and reads it if it is a document.
    ///
    /// # Errors
    /// Scenes and pictures that cannot be read, pictures that do not say how they were made, or that name files
    /// elsewhere.
    pub fn of_path(path: &str, rules: ReadRules) -> Result<Self, DocumentError> {
        let file = Path::new(path);
        let has = |extensions: &[&str]| {
            let name = path.to_ascii_lowercase();
            file.is_file() && extensions.iter().any(|extension| name.ends_with(extension))
        };
        if is_scene(file) {
            return Ok(Self::Document(Box::new(read_scene(file)?), None));
        }
        if has(&[".png", ".exr"]) {
            return picture(file, rules);
        }
        if has(&[".json", ".itf", ".lut"]) {
            return Ok(Self::Look(path.to_owned()));
        }
        Ok(Self::Data(Box::new(ItemKeys::of_file(path))))
    }
}

/// The document of an earlier picture.
fn picture(path: &Path, rules: ReadRules) -> Result<Opening, DocumentError> {
    let record = Record::of_picture(path)?;
    if !rules.allow_outside
        && let Some(outside) = path_outside(record.document.paths(), Some(path))
    {
        let refused = format!("{outside}, which the picture names, lies outside its folder and this one");
        return Err(DocumentError::usage(refused).hinting("--allow-outside reads it"));
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let document = record.document.clone().located(folder);
    Ok(Opening::Document(Box::new(document), Some(Box::new(record))))
}

/// The document of several paths: data side by side, or one scene or picture alone.
///
/// # Errors
/// See [`Opening::of_path`]; scenes, pictures and transfer functions among several paths.
pub fn documents(paths: &[String], rules: ReadRules) -> Result<(Document, Option<Record>), DocumentError> {
    let mut items = Vec::new();
    for path in paths {
        match Opening::of_path(path, rules)? {
            Opening::Document(document, record) if paths.len() == 1 => {
                return Ok((*document, record.map(|record| *record)));
            }
            Opening::Data(item) => items.push(*item),
            Opening::Document(..) => {
                let refused =
                    format!("{path}: a scene or a picture says itself what is shown, and is opened alone");
                return Err(DocumentError::usage(refused));
            }
            Opening::Look(_) => {
                let refused = format!("{path}: a transfer function is opened where data are shown");
                return Err(DocumentError::usage(refused));
            }
        }
    }
    Ok((Document::of_items(items), None))
}

/// The document with another one's look: keys over those of an item, as flags are laid over an earlier picture.
#[must_use]
pub fn with_item_keys(document: &Document, index: usize, keys: ItemKeys) -> Document {
    let mut changed = document.clone();
    if let Some(item) = changed.items.get_mut(index) {
        *item = keys.over(item);
    }
    changed
}

/// The same data in the same place, with a look that is chosen again.
pub fn without_look(item: &ItemKeys) -> ItemKeys {
    ItemKeys {
        tf: None,
        cmap: None,
        clim: None,
        opacity: None,
        iso: None,
        labels: None,
        transfer_function: None,
        ..item.clone()
    }
}

/// The size of the view in a pane: the document's if it fits, the largest of the same shape if not, and the pane's if
/// the document leaves it open. All in pixels.
pub fn view_size(asked: Option<PictureSize>, [width, height]: [u32; 2]) -> [u32; 2] {
    let Some(PictureSize(size)) = asked else {
        return [width, height];
    };
    if size.width() <= width && size.height() <= height {
        return [size.width(), size.height()];
    }
    let scale =
        (f64::from(width) / f64::from(size.width())).min(f64::from(height) / f64::from(size.height()));
    [size.width(), size.height()].map(|side| ((f64::from(side) * scale).round() as u32).max(1))
}

#[cfg(test)]
mod tests {
    use splatvol::ImageSize;

    use super::*;

    #[test]
    fn pictures_keep_their_shape_in_any_pane() {
        let asked = |width, height| Some(PictureSize(ImageSize::new(width, height).unwrap()));
        assert_eq!(view_size(None, [800, 500]), [800, 500]);
        assert_eq!(view_size(asked(400, 400), [800, 500]), [400, 400]);
        assert_eq!(view_size(asked(4000, 1000), [800, 500]), [800, 200]);
        assert_eq!(view_size(asked(1000, 4000), [800, 500]), [125, 500]);
    }

    #[test]
    fn data_are_items_and_pictures_without_a_record_are_refused() {
        let rules = ReadRules::default();
        let head = Opening::of_path("sample:head", rules).unwrap();
        assert_eq!(head, Opening::Data(Box::new(ItemKeys::of_file("sample:head"))));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let frame = splatvol::Frame::empty(ImageSize::new(2, 2).unwrap());
        splatvol_io::write_frame(&path, &frame, &[]).unwrap();
        let error = Opening::of_path(&path.to_string_lossy(), rules).unwrap_err();
        assert!(
            error.to_string().contains("does not say how it was made"),
            "{error}"
        );
        let several = ["sample:head".to_owned(), "sample:tomato".to_owned()];
        assert_eq!(documents(&several, rules).unwrap().0.items.len(), 2);
    }
}
