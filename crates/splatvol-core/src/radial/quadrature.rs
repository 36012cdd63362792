//! Gauss-Legendre quadrature with 32 nodes: exact for polynomials to degree 63.

use std::f64::consts::PI;
use std::sync::LazyLock;

const COUNT: usize = 32;

/// Nodes in -1..1 and their weights.
static NODES: LazyLock<[[f64; 2]; COUNT]> = LazyLock::new(|| std::array::from_fn(node));

/// `int_from^to f(x) dx` for an f that is smooth on the interval.
pub(super) fn integral(from: f64, to: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    half * NODES
        .iter()
        .map(|&[node, weight]| weight * f(middle + half * node))
        .sum::<f64>()
}

/// A zero of the Legendre polynomial by Newton's method, and `2 / ((1 - x^2) P'(x)^2)`.
fn node(index: usize) -> [f64; 2] {
    let mut x = libm::cos(PI * (index as f64 + 0.75) / (COUNT as f64 + 0.5));
    let mut slope = 1.0;
    for _ in 0..8 {
        let value;
        [value, slope] = legendre(x);
        x -= value / slope;
    }
    [x, 2.0 / ((1.0 - x * x) * slope * slope)]
}

/// The Legendre polynomial of degree [`COUNT`] and its derivative.
fn legendre(x: f64) -> [f64; 2] {
    let (mut before, mut value) = (1.0, x);
    for degree in 2..=COUNT {
        let degree = degree as f64;
        (before, value) = (
            value,
            ((2.0 * degree - 1.0) * x * value - (degree - 1.0) * before) / degree,
        );
    }
    [value, COUNT as f64 * (x * value - before) / (x * x - 1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_exact() {
        for power in [0, 1, 2, 7, 30, 63] {
            let exact = (3.0_f64.powi(power + 1) - 1.0) / f64::from(power + 1);
            let found = integral(1.0, 3.0, |x| x.powi(power));
            assert!((found / exact - 1.0).abs() < 1e-13, "{power} {found} {exact}");
        }
    }
}
