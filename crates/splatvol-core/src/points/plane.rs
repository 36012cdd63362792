//! Normals of planes through neighbours, with undetermined sign.
//!
//! The normal is the eigenvector of the smallest eigenvalue of the covariance of a place and its neighbours (Hoppe
//! et al., Surface reconstruction from unorganized points, 1992, section 3.2). Eigenvalues come from Jacobi
//! rotations, which are exact to the last digits even where the plane is perfect and two eigenvalues are equal.
//! Neighbours on a line, as in the rows of a scanner, define no plane; then the neighbours' neighbours are added.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::Neighborhoods;
use crate::eigen::eigen;

/// Ratio of the middle to the largest eigenvalue below which neighbours count as a line.
const LINE: f64 = 1e-4;

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
