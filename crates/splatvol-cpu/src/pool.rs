//! The threads that renderers work with: their own, or somebody else's.

use std::sync::Arc;

use crate::EngineError;

/// Worker threads. Clones share them: any number of renderers can work with one pool, one after the other or at the same time.
#[derive(Debug, Clone)]
pub struct Pool(Threads);

#[derive(Debug, Clone)]
enum Threads {
    Started(Arc<rayon::ThreadPool>),
    /// The platform starts no threads: work is done by whoever asks for it.
    Calling,
}

impl Pool {
    /// So many threads, or one per logical processor. Where the platform cannot start any (WebAssembly without threads), the
    /// calling thread does the work.
    ///
    /// # Errors
    /// Threads that the system refuses; more than one where there cannot be any.
    pub fn new(threads: Option<usize>) -> Result<Self, EngineError> {
        if cfg!(target_family = "wasm") && threads.is_none_or(|count| count <= 1) {
            return Ok(Self(Threads::Calling));
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

    /// How many threads there are.
    pub fn current_num_threads(&self) -> usize {
        match &self.0 {
            Threads::Started(pool) => pool.current_num_threads(),
            Threads::Calling => rayon::current_num_threads(),
        }
    }

    /// Does work with these threads, and waits for it.
    pub fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.0 {
            Threads::Started(pool) => pool.install(work),
            Threads::Calling => work(),
        }
    }

    /// Has work done with these threads; where there are none, now.
    pub(crate) fn spawn(&self, work: impl FnOnce() + Send + 'static) {
        match &self.0 {
            Threads::Started(pool) => pool.spawn(work),
            Threads::Calling => work(),
        }
    }
}

/// Threads that somebody else has started.
impl From<Arc<rayon::ThreadPool>> for Pool {
    fn from(pool: Arc<rayon::ThreadPool>) -> Self {
        Self(Threads::Started(pool))
    }
}
