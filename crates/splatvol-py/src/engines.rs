//! Threads and renderers of the process: one pool, and a few renderers that wait for work with what they have prepared.
//!
//! After a fork the child has none of its parent's threads, so it leaves what it inherited alone and starts its own.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use pyo3::prelude::*;
use splatvol::{Content, EngineConfig, Item, Pool, Renderer, Scene};

use crate::error::{Raise, refused};

/// The environment's number of threads.
const VARIABLE: &str = "SPLATVOL_THREADS";
/// Renderers that wait with their prepared data: the scenes that a notebook turns to and fro between.
const WAITING: usize = 2;

/// Between two looks for signals while a picture waits for its turn.
const SLICE: Duration = Duration::from_millis(40);

/// What a process has.
struct Engines {
    process: u32,
    /// Number of threads; one per processor without it.
    threads: Option<usize>,
    pool: Option<Pool>,
    /// The last one last, each with the data that it has rendered.
    waiting: Vec<(Vec<usize>, Renderer)>,
}

static ENGINES: Mutex<Engines> = Mutex::new(Engines {
    process: 0,
    threads: None,
    pool: None,
    waiting: Vec::new(),
});

/// Works with this process's engines. Renderers are dropped elsewhere: they may hold arrays, which are given back with the
/// interpreter's lock, and whoever has that may be waiting for this.
fn with<R>(work: impl FnOnce(&mut Engines) -> R) -> R {
    let mut engines = ENGINES.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    if engines.process != process {
        // Threads of a parent process cannot be joined, so nothing of theirs is dropped.
        std::mem::forget(engines.pool.take());
        std::mem::forget(std::mem::take(&mut engines.waiting));
        engines.process = process;
    }
    work(&mut engines)
}

/// The threads.
pub(crate) fn pool() -> PyResult<Pool> {
    with(|engines| match &engines.pool {
        Some(pool) => Ok(pool.clone()),
        None => {
            if engines.threads.is_none() {
                engines.threads = threads_of_environment()?;
            }
            let pool = Pool::new(engines.threads).map_err(Raise::raised)?;
            engines.pool = Some(pool.clone());
            Ok(pool)
        }
    })
}

/// The number that `SPLATVOL_THREADS` says, if it is set.
fn threads_of_environment() -> PyResult<Option<usize>> {
    let Some(text) = std::env::var_os(VARIABLE).filter(|text| !text.is_empty()) else {
        return Ok(None);
    };
    let count = text
        .to_str()
        .and_then(|text| text.parse().ok())
        .filter(|&count| count > 0);
    match count {
        Some(count) => Ok(Some(count)),
        None => Err(refused(
            "threads",
            format!("{VARIABLE}={}: expected a number above 0", text.display()),
        )),
    }
}

/// Renders a scene with the renderer that has prepared its data, if one waits; else with the one that waits longest, or a new one
/// while there are few.
pub(crate) fn render<R>(scene: &Scene, work: impl FnOnce(&mut Renderer) -> R) -> PyResult<R> {
    let pool = pool()?;
    let data = addresses(scene);
    let budgets: Vec<usize> = scene.items.iter().filter_map(budget).collect();
    let (waiting, others) = with(|engines| {
        let known = engines.waiting.iter().position(|(of, _)| *of == data);
        let any = (engines.waiting.len() >= WAITING).then_some(0);
        let waiting = known.or(any).map(|index| engines.waiting.remove(index).1);
        // Another renderer with the same volume in chunks would keep a part of that volume's memory.
        let shares = |(of, _): &mut (Vec<usize>, Renderer)| of.iter().any(|own| budgets.contains(own));
        let others: Vec<_> = engines.waiting.extract_if(.., shares).collect();
        (waiting, others)
    });
    drop(others);
    let mut renderer = match waiting {
        Some(renderer) => renderer,
        None => Renderer::with_pool(pool.clone(), EngineConfig::default()).map_err(Raise::raised)?,
    };
    let done = work(&mut renderer);
    let surplus = with(|engines| {
        let same_threads = engines
            .threads
            .is_none_or(|count| count == pool.current_num_threads());
        if same_threads && engines.waiting.len() < WAITING {
            engines.waiting.push((data, renderer));
            None
        } else {
            Some(renderer)
        }
    });
    drop(surplus);
    Ok(done)
}

/// Budgets of the volumes in chunks that are being drawn.
static DRAWN: Mutex<Vec<usize>> = Mutex::new(Vec::new());
/// Told when one of them is done.
static DONE: Condvar = Condvar::new();

fn drawn() -> MutexGuard<'static, Vec<usize>> {
    DRAWN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The right to draw volumes in chunks, whose memory two pictures cannot share. Dropping it ends that.
#[derive(Debug)]
pub(crate) struct Turn(Vec<usize>);

impl Turn {
    /// Waits until no other picture of the same volumes in chunks is drawn.
    ///
    /// # Errors
    /// Ctrl-C meanwhile.
    pub(crate) fn wait_for(py: Python<'_>, scene: &Scene) -> PyResult<Self> {
        let budgets: Vec<usize> = scene.items.iter().filter_map(budget).collect();
        if budgets.is_empty() || pool()?.is_current() {
            // A picture that a lazy source draws must not wait for that which asks it.
            return Ok(Self(Vec::new()));
        }
        loop {
            let is_mine = py.detach(|| {
                let is_taken = |drawn: &mut Vec<usize>| budgets.iter().any(|own| drawn.contains(own));
                let waited = DONE.wait_timeout_while(drawn(), SLICE, is_taken);
                let (mut drawn, timed_out) = waited.unwrap_or_else(PoisonError::into_inner);
                if !timed_out.timed_out() {
                    drawn.extend(&budgets);
                }
                !timed_out.timed_out()
            });
            if is_mine {
                return Ok(Self(budgets));
            }
            py.check_signals()?;
        }
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        if !self.0.is_empty() {
            drawn().retain(|own| !self.0.contains(own));
            DONE.notify_all();
        }
    }
}

/// Where the budget of a volume lies that is read in chunks; wherever the volume is placed, it is the same.
fn budget(item: &Item) -> Option<usize> {
    match &item.content {
        Content::Volume { volume, .. } => Some(Arc::as_ptr(volume.chunks()?.budget()).addr()),
        _ => None,
    }
}

/// Where a scene's data lie: renderers recognise them by that, too.
fn addresses(scene: &Scene) -> Vec<usize> {
    let address = |item: &Item| match &item.content {
        Content::Volume { volume, .. } => budget(item).unwrap_or_else(|| Arc::as_ptr(volume).addr()),
        Content::Mesh { mesh, .. } => Arc::as_ptr(mesh).addr(),
        Content::Points { points, .. } => Arc::as_ptr(points).addr(),
        Content::Gaussians(gaussians) => Arc::as_ptr(gaussians).addr(),
    };
    scene.items.iter().map(address).collect()
}

/// Sets the number of threads of this process; `None` takes what `SPLATVOL_THREADS` says, or one per logical processor.
#[pyfunction]
#[pyo3(signature = (count))]
pub(crate) fn set_threads(count: Option<usize>) -> PyResult<()> {
    if count == Some(0) {
        return Err(refused(
            "threads",
            "threads: 0 is not allowed (1 or more, or None)",
        ));
    }
    let before = with(|engines| {
        engines.threads = count;
        (engines.pool.take(), std::mem::take(&mut engines.waiting))
    });
    drop(before);
    Ok(())
}

/// Number of threads of this process.
#[pyfunction]
pub(crate) fn threads() -> PyResult<usize> {
    Ok(pool()?.current_num_threads())
}
