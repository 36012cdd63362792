//! The published evaluation of harmonics, written out with its constants, and what else tests need to compare clouds.

use glam::{DMat3, DQuat, DVec3};
use splatvol_scene::Gaussians;

/// Colour from a direction in the Gaussians' own frame, not clipped.
fn color(harmonics: &[[f32; 3]], degree: u32, d: DVec3) -> DVec3 {
    let c = |i: usize| DVec3::from_array(harmonics[i].map(f64::from));
    let (x, y, z) = (d.x, d.y, d.z);
    let (xx, yy, zz, xy, yz, xz) = (x * x, y * y, z * z, x * y, y * z, x * z);
    let mut sum = 0.28209479177387814 * c(0);
    if degree > 0 {
        let k = 0.4886025119029199;
        sum += -k * y * c(1) + k * z * c(2) - k * x * c(3);
    }
    if degree > 1 {
        sum += 1.0925484305920792 * xy * c(4) - 1.0925484305920792 * yz * c(5)
            + 0.31539156525252005 * (2.0 * zz - xx - yy) * c(6)
            - 1.0925484305920792 * xz * c(7)
            + 0.5462742152960396 * (xx - yy) * c(8);
    }
    if degree > 2 {
        sum += -0.5900435899266435 * y * (3.0 * xx - yy) * c(9) + 2.890611442640554 * xy * z * c(10)
            - 0.4570457994644658 * y * (4.0 * zz - xx - yy) * c(11)
            + 0.3731763325901154 * z * (2.0 * zz - 3.0 * xx - 3.0 * yy) * c(12)
            - 0.4570457994644658 * x * (4.0 * zz - xx - yy) * c(13)
            + 1.445305721320277 * z * (xx - yy) * c(14)
            - 0.5900435899266435 * x * (xx - 3.0 * yy) * c(15);
    }
    sum + 0.5
}

/// Directions all around, in the world.
pub(crate) fn directions() -> Vec<DVec3> {
    let raw = [
        [1, 0, 0],
        [0, 1, 0],
        [0, 0, 1],
        [1, 2, 3],
        [-3, 1, 2],
        [2, -3, -1],
        [-1, -1, 2],
        [1, -2, -2],
    ];
    raw.iter()
        .map(|d| DVec3::from_array(d.map(f64::from)).normalize())
        .collect()
}

/// A Gaussian in the world.
pub(crate) struct InWorld {
    pub(crate) mean: DVec3,
    pub(crate) covariance: DMat3,
    pub(crate) opacity: f64,
    /// Colours seen from the directions above.
    pub(crate) colors: Vec<DVec3>,
}

/// All Gaussians of a cloud in the world.
pub(crate) fn in_world(gaussians: &Gaussians) -> Vec<InWorld> {
    let frame = gaussians.world_from_local();
    let scale = frame.matrix3.determinant().abs().cbrt();
    let turn = frame.matrix3 * (1.0 / scale);
    let attributes = gaussians.attributes();
    let per_splat = (gaussians.degree() as usize + 1).pow(2);
    assert_eq!(attributes.harmonics.len(), per_splat * gaussians.len());
    (0..gaussians.len())
        .map(|i| {
            let rotation = DQuat::from_array(attributes.rotations[i].map(f64::from));
            let axes = frame.matrix3
                * DMat3::from_quat(rotation)
                * DMat3::from_diagonal(DVec3::from_array(attributes.scales[i].map(f64::from)));
            let harmonics = &attributes.harmonics[i * per_splat..(i + 1) * per_splat];
            InWorld {
                mean: frame.transform_point3(DVec3::from_array(attributes.means[i].map(f64::from))),
                covariance: axes * axes.transpose(),
                opacity: f64::from(attributes.opacities[i]),
                colors: directions()
                    .iter()
                    .map(|d| color(harmonics, gaussians.degree(), turn.transpose() * *d))
                    .collect(),
            }
        })
        .collect()
}

/// Largest differences of two clouds: means, opacities, colours, and covariances relative to their trace.
pub(crate) fn differences(a: &Gaussians, b: &Gaussians) -> [f64; 4] {
    assert_eq!(a.len(), b.len());
    let mut largest = [0.0f64; 4];
    for (a, b) in in_world(a).iter().zip(in_world(b)) {
        let trace: f64 = (0..3).map(|i| a.covariance.col(i)[i]).sum();
        let covariance = (a.covariance - b.covariance)
            .to_cols_array()
            .into_iter()
            .fold(0.0, |m: f64, v| m.max(v.abs()));
        let color = a
            .colors
            .iter()
            .zip(&b.colors)
            .map(|(a, b)| (*a - *b).abs().max_element());
        let found = [
            (a.mean - b.mean).abs().max_element(),
            (a.opacity - b.opacity).abs(),
            color.fold(0.0, f64::max),
            covariance / trace,
        ];
        for (largest, found) in largest.iter_mut().zip(found) {
            *largest = largest.max(found);
        }
    }
    largest
}
