//! The looks of benchmarks: the two extremes of a transfer function.
//!
//! In shares of a window of data values, W wide: *opaque* is a surface, from 0 at `iso - 0.02 W` to 1 at
//! `iso + 0.02 W`, which ends most rays early; *translucent* rises from 0 at 0.04 W to 0.03 at the top of the window,
//! which ends none. Opacities are per mean voxel spacing.

use splatvol::{ColorPoint, OpacityPoint, SceneError, TransferFunction, Volume};
use splatvol_samples::Sample;

use crate::args::LookArgs;

/// Half the width of a surface's ramp, share of the window.
const HALF_RAMP: f64 = 0.02;
/// Where the translucent ramp begins, share of the window.
const CLEAR: f64 = 0.04;
/// Opacity per voxel at the top of the window.
const TRANSLUCENT: f64 = 0.03;
/// Colours along the window, sRGB.
const COLORS: [(f64, [f64; 3]); 4] = [
    (0.0, [0.10, 0.15, 0.60]),
    (0.30, [0.20, 0.70, 0.80]),
    (0.60, [0.95, 0.85, 0.45]),
    (1.0, [0.90, 0.20, 0.12]),
];
/// Bins for the choice of a surface.
const BINS: usize = 256;

/// Reference values of a volume's looks, data units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Window {
    range: [f64; 2],
    iso: f64,
    /// World length to which opacities refer; `None` is the mean voxel spacing.
    unit_distance: Option<f64>,
}

impl Window {
    /// The requested range, or the sample's, or all values; and the sample's best known surface, or the value that
    /// divides the data best.
    pub(super) fn new((volume, sample): (&Volume, Option<Sample>), args: &LookArgs) -> Self {
        let (range, iso) = match sample {
            // Bone, in Hounsfield units.
            Some(Sample::Head) => ([-1000.0, 2000.0], 350.0),
            // The outermost shell, whose values reach 110.
            Some(Sample::Shells) => ([0.0, 255.0], 60.0),
            _ => (volume.value_range(), dividing_value(volume)),
        };
        Self {
            range: args.clim.unwrap_or(range),
            iso,
            unit_distance: args.unit_distance,
        }
    }

    /// The surface of the value `iso`.
    pub(super) fn opaque(&self) -> Result<TransferFunction, SceneError> {
        let [low, high] = self.range;
        let half_ramp = HALF_RAMP * (high - low);
        self.colored(vec![
            OpacityPoint::new(self.iso - half_ramp, 0.0),
            OpacityPoint::new(self.iso + half_ramp, 1.0),
        ])
    }

    /// A fog of all values but the lowest.
    pub(super) fn translucent(&self) -> Result<TransferFunction, SceneError> {
        self.colored(vec![
            OpacityPoint::new(self.at(CLEAR), 0.0),
            OpacityPoint::new(self.at(1.0), TRANSLUCENT),
        ])
    }

    fn colored(&self, opacities: Vec<OpacityPoint>) -> Result<TransferFunction, SceneError> {
        let colors = COLORS.map(|(share, rgb)| ColorPoint::new(self.at(share), rgb));
        TransferFunction::new(colors.to_vec(), opacities, self.unit_distance)
    }

    fn at(&self, share: f64) -> f64 {
        let [low, high] = self.range;
        low + share * (high - low)
    }
}

/// The value with the largest variance between the values below and those above it (Otsu 1979).
fn dividing_value(volume: &Volume) -> f64 {
    let [low, high] = volume.value_range();
    let counts = volume.histogram(BINS).into_iter().map(|count| count as f64);
    let counts: Vec<f64> = counts.collect();
    let moment = |counts: &[f64]| -> f64 { counts.iter().enumerate().map(|(i, n)| i as f64 * n).sum() };
    let (total, total_moment) = (counts.iter().sum::<f64>(), moment(&counts));
    let (mut below, mut below_moment) = (0.0, 0.0);
    let mut best = (0.0, BINS / 2);
    for (i, count) in counts.iter().enumerate().take(BINS - 1) {
        below += count;
        below_moment += i as f64 * count;
        let above = total - below;
        let distance = below_moment / below - (total_moment - below_moment) / above;
        let variance = below * above * distance * distance;
        // False if one side is empty.
        if variance > best.0 {
            best = (variance, i + 1);
        }
    }
    low + best.1 as f64 / BINS as f64 * (high - low)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use splatvol::{Grid, LengthUnit, Rescale, Samples};

    #[test]
    fn a_surface_divides_two_populations() {
        let data = (0..1000u32).map(|i| if i % 3 == 0 { 180 + i % 20 } else { 10 + i % 30 });
        let data = data.map(|value| value as u8).collect();
        let grid = Grid::centred([10; 3], DVec3::ONE).unwrap();
        let volume = Volume::new(grid, Samples::U8(data), Rescale::default(), LengthUnit::Unknown).unwrap();
        let value = dividing_value(&volume);
        assert!((39.0..181.0).contains(&value), "{value}");
        let constant = Samples::U8(vec![7; 1000].into());
        let grid = Grid::centred([10; 3], DVec3::ONE).unwrap();
        let volume = Volume::new(grid, constant, Rescale::default(), LengthUnit::Unknown).unwrap();
        assert_eq!(dividing_value(&volume), 7.0);
    }

    #[test]
    fn looks_have_the_stated_ramps() {
        let window = Window {
            range: [-1000.0, 1000.0],
            iso: 300.0,
            unit_distance: None,
        };
        let opaque = window.opaque().unwrap();
        assert_eq!(
            [260.0, 300.0, 340.0].map(|value| opaque.opacity(value)),
            [0.0, 0.5, 1.0]
        );
        let translucent = window.translucent().unwrap();
        assert_eq!(
            [-920.0, 1000.0].map(|value| translucent.opacity(value)),
            [0.0, 0.03]
        );
        assert_eq!(translucent.color(-1000.0), [0.10, 0.15, 0.60]);
    }
}
