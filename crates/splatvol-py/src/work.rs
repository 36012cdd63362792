//! Work without the interpreter's lock: other Python threads run, Ctrl-C ends it, progress is heard of.
//!
//! The calling thread waits in slices of a few hundredths of a second. Between them it has the lock for a moment, looks for
//! signals and calls the progress callback.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use pyo3::prelude::*;
use splatvol::Control;

use crate::engines;
use crate::error::panicked;

/// Between two looks for signals: a render ends within a tenth of a second after Ctrl-C.
const SLICE: Duration = Duration::from_millis(40);

/// A flag that any thread sets to end work.
#[pyclass(frozen)]
#[derive(Debug, Default)]
pub(crate) struct Stop(Arc<AtomicBool>);

#[pymethods]
impl Stop {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// Ends the work.
    fn set(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether it was ended.
    fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// The state of work in progress.
#[derive(Debug)]
pub(crate) struct Watch {
    stop: Arc<AtomicBool>,
    /// Finished share, the bits of an f64.
    share: AtomicU64,
}

impl Watch {
    fn new(stop: Option<&Stop>) -> Self {
        Self {
            stop: stop.map_or_else(Arc::default, |stop| Arc::clone(&stop.0)),
            share: AtomicU64::new(0),
        }
    }

    /// Runs a render that is stopped, and reports, through this.
    pub(crate) fn controls<R>(&self, render: impl FnOnce(&Control<'_>) -> R) -> R {
        let report = |share: f64| self.share.store(share.to_bits(), Ordering::Relaxed);
        render(&Control {
            stop: Some(&self.stop),
            progress: Some(&report),
            ..Control::default()
        })
    }
}

/// Runs work on the process's threads, without the interpreter's lock. `progress` is called with the finished share; where it
/// returns `False` or raises, the work is stopped.
pub(crate) fn run<R: Send>(
    py: Python<'_>,
    (stop, progress): (Option<&Stop>, Option<&Py<PyAny>>),
    work: impl FnOnce(&Watch) -> PyResult<R> + Send,
) -> PyResult<R> {
    let pool = engines::pool()?;
    let watch = Watch::new(stop);
    if pool.is_current() {
        // A lazy source works while a picture asks it for samples: this is one of the threads that would be waited for.
        let done = py.detach(|| catch_unwind(AssertUnwindSafe(|| work(&watch))));
        return done.unwrap_or_else(|reason| Err(panicked(&*reason)));
    }
    py.detach(|| {
        let (send, receive) = channel();
        std::thread::scope(|scope| {
            let watched = &watch;
            scope.spawn(move || {
                let done = catch_unwind(AssertUnwindSafe(|| pool.install(|| work(watched))));
                // The receiver outlives this thread.
                let _ = send.send(done.unwrap_or_else(|reason| Err(panicked(&*reason))));
            });
            let mut interrupted = None;
            loop {
                match receive.recv_timeout(SLICE) {
                    Ok(done) => return interrupted.map_or(done, Err),
                    Err(RecvTimeoutError::Timeout) if interrupted.is_none() => {
                        interrupted = Python::attach(|py| listen(py, progress, &watch)).err();
                        if interrupted.is_some() {
                            watch.stop.store(true, Ordering::Relaxed);
                        }
                    }
                    Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => unreachable!("the worker always sends"),
                }
            }
        })
    })
}

/// Looks for signals, and reports.
fn listen(py: Python<'_>, progress: Option<&Py<PyAny>>, watch: &Watch) -> PyResult<()> {
    py.check_signals()?;
    let Some(progress) = progress else {
        return Ok(());
    };
    let share = f64::from_bits(watch.share.load(Ordering::Relaxed));
    let answer = progress.bind(py).call1((share,))?;
    match answer.extract::<bool>() {
        Ok(false) => Err(crate::error::Raise::raised(splatvol::SceneError::Stopped)),
        _ => Ok(()),
    }
}
