//! What an experiment works with: how thorough to be, threads, progress.

use splatvol::{EngineConfig, Renderer};

use crate::LabError;

/// How thorough to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effort {
    /// The sizes of the papers.
    Full,
    /// Smaller pictures, fewer samples: the same findings in seconds.
    Quick,
}

/// What an experiment works with.
#[derive(Clone, Copy)]
pub struct Workbench<'a> {
    /// How thorough to be.
    pub effort: Effort,
    /// Worker threads; `None` takes one per logical processor. Changes nothing but times.
    pub threads: Option<usize>,
    /// Takes the finished share, 0..1, and what is being done.
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

    /// Says that step `done` of `of` begins.
    pub fn step(&self, done: usize, of: usize, what: &str) {
        (self.progress)(done as f64 / of.max(1) as f64, what);
    }
}
