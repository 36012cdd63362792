//! Paths in records: no more about a machine than finding the files again takes.

use std::path::{Component, Path, PathBuf};

use super::Record;
use crate::Document;
use crate::input::locate;

impl Document {
    /// Every path of a file, and every address, that the document names and that is read; samples have none.
    pub fn paths(&self) -> Vec<&str> {
        let items = self.items.iter().flat_map(|item| {
            // A transfer function goes over its file.
            let tf = item.tf.as_ref().filter(|_| item.transfer_function.is_none());
            [Some(&item.file), item.drape.as_ref(), item.solution.as_ref(), tf]
        });
        let effects = &self.effects;
        let others = [
            &effects.bump,
            &effects.environment,
            &effects.tf2d,
            &self.animation.path,
        ];
        let all = items.chain(others.map(Option::as_ref)).flatten();
        all.map(String::as_str)
            .filter(|path| !path.starts_with("sample:"))
            .collect()
    }

    fn paths_mut(&mut self) -> impl Iterator<Item = &mut String> {
        let items = self.items.iter_mut().flat_map(|item| {
            [
                Some(&mut item.file),
                item.drape.as_mut(),
                item.solution.as_mut(),
                item.tf.as_mut(),
            ]
        });
        let effects = &mut self.effects;
        let others = [
            &mut effects.bump,
            &mut effects.environment,
            &mut effects.tf2d,
            &mut self.animation.path,
        ];
        let named = items.chain(others.map(Option::as_mut)).flatten();
        named.filter(|path| !path.starts_with("sample:") && !is_address(path))
    }

    /// The document of a picture in a folder, for the current one: paths that lead nowhere from here, but to a file from there, lead
    /// there. [`crate::Reading::folder`] finds the same files one by one.
    #[must_use]
    pub fn located(mut self, folder: &Path) -> Self {
        for path in self.paths_mut() {
            *path = locate(Path::new(path), Some(folder))
                .to_string_lossy()
                .into_owned();
        }
        self
    }
}

impl Document {
    /// The document with paths that lead to its files from any folder.
    #[must_use]
    pub fn absolute(mut self) -> Self {
        for path in self.paths_mut() {
            if let Ok(absolute) = std::path::absolute(&*path) {
                *path = absolute.to_string_lossy().into_owned();
            }
        }
        self
    }
}

impl Record {
    /// The record for a picture in a folder. Absolute paths say who works where: those inside the current folder become
    /// relative to it, others relative to the picture's folder, and where they share no more than the root, only the
    /// file's name stays.
    #[must_use]
    pub fn shortened(mut self, folder: &Path) -> Self {
        for path in self.document.paths_mut() {
            *path = shortened(path, folder);
        }
        self
    }
}

/// A path as a record holds it; see [`Record::shortened`].
pub fn shortened(path: &str, folder: &Path) -> String {
    let absolute = Path::new(path);
    if !absolute.is_absolute() {
        return path.to_owned();
    }
    let current = std::env::current_dir().unwrap_or_default();
    if let Ok(inside) = absolute.strip_prefix(&current)
        && !inside.as_os_str().is_empty()
    {
        return inside.to_string_lossy().into_owned();
    }
    let folder = std::path::absolute(folder).unwrap_or(current);
    let relative = between(&folder, absolute);
    let short = relative.unwrap_or_else(|| absolute.file_name().unwrap_or_default().into());
    short.to_string_lossy().into_owned()
}

/// The path from a folder to a file, both absolute; `None` where they share no more than the root.
fn between(folder: &Path, file: &Path) -> Option<PathBuf> {
    let is_name = |component: &Component<'_>| matches!(component, Component::Normal(_));
    let pairs = folder.components().zip(file.components());
    let common: Vec<Component<'_>> = pairs.take_while(|(a, b)| a == b).map(|(a, _)| a).collect();
    if !common.iter().any(is_name) || folder.components().any(|part| part == Component::ParentDir) {
        return None;
    }
    let up = folder
        .components()
        .skip(common.len())
        .map(|_| Component::ParentDir);
    Some(up.chain(file.components().skip(common.len())).collect())
}

/// Whether a path is the address of a store, which is the same everywhere.
fn is_address(path: &str) -> bool {
    splatvol_io::remote::address(Path::new(path)).is_some()
}

/// The first of the paths that a picture's record names and that leads elsewhere than into the current folder or the
/// picture's, and below, or that is an address. Whoever made the picture chose them. Paths that lead nowhere pass: readers say so.
pub fn path_outside<'a>(paths: impl IntoIterator<Item = &'a str>, picture: Option<&Path>) -> Option<&'a str> {
    let current = std::env::current_dir().ok();
    let beside = picture.map(|picture| picture.parent().unwrap_or(Path::new("")).join(""));
    let beside = beside.and_then(|folder| std::path::absolute(folder).ok());
    let folders: Vec<PathBuf> = [current, beside]
        .into_iter()
        .flatten()
        .filter_map(|folder| folder.canonicalize().ok())
        .collect();
    paths.into_iter().find(|path| {
        if is_address(path) {
            return true;
        }
        let mut found = folders
            .iter()
            .filter_map(|folder| folder.join(path).canonicalize().ok());
        found
            .next()
            .is_some_and(|found| !folders.iter().any(|folder| found.starts_with(folder)))
    })
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn absolute_paths_become_relative_or_names() {
        let current = std::env::current_dir().unwrap();
        let inside = current.join("data/scan.nrrd").display().to_string();
        for (path, folder, short) in [
            ("data/scan.nrrd", "/a", "data/scan.nrrd"),
            ("../scan.nrrd", "/a", "../scan.nrrd"),
            (inside.as_str(), "/a", "data/scan.nrrd"),
            ("/a/b/data/scan.nrrd", "/a/b/out", "../data/scan.nrrd"),
            ("/a/b/scan.nrrd", "/a/b", "scan.nrrd"),
            ("/mnt/b/scan.nrrd", "/a/b/out", "scan.nrrd"),
        ] {
            assert_eq!(shortened(path, Path::new(folder)), short, "{path} {folder}");
        }
    }

    #[test]
    fn all_files_of_a_document_are_shortened_and_samples_stay() {
        let mut items = ["sample:head", "/mnt/x/scan.nrrd"]
            .map(crate::keys::ItemKeys::of_file)
            .to_vec();
        items[1].drape = Some("/mnt/x/photo.png".to_owned());
        items[1].solution = Some("/mnt/x/solution.q".to_owned());
        items[1].tf = Some("/mnt/x/look.json".to_owned());
        let document = Document {
            items,
            effects: crate::keys::EffectKeys {
                bump: Some("/mnt/x/word.png".to_owned()),
                ..Default::default()
            },
            animation: crate::keys::AnimationKeys {
                path: Some("/mnt/x/path.toml".to_owned()),
                ..Default::default()
            },
            ..Document::default()
        };
        let record = Record {
            document,
            command: String::new(),
        };
        let short = record.shortened(Path::new("/a/b")).document;
        let names = [
            "scan.nrrd",
            "photo.png",
            "solution.q",
            "look.json",
            "word.png",
            "path.toml",
        ];
        assert_eq!(short.paths(), names);
        assert_eq!(short.items[0].file, "sample:head");
    }

    #[test]
    fn files_are_found_here_first_and_then_in_the_pictures_folder() {
        let folder = std::env::temp_dir().join(format!("splatvol-located-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        for name in ["there.png", "Cargo.toml"] {
            std::fs::write(folder.join(name), "").unwrap();
        }
        // Tests run in the folder of the crate, whose Cargo.toml goes first.
        let names = ["sample:head", "there.png", "Cargo.toml", "nowhere.png"];
        let document = Document::of_items(names.map(crate::keys::ItemKeys::of_file)).located(&folder);
        let _ = std::fs::remove_dir_all(&folder);
        let there = folder.join("there.png").display().to_string();
        let found: Vec<&str> = document.items.iter().map(|item| item.file.as_str()).collect();
        assert_eq!(found, ["sample:head", &there, "Cargo.toml", "nowhere.png"]);
    }
}
