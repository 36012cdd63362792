//! Which way is up in a scan whose file does not say.
//!
//! A thing stands where the points of its lowest three percent enclose its centre, seen from above. PLY files have no
//! frame: z is up unless the points stand on y and not on z. A thing that neither stands nor lies stays as it is.
//!
//! Volumes show more than a surface, and their grid often cuts things off, which makes flat ends where there are none.
//! A volume stands on its bottom if it is heavy there. A pot, a plate or a table in the lowest tenth of the height
//! holds a third of the opacity. The centre of mass lies in the lowest quarter (that of a full cone is a quarter up),
//! and the base is below it and wide. Patients, who lie on tables, and molecules do not. Upside down (-y) is not
//! considered: slices of patients are often stored so, with the table at the end.

use std::ops::Range;

use splatvol_scene::{TransferFunction, Volume};

use crate::visible::{SeenValues, opacity_per_slice, without_specks};

/// Share of the height that counts as the bottom.
const BOTTOM: f32 = 0.03;
/// Share of the footprint's box that a base has at least.
const BASE: f32 = 0.1;
/// Share of a volume's height that its base has...
const PLATE: f64 = 0.1;
/// ...the share of opacity in it, at least...
const HEAVY: f64 = 1.0 / 3.0;
/// ...the share of height at which the centre of mass lies, at most...
const LOW: f64 = 0.25;
/// ...and the share of the footprint's box, at least.
const WIDE: f64 = 0.5;
/// Slices that make a height.
const SLICES: usize = 10;

/// Whether points stand with y up, but not with z up.
pub fn is_y_up(positions: &[[f32; 3]]) -> bool {
    stands(positions, 1) && !stands(positions, 2)
}

/// Whether points stand with this axis up.
fn stands(positions: &[[f32; 3]], up: usize) -> bool {
    let across = [(up + 1) % 3, (up + 2) % 3];
    let (low, high) = bounds(positions.iter());
    let height = high[up] - low[up];
    let bottom = positions.iter().filter(|p| p[up] - low[up] <= BOTTOM * height);
    let (base_low, base_high) = bounds(bottom);
    let centre = across.map(|axis| {
        let sum: f64 = positions.iter().map(|p| f64::from(p[axis])).sum();
        (sum / positions.len() as f64) as f32
    });
    let encloses = across
        .iter()
        .zip(centre)
        .all(|(&axis, centre)| (base_low[axis]..=base_high[axis]).contains(&centre));
    let area = |low: [f32; 3], high: [f32; 3]| across.iter().map(|&a| high[a] - low[a]).product::<f32>();
    height > 0.0 && encloses && area(base_low, base_high) >= BASE * area(low, high)
}

fn bounds<'a>(positions: impl Iterator<Item = &'a [f32; 3]>) -> ([f32; 3], [f32; 3]) {
    positions.fold(([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]), |(low, high), p| {
        (
            std::array::from_fn(|a| low[a].min(p[a])),
            std::array::from_fn(|a| high[a].max(p[a])),
        )
    })
}

/// Whether what can be seen of a volume stands with y up, but not with z up.
pub fn is_volume_y_up(volume: &Volume) -> bool {
    let grid = volume.grid();
    let direction = grid.direction();
    let along = [direction.x_axis.x, direction.y_axis.y, direction.z_axis.z];
    // Oblique directions are left to the file.
    if along.iter().any(|cosine| cosine.abs() < 1.0 - 1e-6) {
        return false;
    }
    let (transfer_function, _) = TransferFunction::automatic(volume, None);
    let seen = SeenValues::new(volume, &transfer_function);
    let rows = 0..grid.dims()[1];
    let sums = opacity_per_slice(volume, &seen, &rows);
    let [x, y, z] = std::array::from_fn(|axis| Extent::new(&sums[axis], along[axis] < 0.0));
    if !y.is_heavy_below() || z.is_heavy_below() {
        return false;
    }
    let [base_x, _, base_z] = opacity_per_slice(volume, &seen, &y.base);
    let wide = [(x, base_x), (z, base_z)].map(|(whole, base)| {
        let base = without_specks(&base);
        let below = (base.start as f64..=base.end as f64).contains(&whole.centre);
        if below {
            base.len() as f64 / whole.slices.len() as f64
        } else {
            0.0
        }
    });
    wide[0] * wide[1] >= WIDE
}

/// How the opacity of a volume is spread along an axis.
struct Extent {
    /// Slices that are seen, without specks.
    slices: Range<usize>,
    /// Slices of the lowest tenth.
    base: Range<usize>,
    /// Share of opacity in these.
    base_share: f64,
    /// Centre of mass, slices.
    centre: f64,
    /// Centre of mass, share of the height from the lower end.
    height: f64,
}

impl Extent {
    /// Of the opacities of slices; `falls` where the last slice is the lowest.
    fn new(sums: &[u64], falls: bool) -> Self {
        let slices = without_specks(sums);
        let count = slices.len();
        let thickness = (PLATE * count as f64).ceil() as usize;
        let base = if falls {
            slices.end - thickness..slices.end
        } else {
            slices.start..slices.start + thickness
        };
        let total: u64 = sums[slices.clone()].iter().sum();
        let moment: f64 = slices.clone().map(|i| (i as f64 + 0.5) * sums[i] as f64).sum();
        let centre = moment / total as f64;
        let share = (centre - slices.start as f64) / count as f64;
        Self {
            base_share: sums[base.clone()].iter().sum::<u64>() as f64 / total as f64,
            height: if falls { 1.0 - share } else { share },
            slices,
            base,
            centre,
        }
    }

    fn is_heavy_below(&self) -> bool {
        // An empty volume has no share.
        self.slices.len() >= SLICES && self.base_share >= HEAVY && self.height <= LOW
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, DVec3};
    use splatvol_scene::{Grid, LengthUnit, Rescale, Samples};

    /// Points within a pyramid, `up` being the axis along its height.
    fn pyramid(up: usize) -> Vec<[f32; 3]> {
        let mut points = Vec::new();
        for step in 0..20 {
            let height = 0.05 * step as f32;
            for side in 0..100 {
                let [x, y] = [side % 10, side / 10].map(|i| (i as f32 / 4.5 - 1.0) * (1.0 - height));
                let mut point = [0.0; 3];
                point[up] = height;
                point[(up + 1) % 3] = x;
                point[(up + 2) % 3] = y;
                points.push(point);
            }
        }
        points
    }

    #[test]
    fn a_pyramid_stands_on_its_base() {
        assert!(is_y_up(&pyramid(1)));
        assert!(!is_y_up(&pyramid(2)));
        assert!(!is_y_up(&pyramid(0)));
    }

    /// A volume of 30 samples along each axis, brighter to one side so that it is not a label volume.
    fn volume(is_there: impl Fn([usize; 3]) -> bool, direction: DMat3) -> Volume {
        let value = |i: usize| {
            let place = [i % 30, i / 30 % 30, i / 900];
            if is_there(place) {
                100.0 + (place[0] + 2 * place[1] + 3 * place[2]) as f32 / 7.0
            } else {
                0.0
            }
        };
        let samples = Samples::F32((0..27_000).map(value).collect());
        let grid = Grid::new([30; 3], DVec3::ZERO, DVec3::ONE, direction).unwrap();
        Volume::new(grid, samples, Rescale::default(), LengthUnit::Unknown).unwrap()
    }

    /// A stem on a plate that spans this range, `up` being the axis along its height.
    fn plant(up: usize, falls: bool, plate: Range<usize>) -> impl Fn([usize; 3]) -> bool {
        move |place| {
            let height = if falls { 29 - place[up] } else { place[up] };
            let across = [(up + 1) % 3, (up + 2) % 3].map(|axis| place[axis]);
            let width = if (2..5).contains(&height) {
                plate.clone()
            } else {
                13..16
            };
            (2..29).contains(&height) && across.iter().all(|i| width.contains(i))
        }
    }

    #[test]
    fn a_volume_stands_on_a_heavy_plate_across_y() {
        let is_y_up = |up, falls| is_volume_y_up(&volume(plant(up, falls, 3..26), DMat3::IDENTITY));
        assert!(is_y_up(1, false));
        for (up, falls) in [(0, false), (2, false), (0, true), (1, true), (2, true)] {
            assert!(!is_y_up(up, falls), "{up} {falls}");
        }
        // The same voxels, the axis turned around.
        let flipped = DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0));
        assert!(is_volume_y_up(&volume(plant(1, true, 3..26), flipped)));
        assert!(!is_volume_y_up(&volume(plant(1, false, 3..26), flipped)));
    }

    #[test]
    fn volumes_without_a_base_stay_as_they_are() {
        let is_y_up =
            |is_there: &dyn Fn([usize; 3]) -> bool| is_volume_y_up(&volume(is_there, DMat3::IDENTITY));
        let radius = |[x, y, z]: [usize; 3]| {
            let squares = [x, y, z].map(|i| (i as f64 - 14.5).powi(2));
            squares.iter().sum::<f64>().sqrt()
        };
        assert!(!is_y_up(&|place| radius(place) < 12.0), "ball");
        assert!(!is_y_up(&|_| true), "full");
        assert!(!is_y_up(&|_| false), "empty");
        // Half a ball lies on its flat side, and so does a patient on a table.
        assert!(!is_y_up(&|place| place[1] > 14 && radius(place) < 12.0), "half");
        let patient = |[x, y, _]: [usize; 3]| {
            let body = ((x as f64 - 14.5) / 11.0).hypot((y as f64 - 14.5) / 8.0) < 1.0;
            body || (4..6).contains(&y)
        };
        assert!(!is_y_up(&patient), "patient");
        assert!(!is_y_up(&plant(1, false, 11..18)), "light base");
        // Twigs farther out than the base make it a small one.
        let trunk = plant(1, false, 5..24);
        let twigs = |[x, y, z]: [usize; 3]| y == 28 && (x == 14 || z == 14);
        assert!(is_y_up(&trunk));
        assert!(!is_y_up(&|place| trunk(place) || twigs(place)), "small base");
    }

    #[test]
    fn what_stands_either_way_stays_as_it_is() {
        let cube: Vec<[f32; 3]> = (0..1000)
            .map(|i| [i % 10, i / 10 % 10, i / 100].map(|at| at as f32))
            .collect();
        assert!(!is_y_up(&cube));
        assert!(!is_y_up(&[[1.0; 3]]));
    }
}
