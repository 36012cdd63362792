//! Gaussians in another frame: similarities only, since those keep Gaussians' axes orthogonal and their harmonics'
//! degrees.
//!
//! A mirrored Gaussian has the rotation `M R diag(1, 1, -1)`: changing the sign of one of its own axes does not change
//! its covariance `R S S^T R^T`.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use splatvol_scene::GaussianAttributes;

use super::harmonics::{Turn, harmonics_count};

/// Largest deviation of a matrix from a similarity, relative to its scale: matrices in files have 6 or 7 digits.
const TOLERANCE: f64 = 1e-4;

/// Scale and orthogonal part of a similarity; `None` if the matrix is not one.
fn similarity(matrix: DMat3) -> Option<(f64, DMat3)> {
    let scale = matrix.determinant().abs().cbrt();
    let orthogonal = matrix * (1.0 / scale);
    let product = orthogonal.transpose() * orthogonal - DMat3::IDENTITY;
    let largest = product
        .to_cols_array()
        .into_iter()
        .fold(0.0, |m: f64, v| m.max(v.abs()));
    (scale.is_normal() && largest < TOLERANCE).then_some((scale, orthogonal))
}

/// Moves Gaussians with their harmonics; returns false and does nothing if `new_from_old` is not a
/// similarity.
pub(crate) fn transform(attributes: &mut GaussianAttributes, degree: u32, new_from_old: &DAffine3) -> bool {
    let Some((scale, orthogonal)) = similarity(new_from_old.matrix3) else {
        return false;
    };
    if new_from_old.abs_diff_eq(DAffine3::IDENTITY, 1e-12) {
        return true;
    }
    let mirrors = orthogonal.determinant() < 0.0;
    for mean in &mut attributes.means {
        let moved = new_from_old.transform_point3(DVec3::from_array(mean.map(f64::from)));
        *mean = moved.as_vec3().to_array();
    }
    for lengths in &mut attributes.scales {
        *lengths = lengths.map(|length| (f64::from(length) * scale) as f32);
    }
    for rotation in &mut attributes.rotations {
        let old = DQuat::from_array(rotation.map(f64::from)).normalize();
        let mut axes = orthogonal * DMat3::from_quat(old);
        if mirrors {
            axes.z_axis = -axes.z_axis;
        }
        *rotation = DQuat::from_mat3(&axes).as_quat().to_array();
    }
    if degree > 0 {
        let turn = Turn::new(orthogonal);
        let each = attributes.harmonics.chunks_exact_mut(harmonics_count(degree));
        each.for_each(|harmonics| turn.apply(harmonics));
    }
    true
}
