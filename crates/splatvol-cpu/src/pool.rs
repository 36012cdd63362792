//! Thread pools of renderers: their own, or one provided by the caller.

use std::num::NonZero;
use std::sync::Arc;

use crate::EngineError;

/// More threads than this on a processor only wait for each other.
const THREADS_PER_PROCESSOR: usize = 16;
/// Any machine may start as many: a container may see fewer processors than its machine has.
const LEAST_MOST_THREADS: usize = 64;

/// Worker threads. Clones share them: any number of renderers can use one pool, one after the other or at the same
/// time.
#[derive(Debug, Clone)]
pub struct Pool(Threads);

#[derive(Debug, Clone)]
enum Threads {
    Started(Arc<rayon::ThreadPool>),
    /// The platform starts no threads: the calling thread does the work.
    Calling,
}

/// Threads that [`Pool::new`] starts at most: enough for every use, and few enough for every system.
pub fn most_threads() -> usize {
    let processors = std::thread::available_parallelism().map_or(1, NonZero::get);
    (THREADS_PER_PROCESSOR * processors).max(LEAST_MOST_THREADS)
}

impl Pool {
    /// So many threads, [`most_threads`] at most, or one per logical processor. Where the platform cannot start any (WebAssembly without
    /// threads), the calling thread does the work.
    ///
    /// # Errors
    /// Threads that the system refuses; more than one where there cannot be any.
    pub fn new(threads: Option<usize>) -> Result<Self, EngineError> {
        if cfg!(target_family = "wasm") && threads.is_none_or(|count| count <= 1) {
            return Ok(Self(Threads::Calling));
        }
        if let Some(count) = threads.filter(|&count| count > most_threads()) {
            return Err(EngineError::TooManyThreads {
                threads: count,
                most: most_threads(),
            });
        }
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads.unwrap_or(0))
            .thread_name(|i| format!("splatvol-{i}"))
            .build()
            .map(|pool| Self::from(Arc::new(pool)))
            .map_err(|error| EngineError::Threads {
                threads,
                reason: error.to_string(),
            })
    }

    /// Number of threads.
    pub fn current_num_threads(&self) -> usize {
        match &self.0 {
            Threads::Started(pool) => pool.current_num_threads(),
            Threads::Calling => rayon::current_num_threads(),
        }
    }

    /// Whether the calling thread is one of these.
    pub fn is_current(&self) -> bool {
        match &self.0 {
            Threads::Started(pool) => pool.current_thread_index().is_some(),
            Threads::Calling => true,
        }
    }

    /// Runs work on these threads, and waits for it.
    pub fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.0 {
            Threads::Started(pool) => pool.install(work),
            Threads::Calling => work(),
        }
    }

    /// Starts work on these threads; without threads, runs it at once.
    pub(crate) fn spawn(&self, work: impl FnOnce() + Send + 'static) {
        match &self.0 {
            Threads::Started(pool) => pool.spawn(work),
            Threads::Calling => work(),
        }
    }
}

/// A thread pool that the caller has started.
impl From<Arc<rayon::ThreadPool>> for Pool {
    fn from(pool: Arc<rayon::ThreadPool>) -> Self {
        Self(Threads::Started(pool))
    }
}
