//! Running the built command in a folder of its own.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::Arc;
use std::time::Duration;

use tempfile::TempDir;

/// A folder for one test's files.
pub(crate) struct Sandbox {
    folder: Arc<TempDir>,
    /// Where commands run, below it.
    below: PathBuf,
}

impl Sandbox {
    pub(crate) fn new() -> Self {
        Self {
            folder: Arc::new(tempfile::tempdir().expect("the system has a temporary folder")),
            below: PathBuf::new(),
        }
    }

    /// A folder inside, in which commands run.
    pub(crate) fn below(&self, name: &str) -> Self {
        Self {
            folder: Arc::clone(&self.folder),
            below: self.below.join(name),
        }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(&self.below).join(name)
    }

    pub(crate) fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub(crate) fn write(&self, name: &str, contents: impl AsRef<[u8]>) {
        let path = self.path(name);
        let folder = path.parent().expect("files lie in the sandbox");
        std::fs::create_dir_all(folder)
            .and_then(|()| std::fs::write(&path, contents))
            .unwrap_or_else(|error| panic!("{name}: {error}"));
    }

    /// Runs `splatvol` with arguments separated by blanks.
    pub(crate) fn run(&self, arguments: &str) -> Run {
        self.output_of(arguments, &mut Command::new(env!("CARGO_BIN_EXE_splatvol")))
    }

    /// Starts `splatvol`, and kills it after a time; returns whether it was killed.
    pub(crate) fn kill(&self, arguments: &str, after: Duration) -> bool {
        let mut child = Command::new(env!("CARGO_BIN_EXE_splatvol"))
            .args(arguments.split_whitespace())
            .current_dir(self.path(""))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("the command was built");
        std::thread::sleep(after);
        // It may have ended meanwhile.
        let _ = child.kill();
        let status = child.wait().expect("it was started");
        status.code().is_none()
    }

    /// Runs `splatvol` where programs are looked for in `path`.
    pub(crate) fn run_with_path(&self, arguments: &str, path: &str) -> Run {
        let mut command = Command::new(env!("CARGO_BIN_EXE_splatvol"));
        self.output_of(arguments, command.env("PATH", path))
    }

    fn output_of(&self, arguments: &str, command: &mut Command) -> Run {
        let output = command
            .args(arguments.split_whitespace())
            .current_dir(self.path(""))
            .output()
            .expect("the command was built");
        Run {
            arguments: arguments.to_owned(),
            output,
        }
    }

    /// Names of all files in the folder.
    pub(crate) fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path()).expect("the folder is there");
        let mut names: Vec<_> = entries
            .map(|entry| {
                entry
                    .expect("entries can be read")
                    .file_name()
                    .to_string_lossy()
                    .into_owned()
            })
            .collect();
        names.sort();
        names
    }
}

/// A finished command.
pub(crate) struct Run {
    arguments: String,
    output: Output,
}

impl Run {
    pub(crate) fn stdout(&self) -> String {
        String::from_utf8_lossy(&self.output.stdout).into_owned()
    }

    pub(crate) fn stdout_bytes(&self) -> &[u8] {
        &self.output.stdout
    }

    pub(crate) fn stderr(&self) -> String {
        String::from_utf8_lossy(&self.output.stderr).into_owned()
    }

    #[track_caller]
    pub(crate) fn succeeds(self) -> Self {
        self.exits(0)
    }

    #[track_caller]
    pub(crate) fn exits(self, code: i32) -> Self {
        assert_eq!(
            self.output.status.code(),
            Some(code),
            "splatvol {}\n{}",
            self.arguments,
            self.stderr()
        );
        self
    }

    /// Asserts that it failed with `code`, with all of `words` on stderr.
    #[track_caller]
    pub(crate) fn fails(self, code: i32, words: &[&str]) -> Self {
        let run = self.exits(code);
        for word in words {
            assert!(
                run.stderr().contains(word),
                "splatvol {}: no {word:?} in\n{}",
                run.arguments,
                run.stderr()
            );
        }
        run
    }
}

/// Width, height and RGB(A) codes of an 8- or 16-bit PNG.
pub(crate) fn png(path: &Path) -> (u32, u32, Vec<u8>) {
    let file = std::io::BufReader::new(std::fs::File::open(path).expect("the picture is there"));
    let mut reader = png::Decoder::new(file).read_info().expect("the picture is a PNG");
    let mut codes = vec![0; reader.output_buffer_size().expect("the picture is small")];
    let info = reader.next_frame(&mut codes).expect("the picture is whole");
    codes.truncate(info.buffer_size());
    (info.width, info.height, codes)
}
