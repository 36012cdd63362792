//! Crossing: places at which the cubic between two planes takes a given value.
//!
//! Between its extrema a cubic is monotonic, so a change of sign there is one root, found by bisection to 2^-24 of
//! the interval. A zero at a plane counts as positive on both sides: neighbouring intervals share the plane's value
//! and find a root there once.

/// `a + u (b + u (c + u d))`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cubic(pub [f32; 4]);

impl Cubic {
    /// Through the middle two of four values one interval apart, with the slopes that the outer ones give.
    pub(crate) fn through([before, near, far, after]: [f32; 4]) -> Self {
        let rise = far - near;
        let (start, end) = ((far - before) * 0.5, (after - near) * 0.5);
        Self([
            near,
            start,
            rise * 3.0 - start * 2.0 - end,
            start + end - rise * 2.0,
        ])
    }

    pub(crate) fn at(&self, u: f32) -> f32 {
        let [a, b, c, d] = self.0;
        ((d * u + c) * u + b) * u + a
    }

    /// Bounds of its values over 0..1: those of its Bezier points.
    pub(crate) fn bounds(&self) -> [f32; 2] {
        let [a, b, c, d] = self.0;
        let end = a + b + c + d;
        let points = [a, a + b / 3.0, end - (b + 2.0 * c + 3.0 * d) / 3.0, end];
        points
            .into_iter()
            .fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], v| {
                [low.min(v), high.max(v)]
            })
    }

    /// Places of its extrema within 0..1, ascending; 1 stands for none.
    fn extrema(&self) -> [f32; 2] {
        let [_, b, c, d] = self.0;
        let square = c * c - 3.0 * b * d;
        if square <= 0.0 {
            return [1.0; 2];
        }
        // Without cancellation: one root by the sum of like signs, the other by their product.
        let sum = -(c + c.signum() * square.sqrt());
        let mut roots = [sum / (3.0 * d), b / sum].map(|u| if u > 0.0 && u < 1.0 { u } else { 1.0 });
        roots.sort_by(f32::total_cmp);
        roots
    }

    /// Calls `found` with each place in 0..1 where it takes the value, ascending; `near` and `far` are its ends.
    pub(crate) fn crossings(&self, value: f32, [near, far]: [f32; 2], mut found: impl FnMut(f32)) {
        let [first, second] = self.extrema();
        let end = |u: f32| {
            if u <= 0.0 {
                near
            } else if u >= 1.0 {
                far
            } else {
                self.at(u)
            }
        };
        for [from, to] in [[0.0, first], [first, second], [second, 1.0]] {
            let rising = end(to) >= value;
            if from < to && (end(from) >= value) != rising {
                found(self.bisect(value, [from, to], rising));
            }
        }
    }

    fn bisect(&self, value: f32, [mut from, mut to]: [f32; 2], rising: bool) -> f32 {
        for _ in 0..24 {
            let middle = 0.5 * (from + to);
            if (self.at(middle) >= value) == rising {
                to = middle;
            } else {
                from = middle;
            }
        }
        0.5 * (from + to)
    }
}

#[cfg(test)]
mod tests {
    use splatvol_testing::Random;

    use super::*;

    /// Against changes of sign among many samples in f64.
    #[test]
    fn crossings_are_those_of_many_samples() {
        let mut random = Random::new(3);
        let mut several = 0;
        for round in 0..8000u32 {
            let values: [f32; 4] = std::array::from_fn(|_| (random.unit() * 2.0 - 1.0) as f32);
            let cubic = Cubic::through(values);
            let [low, high] = cubic.bounds();
            let exact = |u: f64| {
                let [a, b, c, d] = cubic.0.map(f64::from);
                ((d * u + c) * u + b) * u + a
            };
            let target = (random.unit() * 0.4 - 0.2) as f32;
            let mut found = Vec::new();
            cubic.crossings(target, [values[1], values[2]], |u| found.push(u));
            several += usize::from(found.len() > 1);
            let steps = 4000;
            let mut expected = Vec::new();
            for i in 0..steps {
                let [u, w] = [i, i + 1].map(|i| f64::from(i) / f64::from(steps));
                assert!((f64::from(low) - 1e-6..=f64::from(high) + 1e-6).contains(&exact(u)));
                if (exact(u) >= f64::from(target)) != (exact(w) >= f64::from(target)) {
                    expected.push((u + w) * 0.5);
                }
            }
            assert_eq!(found.len(), expected.len(), "{round}: {found:?} {expected:?}");
            for (a, b) in found.iter().zip(&expected) {
                assert!((f64::from(*a) - b).abs() < 2e-4, "{round}: {a} {b}");
            }
        }
        assert!(several > 20, "{several}");
    }
}
