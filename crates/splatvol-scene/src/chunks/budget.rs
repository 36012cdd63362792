//! Bytes that all work at once may take.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// A request that no waiting can grant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{wanted} bytes are needed at once, the budget is {limit}")]
pub struct OverBudget {
    /// Bytes asked for.
    pub wanted: u64,
    /// Bytes of the budget.
    pub limit: u64,
}

/// A number of bytes, parts of which are reserved before memory is taken and given back when it is freed.
#[derive(Debug)]
pub struct Budget {
    limit: u64,
    reserved: Mutex<Reserved>,
    freed: Condvar,
}

#[derive(Debug, Default)]
struct Reserved {
    now: u64,
    most: u64,
}

impl Budget {
    /// A budget of so many bytes.
    pub fn new(limit: u64) -> Arc<Self> {
        Arc::new(Self {
            limit,
            reserved: Mutex::default(),
            freed: Condvar::new(),
        })
    }

    /// All its bytes.
    pub fn limit(&self) -> u64 {
        self.limit
    }

    /// The most bytes that were reserved at a time.
    pub fn most(&self) -> u64 {
        self.reserved().most
    }

    /// Bytes that are reserved.
    pub fn used(&self) -> u64 {
        self.reserved().now
    }

    /// Reserves bytes, and waits for those that others hold.
    ///
    /// # Errors
    /// More bytes than the budget has.
    pub fn reserve(self: &Arc<Self>, bytes: u64) -> Result<Reservation, OverBudget> {
        if bytes > self.limit {
            let (wanted, limit) = (bytes, self.limit);
            return Err(OverBudget { wanted, limit });
        }
        let mut reserved = self.reserved();
        while bytes > self.limit - reserved.now {
            reserved = self.freed.wait(reserved).unwrap_or_else(PoisonError::into_inner);
        }
        Ok(self.take(reserved, bytes))
    }

    /// Reserves bytes if they are free.
    pub fn try_reserve(self: &Arc<Self>, bytes: u64) -> Option<Reservation> {
        let reserved = self.reserved();
        (bytes <= self.limit - reserved.now).then(|| self.take(reserved, bytes))
    }

    fn take(self: &Arc<Self>, mut reserved: MutexGuard<'_, Reserved>, bytes: u64) -> Reservation {
        reserved.now += bytes;
        reserved.most = reserved.most.max(reserved.now);
        Reservation {
            budget: Arc::clone(self),
            bytes,
        }
    }

    fn reserved(&self) -> MutexGuard<'_, Reserved> {
        self.reserved.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Bytes of a budget, given back when this is dropped.
#[derive(Debug)]
pub struct Reservation {
    budget: Arc<Budget>,
    bytes: u64,
}

impl Reservation {
    /// The bytes.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Another reservation in the same budget, of no bytes.
    #[must_use]
    pub fn empty(&self) -> Self {
        Self {
            budget: Arc::clone(&self.budget),
            bytes: 0,
        }
    }

    /// Reserves so many bytes instead. It does not wait for those that others hold.
    ///
    /// # Errors
    /// More than are left; the reservation stays as it was.
    pub fn resize(&mut self, bytes: u64) -> Result<(), OverBudget> {
        let limit = self.budget.limit;
        let mut reserved = self.budget.reserved();
        let wanted = (reserved.now - self.bytes).saturating_add(bytes);
        if wanted > limit {
            return Err(OverBudget { wanted, limit });
        }
        reserved.now = wanted;
        reserved.most = reserved.most.max(wanted);
        drop(reserved);
        let shrinks = bytes < self.bytes;
        self.bytes = bytes;
        if shrinks {
            self.budget.freed.notify_all();
        }
        Ok(())
    }
}

impl Drop for Reservation {
    fn drop(&mut self) {
        self.budget.reserved().now -= self.bytes;
        self.budget.freed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reservations_never_exceed_the_budget() {
        let budget = Budget::new(100);
        let error = budget.reserve(101).unwrap_err();
        assert_eq!(
            error.to_string(),
            "101 bytes are needed at once, the budget is 100"
        );
        let first = budget.reserve(60).unwrap();
        assert!(budget.try_reserve(41).is_none());
        assert_eq!(budget.try_reserve(40).map(|second| second.bytes()), Some(40));
        drop(first);
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| (0..100).for_each(|_| drop(budget.reserve(40).unwrap())));
            }
        });
        assert!(budget.most() <= 100);
        let mut all = budget.try_reserve(100).unwrap();
        all.resize(30).unwrap();
        let other = budget.reserve(60).unwrap();
        assert!(all.resize(41).is_err() && all.resize(40).is_ok());
        assert_eq!((all.bytes(), other.bytes()), (40, 60));
    }
}
