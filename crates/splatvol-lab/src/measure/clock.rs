//! Times that can be compared: everything once per round, medians over the rounds, so that a slow minute of the machine
//! slows all alike.

use std::time::Instant;

use super::median;
use crate::LabError;

/// Something to time.
pub(crate) type Timed<'a> = Box<dyn FnMut() -> Result<(), LabError> + 'a>;

/// Median seconds of each, over `rounds` rounds after one that is not counted.
pub(crate) fn median_seconds(timed: &mut [Timed<'_>], rounds: usize) -> Result<Vec<f64>, LabError> {
    let mut seconds = vec![Vec::with_capacity(rounds); timed.len()];
    for round in 0..=rounds {
        for (one, seconds) in timed.iter_mut().zip(&mut seconds) {
            let start = Instant::now();
            one()?;
            if round > 0 {
                seconds.push(start.elapsed().as_secs_f64());
            }
        }
    }
    Ok(seconds.into_iter().map(median).collect())
}
