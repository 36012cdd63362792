//! Cancellable preparation: a cancelled call returns at once, and the threads that prepare its data stop at their
//! next step.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::Duration;

use crate::pool::Pool;

/// Interval at which a waiting thread checks for cancellation.
const LOOK: Duration = Duration::from_millis(1);

/// Cancellation flag of a preparation, checked between its steps.
#[derive(Debug, Clone, Default)]
pub(crate) struct Patience(Arc<AtomicBool>);

impl Patience {
    /// `None` once the preparation is cancelled.
    pub(crate) fn go_on(&self) -> Option<()> {
        (!self.0.load(Ordering::Relaxed)).then_some(())
    }
}

impl Pool {
    /// Prepares something on these threads and waits for it; `None` if `stop` is set meanwhile.
    ///
    /// Cancelled work ends at its next step, and frees its memory on its own thread. Where there are no threads,
    /// nothing could set `stop` meanwhile, and the calling thread does the work.
    pub(crate) fn prepare<R: Send + 'static>(
        &self,
        stop: &AtomicBool,
        work: impl FnOnce(&Patience) -> Option<R> + Send + 'static,
    ) -> Option<R> {
        let patience = Patience::default();
        let own = patience.clone();
        let (sender, receiver) = sync_channel(1);
        self.spawn(move || {
            let result = catch_unwind(AssertUnwindSafe(|| work(&own)));
            // Nobody listens if the picture was cancelled.
            let _ = sender.send(result);
        });
        loop {
            // First without a clock, which platforms without threads may lack.
            match receiver.try_recv().or_else(|_| receiver.recv_timeout(LOOK)) {
                Ok(Ok(result)) => return result,
                Ok(Err(panic)) => resume_unwind(panic),
                Err(RecvTimeoutError::Disconnected) => return None,
                Err(RecvTimeoutError::Timeout) => {}
            }
            if stop.load(Ordering::Relaxed) {
                patience.0.store(true, Ordering::Relaxed);
                return None;
            }
            // A thread of this very pool has to help: perhaps nobody else is free for the work.
            rayon::yield_now();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use super::*;

    const LONG: Duration = Duration::from_secs(20);

    #[test]
    fn whoever_gives_up_does_not_wait() {
        let pool = Pool::new(Some(1)).unwrap();
        let stop = AtomicBool::new(false);
        let (heard, hears) = sync_channel(1);
        let start = Instant::now();
        let result: Option<()> = std::thread::scope(|threads| {
            threads.spawn(|| {
                std::thread::sleep(Duration::from_millis(20));
                stop.store(true, Ordering::Relaxed);
            });
            pool.prepare(&stop, move |patience| {
                while patience.go_on().is_some() {
                    std::thread::sleep(Duration::from_millis(1));
                    assert!(start.elapsed() < LONG, "nobody told the work to end");
                }
                heard.send(()).unwrap();
                None
            })
        });
        assert!(result.is_none());
        // The work hears of it.
        hears.recv_timeout(LONG).unwrap();
    }

    /// A pool of one thread can wait for its own work.
    #[test]
    fn threads_of_the_pool_may_wait() {
        let pool = Pool::new(Some(1)).unwrap();
        let never = AtomicBool::new(false);
        assert_eq!(pool.install(|| pool.prepare(&never, |_| Some(3))), Some(3));
    }

    #[test]
    #[should_panic(expected = "of the work")]
    fn panics_arrive() {
        let pool = Pool::new(Some(1)).unwrap();
        pool.prepare::<()>(&AtomicBool::new(false), |_| panic!("of the work"));
    }
}
