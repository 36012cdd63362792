//! Normals of planes through neighbours, their sign still open.
//!
//! The normal is the eigenvector of the smallest eigenvalue of the covariance of a place and its neighbours (Hoppe et al.,
//! Surface reconstruction from unorganized points, 1992, section 3.2). Eigenvalues come from Jacobi rotations, which are
//! exact to the last digits also where the plane is perfect and two eigenvalues are equal. Neighbours on a line, as in the
//! rows of a scanner, say nothing; then the neighbours' neighbours are asked too.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::Neighborhoods;

/// Neighbours count as a line where the middle eigenvalue is less than this share of the largest.
const LINE: f64 = 1e-4;
/// Rotations over all three pairs; five are enough for 64-bit numbers.
const SWEEPS: usize = 8;

impl Neighborhoods {
    /// Unit vectors perpendicular to the planes through each place's neighbours; zero on lines.
    pub(super) fn plane_normals(&self) -> Vec<DVec3> {
        (0..self.place_count())
            .into_par_iter()
            .map(|place| {
                let near = self.of(place);
                self.fit(place, near.iter())
                    .or_else(|| self.fit(place, near.iter().flat_map(|&j| self.of(j as usize))))
                    .unwrap_or(DVec3::ZERO)
            })
            .collect()
    }

    /// Normal of the plane through a place and others, `None` on lines.
    fn fit<'a>(&self, place: usize, others: impl Iterator<Item = &'a u32> + Clone) -> Option<DVec3> {
        let at = self.place(place);
        let offset = |&other: &u32| self.place(other as usize) - at;
        let mut sum = DVec3::ZERO;
        let mut count = 1.0;
        for other in others.clone() {
            sum += offset(other);
            count += 1.0;
        }
        let mean = sum / count;
        let outer = |v: DVec3| DMat3::from_cols(v * v.x, v * v.y, v * v.z);
        let covariance = others.fold(outer(mean), |sum, other| sum + outer(offset(other) - mean));
        let (values, vectors) = eigen(covariance);
        (values[1] > LINE * values[2]).then(|| vectors[0].normalize_or_zero())
    }
}

/// Eigenvalues of a symmetric matrix, smallest first, with their eigenvectors.
fn eigen(matrix: DMat3) -> ([f64; 3], [DVec3; 3]) {
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
