//! Estimation of radii and normals for bare point clouds.
//!
//! Both follow from the `k` nearest neighbours of every point. Points at the same place count once: in a scan
//! stored twice, every point would otherwise have a neighbour at distance zero.
//!
//! | module | what | source |
//! |---|---|---|
//! | `neighbors`, `nearest` | the `k` nearest distinct places of each | Samet 2006, section 4.2 |
//! | `radii` | spacing from local density | `n = k / (pi d_k^2)` points per area |
//! | `plane` | normal of the plane through the neighbours | Hoppe et al. 1992, section 3.2 |
//! | `orientation`, `spanning` | one side for all of them | Hoppe et al. 1992, section 3.3; König and Gumhold 2009; Borůvka 1926 |
//!
//! Results are the same to the byte for any number of threads.

mod nearest;
mod neighbors;
mod orientation;
mod plane;
mod radii;
mod spanning;

use glam::DVec3;

pub use neighbors::Neighborhoods;

/// Which of its two sides a surface shows.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Orientation {
    /// Normals agree with their neighbours' and point out of the enclosed volume; an open, nearly flat surface
    /// faces the positive end of the axis most perpendicular to it.
    #[default]
    Outward,
    /// Every normal points to the side of this place (in the positions' space), such as a scanner's.
    Towards(DVec3),
    /// Every normal has a positive component along this direction, such as up for terrain seen from the air.
    Along(DVec3),
}

/// Height of a landscape relative to the lesser of its widths, at most.
const FLAT: f64 = 0.25;
/// Share of the heights at either end that does not count: birds, and echoes from below the ground.
const STRAYS: f64 = 0.005;

impl Orientation {
    /// The side that a cloud shows: a survey of a landscape, far wider than high, was taken from above, so that all its normals
    /// point up, on single trees and the scattered points of a sparse scan too; anything else shows its outside. `up` is a
    /// direction in the positions' space.
    pub fn of(positions: &[[f32; 3]], up: DVec3) -> Self {
        let up = up.normalize_or(DVec3::Z);
        let (right, forward) = up.any_orthonormal_pair();
        let along = |axis: DVec3| move |p: &[f32; 3]| DVec3::from_array(p.map(f64::from)).dot(axis);
        let width = |axis| {
            let [low, high] = positions
                .iter()
                .map(along(axis))
                .filter(|at| at.is_finite())
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| {
                    [low.min(at), high.max(at)]
                });
            high - low
        };
        let mut heights: Vec<f64> = positions
            .iter()
            .map(along(up))
            .filter(|at| at.is_finite())
            .collect();
        let strays = (STRAYS * heights.len() as f64) as usize;
        let Some(last) = heights.len().checked_sub(1 + strays) else {
            return Self::Outward;
        };
        let highest = *heights.select_nth_unstable_by(last, f64::total_cmp).1;
        let lowest = *heights.select_nth_unstable_by(strays, f64::total_cmp).1;
        if highest - lowest < FLAT * width(right).min(width(forward)) {
            Self::Along(up)
        } else {
            Self::Outward
        }
    }
}

/// Radii, lengths of the positions' space, from the distances to the `k` nearest neighbours (6 to 8 are usual): the
/// mean distance between points of the surface nearby. Discs of these radii cover a regular grid twice over,
/// without holes. A stray point is at most twice as large as the median of its neighbours.
///
/// Every radius is finite and above zero. If all points lie at one place, every radius is 1.
pub fn estimate_radii(positions: &[[f32; 3]], k: usize) -> Vec<f32> {
    Neighborhoods::new(positions, k).radii()
}

/// Unit normals of planes fitted to the `k` nearest neighbours (8 to 16 are usual), pointing outward
/// ([`Orientation::Outward`]); zero where the neighbours lie on a line, which defines no plane.
pub fn estimate_normals(positions: &[[f32; 3]], k: usize) -> Vec<[f32; 3]> {
    Neighborhoods::new(positions, k).normals(Orientation::Outward)
}

#[cfg(test)]
mod tests;
