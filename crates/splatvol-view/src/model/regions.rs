//! Edits of a transfer function of value and gradient magnitude: its regions are begun, moved and resized.

use splatvol::{Region, TransferFunction};

/// Smallest side of a region, share of the axis.
const LEAST: f64 = 0.004;
/// Softness of a region that is begun.
const SOFTNESS: f64 = 0.4;

/// A side of a region along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The lower one.
    Low,
    /// The upper one.
    High,
}

/// What of a region is held: sides along the axes of values and gradients, or all of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part(pub [Option<Side>; 2]);

impl Part {
    /// All of it.
    pub const WHOLE: Self = Self([None, None]);
}

/// The axes: from the smallest to the largest value, and from no gradient to the steepest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// Smallest and largest value.
    pub values: [f64; 2],
    /// Largest gradient magnitude, data units per world length.
    pub steepest: f64,
}

impl Extent {
    fn lengths(&self) -> [f64; 2] {
        [self.values[1] - self.values[0], self.steepest]
    }
}

/// The region that shows about what a transfer function of values shows, where values change.
pub fn begun(function: &TransferFunction, extent: Extent) -> Region {
    let most = function.opacities().iter().map(|point| point.opacity);
    let most = most.fold(0.0, f64::max);
    let [low, high] = extent.values;
    let steps = (0..=200).map(|step| low + f64::from(step) / 200.0 * (high - low));
    let seen = |value: &f64| function.opacity(*value) > 0.1 * most;
    let first = steps.clone().find(seen).unwrap_or(low);
    let last = steps.rev().find(seen).unwrap_or(high);
    let value = match last - first >= LEAST * (high - low) {
        true => [first, last],
        false => extent.values,
    };
    let middle = 0.5 * (value[0] + value[1]);
    of(
        [value, [0.1 * extent.steepest, extent.steepest]],
        function.color(middle),
        most.clamp(0.02, 0.95),
    )
}

/// A region between two places of the axes, in another's colour.
pub fn between(corners: [[f64; 2]; 2], like: Option<&Region>) -> Region {
    let [a, b] = corners;
    let side = |axis: usize| [a[axis].min(b[axis]), a[axis].max(b[axis])];
    let (rgb, opacity) = like.map_or(([0.9, 0.8, 0.6], 0.3), |like| (like.rgb, like.opacity));
    of([side(0), side(1)], rgb, opacity)
}

fn of([value, gradient]: [[f64; 2]; 2], rgb: [f64; 3], opacity: f64) -> Region {
    Region {
        value,
        gradient,
        rgb,
        opacity,
        softness: SOFTNESS,
    }
}

/// A region of which a part was dragged by a way; it keeps a width, and gradients are magnitudes.
pub fn dragged(region: &Region, part: Part, way: [f64; 2], extent: Extent) -> Region {
    let lengths = extent.lengths();
    let [value, gradient] = [region.value, region.gradient];
    let side = |axis: usize, [low, high]: [f64; 2]| {
        let least = LEAST * lengths[axis];
        // All of a region moves, unless its other axis alone is held.
        let moves = part == Part::WHOLE;
        match part.0[axis] {
            Some(Side::Low) => [(low + way[axis]).min(high - least), high],
            Some(Side::High) => [low, (high + way[axis]).max(low + least)],
            None if moves => [low + way[axis], high + way[axis]],
            None => [low, high],
        }
    };
    let [low, high] = side(1, gradient);
    let lift = match part.0[1] {
        None => (-low).max(0.0),
        _ => 0.0,
    };
    Region {
        value: side(0, value),
        gradient: [(low + lift).max(0.0), high + lift],
        ..*region
    }
}

/// A region whose numbers are those that were typed, as far as they make one.
pub fn ordered(region: Region) -> Option<Region> {
    let is_range = |[low, high]: [f64; 2]| low.is_finite() && high.is_finite() && low < high;
    (is_range(region.value) && is_range(region.gradient)).then_some(region)
}

#[cfg(test)]
mod tests {
    use splatvol::{ColorMap, OpacityPoint, TransferFunction2d};

    use super::*;

    const EXTENT: Extent = Extent {
        values: [0.0, 100.0],
        steepest: 50.0,
    };

    fn region() -> Region {
        of([[20.0, 60.0], [5.0, 25.0]], [1.0, 0.0, 0.0], 0.5)
    }

    #[test]
    fn sides_are_dragged_alone_and_all_of_it_keeps_its_size() {
        let low = |way| dragged(&region(), Part([Some(Side::Low), None]), way, EXTENT);
        assert_eq!(low([10.0, 9.0]).value, [30.0, 60.0]);
        assert_eq!(low([10.0, 9.0]).gradient, region().gradient);
        assert_eq!(low([99.0, 0.0]).value, [60.0 - 0.4, 60.0]);
        let corner = dragged(
            &region(),
            Part([Some(Side::High), Some(Side::High)]),
            [5.0, -99.0],
            EXTENT,
        );
        assert_eq!((corner.value, corner.gradient), ([20.0, 65.0], [5.0, 5.2]));
        let moved = dragged(&region(), Part::WHOLE, [-5.0, -9.0], EXTENT);
        assert_eq!((moved.value, moved.gradient), ([15.0, 55.0], [0.0, 20.0]));
        for region in [low([99.0, 0.0]), corner, moved] {
            assert!(TransferFunction2d::new(&[region], 1.0).is_ok(), "{region:?}");
        }
    }

    #[test]
    fn it_begins_with_what_the_values_show() {
        let colors = ColorMap::from_name("viridis").unwrap().points([0.0, 100.0], 5);
        let opacities =
            [(0.0, 0.0), (40.0, 0.0), (60.0, 0.4), (100.0, 0.4)].map(|(v, o)| OpacityPoint::new(v, o));
        let function = TransferFunction::new(colors, opacities.to_vec(), None).unwrap();
        let region = begun(&function, EXTENT);
        assert_eq!((region.value, region.gradient), ([42.5, 100.0], [5.0, 50.0]));
        assert_eq!(region.opacity, 0.4);
        let clear = function.opacities().iter().map(|point| OpacityPoint {
            opacity: 0.0,
            ..*point
        });
        let clear = TransferFunction::new(function.colors().to_vec(), clear.collect(), None).unwrap();
        assert!(TransferFunction2d::new(&[begun(&clear, EXTENT)], 1.0).is_ok());
        assert_eq!(between([[9.0, 8.0], [3.0, 2.0]], None).value, [3.0, 9.0]);
        assert!(
            ordered(Region {
                value: [3.0, 3.0],
                ..region
            })
            .is_none()
        );
    }
}
