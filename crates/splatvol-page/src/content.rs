//! What a page shows of a picture: its data, and a document that names no files.

use splatvol::{Content, Item};
use splatvol_document::keys::ItemKeys;
use splatvol_document::{Document, DocumentError, HeldContent, Picture};

use crate::{Bits, Fitted, PageError, Piece, fit};

/// What a page shows of a picture.
#[derive(Debug)]
pub struct PageContent<'a> {
    picture: &'a Picture,
    pieces: Vec<Piece>,
    distances: Vec<Option<f64>>,
}

impl<'a> PageContent<'a> {
    /// The content of a picture.
    ///
    /// # Errors
    /// Pictures that a page cannot show, by the key that it cannot.
    pub fn of(picture: &'a Picture) -> Result<Self, DocumentError> {
        check(picture)?;
        let items = &picture.scene.items;
        let pieces = items.iter().map(|item| Piece {
            content: HeldContent::from(&item.content),
            labels: matches!(item.content, Content::Volume { labels: true, .. }),
        });
        Ok(Self {
            picture,
            pieces: pieces.collect(),
            distances: items.iter().map(distance).collect(),
        })
    }

    /// The data, in the order of the items that are shown.
    pub fn data(&self) -> impl Iterator<Item = &HeldContent> {
        self.pieces.iter().map(|piece| &piece.content)
    }

    /// The lengths to which the opacities of the items refer, world; nothing for points and Gaussians.
    pub fn distances(&self) -> &[Option<f64>] {
        &self.distances
    }

    /// The data, made to fit: see [`fit`].
    ///
    /// # Errors
    /// See [`fit`].
    pub fn fit(&self, bits: &[Bits], most: u64) -> Result<Fitted, PageError> {
        fit(&self.pieces, bits, most)
    }

    /// The document of the page; items have the names that `name` makes of their files. At coarser levels than the finest, and for
    /// volumes that are read in chunks, opacities refer to the lengths that they had, and points that are fewer are larger.
    pub fn document(&self, level: usize, name: impl Fn(&str) -> String) -> Document {
        let all = self.picture.document.clone();
        let exact = all.effects.iso_exact == Some(true);
        let items = all.items.into_iter().filter(ItemKeys::is_visible);
        let items = items.zip(&self.picture.scene.items).zip(&self.distances);
        let items = items.map(|((keys, item), distance)| {
            let mut look = keys.transfer_function.clone();
            let coarse = distance.filter(|_| level > 0 || is_overview(item));
            if let (Some(look), Some(distance)) = (&mut look, coarse) {
                look.unit_distance = Some(distance);
            }
            ItemKeys {
                up: keys.up.filter(|_| !is_turned(&keys, item)),
                scale: keys.scale,
                rotate: keys.rotate,
                translate: keys.translate,
                iso: keys.iso.filter(|_| exact),
                unit_distance: keys.unit_distance.or(coarse),
                labels: keys.labels,
                color: keys.color,
                radius: keys.radius.map(|radius| radius * f64::from(1 << level)),
                opacity: match item.content {
                    Content::Points { .. } => keys.opacity,
                    _ => None,
                },
                transfer_function: look,
                ..ItemKeys::of_file(name(&keys.file))
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

/// Whether the samples in memory are an overview of others, which are read when they are drawn.
fn is_overview(item: &Item) -> bool {
    matches!(&item.content, Content::Volume { volume, .. } if volume.chunks().is_some())
}

/// Whether data have the way up that is asked for already: that of volumes, unlike that of all else, is none of an item's place.
fn is_turned(keys: &ItemKeys, item: &Item) -> bool {
    keys.world_from_file()
        .is_ok_and(|place| place == item.world_from_item)
}

/// The length to which the opacities of an item refer, world.
fn distance(item: &Item) -> Option<f64> {
    match &item.content {
        Content::Volume {
            volume,
            transfer_function,
            ..
        } => {
            let own = transfer_function.unit_distance;
            Some(own.unwrap_or_else(|| volume.finest_grid().mean_spacing()))
        }
        Content::Mesh {
            mesh,
            transfer_function,
            ..
        } => Some(
            transfer_function
                .unit_distance
                .unwrap_or_else(|| mesh.mean_spacing()),
        ),
        Content::Points { .. } | Content::Gaussians(_) => None,
    }
}

/// Refuses by name what a page cannot show.
fn check(picture: &Picture) -> Result<(), DocumentError> {
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
