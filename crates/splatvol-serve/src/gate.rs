//! Gate: one picture at a time has all processors. Drafts go first, then whoever was served longest ago, so that many
//! clients share fairly; what has waited long counts as a draft, so that nobody starves.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Most pixels of a draft.
const DRAFT: usize = 1 << 16;
/// How long a large share lets drafts pass.
const LONG: Duration = Duration::from_secs(1);
/// Between two looks whether a client has left.
const SLICE: Duration = Duration::from_millis(50);

/// Who draws.
#[derive(Debug, Default)]
pub(crate) struct Gate {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    is_busy: bool,
    /// Number of the next turn.
    turn: u64,
    waiting: Vec<Waiting>,
    /// The last turn of each client.
    served: HashMap<u64, u64>,
}

#[derive(Debug)]
struct Waiting {
    ticket: u64,
    client: u64,
    pixels: usize,
    since: Instant,
}

/// The right to draw, until it is dropped.
#[derive(Debug)]
pub(crate) struct Turn<'a>(&'a Gate);

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        self.0.lock().is_busy = false;
        self.0.changed.notify_all();
    }
}

impl State {
    /// The ticket that is due.
    fn due(&self, now: Instant) -> Option<u64> {
        let rank = |own: &Waiting| {
            let is_large = own.pixels > DRAFT && now.duration_since(own.since) < LONG;
            (is_large, self.served.get(&own.client).copied(), own.ticket)
        };
        self.waiting
            .iter()
            .min_by_key(|own| rank(own))
            .map(|own| own.ticket)
    }

    fn leave(&mut self, ticket: u64) {
        self.waiting.retain(|own| own.ticket != ticket);
    }
}

impl Gate {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for a client's turn to draw so many pixels; `None` once it has left.
    pub(crate) fn enter(&self, client: u64, pixels: usize, has_left: &AtomicBool) -> Option<Turn<'_>> {
        let mut state = self.lock();
        let ticket = state.turn;
        state.turn += 1;
        state.waiting.push(Waiting {
            ticket,
            client,
            pixels,
            since: Instant::now(),
        });
        loop {
            if has_left.load(Ordering::Relaxed) {
                state.leave(ticket);
                self.changed.notify_all();
                return None;
            }
            if !state.is_busy && state.due(Instant::now()) == Some(ticket) {
                state.leave(ticket);
                state.is_busy = true;
                let turn = state.turn;
                state.turn += 1;
                state.served.insert(client, turn);
                return Some(Turn(self));
            }
            let waited = self.changed.wait_timeout(state, SLICE);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Forgets a client.
    pub(crate) fn forget(&self, client: u64) {
        self.lock().served.remove(&client);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn waiting(ticket: u64, client: u64, pixels: usize, since: Instant) -> Waiting {
        Waiting {
            ticket,
            client,
            pixels,
            since,
        }
    }

    #[test]
    fn drafts_go_first_then_whoever_waits_longest_and_nobody_starves() {
        let now = Instant::now();
        let mut state = State {
            waiting: vec![
                waiting(1, 1, 1_000_000, now),
                waiting(2, 2, 1_000_000, now),
                waiting(3, 1, 100, now),
                waiting(4, 3, 100, now),
            ],
            served: HashMap::from([(1, 9), (2, 5), (3, 7)]),
            ..State::default()
        };
        for expected in [4, 3, 2, 1] {
            assert_eq!(state.due(now), Some(expected));
            state.leave(expected);
        }
        state.waiting = vec![waiting(5, 2, 1_000_000, now), waiting(6, 1, 10, now)];
        assert_eq!(state.due(now), Some(6));
        assert_eq!(state.due(now + 2 * LONG), Some(5));
    }

    #[test]
    fn turns_come_one_at_a_time_and_those_who_left_have_none() {
        let gate = Gate::default();
        let [stays, has_left] = [false, true].map(AtomicBool::new);
        let turn = gate.enter(1, 10, &stays).unwrap();
        assert!(gate.enter(2, 10, &has_left).is_none());
        std::thread::scope(|scope| {
            let other = scope.spawn(|| gate.enter(2, 10, &stays).is_some());
            std::thread::sleep(Duration::from_millis(100));
            assert!(!other.is_finished());
            drop(turn);
            assert!(other.join().unwrap());
        });
        assert!(gate.lock().waiting.is_empty());
    }
}
