//! Parsers of single values. Errors say what would be accepted.

use std::str::FromStr;

use glam::DVec3;
use splatvol::{ClipPlane, ColorMap, GradientOpacity, GradientOpacityPoint, ImageSize, OpacityCurve};
use splatvol_io::{DataKind, Endian, SampleType};
use splatvol_samples::SampleSize;

use super::{Background, BoxSides, GradientCurve};

/// x, y, z.
pub(crate) type Triple = [f64; 3];
/// Samples along x, y, z.
pub(crate) type Dims = [usize; 3];

/// How alike two names must be for one to be suggested for the other, 0..1, as clap has it.
const ALIKE: f64 = 0.7;

/// Named backgrounds, sRGB and alpha.
const COLORS: [(&str, [f64; 4]); 4] = [
    ("black", [0.0, 0.0, 0.0, 1.0]),
    ("white", [1.0, 1.0, 1.0, 1.0]),
    ("gray", [0.5, 0.5, 0.5, 1.0]),
    ("charcoal", CHARCOAL),
];

/// The default background: dark enough for translucent shells to glow, light enough for dark material to stand out.
pub(crate) const CHARCOAL: [f64; 4] = [0.094, 0.098, 0.110, 1.0];

/// What is expected, and which of the `known` names was probably meant by `name`.
fn expected<Name: AsRef<str>>(what: &str, name: &str, known: impl IntoIterator<Item = Name>) -> String {
    let likeness = |known: &Name| strsim::jaro(known.as_ref(), name);
    let nearest = known
        .into_iter()
        .filter(|known| likeness(known) > ALIKE)
        .max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
    match nearest {
        Some(nearest) => format!("expected {what}; did you mean '{}'?", nearest.as_ref()),
        None => format!("expected {what}"),
    }
}

/// A colour map's name.
pub(crate) fn color_map(text: &str) -> Result<String, String> {
    let known = || ColorMap::names().flat_map(|name| [name.to_owned(), format!("{name}_r")]);
    let what = "a name of matplotlib's, such as viridis, turbo or gray_r";
    let found = ColorMap::from_name(text).map(|_| text.to_owned());
    found.map_err(|_| expected(what, text, known()))
}

/// An opacity curve's name.
pub(crate) fn opacity_curve(text: &str) -> Result<String, String> {
    let known = || OpacityCurve::names().flat_map(|name| [format!("{name}_r"), name]);
    let what = "linear, geom, foreground, sigmoid or sigmoid_N (N: 1 to 10, 15, 20), with _r to reverse";
    let found = OpacityCurve::from_name(text).map(|_| text.to_owned());
    found.map_err(|_| expected(what, text, known()))
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
    GradientOpacity::new(&points).map_err(|error| error.to_string())?;
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

pub(crate) fn image_size(text: &str) -> Result<ImageSize, String> {
    let sides = numbers::<u32>(text, &['x', 'X', ',']);
    match sides.as_deref() {
        Some(&[width, height]) => ImageSize::new(width, height).map_err(|error| error.to_string()),
        Some(&[side]) => ImageSize::new(side, side).map_err(|error| error.to_string()),
        _ => Err("expected WxH, W,H or N, in pixels".to_owned()),
    }
}

pub(crate) fn sample_size(text: &str) -> Result<SampleSize, String> {
    match text.parse() {
        Ok(longest) => Ok(SampleSize::Longest(longest)),
        Err(_) => dims(text)
            .map(SampleSize::Dims)
            .map_err(|_| "expected N or XxYxZ, positive integers".to_owned()),
    }
}

pub(crate) fn sample_type(text: &str) -> Result<SampleType, String> {
    let name = text.to_ascii_lowercase();
    let found = SampleType::ALL.iter().find(|kind| kind.name() == name);
    found.copied().ok_or_else(|| {
        let names: Vec<_> = SampleType::ALL.iter().map(|kind| kind.name()).collect();
        expected(&format!("one of {}", names.join(", ")), &name, &names)
    })
}

pub(crate) fn kind(text: &str) -> Result<DataKind, String> {
    text.parse().map_err(|_| {
        let names = DataKind::ALL.map(DataKind::name);
        expected(&format!("one of {}", names.join(", ")), text, names)
    })
}

pub(crate) fn endian(text: &str) -> Result<Endian, String> {
    match text.to_ascii_lowercase().as_str() {
        "little" | "le" => Ok(Endian::Little),
        "big" | "be" => Ok(Endian::Big),
        name => Err(expected("little or big", name, ["little", "big"])),
    }
}

pub(crate) fn bits(text: &str) -> Result<u8, String> {
    match text {
        "8" => Ok(8),
        "16" => Ok(16),
        _ => Err("expected 8 or 16".to_owned()),
    }
}

pub(crate) fn background(text: &str) -> Result<Background, String> {
    let name = text.to_ascii_lowercase();
    if name == "none" || name == "transparent" {
        return Ok(Background::None);
    }
    if let Some((_, color)) = COLORS.iter().find(|(known, _)| *known == name) {
        return Ok(Background::Color(*color));
    }
    let found = match name.strip_prefix('#') {
        Some(hex) => hex_color(hex),
        None => numbers::<f64>(&name, &[',']).and_then(|values| match values[..] {
            [r, g, b] => Some([r, g, b, 1.0]),
            [r, g, b, a] => Some([r, g, b, a]),
            _ => None,
        }),
    };
    found
        .filter(|color| color.iter().all(|c| (0.0..=1.0).contains(c)))
        .map(Background::Color)
        .ok_or_else(|| {
            let names = COLORS.map(|(name, _)| name);
            let what = format!(
                "r,g,b or r,g,b,a in 0..1, #rrggbb, none, or one of {}",
                names.join(", ")
            );
            expected(&what, &name, names.into_iter().chain(["none"]))
        })
}

fn hex_color(hex: &str) -> Option<[f64; 4]> {
    let channel = |i: usize| {
        u8::from_str_radix(hex.get(i..i + 2)?, 16)
            .ok()
            .map(|v| f64::from(v) / 255.0)
    };
    (hex.len() == 6).then_some(())?;
    Some([channel(0)?, channel(2)?, channel(4)?, 1.0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_come_in_three_spellings() {
        let size = |text| image_size(text).unwrap();
        assert_eq!(size("640x480"), ImageSize::new(640, 480).unwrap());
        assert_eq!(size("640,480"), size("640x480"));
        assert_eq!(size("64"), size("64x64"));
        for bad in ["", "0x4", "4x", "4x4x4", "-3", "70000x2"] {
            assert!(image_size(bad).is_err(), "{bad}");
        }
        assert_eq!(dims("3x4x5").unwrap(), [3, 4, 5]);
        assert!(dims("3x4").is_err() && dims("0x4x4").is_err());
    }

    #[test]
    fn backgrounds_are_names_numbers_or_hex() {
        assert_eq!(background("NONE"), Ok(Background::None));
        assert_eq!(background("white"), Ok(Background::Color([1.0; 4])));
        assert_eq!(background("#ff0000"), Ok(Background::Color([1.0, 0.0, 0.0, 1.0])));
        assert_eq!(
            background("0,0.5,1,0.25"),
            Ok(Background::Color([0.0, 0.5, 1.0, 0.25]))
        );
        for bad in ["mauve", "#ff00", "#\u{e9}12345", "1,2,3", "0,0", "nan,0,0"] {
            assert!(background(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn misspelt_names_get_the_nearest_one() {
        let near = |error: String, name: &str| {
            assert!(error.ends_with(&format!("did you mean '{name}'?")), "{error}");
        };
        near(background("whte").unwrap_err(), "white");
        near(color_map("virids").unwrap_err(), "viridis");
        near(color_map("coolwarn_r").unwrap_err(), "coolwarm_r");
        near(opacity_curve("sigmiod").unwrap_err(), "sigmoid");
        near(opacity_curve("sigmoid_21").unwrap_err(), "sigmoid_2");
        near(kind("gausians").unwrap_err(), "gaussians");
        near(sample_type("uu16").unwrap_err(), "u16");
        near(endian("litle").unwrap_err(), "little");
        assert!(!background("qqqqq").unwrap_err().contains("did you mean"));
        assert_eq!(color_map("Viridis"), Ok("Viridis".to_owned()));
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
