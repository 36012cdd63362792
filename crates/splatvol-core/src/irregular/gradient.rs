//! Gradients of scattered values by least squares.
//!
//! `min_g sum_j w_j (f_j - f_i - g . d_j)^2` over the neighbours j at offsets `d_j`, with `w_j = 1 / |d_j|^2`:
//! exact for linear fields. The gradient is zero in directions without a neighbour, by means of a small ridge.

use glam::{DMat3, DVec3};

use super::outer;

/// Weight of the ridge, relative to the matrix' trace.
const RIDGE: f64 = 1e-12;

/// The gradient at a sample from offsets and differences of value of its neighbours.
pub(super) fn least_squares(neighbours: impl Iterator<Item = (DVec3, f64)>) -> DVec3 {
    let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for (offset, difference) in neighbours {
        let weight = offset.length_squared().recip();
        if weight.is_finite() && difference.is_finite() {
            matrix += weight * outer(offset, offset);
            right += weight * difference * offset;
        }
    }
    let trace = matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z;
    let gradient = (matrix + DMat3::from_diagonal(DVec3::splat(RIDGE * trace))).inverse() * right;
    if gradient.is_finite() {
        gradient
    } else {
        DVec3::ZERO
    }
}
