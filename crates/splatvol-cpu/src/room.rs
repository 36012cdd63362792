//! Allocation in steps that check for cancellation: the system takes time to provide memory.

use std::sync::atomic::{AtomicBool, Ordering};

/// Number of values allocated in one step.
const STEP: usize = 1 << 16;

/// Allocates `count` values, new ones by default; `None` once `stop` is set.
pub(crate) fn grow<T: Default>(values: &mut Vec<T>, count: usize, stop: &AtomicBool) -> Option<()> {
    grow_with(values, count, T::default, stop)
}

/// As `grow`, with a function that makes new values.
pub(crate) fn grow_with<T>(
    values: &mut Vec<T>,
    count: usize,
    new: impl Fn() -> T,
    stop: &AtomicBool,
) -> Option<()> {
    values.reserve_exact(count.saturating_sub(values.len()));
    while values.len() < count {
        if stop.load(Ordering::Relaxed) {
            return None;
        }
        values.resize_with(count.min(values.len() + STEP), &new);
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_not_waited_for_by_who_gives_up() {
        let stop = AtomicBool::new(false);
        let mut values: Vec<u32> = vec![7];
        assert_eq!(grow(&mut values, 3 * STEP, &stop), Some(()));
        assert_eq!((values.len(), values[0], values[STEP]), (3 * STEP, 7, 0));
        stop.store(true, Ordering::Relaxed);
        assert_eq!(grow_with(&mut values, 4 * STEP, || 9, &stop), None);
        assert_eq!(values.len(), 3 * STEP);
        assert_eq!(grow(&mut values, STEP, &stop), Some(()), "nothing to wait for");
    }
}
