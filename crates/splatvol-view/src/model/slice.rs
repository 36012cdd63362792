//! Slices: samples in a plane of voxels, as they are, without reconstruction.

use splatvol::{TransferFunction, Volume};

/// The axes of the grid that run to the right and upwards in a slice across each axis.
pub const SIDES: [[usize; 2]; 3] = [[1, 2], [0, 2], [0, 1]];
/// Colours between the ends of a range.
const SHADES: usize = 1024;
/// Colour of missing samples, of no gray.
const MISSING: [u8; 3] = [52, 20, 64];

/// Colours of values: gray over the range of a transfer function, or its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Palette {
    low: f64,
    per_value: f64,
    shades: Vec<[u8; 3]>,
}

impl Palette {
    /// Colours over the range of a transfer function's colours: its own, or gray.
    pub fn new(function: &TransferFunction, in_colors: bool) -> Self {
        let colors = function.colors();
        let [low, high] = [colors.first(), colors.last()].map(|point| point.map_or(0.0, |point| point.value));
        let last = (SHADES - 1) as f64;
        let shade = |place: usize| {
            let share = place as f64 / last;
            let rgb = match in_colors {
                true => function.color(low + share * (high - low)),
                false => [share; 3],
            };
            rgb.map(|code| (255.0 * code).round() as u8)
        };
        Self {
            low,
            // One colour has no range: what lies below it is black, and the rest white.
            per_value: if high > low { last / (high - low) } else { f64::MAX },
            shades: (0..SHADES).map(shade).collect(),
        }
    }

    /// The colour of a value, sRGB.
    pub fn code(&self, value: f64) -> [u8; 3] {
        match value.is_finite() {
            true => {
                let place = ((value - self.low) * self.per_value).round();
                self.shades[place.clamp(0.0, (SHADES - 1) as f64) as usize]
            }
            false => MISSING,
        }
    }
}

/// The samples `index` along an axis, sRGB: rows of the first of [`SIDES`], the last one of the second first.
///
/// # Panics
/// Indices outside the grid.
pub fn slice(volume: &Volume, (across, index): (usize, usize), palette: &Palette) -> Vec<[u8; 3]> {
    let dims = volume.grid().dims();
    let strides = [1, dims[0], dims[0] * dims[1]];
    let [right, up] = SIDES[across];
    let first = index * strides[across];
    let rows = (0..dims[up]).rev().map(|y| first + y * strides[up]);
    rows.flat_map(|row| (0..dims[right]).map(move |x| row + x * strides[right]))
        .map(|at| palette.code(volume.value(at)))
        .collect()
}

#[cfg(test)]
mod tests {
    use splatvol::{ColorPoint, Grid, LengthUnit, OpacityPoint, Rescale, Samples};

    use super::*;

    fn function() -> TransferFunction {
        let colors = vec![
            ColorPoint::new(0.0, [1.0, 0.0, 0.0]),
            ColorPoint::new(255.0, [0.0, 0.0, 1.0]),
        ];
        TransferFunction::new(colors, vec![OpacityPoint::new(0.0, 1.0)], None).unwrap()
    }

    #[test]
    fn slices_hold_the_samples_of_their_plane_with_the_second_axis_upwards() {
        let dims = [3, 4, 5];
        let value = |at: usize| (at % 3 * 50 + at / 3 % 4 * 10 + at / 12) as f32;
        let samples = Samples::F32((0..60).map(value).collect::<Vec<_>>().into());
        let grid = Grid::centred(dims, [1.0; 3]).unwrap();
        let volume = Volume::new(grid, samples, Rescale::default(), LengthUnit::Unknown).unwrap();
        let palette = Palette::new(&function(), false);
        for (across, [right, up]) in SIDES.into_iter().enumerate() {
            let codes = slice(&volume, (across, 2), &palette);
            assert_eq!(codes.len(), dims[right] * dims[up]);
            for (at, code) in codes.iter().enumerate() {
                let mut voxel = [2; 3];
                voxel[right] = at % dims[right];
                voxel[up] = dims[up] - 1 - at / dims[right];
                let value = (voxel[0] * 50 + voxel[1] * 10 + voxel[2]) as u8;
                assert_eq!(code, &[value; 3], "across {across}, {voxel:?}");
            }
        }
    }

    #[test]
    fn values_beyond_the_range_have_the_colours_of_its_ends() {
        let palette = Palette::new(&function(), true);
        assert_eq!(palette.code(-10.0), [255, 0, 0]);
        assert_eq!(palette.code(1e30), [0, 0, 255]);
        assert_eq!(palette.code(f64::NAN), MISSING);
        let one = TransferFunction::new(
            vec![ColorPoint::new(7.0, [0.5; 3])],
            vec![OpacityPoint::new(7.0, 1.0)],
            None,
        );
        let one = Palette::new(&one.unwrap(), false);
        assert_eq!([one.code(6.0), one.code(8.0)], [[0; 3], [255; 3]]);
    }
}
