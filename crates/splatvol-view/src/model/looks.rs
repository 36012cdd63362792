//! Two looks, A and B, of which one is shown. A look is what items look like and how they are drawn; data, places, camera and
//! clips are common to both.

use splatvol_document::Document;
use splatvol_document::keys::{EffectKeys, ItemKeys, SettingKeys};

use super::store::reading_keys;

/// The look of a document.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    items: Vec<ItemKeys>,
    settings: SettingKeys,
    /// Without clips.
    effects: EffectKeys,
}

impl Look {
    /// The look that a document has.
    pub fn of(document: &Document) -> Self {
        Self {
            items: document.items.clone(),
            settings: document.settings.clone(),
            effects: EffectKeys {
                clip_plane: None,
                clip_box: None,
                clip_inside: None,
                ..document.effects.clone()
            },
        }
    }

    /// The document with this look. Items of other data than when the look was taken keep theirs.
    #[must_use]
    pub fn on(&self, document: &Document) -> Document {
        let mut changed = document.clone();
        changed.settings = self.settings.clone();
        changed.effects = EffectKeys {
            clip_plane: changed.effects.clip_plane,
            clip_box: changed.effects.clip_box,
            clip_inside: changed.effects.clip_inside,
            ..self.effects.clone()
        };
        for (item, look) in changed.items.iter_mut().zip(&self.items) {
            if reading_keys(item) == reading_keys(look) {
                *item = ItemKeys {
                    visible: item.visible,
                    up: item.up,
                    scale: item.scale,
                    rotate: item.rotate.clone(),
                    translate: item.translate,
                    ..look.clone()
                };
            }
        }
        changed
    }
}

/// Both looks.
#[derive(Debug, Default)]
pub struct Looks {
    /// The look that is not shown, once there is one.
    other: Option<Look>,
    shows_b: bool,
}

impl Looks {
    /// The letter of the look that is shown, if there are two.
    pub fn letter(&self) -> Option<char> {
        self.other.as_ref().map(|_| if self.shows_b { 'B' } else { 'A' })
    }

    /// Changes to the other look: the document with it, or `None` if there was none, and B begins as a copy of A.
    pub(super) fn change(&mut self, document: &Document) -> Option<Document> {
        self.shows_b = !self.shows_b;
        let other = self.other.replace(Look::of(document));
        other.map(|look| look.on(document))
    }

    /// Follows a document that a step of the history changed: it may be the step from one look to the other.
    pub(super) fn follow(&mut self, before: Look, document: &Document) {
        let now = Look::of(document);
        if now != before && self.other.as_ref() == Some(&now) {
            self.other = Some(before);
            self.shows_b = !self.shows_b;
        }
    }
}

#[cfg(test)]
mod tests {
    use splatvol::Region;

    use super::*;

    #[test]
    fn a_look_has_its_regions_and_leaves_the_clips() {
        let region = Region {
            value: [1.0, 2.0],
            gradient: [0.0, 3.0],
            rgb: [1.0; 3],
            opacity: 0.5,
            softness: 0.2,
        };
        let mut document = Document::of_items([ItemKeys::of_file("a.nrrd")]);
        document.effects.regions = Some(vec![region]);
        document.effects.clip_box = Some([0.0, 1.0, 0.0, 1.0, 0.0, 1.0]);
        let mut looks = Looks::default();
        assert!(looks.change(&document).is_none());
        document.effects.regions = None;
        document.effects.clip_box = Some([0.0, 2.0, 0.0, 2.0, 0.0, 2.0]);
        let other = looks.change(&document).unwrap();
        assert_eq!(other.effects.regions, Some(vec![region]));
        assert_eq!(other.effects.clip_box, document.effects.clip_box);
        let back = looks.change(&other).unwrap();
        assert_eq!(back, document);
    }
}
