//! Working environment of an experiment: thoroughness, threads, data, progress.

use std::path::{Path, PathBuf};

use splatvol::{EngineConfig, Renderer};

use crate::LabError;

/// Thoroughness of an experiment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effort {
    /// The sizes of the papers.
    Full,
    /// Smaller pictures, fewer samples: the same findings in seconds.
    Quick,
}

/// Working environment of an experiment.
#[derive(Clone, Copy)]
pub struct Workbench<'a> {
    /// Thoroughness.
    pub effort: Effort,
    /// Worker threads; `None` takes one per logical processor. Changes nothing but times.
    pub threads: Option<usize>,
    /// Folder of data that are not part of the program, such as `terrain/dem.csv`.
    pub data: Option<&'a Path>,
    /// Receives the finished share, 0..1, and a description of the current step.
    pub progress: &'a (dyn Fn(f64, &str) + Sync),
}

impl Workbench<'_> {
    /// One of two values, by effort.
    pub fn choose<T>(&self, full: T, quick: T) -> T {
        match self.effort {
            Effort::Full => full,
            Effort::Quick => quick,
        }
    }

    /// A renderer with the bench's threads.
    ///
    /// # Errors
    /// The system refuses threads.
    pub fn renderer(&self) -> Result<Renderer, LabError> {
        Ok(Renderer::new(EngineConfig {
            threads: self.threads,
            ..EngineConfig::default()
        })?)
    }

    /// A file of the folder of data.
    ///
    /// # Errors
    /// [`LabError::NoData`] if there is no folder, or no such file in it.
    pub fn data(&self, file: &'static str) -> Result<PathBuf, LabError> {
        let path = self.data.map(|folder| folder.join(file));
        path.filter(|path| path.is_file())
            .ok_or_else(|| LabError::NoData {
                file,
                folder: self.data.map(Path::to_owned),
            })
    }

    /// Reports that step `done` of `of` begins.
    pub fn step(&self, done: usize, of: usize, what: &str) {
        (self.progress)(done as f64 / of.max(1) as f64, what);
    }
}
