//! Eigenvalues of symmetric matrices by Jacobi rotations (Golub and Van Loan, Matrix Computations, section 8.5),
//! which are exact to the last digits also where two eigenvalues are equal.

use glam::{DMat3, DVec3};

/// Rotations over all three pairs; five are enough for 64-bit numbers.
const SWEEPS: usize = 8;

/// Eigenvalues of a symmetric matrix, smallest first, with their eigenvectors.
pub(crate) fn eigen(matrix: DMat3) -> ([f64; 3], [DVec3; 3]) {
    let mut a = matrix.to_cols_array_2d();
    let mut v = DMat3::IDENTITY.to_cols_array_2d();
    for _ in 0..SWEEPS {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            rotate(&mut a, &mut v, p, q);
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| f64::total_cmp(&a[i][i], &a[j][j]));
    (order.map(|i| a[i][i]), order.map(|i| DVec3::from_array(v[i])))
}

/// The rotation that makes `a[p][q]` zero (Golub and Van Loan, section 8.5); columns of `v` turn with it.
fn rotate(a: &mut [[f64; 3]; 3], v: &mut [[f64; 3]; 3], p: usize, q: usize) {
    if a[p][q] == 0.0 {
        return;
    }
    let tau = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let t = tau.signum() / (tau.abs() + (1.0 + tau * tau).sqrt());
    let c = 1.0 / (1.0 + t * t).sqrt();
    let s = t * c;
    let off = a[p][q];
    a[p][p] -= t * off;
    a[q][q] += t * off;
    (a[p][q], a[q][p]) = (0.0, 0.0);
    let r = 3 - p - q;
    let (rp, rq) = (a[r][p], a[r][q]);
    (a[r][p], a[r][q]) = (c * rp - s * rq, s * rp + c * rq);
    (a[p][r], a[q][r]) = (a[r][p], a[r][q]);
    let (vp, vq) = (DVec3::from_array(v[p]), DVec3::from_array(v[q]));
    (v[p], v[q]) = ((c * vp - s * vq).to_array(), (s * vp + c * vq).to_array());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvectors_satisfy_their_equation() {
        let matrices = [
            DMat3::from_cols_array(&[4.0, 1.0, -2.0, 1.0, 3.0, 0.5, -2.0, 0.5, 1.0]),
            DMat3::from_diagonal(DVec3::new(2.0, 2.0, 1e-9)),
            DMat3::from_cols_array(&[1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]),
            DMat3::ZERO,
        ];
        for matrix in matrices {
            let (values, vectors) = eigen(matrix);
            assert!(values[0] <= values[1] && values[1] <= values[2], "{values:?}");
            for (value, vector) in values.into_iter().zip(vectors) {
                let residual = (matrix * vector - vector * value).length();
                assert!(residual < 1e-14 * 8.0, "{matrix}: {residual}");
                assert!((vector.length() - 1.0).abs() < 1e-14);
            }
        }
    }
}
