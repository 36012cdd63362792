//! The statistics of JPEG-LS: quantised gradients, and the 365 + 2 contexts that learn from errors (T.87, A.3, A.6).

/// Coding parameters such as thresholds of gradients, as the standard derives them or the stream defines them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Parameters {
    pub(super) max_value: i32,
    pub(super) thresholds: [i32; 3],
    pub(super) reset: i32,
    /// Largest error of a sample.
    pub(super) near: i32,
}

impl Parameters {
    /// C.2.4.1.1.
    pub(super) fn new(max_value: i32, near: i32) -> Self {
        let clamp = |value: i32, low: i32| {
            if value > max_value || value < low {
                low
            } else {
                value
            }
        };
        let thresholds = if max_value >= 128 {
            let factor = (max_value.min(4095) + 128) / 256;
            let first = clamp(factor + 2 + 3 * near, near + 1);
            let second = clamp(factor * 4 + 3 + 5 * near, first);
            [first, second, clamp(factor * 17 + 4 + 7 * near, second)]
        } else {
            let factor = 256 / (max_value + 1);
            let first = clamp(2.max(3 / factor + 3 * near), near + 1);
            let second = clamp(3.max(7 / factor + 5 * near), first);
            [first, second, clamp(4.max(21 / factor + 7 * near), second)]
        };
        Self {
            max_value,
            thresholds,
            reset: 64,
            near,
        }
    }

    /// Number of values that an error can have.
    pub(super) fn range(&self) -> i32 {
        (self.max_value + 2 * self.near) / (2 * self.near + 1) + 1
    }

    /// A gradient as -4 to 4.
    pub(super) fn quantised(&self, gradient: i32) -> i32 {
        let [first, second, third] = self.thresholds;
        let size = match gradient.abs() {
            size if size >= third => 4,
            size if size >= second => 3,
            size if size >= first => 2,
            size if size > self.near => 1,
            _ => 0,
        };
        size * gradient.signum()
    }
}

/// Error statistics of one context.
#[derive(Debug, Clone, Copy)]
pub(super) struct Statistics {
    /// Sum of the errors' sizes.
    pub(super) sizes: i32,
    /// Sum of the errors, kept small.
    pub(super) bias: i32,
    /// Correction of the prediction.
    pub(super) correction: i32,
    pub(super) count: i32,
    /// Number of negative errors at the end of runs.
    pub(super) negative: i32,
}

impl Statistics {
    pub(super) fn new(range: i32) -> Self {
        Self {
            sizes: 2.max((range + 32) / 64),
            bias: 0,
            correction: 0,
            count: 1,
            negative: 0,
        }
    }

    /// Golomb's parameter for `total` (A.5.1): the least k with `count 2^k >= total`.
    pub(super) fn golomb(&self, total: i32) -> u32 {
        let mut k = 0;
        while k < 24 && i64::from(self.count) << k < i64::from(total) {
            k += 1;
        }
        k
    }

    /// Learns an error of a regular sample (A.6.1, A.6.2).
    pub(super) fn learn(&mut self, error: i32, parameters: &Parameters) {
        self.sizes = self.sizes.saturating_add(error.abs());
        self.bias = self
            .bias
            .saturating_add(error.saturating_mul(2 * parameters.near + 1));
        if self.count >= parameters.reset {
            self.sizes >>= 1;
            self.bias >>= 1;
            self.count >>= 1;
        }
        self.count += 1;
        if self.bias <= -self.count {
            self.bias = (self.bias + self.count).max(1 - self.count);
            self.correction = (self.correction - 1).max(-128);
        } else if self.bias > 0 {
            self.bias = (self.bias - self.count).min(0);
            self.correction = (self.correction + 1).min(127);
        }
    }

    /// Learns the error of the sample that ends a run (A.7.2.2), coded as `mapped`.
    pub(super) fn learn_end(&mut self, error: i32, mapped: i32, kind: i32, reset: i32) {
        self.negative += i32::from(error < 0);
        self.sizes = self.sizes.saturating_add((mapped + 1 - kind) >> 1);
        if self.count >= reset {
            self.sizes >>= 1;
            self.count >>= 1;
            self.negative >>= 1;
        }
        self.count += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_are_those_of_the_standard() {
        // Table C.3.
        for (max_value, thresholds) in [(255, [3, 7, 21]), (4095, [18, 67, 276]), (65535, [18, 67, 276])] {
            assert_eq!(
                Parameters::new(max_value, 0).thresholds,
                thresholds,
                "{max_value}"
            );
        }
    }
}
