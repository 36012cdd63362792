//! The prefilter's linear system, solved by elimination.
//!
//! On a full box `A_ik = h(i - k)` is the Kronecker product of one small matrix per axis,
//! `A_ik = factor(i - k)`, so that the solution is one dense solve per axis and line of samples. Gaussian elimination
//! with partial pivoting: slow, exact to rounding, and without assumptions about boundaries.

use rayon::prelude::*;

use crate::kernel::GaussianKernel;

/// LU decomposition of the n x n matrix of one axis.
struct AxisMatrix {
    n: usize,
    /// Rows; below the diagonal the factors of the elimination.
    rows: Vec<Vec<f64>>,
    /// Row of the right-hand side that ends up in row i.
    order: Vec<usize>,
}

impl AxisMatrix {
    /// `None` where the matrix is singular to rounding.
    fn new(kernel: &GaussianKernel, n: usize) -> Option<Self> {
        let mut rows: Vec<Vec<f64>> = (0..n)
            .map(|i| (0..n).map(|k| kernel.factor(i as f64 - k as f64)).collect())
            .collect();
        let mut order: Vec<usize> = (0..n).collect();
        for column in 0..n {
            let size = |row: usize| rows[row][column].abs();
            let pivot = (column..n).max_by(|&a, &b| size(a).total_cmp(&size(b)))?;
            if size(pivot) < 1e-12 {
                return None;
            }
            rows.swap(column, pivot);
            order.swap(column, pivot);
            let (upper, lower) = rows.split_at_mut(column + 1);
            let pivot_row = &upper[column];
            for row in lower.iter_mut().filter(|row| row[column] != 0.0) {
                let factor = row[column] / pivot_row[column];
                row[column] = factor;
                for k in column + 1..n {
                    row[k] -= factor * pivot_row[k];
                }
            }
        }
        Some(Self { n, rows, order })
    }

    fn solve(&self, right: &[f64]) -> Vec<f64> {
        let mut x: Vec<f64> = self.order.iter().map(|&i| right[i]).collect();
        for i in 0..self.n {
            let known: f64 = (0..i).map(|k| self.rows[i][k] * x[k]).sum();
            x[i] -= known;
        }
        for i in (0..self.n).rev() {
            let known: f64 = (i + 1..self.n).map(|k| self.rows[i][k] * x[k]).sum();
            x[i] = (x[i] - known) / self.rows[i][i];
        }
        x
    }
}

/// Solves `sum_k c_k h(i - k) = right_i` on a box of `dims` samples (x fastest).
///
/// # Errors
/// The number of samples of the axis whose matrix is singular.
pub(crate) fn solve(kernel: &GaussianKernel, dims: [usize; 3], right: Vec<f64>) -> Result<Vec<f64>, usize> {
    let mut values = right;
    let mut stride = 1;
    for n in dims {
        let matrix = AxisMatrix::new(kernel, n).ok_or(n)?;
        let first_of_line = |line: usize| line / stride * stride * n + line % stride;
        let lines: Vec<Vec<f64>> = (0..values.len() / n)
            .into_par_iter()
            .map(|line| {
                let right: Vec<f64> = (0..n).map(|i| values[first_of_line(line) + i * stride]).collect();
                matrix.solve(&right)
            })
            .collect();
        for (line, solution) in lines.iter().enumerate() {
            for (i, &value) in solution.iter().enumerate() {
                values[first_of_line(line) + i * stride] = value;
            }
        }
        stride *= n;
    }
    Ok(values)
}
