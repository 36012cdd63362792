//! Threads that do the tasks of a level.

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use splatvol_scene::{ChunkBuffer, ChunkSource, Samples};

use super::PyramidOptions;
use super::bounds::{self, Done};
use super::chunks::LevelFiles;
use super::halve::{halve, majorities};
use super::plan::Plan;
use crate::IoError;
use crate::error::Context;

/// The work on a level.
pub(super) struct LevelWork<'a> {
    /// The samples, and which level of the source they are.
    pub(super) source: (&'a dyn ChunkSource, usize),
    pub(super) plan: &'a Plan,
    pub(super) level: usize,
    /// Folder of the image.
    pub(super) folder: &'a Path,
    pub(super) done: Done,
    /// Whether the level itself is to be written, not just the next.
    pub(super) copy: bool,
    pub(super) options: &'a PyramidOptions,
    pub(super) progress: &'a Progress<'a>,
}

/// The finished share.
pub(super) struct Progress<'a> {
    tell: &'a (dyn Fn(f64) + Sync),
    samples: u64,
    done: AtomicU64,
}

impl<'a> Progress<'a> {
    pub(super) fn new(tell: &'a (dyn Fn(f64) + Sync), plan: &Plan) -> Self {
        Self {
            tell,
            samples: plan.levels.iter().map(|level| level.samples()).sum(),
            done: AtomicU64::new(0),
        }
    }

    fn add(&self, samples: usize) {
        let done = self.done.fetch_add(samples as u64, Ordering::Relaxed) + samples as u64;
        (self.tell)(done as f64 / self.samples as f64);
    }
}

/// Memory of a thread.
struct Memory {
    read: Samples,
    next: Samples,
    chunk: Samples,
    buffer: ChunkBuffer,
}

impl LevelWork<'_> {
    /// Does all tasks that are not done, on so many threads; the first error ends the work.
    pub(super) fn run(&self, threads: usize) -> Result<(), IoError> {
        let next = AtomicUsize::new(0);
        let stop = AtomicBool::new(false);
        let failure: Mutex<Option<IoError>> = Mutex::new(None);
        let work = || {
            let empty = || Samples::U8(Vec::new().into());
            let mut memory = Memory {
                read: empty(),
                next: empty(),
                chunk: empty(),
                buffer: ChunkBuffer::default(),
            };
            while !stop.load(Ordering::Relaxed) {
                let task = next.fetch_add(1, Ordering::Relaxed);
                if task >= self.plan.tasks(self.level) {
                    return;
                }
                if let Err(error) = self.task(task, &mut memory) {
                    stop.store(true, Ordering::Relaxed);
                    failure
                        .lock()
                        .unwrap_or_else(PoisonError::into_inner)
                        .get_or_insert(error);
                }
            }
        };
        match threads {
            1 => work(),
            _ => std::thread::scope(|scope| (0..threads).for_each(|_| drop(scope.spawn(work)))),
        }
        failure
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner)
            .map_or(Ok(()), Err)
    }

    fn task(&self, index: usize, memory: &mut Memory) -> Result<(), IoError> {
        let task = self.plan.task(self.level, index);
        let own = &self.plan.levels[self.level];
        if self.done.read(index, (own, task.own)).is_some() {
            self.progress.add(task.own.len());
            return Ok(());
        }
        let (source, level) = self.source;
        let read = source.read_region(level, task.read, &mut memory.read, &mut memory.buffer);
        read.map_err(|error| Context::new("volume", Path::new(&source.identity().name)).chunk(error))?;
        let samples = (&memory.read, task.read);
        if self.copy {
            self.files(self.level)
                .write(task.own, samples, &mut memory.chunk)?;
        }
        if let Some(next) = task.next {
            let of = (&memory.read, task.read);
            match self.options.labels {
                true => majorities(of, own.dims, next, &mut memory.next),
                false => halve(of, own.dims, next, &mut memory.next),
            }
            self.files(self.level + 1)
                .write(next, (&memory.next, next), &mut memory.chunk)?;
        }
        self.done.write(index, &bounds::of_box(own, task.own, samples))?;
        self.progress.add(task.own.len());
        Ok(())
    }

    fn files(&self, level: usize) -> LevelFiles<'_> {
        LevelFiles {
            folder: self.folder.join(level.to_string()),
            level: &self.plan.levels[level],
            options: self.options,
        }
    }
}
