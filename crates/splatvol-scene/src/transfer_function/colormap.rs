//! Colour maps under matplotlib's names.
//!
//! Values agree with matplotlib's 256 entries within 1/255 per channel; between the entries this map is continuous,
//! where matplotlib's is a staircase. A name followed by `_r` is the reversed map, as in matplotlib. Maps from black to one colour
//! have that colour's name (`green`, `magenta`, ...), as channels of microscopes have them in napari.

use super::colormap_tables::TABLES;
use crate::{ColorPoint, SceneError};

/// A continuous map from 0..1 to sRGB.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ColorMap {
    name: &'static str,
    knots: &'static [u32],
    reversed: bool,
}

impl ColorMap {
    /// Number of points with which [`ColorMap::points`] reproduces a map to within 8 bits.
    pub const DEFAULT_POINTS: usize = 64;

    /// Map of a matplotlib name such as `viridis` or `magma_r`; case is ignored, `grey` is `gray`.
    ///
    /// # Errors
    /// A name that is not in [`ColorMap::names`], with or without `_r`.
    pub fn from_name(name: &str) -> Result<Self, SceneError> {
        let (base, reversed) = match name.strip_suffix("_r") {
            Some(base) => (base, true),
            None => (name, false),
        };
        let base = if base.eq_ignore_ascii_case("grey") {
            "gray"
        } else {
            base
        };
        TABLES
            .iter()
            .find(|(known, _)| known.eq_ignore_ascii_case(base))
            .map(|&(name, knots)| Self {
                name,
                knots,
                reversed,
            })
            .ok_or_else(|| {
                SceneError::invalid(
                    "color map",
                    name,
                    "a matplotlib name such as viridis, turbo or gray_r",
                )
            })
    }

    /// All names, each of which may be followed by `_r`.
    pub fn names() -> impl Iterator<Item = &'static str> {
        TABLES.iter().map(|(name, _)| *name)
    }

    /// The map's name with `_r` where it is reversed.
    pub fn name(&self) -> String {
        format!("{}{}", self.name, if self.reversed { "_r" } else { "" })
    }

    /// This colour map in reverse order.
    #[must_use]
    pub fn reversed(self) -> Self {
        Self {
            reversed: !self.reversed,
            ..self
        }
    }

    /// sRGB colour at `t`, which is clamped to 0..1 (NaN counts as 0).
    pub fn rgb(&self, t: f64) -> [f64; 3] {
        let t = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) };
        let entry = 255.0 * if self.reversed { 1.0 - t } else { t };
        let after = self
            .knots
            .partition_point(|&knot| knot_entry(knot) <= entry)
            .clamp(1, self.knots.len() - 1);
        let (low, high) = (self.knots[after - 1], self.knots[after]);
        let t = (entry - knot_entry(low)) / (knot_entry(high) - knot_entry(low));
        std::array::from_fn(|c| {
            let [low, high] = [low, high].map(|knot| f64::from(knot.to_be_bytes()[c + 1]) / 255.0);
            low + t * (high - low)
        })
    }

    /// `count` (at least 2) equally spaced points from `range[0]`, the map's beginning, to `range[1]`, its end.
    pub fn points(&self, range: [f64; 2], count: usize) -> Vec<ColorPoint> {
        let last = count.max(2) - 1;
        (0..=last)
            .map(|i| {
                let t = i as f64 / last as f64;
                ColorPoint::new(range[0] + t * (range[1] - range[0]), self.rgb(t))
            })
            .collect()
    }
}

fn knot_entry(knot: u32) -> f64 {
    f64::from(knot >> 24)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Entries 0, 64, 128, 192 and 255 of matplotlib's tables.
    const MATPLOTLIB: &[(&str, [u32; 5])] = &[
        ("viridis", [0x440154, 0x3b528b, 0x21918c, 0x5ec962, 0xfde725]),
        ("plasma", [0x0d0887, 0x7e03a8, 0xcc4778, 0xf89540, 0xf0f921]),
        ("inferno", [0x000004, 0x57106e, 0xbc3754, 0xf98e09, 0xfcffa4]),
        ("magma", [0x000004, 0x51127c, 0xb73779, 0xfc8961, 0xfcfdbf]),
        ("cividis", [0x00224e, 0x434e6c, 0x7d7c78, 0xbcae6c, 0xfee838]),
        ("turbo", [0x30123b, 0x28bceb, 0xa4fc3c, 0xfb7e21, 0x7a0403]),
        ("twilight", [0xe2d9e2, 0x6275ba, 0x301437, 0xb35953, 0xe2d9e2]),
        ("gray", [0x000000, 0x404040, 0x808080, 0xc0c0c0, 0xffffff]),
        ("bone", [0x000000, 0x38384e, 0x707b90, 0xa9c8c8, 0xffffff]),
        ("copper", [0x000000, 0x4f3220, 0x9e6440, 0xed9660, 0xffc77f]),
        ("hot", [0x0b0000, 0xb30000, 0xff5c00, 0xffff07, 0xffffff]),
        ("afmhot", [0x000000, 0x800000, 0xff8001, 0xffff81, 0xffffff]),
        ("coolwarm", [0x3b4cc0, 0x8db0fe, 0xdddcdc, 0xf4987a, 0xb40426]),
        ("seismic", [0x00004c, 0x0101ff, 0xfffdfd, 0xfe0000, 0x800000]),
        ("RdBu", [0x67001f, 0xe58368, 0xf6f7f7, 0x68abd0, 0x053061]),
        ("RdYlBu", [0xa50026, 0xf98e52, 0xfeffc0, 0x8ec2dc, 0x313695]),
        ("Spectral", [0x9e0142, 0xf98e52, 0xffffbe, 0x86cfa5, 0x5e4fa2]),
        ("jet", [0x000080, 0x0080ff, 0x7dff7a, 0xff9400, 0x800000]),
        ("hsv", [0xff0000, 0x84ff00, 0x00fff6, 0x7200ff, 0xff0018]),
        // Not matplotlib's.
        ("green", [0x000000, 0x004000, 0x008000, 0x00c000, 0x00ff00]),
        ("magenta", [0x000000, 0x400040, 0x800080, 0xc000c0, 0xff00ff]),
        ("cyan", [0x000000, 0x004040, 0x008080, 0x00c0c0, 0x00ffff]),
        ("yellow", [0x000000, 0x404000, 0x808000, 0xc0c000, 0xffff00]),
        ("red", [0x000000, 0x400000, 0x800000, 0xc00000, 0xff0000]),
        ("blue", [0x000000, 0x000040, 0x000080, 0x0000c0, 0x0000ff]),
    ];

    fn hex(rgb: u32) -> [f64; 3] {
        [16, 8, 0].map(|shift| f64::from(rgb >> shift & 255) / 255.0)
    }

    #[test]
    fn colors_are_matplotlibs() {
        assert_eq!(ColorMap::names().count(), MATPLOTLIB.len());
        for (name, colors) in MATPLOTLIB {
            let map = ColorMap::from_name(name).unwrap();
            let reversed = ColorMap::from_name(&format!("{name}_r")).unwrap();
            for (entry, &color) in [0.0, 64.0, 128.0, 192.0, 255.0].into_iter().zip(colors) {
                let t = entry / 255.0;
                for (got, back, want) in channels(map.rgb(t), reversed.rgb(1.0 - t), hex(color)) {
                    assert!((got - want).abs() < 1.0 / 255.0, "{name} {entry}: {got} {want}");
                    assert!((got - back).abs() < 1e-9);
                }
            }
        }
    }

    fn channels(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> [(f64, f64, f64); 3] {
        std::array::from_fn(|i| (a[i], b[i], c[i]))
    }

    #[test]
    fn tables_run_from_first_to_last_entry() {
        for (name, knots) in TABLES {
            assert_eq!(knot_entry(knots[0]), 0.0, "{name}");
            assert_eq!(knot_entry(knots[knots.len() - 1]), 255.0, "{name}");
            assert!(
                knots.windows(2).all(|pair| pair[0] >> 24 < pair[1] >> 24),
                "{name}"
            );
        }
    }

    #[test]
    fn names_are_forgiving_but_not_invented() {
        assert_eq!(ColorMap::from_name("Grey_r").unwrap().name(), "gray_r");
        assert_eq!(ColorMap::from_name("rdbu").unwrap().name(), "RdBu");
        let error = ColorMap::from_name("virids").unwrap_err().to_string();
        assert!(error.starts_with("color map: \"virids\""), "{error}");
        assert!(ColorMap::from_name("_r").is_err());
    }

    #[test]
    fn points_span_the_range_and_odd_arguments_are_clamped() {
        let map = ColorMap::from_name("gray").unwrap();
        let points = map.points([-10.0, 30.0], 5);
        assert_eq!(
            points.iter().map(|p| p.value).collect::<Vec<_>>(),
            [-10.0, 0.0, 10.0, 20.0, 30.0]
        );
        assert!((points[2].rgb[1] - 0.5).abs() < 1e-9);
        assert_eq!([map.rgb(f64::NAN), map.rgb(7.0)], [[0.0; 3], [1.0; 3]]);
    }
}
