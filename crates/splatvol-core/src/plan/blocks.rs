//! Blocks: footprints are drawn in squares of whole blocks of 2 x 2 raster points, in a few sizes.

use super::raster::SheetShape;
use crate::normal::mass_within;

/// Largest footprint, blocks along an edge. Other sizes are rounded up to the next compiled one.
pub const MAX_BLOCKS: usize = 16;

/// Compiled sizes of footprints: blocks along the edge.
pub const SIZES: [usize; 10] = [2, 3, 4, 5, 6, 7, 8, 10, 12, MAX_BLOCKS];

/// Least size of ellipses whose blocks are not all added, but those alone in which they weigh more than nothing.
pub const TRIMMED: usize = 6;

/// Octaves below the kernel's cut at which footprints are nothing. The mass of a Gaussian outside the ellipse of exponent t, to
/// base 2, is `2^t`: of footprints cut at 3.3 standard deviations 1/2000, less than a step of 8 bits.
pub const BELOW_CUT: f32 = 3.0;

/// Edge of the drawn square, in reaches of the footprint. Two would hold all of it; the outermost twentieth, less
/// than a hundredth of the peak, may be left out at an unfavourable position.
const DRAWN: f32 = 1.88;

/// Farthest raster point of a square of blocks from its footprint's centre, less half the square's edge: half a point,
/// as blocks begin at even points, and a quarter for rounding.
const OFF_CENTRE: f32 = 0.75;

/// Room for the footprints of a voxel's sheets, around that of its middle sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Room {
    /// Along x and y, world length.
    pub around: [f32; 2],
    /// Relative to all this.
    pub factor: f32,
}

impl Default for Room {
    fn default() -> Self {
        Self {
            around: [0.0; 2],
            factor: 1.0,
        }
    }
}

/// Reach of a voxel's footprints around that of its middle sheet, raster points.
pub fn room_of(shape: &SheetShape, cut: f32, room: &Room) -> [f32; 2] {
    let half = shape.half_extent(cut);
    std::array::from_fn(|axis| (half[axis] + room.around[axis] * shape.scale) * room.factor)
}

/// Blocks along the edge of footprints with the given reach, raster points.
pub fn blocks_of([x, y]: [f32; 2]) -> usize {
    // Reaches without bounds count as the longest there are.
    let points = ((DRAWN * x.max(y)).floor() as usize).saturating_add(1);
    let blocks = points.saturating_add(1).div_ceil(2);
    SIZES
        .into_iter()
        .find(|&size| size >= blocks)
        .unwrap_or(MAX_BLOCKS)
}

/// Share of a footprint's mass within the blocks in which it is drawn.
pub fn mass_drawn(shape: &SheetShape, cut: f32, room: &Room) -> f32 {
    let blocks = blocks_of(room_of(shape, cut, room));
    let share = |sigma: f32| mass_in_blocks(blocks, f64::from(sigma)) as f32;
    let [x, y] = shape.half_extent(1.0).map(share);
    x * y
}

/// Share of a Gaussian's mass, of standard deviation `sigma`, raster points, along an axis. Blocks begin at even points: on
/// average over the centre's places, their points are those around it and one farther, half each.
fn mass_in_blocks(blocks: usize, sigma: f64) -> f64 {
    let half = |beside: f64| 0.5 * mass_within((blocks as f64 + beside) / sigma);
    half(0.5) + half(-0.5)
}

/// Whether the largest blocks hold footprints that reach so far.
pub(super) fn fit_blocks([x, y]: [f32; 2]) -> bool {
    DRAWN * x.max(y) < (2 * MAX_BLOCKS - 1) as f32
}

/// Reach of a coefficient of a coarse raster, points: two and a half to those of the raster twice as fine, and the cubic
/// spline of these.
const COEFFICIENT_REACH: f32 = 3.5;

/// Largest distance from a footprint's centre at which pixels change. Pixels change if a block of the footprint
/// covers them, or the support of their coefficients or gradient. `half_extent`: reach of the footprints, raster points.
pub(super) fn pixel_reach(half_extent: [f32; 2], step: usize) -> f32 {
    let blocks = blocks_of(half_extent) as f32 + OFF_CENTRE;
    let coefficient = if step > 1 { COEFFICIENT_REACH } else { 0.0 };
    (blocks + coefficient) * step as f32 + 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mass_in_blocks_is_that_of_their_points_wherever_the_centre_is() {
        for (blocks, sigma) in [(2, 0.8), (3, 1.2), (5, 1.2), (4, 2.3), (16, 4.6)] {
            let (mut sum, places) = (0.0, 200);
            for place in 0..places {
                let centre = 2.0 * (f64::from(place) + 0.5) / f64::from(places) - 1.0;
                let points = (0..2 * blocks).map(|i| i as f64 - blocks as f64 + 0.5 - centre);
                sum += points
                    .map(|x| crate::normal::density(x / sigma) / sigma)
                    .sum::<f64>();
            }
            let expected = sum / f64::from(places);
            let mass = mass_in_blocks(blocks, sigma);
            assert!(
                (mass - expected).abs() < 1e-5,
                "{blocks} {sigma}: {mass} {expected}"
            );
        }
    }
}
