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
