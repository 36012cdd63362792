//! Looks for pictures that show one number of each ray: its largest, smallest or mean value, or an integral.
//!
//! | picture | grey from | to |
//! |---|---|---|
//! | maxima | the least value | the largest; where all but one value in ten thousand lie in the lower half, what these reach |
//! | minima, means | what one ray in two hundred is below | what one in two hundred is above |
//! | X-ray | white; extinction grows with the value above the background | one ray in a hundred keeps less than `exp(-1.5)` of its light |
//!
//! Rays are those of the [`survey`](super::survey), along the axes. Where all of them show the same the whole range is shown.

use super::materials::Background;
use super::survey::{Survey, quantile};
use super::{labels, shapes};
use crate::{ColorPoint, Compositing, OpacityPoint, TransferFunction, Volume};

/// Share of the values that a window of maxima may leave out, if most of the range is theirs.
const SPECKS: f64 = 1e-4;
/// Share of the rays that a window leaves out at each end.
const STRAY_RAYS: f64 = 5e-3;
/// Share of the rays of an X-ray that are denser than [`DENSE`].
const DENSEST: f64 = 0.01;
/// Optical depth of these.
const DENSE: f64 = 1.5;
/// Points of a curve of opacity.
const POINTS: u32 = 16;
/// Air, Hounsfield units.
const AIR: f64 = -1000.0;

impl TransferFunction {
    /// Look of a volume for pictures of one number per ray; `None` for other pictures, of labels, and for an X-ray of
    /// nothing but background.
    pub fn automatic_projection(volume: &Volume, compositing: Compositing) -> Option<Self> {
        let [min, max] = volume.value_range();
        if min == max {
            return None;
        }
        let survey = Survey::new(volume);
        if labels::find(volume, &survey).is_some() {
            return None;
        }
        let window = match compositing {
            Compositing::Mip => {
                let most = quantile(&survey.sorted, 1.0 - SPECKS);
                [min, if most < 0.5 * (min + max) { most } else { max }]
            }
            Compositing::MinimumIntensity => of_rays(&survey, |values| values.fold(f64::INFINITY, f64::min)),
            Compositing::Mean => of_rays(&survey, |values| {
                let (count, sum) = values.fold((0.0, 0.0), |(count, sum), value| (count + 1.0, sum + value));
                sum / count
            }),
            Compositing::Xray => return xray(&survey, [min, max]),
            _ => return None,
        };
        let window = if window[0] < window[1] { window } else { [min, max] };
        Self::gray_ramp(window, 1.0).ok()
    }
}

/// Window of a number of each ray, its values given.
fn of_rays(survey: &Survey, number: impl Fn(&mut dyn Iterator<Item = f64>) -> f64) -> [f64; 2] {
    let rays = (0..3).flat_map(|axis| survey.rays(axis));
    let mut numbers: Vec<f64> = rays
        .map(|ray| number(&mut ray.filter(|value| value.is_finite())))
        .filter(|number| number.is_finite())
        .collect();
    numbers.sort_unstable_by(f64::total_cmp);
    [STRAY_RAYS, 1.0 - STRAY_RAYS].map(|share| quantile(&numbers, share))
}

fn xray(survey: &Survey, [min, max]: [f64; 2]) -> Option<TransferFunction> {
    let air = match shapes::is_hounsfield(survey, [min, max]) {
        true => AIR.max(min),
        false => Background::find(survey).map_or(min, |background| background.level),
    };
    let mut depths: Vec<f64> = (0..3)
        .flat_map(|axis| survey.rays(axis).map(move |ray| (axis, ray)))
        .map(|(axis, ray)| {
            let above = ray.filter(|value| *value > air).map(|value| value - air);
            above.sum::<f64>() * survey.cell_size[axis]
        })
        .collect();
    depths.sort_unstable_by(f64::total_cmp);
    let dense = quantile(&depths, 1.0 - DENSEST);
    let per_value = DENSE / dense;
    if !(per_value.is_finite() && per_value > 0.0) {
        return None;
    }
    let point = |n: u32| {
        let value = air + f64::from(n) / f64::from(POINTS) * (max - air);
        OpacityPoint::new(value, -libm::expm1(-per_value * (value - air)))
    };
    let opacities = (0..=POINTS).map(point).collect();
    TransferFunction::new(vec![ColorPoint::new(air, [1.0; 3])], opacities, None).ok()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::{Grid, LengthUnit, Rescale, Samples};

    /// A ball of a value in a box of another, and one speck.
    fn ball(inside: f32, outside: f32, speck: f32) -> Volume {
        let n = 40i32;
        let mut data = Vec::new();
        for i in 0..n * n * n {
            let [x, y, z] = [i % n, i / n % n, i / (n * n)].map(|c| f64::from(c) - 19.5);
            let spread = 1e-5 * (inside - outside) * (i % 97) as f32;
            data.push(
                spread
                    + if x * x + y * y + z * z < 144.0 {
                        inside
                    } else {
                        outside
                    },
            );
        }
        data[20_000] = speck;
        let grid = Grid::centred([40; 3], DVec3::ONE).unwrap();
        Volume::new(
            grid,
            Samples::F32(data.into()),
            Rescale::default(),
            LengthUnit::Unknown,
        )
        .unwrap()
    }

    fn window(volume: &Volume, compositing: Compositing) -> [f64; 2] {
        let look = TransferFunction::automatic_projection(volume, compositing).unwrap();
        [0, 1].map(|i| look.opacities()[i].value)
    }

    #[test]
    fn windows_are_what_rays_show() {
        let volume = ball(100.0, 0.0, 5000.0);
        let near = |found: [f64; 2], expected: [f64; 2]| {
            let off = (0..2).map(|i| (found[i] - expected[i]).abs()).fold(0.0, f64::max);
            assert!(
                off < 0.002 * (expected[1] - expected[0]),
                "{found:?}, not {expected:?}"
            );
        };
        // The speck, one of 64 000 values, would leave the ball black.
        near(window(&volume, Compositing::Mip), [0.0, 100.0]);
        near(window(&ball(100.0, 0.0, 130.0), Compositing::Mip), [0.0, 130.0]);
        // Through the middle 24 of 40 values are the ball's.
        near(window(&ball(100.0, 0.0, 100.0), Compositing::Mean), [0.0, 60.0]);
        near(
            window(&ball(-30.0, 10.0, 10.0), Compositing::MinimumIntensity),
            [-30.0, 10.0],
        );
        // All rays meet the outside: what varies there is shown.
        let [low, high] = window(&ball(100.0, 0.0, 100.0), Compositing::MinimumIntensity);
        assert!(low < high && high < 1.0, "{low} {high}");
        assert!(TransferFunction::automatic_projection(&volume, Compositing::ImageSheets).is_none());
    }

    #[test]
    fn an_x_ray_through_the_densest_keeps_a_fifth_of_its_light() {
        for (inside, outside) in [(100.0, 0.0), (1000.0, -1000.0), (0.02, 0.01)] {
            let volume = ball(inside, outside, inside);
            let look = TransferFunction::automatic_projection(&volume, Compositing::Xray).unwrap();
            let through = 24.0 * look.extinction(f64::from(inside), 1.0);
            assert!((1.35..1.65).contains(&through), "{inside}: {through}");
            assert!(look.extinction(f64::from(outside), 1.0) < 1e-3 * through);
            let half = f64::from(0.5 * (inside + outside));
            let share = look.extinction(half, 1.0) * 24.0 / through;
            assert!((share - 0.5).abs() < 0.01, "{share}");
        }
    }
}
