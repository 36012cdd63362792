//! Folders of keys: on a disk, or in a store.

use std::fmt::{self, Debug, Formatter};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::Value;

use super::{IoError, is_zarr};
use crate::error::Context;
use crate::files;
use crate::key_store::{ByteRange, KeyStore};
use crate::source::{check_inside, read_file};
use crate::volume::detect::natural_order;

/// Most bytes of metadata in a store.
const METADATA: u64 = 64 << 20;
/// Images that are looked for in a store, which lists nothing.
const SERIES: usize = 1000;

/// A folder.
#[derive(Clone)]
pub(super) struct Folder {
    /// The folder, or its address in a store.
    path: PathBuf,
    /// The store, and the folder's key there.
    stored: Option<(Arc<dyn KeyStore>, String)>,
}

impl Debug for Folder {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        self.path.fmt(formatter)
    }
}

impl PartialEq for Folder {
    fn eq(&self, other: &Self) -> bool {
        self.path == other.path
    }
}

impl Folder {
    /// On a disk.
    pub(super) fn on_disk(path: &Path) -> Self {
        Self {
            path: path.to_owned(),
            stored: None,
        }
    }

    /// The root of a store.
    pub(super) fn of_store(store: Arc<dyn KeyStore>) -> Self {
        Self {
            path: PathBuf::from(store.name()),
            stored: Some((store, String::new())),
        }
    }

    /// The path or the address.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// The store and the key of a name in this folder; `None` on a disk.
    pub(super) fn stored(&self, name: &str) -> Option<(&dyn KeyStore, String)> {
        let (store, key) = self.stored.as_ref()?;
        Some((&**store, join_keys(key, name)))
    }

    /// A folder in it. An empty name is the folder itself.
    pub(super) fn join(&self, name: &str) -> Self {
        let inner = |(store, key): &(Arc<dyn KeyStore>, String)| (Arc::clone(store), join_keys(key, name));
        Self {
            path: match name.is_empty() {
                true => self.path.clone(),
                false => self.path.join(name),
            },
            stored: self.stored.as_ref().map(inner),
        }
    }

    /// A JSON file in it, or `None` if it does not exist, or a store denies it.
    pub(super) fn json(&self, name: &str) -> Result<Option<Value>, IoError> {
        let path = self.path.join(name);
        let context = &Context::new("Zarr metadata", &path);
        let bytes = match self.stored(name) {
            Some((store, key)) => match store.read(&key, ByteRange::All, METADATA) {
                Ok(Some(bytes)) => bytes,
                Ok(None) => return Ok(None),
                // Object stores that list nothing say so of what is not there.
                Err(error) if error.kind() == io::ErrorKind::PermissionDenied => return Ok(None),
                Err(error) => return Err(context.unreachable(error)),
            },
            None if !files::is_file(&path) => return Ok(None),
            None => read_file(&path, context)?,
        };
        let value = serde_json::from_slice(&bytes);
        value
            .map(Some)
            .map_err(|error| context.field("JSON", error, None, "well-formed JSON"))
    }

    /// Refuses a link that leads out of a folder; stores have none.
    pub(super) fn check_inside(&self, outer: &Self, context: &Context<'_>) -> Result<(), IoError> {
        match self.stored {
            Some(_) => Ok(()),
            None => check_inside(&self.path, &outer.path, context),
        }
    }

    /// Names of the groups and arrays in it, in their natural order; in a store, of those that are named `0`, `1`, ...
    pub(super) fn series(&self, context: &Context<'_>) -> Result<Vec<String>, IoError> {
        if self.stored.is_some() {
            let names = (0..SERIES).map(|number| number.to_string());
            let mut found = Vec::new();
            for name in names {
                let folder = self.join(&name);
                let is_there = |file: &str| folder.json(file).map(|json| json.is_some());
                if !is_there(".zattrs")? && !is_there("zarr.json")? && !is_there(".zarray")? {
                    break;
                }
                found.push(name);
            }
            return Ok(found);
        }
        let mut names: Vec<String> = files::read_dir(&self.path)
            .map_err(|error| context.read(error))?
            .flatten()
            .filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()) && is_zarr(&entry.path()))
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .collect();
        names.sort_by(|a, b| natural_order(a, b));
        // OME's own metadata are not an image.
        names.retain(|name| name != "OME");
        Ok(names)
    }
}

fn join_keys(key: &str, name: &str) -> String {
    match (key, name) {
        ("", name) => name.to_owned(),
        (key, "") => key.to_owned(),
        (key, name) => format!("{key}/{name}"),
    }
}

impl Context<'_> {
    /// A store that does not answer.
    fn unreachable(&self, source: io::Error) -> IoError {
        IoError::Open {
            source,
            path: self.path.to_owned(),
        }
    }
}
