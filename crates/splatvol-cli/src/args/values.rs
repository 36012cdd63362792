//! Parsers of single values. Errors name the accepted values.

use std::str::FromStr;

use glam::DVec3;
use splatvol::{ClipPlane, GradientOpacityPoint};
use splatvol_document::keys::{Axis, Background, PictureSize, Rotate, Scale, check_gradient_opacity};
use splatvol_document::spelling;
pub(crate) use splatvol_document::spelling::{endian, kind, sample_size, sample_type};

use super::{BoxSides, GradientCurve};

/// x, y, z.
pub(crate) type Triple = [f64; 3];
/// Samples along x, y, z.
pub(crate) type Dims = [usize; 3];

/// A colour map's name.
pub(crate) fn color_map(text: &str) -> Result<String, String> {
    spelling::color_map(text).map(|_| text.to_owned())
}

/// An opacity curve's name.
pub(crate) fn opacity_curve(text: &str) -> Result<String, String> {
    spelling::opacity_curve(text).map(|_| text.to_owned())
}

/// A factor, or one for each axis.
pub(crate) fn scale(text: &str) -> Result<Scale, String> {
    match text.contains(',') {
        true => triple(text).map(Scale::Axes),
        false => finite(text).map(Scale::Uniform),
    }
}

/// An axis and degrees.
pub(crate) fn rotation(text: &str) -> Result<Rotate, String> {
    let (axis, degrees) = text
        .split_once(':')
        .ok_or_else(|| "expected an axis and degrees: z:30 or X,Y,Z:30".to_owned())?;
    let axis = match axis {
        "x" | "y" | "z" => Axis::Name(axis.to_owned()),
        axis => match triple(axis)? {
            [0.0, 0.0, 0.0] => return Err("expected an axis other than 0,0,0".to_owned()),
            axis => Axis::Direction(axis),
        },
    };
    Ok(Rotate::Axis(axis, finite(degrees)?))
}

pub(crate) fn picture_size(text: &str) -> Result<PictureSize, String> {
    text.parse()
}

/// A number of bytes, with K, M, G or T, or KiB and so on, for powers of 1024.
pub(crate) fn bytes(text: &str) -> Result<u64, String> {
    let text = text.strip_suffix(['B', 'b']).unwrap_or(text);
    let (digits, unit) = match text.strip_suffix('i').unwrap_or(text) {
        text if text.ends_with(|c: char| c.is_ascii_alphabetic()) => text.split_at(text.len() - 1),
        text => (text, ""),
    };
    let power = ["", "K", "M", "G", "T"]
        .iter()
        .position(|name| name.eq_ignore_ascii_case(unit));
    let number = digits
        .parse::<f64>()
        .ok()
        .filter(|number| number.is_finite() && *number > 0.0);
    let bytes = power
        .zip(number)
        .map(|(power, number)| number * f64::from(1u32 << 10).powi(power as i32));
    bytes
        .map(|bytes| bytes as u64)
        .ok_or_else(|| "expected bytes, such as 500M or 8G".to_owned())
}

pub(crate) fn background(text: &str) -> Result<Background, String> {
    text.parse()
}

fn numbers<T: FromStr>(text: &str, separators: &[char]) -> Option<Vec<T>> {
    text.split(separators)
        .map(|part| part.trim().parse().ok())
        .collect()
}

pub(crate) fn triple(text: &str) -> Result<Triple, String> {
    numbers(text, &[','])
        .and_then(|values| <Triple>::try_from(values).ok())
        .filter(|values| values.iter().all(|v| v.is_finite()))
        .ok_or_else(|| "expected three numbers: X,Y,Z".to_owned())
}

pub(crate) fn finite(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|value: &f64| value.is_finite())
        .ok_or_else(|| "expected a number".to_owned())
}

pub(crate) fn range(text: &str) -> Result<[f64; 2], String> {
    numbers(text, &[','])
        .and_then(|values| <[f64; 2]>::try_from(values).ok())
        .filter(|[low, high]| low.is_finite() && high.is_finite() && low < high)
        .ok_or_else(|| "expected two numbers, the smaller first: LO,HI".to_owned())
}

pub(crate) fn gradient_curve(text: &str) -> Result<GradientCurve, String> {
    let point = |part: &str| {
        let (gradient, factor) = part.split_once(':')?;
        Some(GradientOpacityPoint {
            gradient: gradient.trim().parse().ok()?,
            factor: factor.trim().parse().ok()?,
        })
    };
    let points = text.split(',').map(point).collect::<Option<Vec<_>>>();
    let points = points.ok_or_else(|| "expected GRADIENT:FACTOR,GRADIENT:FACTOR,...".to_owned())?;
    check_gradient_opacity(&points)?;
    Ok(GradientCurve(points))
}

pub(crate) fn clip_plane(text: &str) -> Result<ClipPlane, String> {
    let (point, normal) = text
        .split_once(':')
        .ok_or_else(|| "expected a point and a normal: X,Y,Z:NX,NY,NZ".to_owned())?;
    let [point, normal] = [triple(point)?, triple(normal)?].map(DVec3::from_array);
    ClipPlane::new(point, normal).map_err(|error| error.to_string())
}

pub(crate) fn box_sides(text: &str) -> Result<BoxSides, String> {
    numbers(text, &[','])
        .and_then(|values| <BoxSides>::try_from(values).ok())
        .filter(|sides| sides.iter().all(|v| v.is_finite()) && sides.chunks(2).all(|pair| pair[0] < pair[1]))
        .ok_or_else(|| "expected six numbers, the smaller of each pair first: X0,X1,Y0,Y1,Z0,Z1".to_owned())
}

pub(crate) fn dims(text: &str) -> Result<Dims, String> {
    numbers(text, &['x', 'X', ','])
        .and_then(|values| <Dims>::try_from(values).ok())
        .filter(|dims| !dims.contains(&0))
        .ok_or_else(|| "expected three positive integers: XxYxZ".to_owned())
}

pub(crate) fn posts(text: &str) -> Result<[usize; 2], String> {
    numbers(text, &['x', 'X', ','])
        .and_then(|values| <[usize; 2]>::try_from(values).ok())
        .filter(|sides| sides.iter().all(|&side| side >= 2))
        .ok_or_else(|| "expected two integers, at least 2 each: COLUMNSxROWS".to_owned())
}

pub(crate) fn bits(text: &str) -> Result<u8, String> {
    match text {
        "8" => Ok(8),
        "16" => Ok(16),
        _ => Err("expected 8 or 16".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dims_turns_and_scales_are_checked() {
        assert_eq!(dims("3x4x5").unwrap(), [3, 4, 5]);
        assert!(dims("3x4").is_err() && dims("0x4x4").is_err());
        assert_eq!(scale("2"), Ok(Scale::Uniform(2.0)));
        assert_eq!(scale("1,2,-3"), Ok(Scale::Axes([1.0, 2.0, -3.0])));
        assert_eq!(
            rotation("z:30"),
            Ok(Rotate::Axis(Axis::Name("z".to_owned()), 30.0))
        );
        assert_eq!(
            rotation("0,1,1:-5"),
            Ok(Rotate::Axis(Axis::Direction([0.0, 1.0, 1.0]), -5.0))
        );
        for bad in ["z", "w:3", "z:", "1,2:3"] {
            assert!(rotation(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn curves_planes_and_boxes_are_checked() {
        let curve = gradient_curve("0:0, 40:.5,90:1").unwrap();
        assert_eq!(curve.0.len(), 3);
        assert_eq!((curve.0[1].gradient, curve.0[1].factor), (40.0, 0.5));
        let plane = clip_plane("1,2,3:0,0,-2").unwrap();
        assert_eq!(plane.normal(), -DVec3::Z);
        assert_eq!(box_sides("-1,1,-2,2,-3,3"), Ok([-1.0, 1.0, -2.0, 2.0, -3.0, 3.0]));
        for bad in ["", "1", "1:2", "-1:0", "0:0,x:1"] {
            assert!(gradient_curve(bad).is_err(), "{bad}");
        }
        for bad in ["1,2,3", "1,2,3:0,0,0", "1,2:0,0,1"] {
            assert!(clip_plane(bad).is_err(), "{bad}");
        }
        for bad in ["1,0,0,1,0,1", "0,1,0,1", "0,1,0,1,0,nan"] {
            assert!(box_sides(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn vectors_and_ranges_are_finite() {
        assert_eq!(triple("-1, 2.5,3e1"), Ok([-1.0, 2.5, 30.0]));
        assert!(triple("1,2").is_err() && triple("1,inf,0").is_err());
        assert_eq!(range("-1000,3000"), Ok([-1000.0, 3000.0]));
        assert!(range("3,1").is_err() && range("nan,1").is_err());
    }
}
