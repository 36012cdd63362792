//! One value of a ray (docs/numerics.md, modes mip, minip and mean).
//!
//! The largest and the smallest: dense samples, then golden-section search around the best of them. Only positions with
//! coverage of at least one half count. The value is band-limited (a Gaussian of at least 0.3 voxels), so that between
//! samples a fraction of a voxel apart it has no second maximum.
//!
//! The mean `int q v dl / int q dl`, where q reaches one half: Simpson's rule over the same samples and their middles.

use crate::medium::MediumSample;

/// Iterations of the golden-section search: the bracket shrinks by 0.618^40 = 4e-9.
const ITERATIONS: usize = 40;

/// A value of the ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RayValue {
    /// Value, data units.
    pub(crate) value: f64,
    /// Position along the ray, 0..1: where it is, or the mean one.
    pub(crate) position: f64,
}

/// Value of a sample, minus infinity where it does not count.
fn counted(sample: &MediumSample) -> f64 {
    if sample.coverage >= 0.5 {
        sample.value
    } else {
        f64::NEG_INFINITY
    }
}

/// Largest value over positions 0..1 from `steps` equal intervals; the first of equals, `None` where nothing counts.
pub(crate) fn maximum(medium: impl Fn(f64) -> MediumSample, steps: usize) -> Option<RayValue> {
    let at = |position: f64| RayValue {
        value: counted(&medium(position)),
        position,
    };
    let samples: Vec<RayValue> = (0..=steps).map(|i| at(i as f64 / steps as f64)).collect();
    let better = |a: RayValue, b: RayValue| if b.value > a.value { b } else { a };
    let mut best = samples.iter().copied().reduce(better)?;
    for i in 0..=steps {
        let (before, after) = (samples[i.saturating_sub(1)], samples[(i + 1).min(steps)]);
        let here = samples[i];
        let is_peak = here.value.is_finite() && here.value >= before.value && here.value >= after.value;
        // Between samples a peak rises less than the samples around it fall; a neighbour that does not count says
        // nothing.
        let rise = (here.value - before.value).max(here.value - after.value);
        if is_peak && here.value + rise >= best.value {
            best = better(best, golden_section(&at, before.position, after.position));
        }
    }
    best.value.is_finite().then_some(best)
}

/// Smallest value, as [`maximum`].
pub(crate) fn minimum(medium: impl Fn(f64) -> MediumSample, steps: usize) -> Option<RayValue> {
    let negated = |position: f64| {
        let sample = medium(position);
        MediumSample {
            value: -sample.value,
            ..sample
        }
    };
    maximum(negated, steps).map(|found| RayValue {
        value: -found.value,
        ..found
    })
}

/// Mean value and position, weighted by coverage; `None` where coverage is nowhere one half.
pub(crate) fn mean(medium: impl Fn(f64) -> MediumSample, steps: usize) -> Option<RayValue> {
    let (mut coverage, mut value, mut place, mut most) = (0.0, 0.0, 0.0, 0.0f64);
    let last = 2 * steps;
    for i in 0..=last {
        let position = i as f64 / last as f64;
        let sample = medium(position);
        if sample.coverage <= 0.0 {
            // Values far outside are not defined.
            continue;
        }
        let simpson = match i {
            _ if i == 0 || i == last => 1.0,
            _ if i % 2 == 1 => 4.0,
            _ => 2.0,
        };
        let weight = simpson * sample.coverage;
        coverage += weight;
        value += weight * sample.value;
        place += weight * position;
        most = most.max(sample.coverage);
    }
    (most >= 0.5).then(|| RayValue {
        value: value / coverage,
        position: place / coverage,
    })
}

fn golden_section(at: &impl Fn(f64) -> RayValue, mut low: f64, mut high: f64) -> RayValue {
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    let mut left = at(high - ratio * (high - low));
    let mut right = at(low + ratio * (high - low));
    for _ in 0..ITERATIONS {
        // Where neither counts, those that do may be on either side of both; the sampled peak remains.
        if left.value >= right.value {
            high = right.position;
            right = left;
            left = at(high - ratio * (high - low));
        } else {
            low = left.position;
            left = right;
            right = at(low + ratio * (high - low));
        }
    }
    if left.value >= right.value { left } else { right }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn search(value: impl Fn(f64) -> f64, counts: impl Fn(f64) -> bool) -> Option<RayValue> {
        let medium = |x: f64| MediumSample {
            value: value(x),
            coverage: if counts(x) { 1.0 } else { 0.0 },
            ..MediumSample::default()
        };
        maximum(medium, 50)
    }

    #[test]
    fn a_peak_between_samples_is_found() {
        let found = search(|x| 2.0 - (x - 0.3456).powi(2), |_| true).unwrap();
        assert!((found.value - 2.0).abs() < 1e-14 && (found.position - 0.3456).abs() < 1e-6);
    }

    #[test]
    fn a_maximum_at_the_border_of_what_counts_is_found() {
        for border in [0.500_1, 0.513, 0.519_9] {
            let found = search(|x| x, |x| x <= border).unwrap();
            assert!((found.value - border).abs() < 1e-6, "{border}: {}", found.value);
            let found = search(|x| -x, |x| x >= border).unwrap();
            assert!((found.value + border).abs() < 1e-6, "{border}: {}", found.value);
        }
        assert_eq!(search(|x| x, |_| false), None);
    }

    #[test]
    fn the_smallest_value_is_the_largest_of_the_opposite() {
        let medium = |x: f64| MediumSample {
            value: 3.0 + (x - 0.3456).powi(2),
            coverage: 1.0,
            ..MediumSample::default()
        };
        let found = minimum(medium, 50).unwrap();
        assert!((found.value - 3.0).abs() < 1e-14 && (found.position - 0.3456).abs() < 1e-6);
    }

    #[test]
    fn the_mean_is_weighted_by_coverage() {
        // int x^2 (1 - x) / int (1 - x) = 1/6, int x (1 - x) / int (1 - x) = 1/3.
        let medium = |x: f64| MediumSample {
            value: x * x,
            coverage: 1.0 - x,
            ..MediumSample::default()
        };
        let found = mean(medium, 50).unwrap();
        assert!((found.value - 1.0 / 6.0).abs() < 1e-12, "{}", found.value);
        assert!((found.position - 1.0 / 3.0).abs() < 1e-7, "{}", found.position);
        let outside = |x: f64| MediumSample {
            value: f64::NAN,
            coverage: 0.0,
            ..medium(x)
        };
        assert_eq!(mean(outside, 50), None);
        let faint = |x: f64| MediumSample {
            coverage: 0.49 * x,
            ..medium(x)
        };
        assert_eq!(mean(faint, 50), None);
    }
}
