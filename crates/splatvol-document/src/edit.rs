//! Edits of a document, and their undoing.
//!
//! An edit names a key by its path, `camera.azimuth` or `item[2].cmap`, and gives it a value, or none; or it adds,
//! removes or moves an item. Every edit has an inverse, which is an edit too: undoing applies it, and redoing undoes
//! that.

use serde_json::Value;

use crate::keys::ItemKeys;
use crate::{Document, DocumentError};

/// A change of a document.
#[derive(Debug, Clone, PartialEq)]
pub enum Edit {
    /// Gives a key a value, as JSON has it, or leaves it open again.
    Set {
        /// Path of the key: names separated by dots, items by their number.
        path: String,
        /// The value; `None` removes the key.
        value: Option<Value>,
    },
    /// Inserts an item in this place; those after it move one place on.
    Insert(usize, Box<ItemKeys>),
    /// Removes the item in this place.
    Remove(usize),
    /// Moves an item from one place to another.
    Move(usize, usize),
    /// Replaces everything, as by another file.
    Replace(Box<Document>),
}

impl Edit {
    /// A key and its value.
    pub fn set(path: impl Into<String>, value: impl Into<Value>) -> Self {
        Self::Set {
            path: path.into(),
            value: Some(value.into()),
        }
    }

    /// A key that is left open again.
    pub fn unset(path: impl Into<String>) -> Self {
        Self::Set {
            path: path.into(),
            value: None,
        }
    }
}

/// A document with the edits that led to it.
#[derive(Debug, Clone, Default)]
pub struct History {
    document: Document,
    /// Inverses of the edits made, the last one last.
    undo: Vec<Edit>,
    /// Inverses of the edits undone.
    redo: Vec<Edit>,
}

impl History {
    /// A document that nobody has edited.
    pub fn new(document: Document) -> Self {
        Self {
            document,
            ..Self::default()
        }
    }

    /// The document as it is.
    pub fn document(&self) -> &Document {
        &self.document
    }

    /// Whether there is an edit to undo.
    pub fn can_undo(&self) -> bool {
        !self.undo.is_empty()
    }

    /// Whether there is an edit to repeat.
    pub fn can_redo(&self) -> bool {
        !self.redo.is_empty()
    }

    /// Makes an edit.
    ///
    /// # Errors
    /// Keys that do not exist, values of the wrong kind, items that are not there; the document is then as before.
    pub fn edit(&mut self, edit: Edit) -> Result<(), DocumentError> {
        let inverse = self.document.apply(edit)?;
        self.undo.push(inverse);
        self.redo.clear();
        Ok(())
    }

    /// Makes an edit that continues the last one, as while something is dragged: both are undone at once if they change
    /// the same key.
    ///
    /// # Errors
    /// See [`History::edit`].
    pub fn edit_on(&mut self, edit: Edit) -> Result<(), DocumentError> {
        let continues = match (&edit, self.undo.last()) {
            (Edit::Set { path, .. }, Some(Edit::Set { path: last, .. })) => path == last,
            _ => false,
        };
        if !continues {
            return self.edit(edit);
        }
        self.document.apply(edit)?;
        self.redo.clear();
        Ok(())
    }

    /// Undoes the last edit; returns whether there was one.
    ///
    /// # Errors
    /// Never: inverses can be made.
    pub fn undo(&mut self) -> Result<bool, DocumentError> {
        let Some(inverse) = self.undo.pop() else {
            return Ok(false);
        };
        let again = self.document.apply(inverse)?;
        self.redo.push(again);
        Ok(true)
    }

    /// Repeats the edit that was undone last; returns whether there was one.
    ///
    /// # Errors
    /// Never: inverses can be made.
    pub fn redo(&mut self) -> Result<bool, DocumentError> {
        let Some(again) = self.redo.pop() else {
            return Ok(false);
        };
        let inverse = self.document.apply(again)?;
        self.undo.push(inverse);
        Ok(true)
    }
}

impl Document {
    /// Makes an edit, and returns the one that undoes it.
    ///
    /// # Errors
    /// Keys that do not exist, values of the wrong kind, items that are not there; the document is then as before.
    pub fn apply(&mut self, edit: Edit) -> Result<Edit, DocumentError> {
        let there = |index: usize, count: usize| match index < count {
            true => Ok(()),
            false => Err(DocumentError::refused(
                &format!("item[{index}]"),
                format!("is not there: {count} are"),
            )),
        };
        let count = self.items.len();
        match edit {
            Edit::Insert(index, item) => {
                there(index, count + 1)?;
                self.items.insert(index, *item);
                Ok(Edit::Remove(index))
            }
            Edit::Remove(index) => {
                there(index, count)?;
                let item = self.items.remove(index);
                Ok(Edit::Insert(index, Box::new(item)))
            }
            Edit::Move(from, to) => {
                there(from, count)?;
                there(to, count)?;
                let item = self.items.remove(from);
                self.items.insert(to, item);
                Ok(Edit::Move(to, from))
            }
            Edit::Replace(document) => {
                let before = std::mem::replace(self, *document);
                Ok(Edit::Replace(Box::new(before)))
            }
            Edit::Set { path, value } => self.set(path, value),
        }
    }

    fn set(&mut self, path: String, value: Option<Value>) -> Result<Edit, DocumentError> {
        let refused = |why: &str| DocumentError::refused(&path, why);
        let mut tree = serde_json::to_value(&*self).map_err(|error| refused(&error.to_string()))?;
        let (tables, key) = match path.rsplit_once('.') {
            Some((tables, key)) => (tables.split('.').collect(), key),
            None => (Vec::new(), path.as_str()),
        };
        let mut table = &mut tree;
        for name in tables {
            table = entry(table, name).ok_or_else(|| refused("is not there"))?;
        }
        let entries = table.as_object_mut().ok_or_else(|| refused("is not there"))?;
        let before = match value.filter(|value| !value.is_null()) {
            Some(value) => entries.insert(key.to_owned(), value),
            None => entries.remove(key),
        };
        let edited: Self = serde_json::from_value(tree).map_err(|error| refused(&format!(": {error}")))?;
        if edited.version != self.version {
            return Err(refused(
                "says how the document is written, and is no matter of edits",
            ));
        }
        *self = edited;
        Ok(Edit::Set { path, value: before })
    }
}

/// The table of this name, created if absent: `settings`, or `item[2]`.
fn entry<'a>(table: &'a mut Value, name: &str) -> Option<&'a mut Value> {
    let entries = table.as_object_mut()?;
    match name.strip_suffix(']').and_then(|name| name.split_once('[')) {
        Some((name, index)) => entries.get_mut(name)?.get_mut(index.parse::<usize>().ok()?),
        None => Some(
            entries
                .entry(name)
                .or_insert_with(|| Value::Object(serde_json::Map::new())),
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_are_made_undone_and_made_again() {
        let start = Document::of_items([ItemKeys::of_file("a.nrrd"), ItemKeys::of_file("b.ply")]);
        let mut history = History::new(start.clone());
        history.edit(Edit::set("camera.azimuth", 30.0)).unwrap();
        history.edit(Edit::set("item[0].cmap", "viridis")).unwrap();
        history.edit(Edit::Move(0, 1)).unwrap();
        history.edit(Edit::Remove(0)).unwrap();
        history.edit(Edit::unset("camera.azimuth")).unwrap();
        let end = history.document().clone();
        assert_eq!(end.items[0].cmap.as_deref(), Some("viridis"));
        assert!(end.camera.is_empty());
        while history.undo().unwrap() {}
        assert_eq!(history.document(), &start);
        while history.redo().unwrap() {}
        assert_eq!(history.document(), &end);
    }

    #[test]
    fn what_is_dragged_is_undone_at_once() {
        let mut history = History::default();
        for azimuth in 0..9 {
            history
                .edit_on(Edit::set("camera.azimuth", f64::from(azimuth)))
                .unwrap();
        }
        assert_eq!(history.document().camera.azimuth, Some(8.0));
        assert!(history.undo().unwrap() && history.document() == &Document::default());
        assert!(!history.undo().unwrap());
    }

    #[test]
    fn what_cannot_be_is_refused_and_changes_nothing() {
        let mut document = Document::default();
        for edit in [
            Edit::set("camera.azimut", 3),
            Edit::set("camera.azimuth", "far"),
            Edit::set("item[0].cmap", "gray"),
            Edit::set("size.width", 3),
            Edit::set("version", 1),
            Edit::Remove(0),
        ] {
            let error = document.apply(edit.clone()).unwrap_err().to_string();
            assert!(!error.is_empty() && document == Document::default(), "{edit:?}");
        }
    }
}
