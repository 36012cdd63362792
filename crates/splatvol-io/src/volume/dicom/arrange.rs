//! Arrangement of slices into a grid: their order, spacing, gaps and duplicates.
//!
//! A slice's sample (i, j) lies at `P + i sx X + j sy Y` (PS3.3, C.7.6.2.1.1), P its position, X and Y the directions
//! of its orientation, sx and sy its spacing. Slices are sorted along `N = X x Y`. The grid's third axis is the mean
//! step from the first to the last position: if a gantry was tilted, that step is not along N, and the grid is as
//! oblique as the slices are. Slices that lie more than [`TOLERANCE`] of a step from these places are resampled
//! ([`super::uneven`]) with a warning, smaller deviations are reported. Slices that do not follow one line are refused.

use std::ops::RangeInclusive;

use glam::{DAffine3, DMat3, DVec3};

use super::image::FrameHead;
use super::uneven::Uneven;
use crate::IoError;
use crate::error::Context;
use crate::volume::{ReadOptions, choose_time};

/// Greatest distance of a slice from its place, in steps. One missing slice moves others by half a step or more.
const TOLERANCE: f64 = 0.25;
/// Least deviation that is reported.
const NOTABLE: f64 = 0.02;
/// Positions closer than this share of the mean step count as one.
const SAME: f64 = 0.01;
/// Lengths that something can have, mm: an atom is 1e-7, the Earth 1e10.
const LENGTHS: RangeInclusive<f64> = 1e-9..=1e12;
/// Two directions are unit vectors and perpendicular up to this.
const SKEW: f64 = 0.01;

/// Slices in order, and where they lie.
#[derive(Debug)]
pub(super) struct Stack {
    /// Numbers of the slices of the chosen time point.
    pub(super) order: Vec<usize>,
    /// The patient's space is LPS.
    pub(super) patient_from_voxel: DAffine3,
    pub(super) times: usize,
    /// Degrees between the third axis and the normal.
    pub(super) tilt: f64,
    /// Whether the file gives the positions of the slices.
    pub(super) placed: bool,
    /// How the slices are resampled, if they must be.
    pub(super) uneven: Option<Uneven>,
    pub(super) warnings: Vec<String>,
}

/// Sorts slices of one orientation.
pub(super) fn stack(
    slices: &[FrameHead],
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<Stack, IoError> {
    let mut warnings = Vec::new();
    let in_plane = in_plane(&slices[0], &mut warnings, context)?;
    let positions: Option<Vec<DVec3>> = slices.iter().map(|slice| slice.position).collect();
    let far = |place: &&DVec3| !place.is_finite() || place.abs().max_element() > *LENGTHS.end();
    if let Some(place) = positions.iter().flatten().find(far) {
        let expected = format!("coordinates up to {:e} mm", LENGTHS.end());
        return Err(context.field(
            "ImagePositionPatient (0020,0032)",
            format!("{:e} {:e} {:e}", place.x, place.y, place.z),
            None,
            expected,
        ));
    }
    match positions.filter(|_| slices[0].orientation.is_some()) {
        Some(positions) => Positioned {
            slices,
            positions,
            in_plane,
            warnings,
        }
        .stack(options, context),
        None => {
            warnings.push(
                "no positions: slices are in the order of their numbers, which side is left is unknown"
                    .to_owned(),
            );
            let mut order: Vec<usize> = (0..slices.len()).collect();
            order.sort_by_key(|&i| (slices[i].order, i));
            choose_time(1, options, context)?;
            let step = DVec3::Z * thickness(&slices[0], in_plane, &mut warnings);
            Ok(Stack {
                order,
                patient_from_voxel: affine(in_plane, step, DVec3::ZERO),
                times: 1,
                tilt: 0.0,
                placed: false,
                uneven: None,
                warnings,
            })
        }
    }
}

/// Steps along x and y.
fn in_plane(
    slice: &FrameHead,
    warnings: &mut Vec<String>,
    context: &Context<'_>,
) -> Result<[DVec3; 2], IoError> {
    let [x, y] = slice.orientation.unwrap_or([DVec3::X, DVec3::Y]);
    let crooked = [x.length() - 1.0, y.length() - 1.0, x.dot(y)];
    if crooked.iter().any(|error| error.abs() > SKEW) {
        let shown = format!("{x} {y}");
        let expected = "two perpendicular directions of length 1";
        return Err(context.field("ImageOrientationPatient (0020,0037)", shown, None, expected));
    }
    let [sx, sy] = slice.spacing.unwrap_or_else(|| {
        warnings.push("no PixelSpacing: 1 is used".to_owned());
        [1.0; 2]
    });
    if sx <= 0.0 || sy <= 0.0 {
        let shown = format!("{sy} {sx}");
        return Err(context.field("PixelSpacing (0028,0030)", shown, None, "two positive numbers"));
    }
    if !LENGTHS.contains(&sx) || !LENGTHS.contains(&sy) {
        let shown = format!("{sy:e} {sx:e}");
        let expected = format!("lengths from {:e} to {:e} mm", LENGTHS.start(), LENGTHS.end());
        return Err(context.field("PixelSpacing (0028,0030)", shown, None, expected));
    }
    Ok([x.normalize() * sx, y.normalize() * sy])
}

/// Distance of slices according to one slice's header.
fn thickness(slice: &FrameHead, in_plane: [DVec3; 2], warnings: &mut Vec<String>) -> f64 {
    let (value, source) = match (slice.between_slices, slice.thickness) {
        (Some(distance), _) => (distance, "SpacingBetweenSlices"),
        (None, Some(thickness)) => (thickness, "SliceThickness"),
        _ => (in_plane[0].length(), "the spacing of columns"),
    };
    if !LENGTHS.contains(&value) {
        warnings.push(format!("{source} is {value:e}: the spacing of columns is used"));
        return in_plane[0].length();
    }
    warnings.push(format!("the distance of slices is taken from {source}: {value}"));
    value
}

fn affine([x, y]: [DVec3; 2], z: DVec3, origin: DVec3) -> DAffine3 {
    DAffine3::from_mat3_translation(DMat3::from_cols(x, y, z), origin)
}

struct Positioned<'a> {
    slices: &'a [FrameHead],
    positions: Vec<DVec3>,
    in_plane: [DVec3; 2],
    warnings: Vec<String>,
}

impl Positioned<'_> {
    fn stack(mut self, options: &ReadOptions, context: &Context<'_>) -> Result<Stack, IoError> {
        // Of unit vectors: the product of absurd spacings is no number.
        let [x, y] = self.in_plane.map(DVec3::normalize);
        let normal = x.cross(y).normalize();
        let (order, times) = self.at_time(normal, options, context)?;
        let place = |i: usize| self.positions[order[i]];
        let last = order.len() - 1;
        let step = match last {
            0 => normal * thickness(&self.slices[order[0]], self.in_plane, &mut self.warnings),
            last => (place(last) - place(0)) / last as f64,
        };
        let distance = step.dot(normal);
        let deviation = |i: usize| (place(i) - place(0) - step * i as f64).length() / distance;
        let worst = (0..=last).max_by(|&a, &b| deviation(a).total_cmp(&deviation(b)));
        let worst = worst.map_or(0.0, deviation);
        let (mut step, mut uneven) = (step, None);
        if worst > TOLERANCE || worst.is_nan() {
            let heights: Vec<f64> = (0..=last).map(|i| place(i).dot(normal)).collect();
            let even = in_line(&heights, place, context)?;
            self.warnings.push(even.describe(&heights));
            step = (place(last) - place(0)) / (even.count - 1) as f64;
            uneven = Some(even);
        } else if worst > NOTABLE {
            self.warnings.push(format!(
                "slices lie up to {:.1} % of their distance from even places",
                100.0 * worst
            ));
        }
        Ok(Stack {
            patient_from_voxel: affine(self.in_plane, step, place(0)),
            order,
            times,
            tilt: step.normalize_or(normal).dot(normal).min(1.0).acos().to_degrees(),
            placed: true,
            uneven,
            warnings: self.warnings,
        })
    }

    /// The slices of one time point along the normal, and the number of time points.
    fn at_time(
        &mut self,
        normal: DVec3,
        options: &ReadOptions,
        context: &Context<'_>,
    ) -> Result<(Vec<usize>, usize), IoError> {
        let height = |i: usize| self.positions[i].dot(normal);
        let mut sorted: Vec<usize> = (0..self.slices.len()).collect();
        sorted.sort_by(|&a, &b| height(a).total_cmp(&height(b)));
        let span = height(sorted[sorted.len() - 1]) - height(sorted[0]);
        let same = SAME * span / sorted.len() as f64;
        let mut places: Vec<Vec<usize>> = Vec::new();
        for slice in sorted {
            match places.last_mut() {
                Some(place) if height(slice) - height(place[0]) <= same => place.push(slice),
                _ => places.push(vec![slice]),
            }
        }
        for place in &mut places {
            place.sort_by_key(|&i| (self.slices[i].order, i));
        }
        let times = places[0].len();
        if places.iter().all(|place| place.len() == times) {
            let time = choose_time(times, options, context)?;
            return Ok((places.iter().map(|place| place[time]).collect(), times));
        }
        choose_time(1, options, context)?;
        let left_out = self.slices.len() - places.len();
        self.warnings.push(format!(
            "{left_out} slices lie where another one lies and are left out"
        ));
        Ok((places.iter().map(|place| place[0]).collect(), 1))
    }
}

/// Even places for slices at these heights, which must lie on one line.
fn in_line(
    heights: &[f64],
    place: impl Fn(usize) -> DVec3,
    context: &Context<'_>,
) -> Result<Uneven, IoError> {
    let last = heights.len() - 1;
    let span = heights[last] - heights[0];
    let whole = place(last) - place(0);
    let off = |i: usize| (place(i) - place(0) - whole * ((heights[i] - heights[0]) / span)).length();
    let worst = (0..=last).max_by(|&a, &b| off(a).total_cmp(&off(b))).unwrap_or(0);
    let distance = span / last as f64;
    if off(worst) <= TOLERANCE * distance {
        return Ok(Uneven::new(heights));
    }
    Err(context.unsupported(format!(
        "slices do not follow one line: number {worst} from the lowest lies {:.4} beside it, where slices lie {distance:.4} apart",
        off(worst)
    )))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn slices(heights: &[f64]) -> Vec<FrameHead> {
        let slice = |(i, &height): (usize, &f64)| FrameHead {
            position: Some(DVec3::new(1.0, 2.0 + 0.5 * height, height)),
            orientation: Some([DVec3::X, DVec3::Y]),
            spacing: Some([0.5, 0.75]),
            thickness: Some(9.0),
            between_slices: None,
            rescale: splatvol_scene::Rescale::default(),
            order: [0, 0, i as i64],
        };
        heights.iter().enumerate().map(slice).collect()
    }

    fn stacked(heights: &[f64], time: usize) -> Result<Stack, IoError> {
        let options = ReadOptions {
            time: Some(time),
            ..ReadOptions::default()
        };
        stack(&slices(heights), &options, &Context::new("DICOM", Path::new("a")))
    }

    #[test]
    fn slices_are_sorted_and_a_tilt_makes_the_grid_oblique() {
        let stack = stacked(&[4.0, 0.0, 8.0, -4.0], 0).unwrap();
        assert_eq!(stack.order, [3, 1, 0, 2]);
        let map = stack.patient_from_voxel;
        assert_eq!(map.translation, DVec3::new(1.0, 0.0, -4.0));
        assert_eq!(map.matrix3.z_axis, DVec3::new(0.0, 2.0, 4.0));
        assert!((stack.tilt - 0.5f64.atan().to_degrees()).abs() < 1e-9);
        assert!(stack.warnings.is_empty(), "{:?}", stack.warnings);
    }

    #[test]
    fn gaps_are_resampled_wherever_they_are_and_small_ones_reported() {
        for missing in 1..19 {
            let heights: Vec<f64> = (0..20)
                .filter(|&i| i != missing)
                .map(|i| f64::from(i) * 2.5)
                .collect();
            let stack = stacked(&heights, 0).unwrap();
            assert_eq!(stack.uneven.map(|uneven| uneven.count), Some(20));
            assert!(
                stack.warnings[0].contains("steps of 2.5000, 5.0000)"),
                "{:?}",
                stack.warnings
            );
            // The tilt is kept.
            assert!((stack.patient_from_voxel.matrix3.z_axis - DVec3::new(0.0, 1.25, 2.5)).length() < 1e-9);
        }
        let stack = stacked(&[0.0, 1.0, 2.1, 3.0], 0).unwrap();
        assert_eq!(
            (stack.warnings.len(), stack.uneven),
            (1, None),
            "{:?}",
            stack.warnings
        );
    }

    #[test]
    fn slices_beside_the_line_are_refused() {
        let mut heads = slices(&[0.0, 1.0, 2.0, 9.0]);
        heads[1].position = Some(DVec3::new(9.0, 2.5, 1.0));
        let context = Context::new("DICOM", Path::new("a"));
        let error = stack(&heads, &ReadOptions::default(), &context).unwrap_err();
        assert!(error.to_string().contains("number 1 from the lowest"), "{error}");
    }

    #[test]
    fn as_many_slices_everywhere_are_times_and_others_doubles() {
        let heights = [0.0, 1.0, 2.0, 0.0, 1.0, 2.0];
        let stack = stacked(&heights, 1).unwrap();
        assert_eq!((stack.order, stack.times), (vec![3, 4, 5], 2));
        assert!(stacked(&heights, 2).is_err());
        let doubled = stacked(&[0.0, 1.0, 2.0, 1.0], 0).unwrap();
        assert_eq!((doubled.order, doubled.times), (vec![0, 1, 2], 1));
        assert!(doubled.warnings[0].starts_with("1 slices lie where"));
    }
}
