//! What a page shows of a picture: its volumes, and a document that names no files.

use std::sync::Arc;

use splatvol::{Content, Volume};
use splatvol_document::keys::ItemKeys;
use splatvol_document::{Document, DocumentError, Picture};

use crate::{Bits, Fitted, PageError, fit};

/// What a page shows of a picture.
#[derive(Debug)]
pub struct PageContent<'a> {
    picture: &'a Picture,
    /// With whether they are labels.
    volumes: Vec<(Arc<Volume>, bool)>,
    distances: Vec<f64>,
}

impl<'a> PageContent<'a> {
    /// The content of a picture.
    ///
    /// # Errors
    /// Pictures that a page cannot show, by the key or the kind of data that it cannot.
    pub fn of(picture: &'a Picture) -> Result<Self, DocumentError> {
        check(picture)?;
        let items = picture.scene.items.iter();
        let all = items.filter_map(|item| match &item.content {
            Content::Volume {
                volume,
                transfer_function,
                labels,
                ..
            } => {
                let distance = transfer_function.unit_distance;
                let distance = distance.unwrap_or_else(|| volume.grid().mean_spacing());
                Some(((Arc::clone(volume), *labels), distance))
            }
            _ => None,
        });
        let (volumes, distances) = all.unzip();
        Ok(Self {
            picture,
            volumes,
            distances,
        })
    }

    /// The volumes, in the order of the items that are shown.
    pub fn volumes(&self) -> impl Iterator<Item = &Arc<Volume>> {
        self.volumes.iter().map(|(volume, _)| volume)
    }

    /// The lengths to which the opacities of the items refer, world.
    pub fn distances(&self) -> &[f64] {
        &self.distances
    }

    /// The volumes, made to fit: see [`fit`].
    ///
    /// # Errors
    /// See [`fit`].
    pub fn fit(&self, bits: Option<Bits>, most: u64) -> Result<Fitted, PageError> {
        fit(&self.volumes, bits, most)
    }

    /// The document of the page; items have the names that `name` makes of their files. At coarser levels than the finest,
    /// opacities refer to the lengths that they had.
    pub fn document(&self, level: usize, name: impl Fn(&str) -> String) -> Document {
        let all = self.picture.document.clone();
        let exact = all.effects.iso_exact == Some(true);
        let items = all.items.into_iter().filter(ItemKeys::is_visible);
        let items = items.enumerate().map(|(index, item)| {
            let mut look = item.transfer_function;
            let distance = self.distances.get(index).filter(|_| level > 0);
            if let (Some(look), Some(distance)) = (&mut look, distance) {
                look.unit_distance = Some(*distance);
            }
            ItemKeys {
                scale: item.scale,
                rotate: item.rotate,
                translate: item.translate,
                iso: item.iso.filter(|_| exact),
                unit_distance: item.unit_distance.or(distance.copied()),
                labels: item.labels,
                transfer_function: look,
                ..ItemKeys::of_file(name(&item.file))
            }
        });
        Document {
            name: None,
            bits: None,
            items: items.collect(),
            ..all
        }
    }
}

/// Refuses by name what a page cannot show.
fn check(picture: &Picture) -> Result<(), DocumentError> {
    let visible = picture.document.items.iter().filter(|item| item.is_visible());
    for (item, keys) in picture.scene.items.iter().zip(visible) {
        let kind = match item.content {
            Content::Volume { .. } => continue,
            Content::Mesh { .. } => "a mesh",
            Content::Points { .. } => "points",
            Content::Gaussians(_) => "Gaussians",
        };
        return Err(DocumentError::Refused {
            message: format!("{}, {kind}: a page cannot show it", keys.file),
            context: None,
            hint: Some("it shows volumes only".to_owned()),
        });
    }
    let effects = &picture.document.effects;
    let moves =
        !picture.sub_frames.is_empty() || picture.scene.items.iter().any(|item| item.motion.is_some());
    let asked = [
        (effects.bump.is_some(), "`effects.bump`"),
        (effects.environment.is_some(), "`effects.environment`"),
        (effects.tf2d.is_some(), "`effects.tf2d`"),
        (moves, "motion blur"),
        (picture.bits() == 16, "`bits` 16"),
    ];
    match asked.iter().find(|(asked, _)| *asked) {
        Some((_, what)) => Err(DocumentError::usage(format!("{what}: a page cannot show it"))),
        None => Ok(()),
    }
}
