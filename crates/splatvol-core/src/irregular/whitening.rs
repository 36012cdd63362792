//! Offsets in standard deviations: `W = C^-1` of a covariance `V = C C^T` (Cholesky; Golub and Van Loan, Matrix
//! Computations, section 4.2), so that `|W d|^2 = d^T V^-1 d` and `W V W^T` is the unit matrix.

use glam::{DMat3, DVec3};

/// The lower triangular W; none where the covariance is not positive definite.
pub(super) fn whitening(v: &DMat3) -> Option<DMat3> {
    let c00 = v.x_axis.x.sqrt();
    let (c10, c20) = (v.x_axis.y / c00, v.x_axis.z / c00);
    let c11 = (v.y_axis.y - c10 * c10).sqrt();
    let c21 = (v.y_axis.z - c20 * c10) / c11;
    let c22 = (v.z_axis.z - c20 * c20 - c21 * c21).sqrt();
    let [w00, w11, w22] = [c00, c11, c22].map(f64::recip);
    let w10 = -c10 * w00 * w11;
    let w20 = -(c20 * w00 + c21 * w10) * w22;
    let w21 = -c21 * w11 * w22;
    let found = DMat3::from_cols(
        DVec3::new(w00, w10, w20),
        DVec3::new(0.0, w11, w21),
        DVec3::new(0.0, 0.0, w22),
    );
    found.is_finite().then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn covariances_become_the_unit_matrix() {
        let map = DMat3::from_cols(
            DVec3::new(2.0, -0.3, 0.1),
            DVec3::new(0.2, 1e-3, 0.4),
            DVec3::new(-0.7, 0.5, 30.0),
        );
        let covariance = map * map.transpose();
        let found = whitening(&covariance).unwrap();
        let unit = found * covariance * found.transpose();
        assert!(unit.abs_diff_eq(DMat3::IDENTITY, 1e-9), "{unit}");
        assert_eq!([found.y_axis.x, found.z_axis.x, found.z_axis.y], [0.0; 3]);
    }

    #[test]
    fn what_is_flat_or_no_covariance_has_none() {
        let flat = DMat3::from_diagonal(DVec3::new(1.0, 1.0, 0.0));
        let negative = DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0));
        let indefinite = DMat3::from_cols(DVec3::new(1.0, 2.0, 0.0), DVec3::new(2.0, 1.0, 0.0), DVec3::Z);
        for covariance in [flat, negative, indefinite, DMat3::ZERO, DMat3::NAN] {
            assert_eq!(whitening(&covariance), None, "{covariance}");
        }
    }
}
