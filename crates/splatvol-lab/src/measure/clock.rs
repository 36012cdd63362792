//! Times that can be compared: everything once per round, medians over the rounds, so that a slow minute of the machine
//! slows all alike.

use std::time::Instant;

use super::median;
use crate::LabError;

/// Something to time.
pub(crate) type Timed<'a> = Box<dyn FnMut() -> Result<(), LabError> + 'a>;

/// Number of timed rounds.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rounds {
    /// At least this many.
    pub(crate) least: usize,
    /// More rounds, as many as fit into this time: short measurements are repeated more often, as they are easier to
    /// disturb.
    pub(crate) seconds: f64,
}

/// Rounds above which medians gain nothing.
const MOST: usize = 31;

impl Rounds {
    /// Exactly `count` rounds.
    pub(crate) fn exactly(count: usize) -> Self {
        Self {
            least: count,
            seconds: 0.0,
        }
    }

    /// Number of rounds, if one takes `seconds`.
    fn count(self, seconds: f64) -> usize {
        let fitting = (self.seconds / seconds.max(1e-9)).min(MOST as f64) as usize;
        fitting.max(self.least)
    }
}

/// Median seconds of each, over rounds after one that is not counted.
pub(crate) fn median_seconds(timed: &mut [Timed<'_>], rounds: Rounds) -> Result<Vec<f64>, LabError> {
    let start = Instant::now();
    for one in timed.iter_mut() {
        one()?;
    }
    let count = rounds.count(start.elapsed().as_secs_f64());
    let mut seconds = vec![Vec::with_capacity(count); timed.len()];
    for _ in 0..count {
        for (one, seconds) in timed.iter_mut().zip(&mut seconds) {
            let start = Instant::now();
            one()?;
            seconds.push(start.elapsed().as_secs_f64());
        }
    }
    Ok(seconds.into_iter().map(median).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_things_are_timed_more_often() {
        let rounds = Rounds {
            least: 3,
            seconds: 10.0,
        };
        assert_eq!(
            [20.0, 1.0, 0.001, 0.0].map(|one| rounds.count(one)),
            [3, 10, MOST, MOST]
        );
        assert_eq!(Rounds::exactly(2).count(0.001), 2);
    }
}
