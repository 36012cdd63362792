//! Values made last, kept within a reservation of bytes.

use std::collections::{HashMap, HashSet};
use std::fmt::Debug;
use std::hash::Hash;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use super::{OverBudget, Reservation};

/// Values by key: those used last, as many as fit. Threads that want the same value wait for the one that makes it.
#[derive(Debug)]
pub struct Recent<K, V> {
    state: Mutex<State<K, V>>,
    made: Condvar,
}

#[derive(Debug)]
struct State<K, V> {
    memory: Reservation,
    values: HashMap<K, Kept<V>>,
    making: HashSet<K>,
    bytes: u64,
    uses: u64,
}

#[derive(Debug)]
struct Kept<V> {
    value: V,
    bytes: u64,
    used: u64,
}

impl<K: Copy + Eq + Hash, V: Clone> State<K, V> {
    fn get(&mut self, key: K) -> Option<V> {
        let kept = self.values.get_mut(&key)?;
        self.uses += 1;
        kept.used = self.uses;
        Some(kept.value.clone())
    }

    /// Keeps a value, if it fits; one of those that had to go for it.
    fn insert(&mut self, key: K, (value, bytes): (V, u64)) -> Option<V> {
        if bytes > self.memory.bytes() {
            return None;
        }
        let freed = self.shrink_to(self.memory.bytes() - bytes);
        self.uses += 1;
        self.bytes += bytes;
        let used = self.uses;
        if let Some(old) = self.values.insert(key, Kept { value, bytes, used }) {
            self.bytes -= old.bytes;
        }
        freed
    }

    /// Frees the values that were used longest ago; the last of them.
    fn shrink_to(&mut self, bytes: u64) -> Option<V> {
        let mut freed = None;
        while self.bytes > bytes {
            let oldest = self.values.iter().min_by_key(|(_, kept)| kept.used);
            let old = self.values.remove(&oldest.map(|(key, _)| *key)?)?;
            self.bytes -= old.bytes;
            freed = Some(old.value);
        }
        freed
    }
}

/// Says that a value is no longer being made, even if making it panicked.
struct Making<'a, K: Copy + Eq + Hash, V: Clone> {
    recent: &'a Recent<K, V>,
    key: K,
}

impl<K: Copy + Eq + Hash, V: Clone> Drop for Making<'_, K, V> {
    fn drop(&mut self) {
        self.recent.state().making.remove(&self.key);
        self.recent.made.notify_all();
    }
}

impl<K: Copy + Eq + Hash, V: Clone> Recent<K, V> {
    /// Nothing yet, and memory for values.
    pub fn new(memory: Reservation) -> Self {
        Self {
            state: Mutex::new(State {
                memory,
                values: HashMap::new(),
                making: HashSet::new(),
                bytes: 0,
                uses: 0,
            }),
            made: Condvar::new(),
        }
    }

    fn state(&self) -> MutexGuard<'_, State<K, V>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Reserves so many bytes instead; what does not fit is freed.
    ///
    /// # Errors
    /// More than the budget has left.
    pub fn resize(&self, bytes: u64) -> Result<(), OverBudget> {
        let mut state = self.state();
        drop(state.shrink_to(bytes));
        state.memory.resize(bytes)
    }

    /// Nothing, with a reservation of no bytes in the same budget.
    #[must_use]
    pub fn emptied(&self) -> Self {
        Self::new(self.state().memory.empty())
    }

    /// Frees all values.
    pub fn clear(&self) {
        drop(self.state().shrink_to(0));
    }

    /// Bytes of the values.
    pub fn bytes(&self) -> u64 {
        self.state().bytes
    }

    /// Whether there is a value of a key, or one is being made.
    pub fn has(&self, key: &K) -> bool {
        let state = self.state();
        state.values.contains_key(key) || state.making.contains(key)
    }

    /// The value of a key; if it is not there, it is made, with its bytes.
    ///
    /// # Errors
    /// Those of `make`.
    pub fn get_or_make<E>(&self, key: K, make: impl FnOnce() -> Result<(V, u64), E>) -> Result<V, E> {
        self.get_or_replace(key, make).map(|(value, _)| value)
    }

    /// The same, and one of the values that had to go for it, whose memory may serve for the next.
    ///
    /// # Errors
    /// Those of `make`.
    pub fn get_or_replace<E>(
        &self,
        key: K,
        make: impl FnOnce() -> Result<(V, u64), E>,
    ) -> Result<(V, Option<V>), E> {
        let mut state = self.state();
        loop {
            if let Some(value) = state.get(key) {
                return Ok((value, None));
            }
            if state.making.insert(key) {
                break;
            }
            state = self.made.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        drop(state);
        let making = Making { recent: self, key };
        let (value, bytes) = make()?;
        let freed = self.state().insert(key, (value.clone(), bytes));
        drop(making);
        Ok((value, freed))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::super::Budget;
    use super::*;

    #[test]
    fn values_used_last_are_kept_and_made_once() {
        let budget = Budget::new(100);
        let recent = Recent::new(budget.reserve(30).unwrap());
        let made = AtomicUsize::new(0);
        let get = |key: usize| {
            let value = recent.get_or_make(key, || {
                made.fetch_add(1, Ordering::Relaxed);
                Ok::<_, ()>((key * 2, 10))
            });
            assert_eq!(value, Ok(key * 2));
            made.load(Ordering::Relaxed)
        };
        assert_eq!([get(1), get(2), get(3), get(1)], [1, 2, 3, 3]);
        // The second was used longest ago.
        assert_eq!([get(4), get(1), get(2)], [4, 4, 5]);
        assert_eq!(recent.bytes(), 30);
        recent.resize(10).unwrap();
        assert_eq!((recent.bytes(), get(2)), (10, 5));
        assert!(recent.resize(101).is_err());
        assert_eq!(recent.get_or_make(9, || Err((7, ()))), Err((7, ())));
        let replace = |key: usize| recent.get_or_replace(key, || Ok::<_, ()>((key * 2, 10)));
        assert_eq!(
            [replace(2), replace(7), replace(7)],
            [Ok((4, None)), Ok((14, Some(4))), Ok((14, None))]
        );
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| (0..50).for_each(|_| assert!(get(8) > 4)));
            }
        });
        assert_eq!(made.load(Ordering::Relaxed), 6);
        recent.clear();
        assert_eq!(recent.bytes(), 0);
    }
}
