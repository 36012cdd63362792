//! Modules for browsers: built for users or for tests, committed with a release, and compared with what is committed.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use flate2::Compression;
use flate2::write::GzEncoder;

use crate::sources::{BUILT, COMMITTED, PROFILES, digest, note_of, noted};
use crate::toolchain::{Toolchain, not_found};

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Wish {
    /// Modules for the programs of this machine, by a cargo profile.
    Built(&'static str),
    /// Modules of the next release, in the repository.
    Committed,
    /// Whether the committed modules are what their sources give.
    Checked,
}

impl Wish {
    /// What the arguments of a task ask for.
    pub(crate) fn of(arguments: &[String]) -> Result<Self> {
        let [for_users, for_tests] = PROFILES;
        match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
            [] => Ok(Self::Built(for_users)),
            ["--dev"] => Ok(Self::Built(for_tests)),
            ["--committed"] => Ok(Self::Committed),
            ["--check"] => Ok(Self::Checked),
            _ => bail!("unknown arguments {arguments:?}: one of --dev, --committed, --check"),
        }
    }
}

/// Builds two files by a toolchain and a cargo profile.
type Build = fn(&Toolchain, &str) -> Result<[Vec<u8>; 2]>;

/// Modules that are built from one crate.
pub(crate) struct Modules {
    /// The crate.
    pub(crate) name: &'static str,
    /// Their files.
    pub(crate) files: [&'static str; 2],
    /// Builds them; they are not compressed yet.
    pub(crate) build: Build,
}

impl Modules {
    /// Does what is asked for.
    pub(crate) fn run(&self, root: &Path, wish: Wish) -> Result<String> {
        let Some(toolchain) = Toolchain::find(root)? else {
            return Ok(not_found());
        };
        let task = Task {
            modules: self,
            note: Note {
                sources: digest(root, self.name).context("the sources of a module cannot be read")?,
                compiler: toolchain.compiler()?,
                linker: toolchain.linker_version()?,
            },
            toolchain,
            root,
        };
        match wish {
            Wish::Built(profile) => task.built(profile),
            Wish::Committed => task.committed(),
            Wish::Checked => task.checked(),
        }
    }
}

/// What modules were built from, and by what.
#[derive(Debug, PartialEq, Eq)]
struct Note {
    sources: String,
    compiler: String,
    linker: String,
}

impl Note {
    fn read(path: &Path) -> Option<Self> {
        let text = std::fs::read_to_string(path).ok()?;
        let value = |key| noted(&text, key).map(str::to_owned);
        Some(Self {
            sources: value("sources")?,
            compiler: value("compiler")?,
            linker: value("linker")?,
        })
    }

    fn text(&self) -> String {
        let Self {
            sources,
            compiler,
            linker,
        } = self;
        format!("sources = {sources}\ncompiler = {compiler}\nlinker = {linker}\n")
    }
}

struct Task<'a> {
    modules: &'a Modules,
    note: Note,
    toolchain: Toolchain,
    root: &'a Path,
}

impl Task<'_> {
    /// Builds modules by a profile, unless they are there.
    fn built(&self, profile: &str) -> Result<String> {
        let folder = self.place(BUILT).join(profile);
        let names = self.modules.files.join(", ");
        if self.note_in(&folder).as_ref() == Some(&self.note) {
            return Ok(format!("{names} are up to date"));
        }
        // Programs prefer those for users, and tests do, too.
        let [for_users, for_tests] = PROFILES;
        let better = [self.place(BUILT).join(for_users), self.place(COMMITTED)];
        let is_current = |folder: &PathBuf| {
            self.note_in(folder)
                .is_some_and(|note| note.sources == self.note.sources)
        };
        if profile == for_tests && better.iter().any(is_current) {
            return Ok(format!("{names}: those for users are of these sources"));
        }
        let built = (self.modules.build)(&self.toolchain, profile)?;
        std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
        let mut said = Vec::new();
        for (name, bytes) in self.modules.files.iter().zip(built) {
            let packed = packed(&bytes)?;
            said.push(format!("{name} has {} bytes ({})", packed.len(), bytes.len()));
            write(&folder.join(name), &packed)?;
        }
        // Last, so that it vouches for the others.
        write(&self.note_path(&folder), self.note.text().as_bytes())?;
        Ok(format!(
            "{}; by {}, the std in {}; programs built from now on include them",
            said.join(", "),
            self.note.compiler,
            self.toolchain.std.display()
        ))
    }

    /// Puts modules of these sources where they are committed.
    fn committed(&self) -> Result<String> {
        let [for_users, _] = PROFILES;
        let said = self.built(for_users)?;
        let (from, to) = (self.place(BUILT).join(for_users), self.place(COMMITTED));
        std::fs::create_dir_all(&to).with_context(|| to.display().to_string())?;
        let note = note_of(self.modules.name);
        for name in self.modules.files.iter().chain([&note.as_str()]) {
            let copied = std::fs::copy(from.join(name), to.join(name));
            copied.with_context(|| (*name).to_owned())?;
        }
        Ok(format!("{said}; copied to {}", to.display()))
    }

    /// Compares the committed modules with what their sources give.
    fn checked(&self) -> Result<String> {
        let names = self.modules.files.join(", ");
        let committed = self.place(COMMITTED);
        let Some(note) = self.note_in(&committed) else {
            return Ok(format!("{names}: none are committed"));
        };
        if note.sources != self.note.sources {
            return Ok(format!(
                "{names}: the committed ones are older than the sources; scripts/engines renews them before a release"
            ));
        }
        if note != self.note {
            let by = |note: &Note| format!("{}, {}", note.compiler, note.linker);
            let (theirs, ours) = (by(&note), by(&self.note));
            return Ok(format!(
                "{names}: not compared: they are of these sources, but by {theirs}; here is {ours}"
            ));
        }
        let [for_users, _] = PROFILES;
        self.built(for_users)?;
        let built = self.place(BUILT).join(for_users);
        for name in self.modules.files {
            let [ours, theirs] = [&built, &committed].map(|folder| std::fs::read(folder.join(name)));
            let (ours, theirs) = (ours?, theirs?);
            if ours != theirs {
                return Ok(format!(
                    "{name}: differs from what is committed, by the same compiler and linker: {} bytes in gzip, {} committed",
                    ours.len(),
                    theirs.len()
                ));
            }
        }
        Ok(format!("{names}: built again, the same bytes as committed"))
    }

    /// A folder of engines.
    fn place(&self, name: &str) -> PathBuf {
        self.root.join("crates/splatvol-page").join(name)
    }

    fn note_path(&self, folder: &Path) -> PathBuf {
        folder.join(note_of(self.modules.name))
    }

    /// What modules in a folder were built from, if they are there.
    fn note_in(&self, folder: &Path) -> Option<Note> {
        let mut files = self.modules.files.iter();
        let there = files.all(|name| folder.join(name).is_file());
        there.then(|| Note::read(&self.note_path(folder))).flatten()
    }
}

fn packed(bytes: &[u8]) -> Result<Vec<u8>> {
    let mut gzip = GzEncoder::new(Vec::new(), Compression::best());
    std::io::Write::write_all(&mut gzip, bytes)?;
    Ok(gzip.finish()?)
}

fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    std::fs::write(path, bytes).with_context(|| path.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_come_back_from_their_text() {
        let note = Note {
            sources: "0123456789abcdef".to_owned(),
            compiler: "rustc 1.95.0 (59807616e 2026-04-14), LLVM 22.1.2".to_owned(),
            linker: "LLD 22.1.2".to_owned(),
        };
        let folder = std::env::temp_dir().join(format!("splatvol-note-{}", std::process::id()));
        std::fs::write(&folder, note.text()).unwrap();
        let read = Note::read(&folder);
        std::fs::remove_file(&folder).unwrap();
        assert_eq!(read, Some(note));
        assert_eq!(Note::read(&folder), None);
    }

    /// Manifests are read line by line for the digest; cargo reads all of TOML.
    #[test]
    fn sources_are_of_the_crates_that_cargo_names() {
        let root = crate::root();
        let arguments = ["metadata", "--no-deps", "--offline", "--format-version", "1"];
        let mut cargo = std::process::Command::new(env!("CARGO"));
        let said = crate::metadata::run(cargo.args(arguments).current_dir(&root)).unwrap();
        let metadata: serde_json::Value = serde_json::from_slice(&said).unwrap();
        let mut crates = 0;
        for package in metadata["packages"].as_array().unwrap() {
            let needed = package["dependencies"]
                .as_array()
                .unwrap()
                .iter()
                .filter(|dependency| {
                    dependency["kind"].is_null()
                        && dependency["path"].is_string()
                        && dependency["optional"] == false
                });
            let mut named: Vec<&str> = needed
                .map(|dependency| dependency["name"].as_str().unwrap())
                .collect();
            let manifest = std::fs::read_to_string(package["manifest_path"].as_str().unwrap()).unwrap();
            let mut found: Vec<&str> = crate::sources::dependencies(&manifest).collect();
            named.sort_unstable();
            named.dedup();
            found.sort_unstable();
            found.dedup();
            assert_eq!(found, named, "{}", package["name"]);
            crates += 1;
        }
        assert!(crates > 15);
        let web = crate::sources::closure(&root, crate::sources::WEB).unwrap();
        assert!(web.contains("splatvol-cpu") && web.contains("splatvol-io") && !web.contains("splatvol-gpu"));
    }

    #[test]
    fn digests_depend_on_sources_but_not_on_ends_of_lines() {
        let root = std::env::temp_dir().join(format!("splatvol-digest-{}", std::process::id()));
        let source = root.join("crates/splatvol-web/src");
        std::fs::create_dir_all(&source).unwrap();
        std::fs::create_dir_all(root.join(".cargo")).unwrap();
        for name in [
            "Cargo.toml",
            "Cargo.lock",
            ".cargo/config.toml",
            "crates/splatvol-web/Cargo.toml",
        ] {
            std::fs::write(root.join(name), "").unwrap();
        }
        let with = |text: &str| {
            std::fs::write(source.join("lib.rs"), text).unwrap();
            digest(&root, "splatvol-web").unwrap()
        };
        let [unix, windows, other] = ["a\nb\n", "a\r\nb\r\n", "a\nc\n"].map(with);
        let elsewhere = digest(&root.join("crates"), "splatvol-web");
        std::fs::remove_dir_all(&root).unwrap();
        assert!(unix == windows && unix != other, "{unix} {windows} {other}");
        assert_eq!(elsewhere, None);
        // The same in every version of Rust, which committed digests outlive.
        assert_eq!(unix, "749a4d011d165693");
    }

    #[test]
    fn tasks_know_their_arguments() {
        let of = |arguments: &[&str]| {
            let arguments: Vec<String> = arguments.iter().map(|&one| one.to_owned()).collect();
            Wish::of(&arguments)
        };
        assert_eq!(of(&[]).unwrap(), Wish::Built("web"));
        assert_eq!(of(&["--dev"]).unwrap(), Wish::Built("web-dev"));
        assert_eq!(of(&["--committed"]).unwrap(), Wish::Committed);
        assert_eq!(of(&["--check"]).unwrap(), Wish::Checked);
        assert!(of(&["--dev", "--check"]).is_err() && of(&["x"]).is_err());
    }
}
