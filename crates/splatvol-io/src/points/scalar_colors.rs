//! Colours of values on a surface or a cloud: viridis over their range, as heights of LAS points.

use splatvol_scene::ColorMap;

use crate::mesh::poly::Scalars;

/// Colour of a value that is missing.
const MISSING: [u8; 4] = [128, 128, 128, 255];

/// A colour map over a range of values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Coloring {
    map: ColorMap,
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl Coloring {
    /// That of an array over its range. Values that are all the same colour nothing; who asked for them is told.
    pub(super) fn of(scalars: &Scalars, warnings: &mut Vec<String>) -> Option<Self> {
        let finite = || scalars.values().filter(|value| value.is_finite());
        let (low, high) = (
            finite().fold(f64::INFINITY, f64::min),
            finite().fold(f64::NEG_INFINITY, f64::max),
        );
        if low >= high {
            if scalars.is_asked {
                warnings.push(format!(
                    "array `{}` has one value everywhere: it colours nothing",
                    scalars.name
                ));
            }
            return None;
        }
        let missing = scalars.values().filter(|value| !value.is_finite()).count();
        if missing > 0 {
            let name = &scalars.name;
            warnings.push(format!(
                "{missing} values of `{name}` are NaN or infinite; they are shown grey"
            ));
        }
        let map = ColorMap::from_name("viridis").ok()?;
        Some(Self { map, low, high })
    }

    /// sRGB and opacity of a value.
    pub(crate) fn color(&self, value: f64) -> [u8; 4] {
        if !value.is_finite() {
            return MISSING;
        }
        // Halved first, so that the range cannot overflow.
        let t = (value / 2.0 - self.low / 2.0) / (self.high / 2.0 - self.low / 2.0);
        let [red, green, blue] = self.map.rgb(t).map(|part| (255.0 * part).round() as u8);
        [red, green, blue, 255]
    }
}
