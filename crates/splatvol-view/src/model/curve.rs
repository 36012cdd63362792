//! Edits of a transfer function: points are added, moved and removed, colours and curves are taken by name, and
//! everything is moved to another range of values.

use splatvol::{ColorMap, ColorPoint, OpacityCurve, OpacityPoint, SceneError, TransferFunction};

/// Range of values of the points.
pub fn span(function: &TransferFunction) -> [f64; 2] {
    let colors = function.colors().iter().map(|point| point.value);
    let opacities = function.opacities().iter().map(|point| point.value);
    let [low, high] = colors
        .chain(opacities)
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
            [low.min(value), high.max(value)]
        });
    // A range of one value cannot be divided by.
    if high > low { [low, high] } else { [low, low + 1.0] }
}

/// Range of values of the colours, which are a map over it.
pub fn color_span(function: &TransferFunction) -> [f64; 2] {
    match function.colors() {
        [first, .., last] if last.value > first.value => [first.value, last.value],
        _ => span(function),
    }
}

/// Moves an opacity point; it stays between its neighbours.
///
/// # Errors
/// See [`TransferFunction::new`].
pub fn move_point(
    function: &TransferFunction,
    index: usize,
    [value, opacity]: [f64; 2],
) -> Result<TransferFunction, SceneError> {
    let mut points = function.opacities().to_vec();
    let low = index
        .checked_sub(1)
        .map_or(f64::NEG_INFINITY, |before| points[before].value);
    let high = points.get(index + 1).map_or(f64::INFINITY, |after| after.value);
    if let Some(point) = points.get_mut(index) {
        point.value = value.clamp(low, high.max(low));
        point.opacity = opacity.clamp(0.0, 1.0);
    }
    with_opacities(function, points)
}

/// Adds an opacity point, and returns its index.
///
/// # Errors
/// See [`TransferFunction::new`].
pub fn add_point(
    function: &TransferFunction,
    [value, opacity]: [f64; 2],
) -> Result<(TransferFunction, usize), SceneError> {
    let mut points = function.opacities().to_vec();
    let index = points.partition_point(|point| point.value <= value);
    points.insert(index, OpacityPoint::new(value, opacity.clamp(0.0, 1.0)));
    Ok((with_opacities(function, points)?, index))
}

/// Removes an opacity point; the last one stays.
///
/// # Errors
/// See [`TransferFunction::new`].
pub fn remove_point(function: &TransferFunction, index: usize) -> Result<TransferFunction, SceneError> {
    let mut points = function.opacities().to_vec();
    if points.len() > 1 && index < points.len() {
        points.remove(index);
    }
    with_opacities(function, points)
}

/// The same opacities under the colours of a map, over the range of the present colours.
///
/// # Errors
/// See [`TransferFunction::new`].
pub fn with_map(function: &TransferFunction, map: ColorMap) -> Result<TransferFunction, SceneError> {
    let colors = map.points(color_span(function), ColorMap::DEFAULT_POINTS);
    TransferFunction::new(colors, function.opacities().to_vec(), function.unit_distance)
}

/// The same colours with the opacities of a named curve, over the range of the present ones.
///
/// # Errors
/// See [`TransferFunction::new`].
pub fn with_curve(function: &TransferFunction, curve: &OpacityCurve) -> Result<TransferFunction, SceneError> {
    with_opacities(function, curve.points(span(function)))
}

/// Everything moved and stretched to another range of values.
///
/// # Errors
/// Ranges that are empty or not finite.
pub fn with_span(function: &TransferFunction, [low, high]: [f64; 2]) -> Result<TransferFunction, SceneError> {
    if !(high > low && (high - low).is_finite()) {
        return Err(SceneError::invalid(
            "range",
            [low, high],
            "two numbers, the first below the second",
        ));
    }
    let [old_low, old_high] = span(function);
    let moved = |value: f64| low + (value - old_low) / (old_high - old_low) * (high - low);
    let colors = function.colors().iter().map(|&point| ColorPoint {
        value: moved(point.value),
        ..point
    });
    let opacities = function.opacities().iter().map(|&point| OpacityPoint {
        value: moved(point.value),
        ..point
    });
    TransferFunction::new(colors.collect(), opacities.collect(), function.unit_distance)
}

/// The same with another length to which opacities refer; `None` for the spacing of the samples.
///
/// # Errors
/// Lengths that are not positive.
pub fn with_unit_distance(
    function: &TransferFunction,
    unit_distance: Option<f64>,
) -> Result<TransferFunction, SceneError> {
    TransferFunction::new(
        function.colors().to_vec(),
        function.opacities().to_vec(),
        unit_distance,
    )
}

fn with_opacities(
    function: &TransferFunction,
    points: Vec<OpacityPoint>,
) -> Result<TransferFunction, SceneError> {
    TransferFunction::new(function.colors().to_vec(), points, function.unit_distance)
}

/// Length of material of this opacity per unit distance that takes half of the light; `None` if it takes none.
pub fn half_depth(opacity: f64, unit_distance: f64) -> Option<f64> {
    let extinction = -libm::log1p(-opacity.min(TransferFunction::MAX_OPACITY)) / unit_distance;
    (extinction > 0.0).then(|| std::f64::consts::LN_2 / extinction)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn function() -> TransferFunction {
        let colors = ColorMap::from_name("viridis").unwrap().points([10.0, 20.0], 5);
        let opacities = [(10.0, 0.0), (14.0, 0.2), (20.0, 0.8)].map(|(value, o)| OpacityPoint::new(value, o));
        TransferFunction::new(colors, opacities.to_vec(), Some(2.0)).unwrap()
    }

    fn points(function: &TransferFunction) -> Vec<[f64; 2]> {
        let opacities = function.opacities().iter();
        opacities.map(|point| [point.value, point.opacity]).collect()
    }

    #[test]
    fn points_stay_in_order_whatever_is_dragged_where() {
        let moved = move_point(&function(), 1, [99.0, 7.0]).unwrap();
        assert_eq!(points(&moved)[1], [20.0, 1.0]);
        let moved = move_point(&moved, 1, [-99.0, -7.0]).unwrap();
        assert_eq!(points(&moved)[1], [10.0, 0.0]);
        assert_eq!(points(&moved)[2], [20.0, 0.8]);
    }

    #[test]
    fn points_are_added_in_their_place_and_the_last_one_stays() {
        let (more, index) = add_point(&function(), [16.0, 0.5]).unwrap();
        assert_eq!((index, points(&more)[2]), (2, [16.0, 0.5]));
        let mut fewer = more;
        for _ in 0..9 {
            fewer = remove_point(&fewer, 0).unwrap();
        }
        assert_eq!(points(&fewer), [[20.0, 0.8]]);
    }

    #[test]
    fn another_range_keeps_the_shape_and_another_map_the_opacities() {
        let wide = with_span(&function(), [0.0, 100.0]).unwrap();
        assert_eq!(points(&wide), [[0.0, 0.0], [40.0, 0.2], [100.0, 0.8]]);
        assert_eq!(wide.color(0.0), function().color(10.0));
        assert!(with_span(&function(), [3.0, 3.0]).is_err());
        let gray = with_map(&wide, ColorMap::from_name("gray").unwrap()).unwrap();
        assert_eq!(points(&gray), points(&wide));
        assert_eq!(color_span(&gray), [0.0, 100.0]);
    }

    #[test]
    fn half_of_the_light_is_lost_in_one_unit_of_half_opacity() {
        assert!((half_depth(0.5, 3.0).unwrap() - 3.0).abs() < 1e-12);
        assert_eq!(half_depth(0.0, 3.0), None);
    }
}
