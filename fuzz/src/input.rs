//! One input: a file, or several in a folder.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use crate::coat;
use crate::mutate::LONGEST;
use crate::random::Random;

/// Files with their paths, and which of them is opened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Input {
    /// The path that is opened; empty for the folder.
    pub(crate) open: String,
    pub(crate) files: Vec<(String, Vec<u8>)>,
}

impl Input {
    pub(crate) fn file(name: &str, bytes: impl Into<Vec<u8>>) -> Self {
        Self {
            open: name.to_owned(),
            files: vec![(name.to_owned(), bytes.into())],
        }
    }

    /// Several files; `open` is one of them, or empty for their folder.
    pub(crate) fn files(open: &str, files: Vec<(String, Vec<u8>)>) -> Self {
        Self {
            open: open.to_owned(),
            files,
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.files.iter().map(|(_, bytes)| bytes.len()).sum()
    }

    /// Writes into a new folder; returns what is to be opened.
    pub(crate) fn write(&self, folder: &Path) -> Result<PathBuf> {
        if folder.exists() {
            std::fs::remove_dir_all(folder).with_context(|| folder.display().to_string())?;
        }
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        for (name, bytes) in &self.files {
            let path = folder.join(name);
            if let Some(parent) = path.parent() {
                std::fs::create_dir_all(parent).with_context(|| parent.display().to_string())?;
            }
            std::fs::write(&path, bytes).with_context(|| path.display().to_string())?;
        }
        Ok(folder.join(&self.open))
    }

    /// Reads what [`Input::write`] wrote, for the seed that it came from.
    pub(crate) fn read(folder: &Path, open: &str) -> Result<Self> {
        let mut files = Vec::new();
        collect(folder, folder, &mut files)?;
        files.sort();
        Ok(Self::files(open, files))
    }

    /// A damaged copy; parts may come from another input.
    pub(crate) fn damaged(&self, random: &mut Random, dictionary: &[&str], other: &Self) -> Self {
        let mut copy = self.clone();
        if copy.files.is_empty() || other.files.is_empty() {
            return copy;
        }
        let chosen = random.below(copy.files.len());
        let donor = &random.one_of(&other.files).1;
        if copy.files.len() > 1 && random.below(24) == 0 {
            let bytes = match random.below(3) {
                0 => Vec::new(),
                1 => donor.clone(),
                _ => copy.files.swap_remove(chosen).1,
            };
            if let Some((_, kept)) = copy.files.get_mut(chosen) {
                *kept = bytes;
            }
            return copy;
        }
        let (_, bytes) = &mut copy.files[chosen];
        coat::damage(bytes, random, dictionary, donor);
        bytes.truncate(LONGEST);
        copy
    }
}

fn collect(root: &Path, folder: &Path, files: &mut Vec<(String, Vec<u8>)>) -> Result<()> {
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.is_dir() {
            collect(root, &path, files)?;
        } else if let Ok(name) = path.strip_prefix(root) {
            files.push((name.to_string_lossy().into_owned(), std::fs::read(&path)?));
        }
    }
    Ok(())
}
