//! Classification tables: extinction and emission of normalised values, and their integrals.
//!
//! Between two sheets the value varies from a to b. If it varies linearly, its mean extinction is
//! `(K(b) - K(a)) / (b - a)` with `K' = kappa`, and likewise for emission `kappa c`. This is pre-integrated
//! classification from one-dimensional tables, right for any transfer function, ray length and sheet thickness. It
//! is the second form of Engel, Kraus and Ertl 2001, which leaves out the attenuation inside the interval, second
//! order in its optical depth. Two-dimensional tables include the attenuation, but for one ray length only; the
//! shading stage takes short intervals instead.

use splatvol_scene::TransferFunction;

/// Extinction per world length (first) and emission (extinction times linear rgb) of values.
#[derive(Debug, Clone)]
pub struct ClassificationTable {
    /// At the nodes.
    points: Vec<[f32; 4]>,
    /// Linear rgb at the nodes, independent of the extinction.
    colors: Vec<[f32; 3]>,
    /// Integral over the normalised value from the first node, f64 because differences of it are taken.
    integrals: Vec<[f64; 4]>,
}

const FIRST: f64 = ClassificationTable::FIRST;
/// Normalised value of the last node.
const LAST: f64 = 1.5;
const CELLS: usize = ClassificationTable::CELLS;
const CELLS_PER_VALUE: f64 = ClassificationTable::CELLS_PER_VALUE;

impl ClassificationTable {
    /// Normalised value of the first node: prefiltered fields overshoot the data.
    pub const FIRST: f64 = -0.5;
    /// Cells between nodes.
    pub const CELLS: usize = 4096;
    /// Cells per normalised value.
    pub const CELLS_PER_VALUE: f64 = Self::CELLS as f64 / (LAST - Self::FIRST);

    /// Tables for values normalised by `value_range`, opacities per `unit_distance` (world length).
    pub fn new(tf: &TransferFunction, value_range: [f64; 2], unit_distance: f64) -> Self {
        const SAMPLES: usize = 4;
        let width = if value_range[1] > value_range[0] {
            value_range[1] - value_range[0]
        } else {
            1.0
        };
        let classify = |v: f64| -> [f64; 4] {
            let value = value_range[0] + v * width;
            let extinction = tf.extinction(value, unit_distance);
            if extinction == 0.0 {
                return [0.0; 4];
            }
            let [r, g, b] = tf.linear_color(value);
            [extinction, extinction * r, extinction * g, extinction * b]
        };
        let node = |i: usize| FIRST + i as f64 / CELLS_PER_VALUE;
        let color = |v: f64| tf.linear_color(value_range[0] + v * width).map(|c| c as f32);
        let colors = (0..=CELLS).map(|i| color(node(i))).collect();
        let points = (0..=CELLS).map(|i| classify(node(i)).map(|v| v as f32)).collect();
        let mut integrals = vec![[0.0; 4]; CELLS + 1];
        for i in 0..CELLS {
            let mut sum = integrals[i];
            for sample in 0..SAMPLES {
                let offset = (sample as f64 + 0.5) / SAMPLES as f64;
                let here = classify(node(i) + offset / CELLS_PER_VALUE);
                for channel in 0..4 {
                    sum[channel] += here[channel] / (SAMPLES as f64 * CELLS_PER_VALUE);
                }
            }
            integrals[i + 1] = sum;
        }
        Self {
            points,
            colors,
            integrals,
        }
    }

    /// Extinction and emission of one value.
    #[inline]
    pub fn at(&self, value: f32) -> [f32; 4] {
        let (cell, t) = locate(value);
        let (a, b) = (self.points[cell], self.points[cell + 1]);
        std::array::from_fn(|c| a[c] + t * (b[c] - a[c]))
    }

    /// A node of [`Self::CELLS`] `+ 1`: integrals of extinction and emission up to it, their values there, and
    /// linear rgb.
    pub fn node(&self, index: usize) -> ([f64; 4], [f32; 4], [f32; 3]) {
        (self.integrals[index], self.points[index], self.colors[index])
    }

    /// Table entries around a value and the weight of the second; a vector form of [`Self::at`].
    #[inline(always)]
    pub fn around(&self, value: f32) -> ([&[f32; 4]; 2], f32) {
        let (cell, t) = locate(value);
        ([&self.points[cell], &self.points[cell + 1]], t)
    }

    /// Extinction of one value.
    #[inline]
    pub fn extinction(&self, value: f32) -> f32 {
        let (cell, t) = locate(value);
        let (a, b) = (self.points[cell][0], self.points[cell + 1][0]);
        a + t * (b - a)
    }

    /// Linear rgb of one value.
    #[inline]
    pub fn color(&self, value: f32) -> [f32; 3] {
        let (cell, t) = locate(value);
        let (a, b) = (self.colors[cell], self.colors[cell + 1]);
        std::array::from_fn(|c| a[c] + t * (b[c] - a[c]))
    }

    /// Mean extinction and emission while the value runs linearly from `a` to `b`.
    #[inline]
    pub fn mean(&self, a: f32, b: f32) -> [f32; 4] {
        let width = f64::from(b) - f64::from(a);
        if width.abs() * CELLS_PER_VALUE < 1.0 {
            return self.at(0.5 * (a + b));
        }
        let (from, to) = (self.integral(a), self.integral(b));
        std::array::from_fn(|c| ((to[c] - from[c]) / width) as f32)
    }

    /// Whether any value from `low` to `high` has extinction.
    #[inline]
    pub fn is_visible(&self, low: f32, high: f32) -> bool {
        let (first, _) = locate(low);
        let (last, _) = locate(high);
        // Cells hold their nodes' values too, so that a single visible value between invisible ones counts.
        self.integrals[last + 1][0] > self.integrals[first][0]
            || self.points[first][0] > 0.0
            || self.points[last + 1][0] > 0.0
    }

    #[inline]
    fn integral(&self, value: f32) -> [f64; 4] {
        let (cell, t) = locate(value);
        let (a, b) = (self.integrals[cell], self.integrals[cell + 1]);
        // Beyond the table the value counts as its last node's.
        let beyond = f64::from(value) - f64::from(value).clamp(FIRST, LAST);
        std::array::from_fn(|c| {
            a[c] + f64::from(t) * (b[c] - a[c]) + beyond * f64::from(self.points[cell][c])
        })
    }
}

#[inline(always)]
fn locate(value: f32) -> (usize, f32) {
    let position = ((value - FIRST as f32) * CELLS_PER_VALUE as f32).clamp(0.0, CELLS as f32);
    let cell = (position as usize).min(CELLS - 1);
    (cell, position - cell as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use splatvol_scene::{ColorPoint, OpacityPoint};

    fn table() -> (TransferFunction, ClassificationTable) {
        let tf = TransferFunction::new(
            vec![
                ColorPoint::new(100.0, [1.0, 0.0, 0.2]),
                ColorPoint::new(200.0, [0.0, 1.0, 0.2]),
            ],
            vec![
                OpacityPoint::new(130.0, 0.0),
                OpacityPoint::new(140.0, 0.9),
                OpacityPoint::new(150.0, 0.0),
                OpacityPoint::new(180.0, 0.0),
                OpacityPoint::new(180.0, 0.5),
            ],
            Some(2.0),
        )
        .unwrap();
        let table = ClassificationTable::new(&tf, [100.0, 200.0], 2.0);
        (tf, table)
    }

    #[test]
    fn means_are_those_of_the_transfer_function() {
        let (tf, table) = table();
        for (a, b) in [
            (0.1, 0.9),
            (0.9, 0.1),
            (0.35, 0.352),
            (0.33, 0.36),
            (0.0, 0.2),
            (0.7, 0.95),
            (1.2, 1.9),
        ] {
            let steps = 20_000;
            let mut sum = [0.0; 4];
            for i in 0..steps {
                let value = 100.0 + 100.0 * (a + (b - a) * (f64::from(i) + 0.5) / f64::from(steps));
                let kappa = tf.extinction(value, 2.0) / f64::from(steps);
                let [r, g, b] = tf.linear_color(value);
                sum = std::array::from_fn(|c| sum[c] + kappa * [1.0, r, g, b][c]);
            }
            let found = table.mean(a as f32, b as f32);
            for c in 0..4 {
                assert!(
                    (f64::from(found[c]) - sum[c]).abs() < 2e-3,
                    "{a} {b} {c}: {found:?} {sum:?}"
                );
            }
        }
    }

    #[test]
    fn visibility_is_conservative_and_not_wasteful() {
        let (_, table) = table();
        assert!(!table.is_visible(-0.3, 0.299));
        assert!(table.is_visible(-0.3, 0.31));
        assert!(!table.is_visible(0.502, 0.798));
        assert!(table.is_visible(0.8, 0.8));
        assert!(table.is_visible(5.0, 9.0));
    }
}
