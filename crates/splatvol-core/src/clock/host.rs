//! Clock set by the host: WebAssembly has none of its own, and std's panics there.

#![cfg_attr(
    not(target_family = "wasm"),
    expect(unreachable_pub, reason = "elsewhere only tests use it")
)]

use std::ops::Sub;
use std::sync::OnceLock;
use std::time::Duration;

static CLOCK: OnceLock<fn() -> f64> = OnceLock::new();

/// Sets the engines' clock: seconds since any moment, such as `performance.now() / 1000`. Only the first call
/// counts. Without a clock all times of [`crate::engine::RenderStatistics`] are zero.
pub fn set_clock(seconds: fn() -> f64) {
    let _ = CLOCK.set(seconds);
}

/// A moment, like `std::time::Instant`.
#[derive(Debug, Clone, Copy)]
pub struct Instant {
    seconds: f64,
}

impl Instant {
    /// The present moment; zero without a clock.
    pub fn now() -> Self {
        Self {
            seconds: CLOCK.get().map_or(0.0, |seconds| seconds()),
        }
    }

    /// Time since this moment.
    pub fn elapsed(self) -> Duration {
        Self::now() - self
    }
}

impl Sub for Instant {
    type Output = Duration;

    /// Zero where the clock has been set back.
    fn sub(self, earlier: Self) -> Duration {
        Duration::try_from_secs_f64(self.seconds - earlier.seconds).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};

    static CALLS: AtomicU32 = AtomicU32::new(0);

    /// 1.5, 3, 2.
    fn seconds() -> f64 {
        [1.5, 3.0, 2.0][CALLS.fetch_add(1, Ordering::Relaxed) as usize % 3]
    }

    #[test]
    fn the_hosts_clock_is_read() {
        assert_eq!(Instant::now().elapsed(), Duration::ZERO);
        set_clock(seconds);
        let start = Instant::now();
        assert_eq!(start.elapsed(), Duration::from_millis(1500));
        assert_eq!(Instant::now() - start, Duration::from_millis(500));
        let late = Instant { seconds: 9.0 };
        assert_eq!(start - late, Duration::ZERO);
    }
}
