//! Colour spaces in which VTK interpolates, and points fine enough to interpolate in sRGB instead.
//!
//! CIELAB: sRGB to XYZ (IEC 61966-2-1), white point D65. Msh and the diverging interpolation: Moreland, "Diverging
//! Color Maps for Scientific Visualization", 2009, section 5.

use std::f64::consts::{PI, TAU};

use splatvol_scene::ColorPoint;
use splatvol_scene::transfer_function::{linear_from_srgb, srgb_from_linear};

/// Pieces per interval.
const PIECES: usize = 32;

/// XYZ of D65 white.
const WHITE: [f64; 3] = [0.9505, 1.0, 1.089];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ColorSpace {
    Rgb,
    Hsv,
    Lab,
    Diverging,
}

impl ColorSpace {
    /// The space with this name in ParaView.
    pub(super) fn from_name(name: &str) -> Option<Self> {
        match name.to_ascii_lowercase().as_str() {
            "rgb" => Some(Self::Rgb),
            "hsv" => Some(Self::Hsv),
            "lab" | "cielab" => Some(Self::Lab),
            "diverging" => Some(Self::Diverging),
            _ => None,
        }
    }

    /// Ascending points, between which interpolation in sRGB is as good as in this space.
    pub(super) fn refine(self, points: &[ColorPoint]) -> Vec<ColorPoint> {
        if self == Self::Rgb {
            return points.to_vec();
        }
        let mut fine = Vec::new();
        for pair in points.windows(2) {
            let count = if pair[1].value > pair[0].value { PIECES } else { 1 };
            fine.extend((0..count).map(|i| {
                let t = i as f64 / count as f64;
                let rgb = if i == 0 {
                    pair[0].rgb
                } else {
                    self.mix(pair[0].rgb, pair[1].rgb, t)
                };
                ColorPoint::new(pair[0].value + t * (pair[1].value - pair[0].value), rgb)
            }));
        }
        fine.extend(points.last().copied());
        fine
    }

    fn mix(self, a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
        let rgb = match self {
            Self::Rgb => lerp(a, b, t),
            Self::Hsv => {
                let (a, mut b) = (hsv_from_srgb(a), hsv_from_srgb(b));
                // The short way round.
                b[0] += 6.0 * ((a[0] - b[0]) / 6.0).round();
                srgb_from_hsv(lerp(a, b, t))
            }
            Self::Lab => srgb_from_lab(lerp(lab_from_srgb(a), lab_from_srgb(b), t)),
            Self::Diverging => diverging(a, b, t),
        };
        rgb.map(|c| c.clamp(0.0, 1.0))
    }
}

fn lerp(a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
    std::array::from_fn(|i| a[i] + t * (b[i] - a[i]))
}

/// Hue in 0..6.
fn hsv_from_srgb([r, g, b]: [f64; 3]) -> [f64; 3] {
    let (value, least) = (r.max(g).max(b), r.min(g).min(b));
    let chroma = value - least;
    if chroma == 0.0 {
        return [0.0, 0.0, value];
    }
    let hue = if value == r {
        (g - b) / chroma
    } else if value == g {
        2.0 + (b - r) / chroma
    } else {
        4.0 + (r - g) / chroma
    };
    [hue.rem_euclid(6.0), chroma / value, value]
}

fn srgb_from_hsv([hue, saturation, value]: [f64; 3]) -> [f64; 3] {
    [5.0, 3.0, 1.0].map(|offset| {
        let k = (offset + hue).rem_euclid(6.0);
        value * (1.0 - saturation * k.min(4.0 - k).clamp(0.0, 1.0))
    })
}

fn lab_from_srgb(rgb: [f64; 3]) -> [f64; 3] {
    let [r, g, b] = rgb.map(linear_from_srgb);
    let xyz = [
        0.4124 * r + 0.3576 * g + 0.1805 * b,
        0.2126 * r + 0.7152 * g + 0.0722 * b,
        0.0193 * r + 0.1192 * g + 0.9505 * b,
    ];
    let f = |t: f64| {
        if t > 0.008_856 {
            t.cbrt()
        } else {
            7.787 * t + 16.0 / 116.0
        }
    };
    let [x, y, z] = std::array::from_fn(|i| f(xyz[i] / WHITE[i]));
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn srgb_from_lab([lightness, a, b]: [f64; 3]) -> [f64; 3] {
    let y = (lightness + 16.0) / 116.0;
    let inverse = |t: f64| {
        let cube = t * t * t;
        if cube > 0.008_856 {
            cube
        } else {
            (t - 16.0 / 116.0) / 7.787
        }
    };
    let [x, y, z] = [y + a / 500.0, y, y - b / 200.0].map(inverse);
    let [x, y, z] = [x * WHITE[0], y * WHITE[1], z * WHITE[2]];
    [
        3.2406 * x - 1.5372 * y - 0.4986 * z,
        -0.9689 * x + 1.8758 * y + 0.0415 * z,
        0.0557 * x - 0.2040 * y + 1.0570 * z,
    ]
    .map(|c| srgb_from_linear(c.max(0.0)))
}

/// Magnitude, saturation angle, hue.
fn msh_from_srgb(rgb: [f64; 3]) -> [f64; 3] {
    let [l, a, b] = lab_from_srgb(rgb);
    let magnitude = (l * l + a * a + b * b).sqrt();
    let saturation = if magnitude > 0.001 {
        (l / magnitude).acos()
    } else {
        0.0
    };
    let hue = if saturation > 0.001 { b.atan2(a) } else { 0.0 };
    [magnitude, saturation, hue]
}

fn srgb_from_msh([magnitude, saturation, hue]: [f64; 3]) -> [f64; 3] {
    srgb_from_lab([
        magnitude * saturation.cos(),
        magnitude * saturation.sin() * hue.cos(),
        magnitude * saturation.sin() * hue.sin(),
    ])
}

/// Moreland 2009: through white where both ends are saturated and differ in hue.
fn diverging(a: [f64; 3], b: [f64; 3], mut t: f64) -> [f64; 3] {
    let (mut a, mut b) = (msh_from_srgb(a), msh_from_srgb(b));
    let turn = (a[2] - b[2]).rem_euclid(TAU);
    let hues_differ = turn.min(TAU - turn) > PI / 3.0;
    if a[1] > 0.05 && b[1] > 0.05 && hues_differ {
        let white = [a[0].max(b[0]).max(88.0), 0.0, 0.0];
        if t < 0.5 {
            (b, t) = (white, 2.0 * t);
        } else {
            (a, t) = (white, 2.0 * t - 1.0);
        }
    }
    if a[1] < 0.05 && b[1] > 0.05 {
        a[2] = adjusted_hue(b, a[0]);
    } else if b[1] < 0.05 && a[1] > 0.05 {
        b[2] = adjusted_hue(a, b[0]);
    }
    srgb_from_msh(lerp(a, b, t))
}

/// Hue for an unsaturated end, such that the way to the saturated one is perceptually even.
fn adjusted_hue([magnitude, saturation, hue]: [f64; 3], unsaturated_magnitude: f64) -> f64 {
    if magnitude >= unsaturated_magnitude - 0.1 {
        return hue;
    }
    let rise = (unsaturated_magnitude * unsaturated_magnitude - magnitude * magnitude).sqrt();
    let spin = saturation * rise / (magnitude * saturation.sin());
    if hue > -0.3 * PI { hue + spin } else { hue - spin }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: [f64; 3], b: [f64; 3], tolerance: f64) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < tolerance)
    }

    #[test]
    fn spaces_return_to_srgb() {
        for rgb in [[0.2, 0.5, 0.9], [1.0, 0.0, 0.3], [0.0; 3], [1.0; 3], [0.5; 3]] {
            assert!(close(srgb_from_hsv(hsv_from_srgb(rgb)), rgb, 1e-12), "{rgb:?}");
            assert!(close(srgb_from_lab(lab_from_srgb(rgb)), rgb, 1e-3), "{rgb:?}");
            assert!(close(srgb_from_msh(msh_from_srgb(rgb)), rgb, 1e-3), "{rgb:?}");
        }
        // Red in CIELAB (D65).
        assert!(close(lab_from_srgb([1.0, 0.0, 0.0]), [53.24, 80.09, 67.20], 0.05));
    }

    #[test]
    fn cool_to_warm_is_morelands() {
        // Entries of matplotlib's table of Moreland's map, which runs between these ends.
        let map = splatvol_scene::ColorMap::from_name("coolwarm").unwrap();
        let (cool, warm) = (
            [0.229_805_7, 0.298_717_966, 0.753_683_153],
            [0.705_673_158, 0.015_556_16, 0.150_232_812],
        );
        for i in 0..=32 {
            let t = f64::from(i) / 32.0;
            let found = ColorSpace::Diverging.mix(cool, warm, t);
            assert!(close(found, map.rgb(t), 0.01), "{t}: {found:?} {:?}", map.rgb(t));
        }
    }

    #[test]
    fn hue_goes_the_short_way() {
        let found = ColorSpace::Hsv.mix([1.0, 0.0, 0.2], [1.0, 0.2, 0.0], 0.5);
        assert!(close(found, [1.0, 0.0, 0.0], 1e-9), "{found:?}");
    }
}
