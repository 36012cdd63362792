//! Values that keys cannot have, whatever the data.

use splatvol_scene::{GradientOpacityPoint, Region};

use super::{ItemKeys, Opacity};
use crate::{DocumentError, spelling};

impl ItemKeys {
    /// Refuses values that no data give a meaning: unknown names, and numbers outside their domains.
    ///
    /// # Errors
    /// The first such key, by name, with its value.
    pub fn check_values(&self) -> Result<(), DocumentError> {
        let curve = match &self.opacity {
            Some(Opacity::Curve(name)) => Some(name),
            _ => None,
        };
        let names = [
            ("kind", &self.kind, unknown(self.kind.as_ref(), spelling::kind)),
            (
                "cmap",
                &self.cmap,
                unknown(self.cmap.as_ref(), spelling::color_map),
            ),
        ];
        for (key, name, why) in names {
            if let (Some(name), Some(why)) = (name, why) {
                return Err(self.refused(key, format!("{name:?}: {why}")));
            }
        }
        if let (Some(name), Some(why)) = (curve, unknown(curve, spelling::opacity_curve)) {
            return Err(self.refused("opacity", format!("{name:?}: {why}")));
        }
        if let Some([low, high]) = self.clim.filter(|[low, high]| !ascend([*low, *high])) {
            let why = format!("= [{low}, {high}]: expected two numbers, the smaller first");
            return Err(self.refused("clim", why));
        }
        if let Some(iso) = self.iso.filter(|iso| !iso.is_finite()) {
            return Err(self.refused("iso", format!("= {iso}: expected a number")));
        }
        self.check_points()
    }

    /// Refuses values of the keys of points.
    fn check_points(&self) -> Result<(), DocumentError> {
        let unit = |value: &f64| (0.0..=1.0).contains(value);
        if let Some(color) = self.color.filter(|color| !color.iter().all(unit)) {
            return Err(self.refused("color", format!("{color:?} is not in 0..1")));
        }
        if let Some(Opacity::Share(share)) = self.opacity.as_ref().filter(|opacity| match opacity {
            Opacity::Share(share) => !unit(share),
            Opacity::Curve(_) => false,
        }) {
            return Err(self.refused("point-opacity", format!("{share} is not in 0..1")));
        }
        match self
            .radius
            .filter(|radius| !(radius.is_finite() && *radius > 0.0))
        {
            Some(radius) => Err(self.refused("radius", format!("{radius} is not a length above zero"))),
            None => Ok(()),
        }
    }

    fn refused(&self, key: &str, why: String) -> DocumentError {
        DocumentError::refused(&format!("item.{key}"), why).of_item(&self.file)
    }
}

/// Why a name is unknown, if it is.
fn unknown<T>(name: Option<&String>, known: fn(&str) -> Result<T, String>) -> Option<String> {
    name.and_then(|name| known(name).err())
}

fn ascend([low, high]: [f64; 2]) -> bool {
    low.is_finite() && high.is_finite() && low < high
}

/// Checks the points of a curve over gradient magnitudes.
///
/// # Errors
/// The first point that has no meaning, as `GRADIENT:FACTOR`, and what is expected.
pub fn check_gradient_opacity(points: &[GradientOpacityPoint]) -> Result<(), String> {
    let legal = |point: &GradientOpacityPoint| {
        point.gradient.is_finite() && point.gradient >= 0.0 && (0.0..=1.0).contains(&point.factor)
    };
    let fault = |point: &GradientOpacityPoint, expected: &str| {
        Err(format!(
            "{}:{}: expected {expected}",
            point.gradient, point.factor
        ))
    };
    if points.is_empty() {
        return Err("expected at least one point".to_owned());
    }
    if let Some(point) = points.iter().find(|point| !legal(point)) {
        return fault(point, "a gradient of 0 or more and a factor from 0 to 1");
    }
    match points.windows(2).find(|pair| pair[0].gradient > pair[1].gradient) {
        Some(pair) => fault(&pair[1], "gradients that ascend"),
        None => Ok(()),
    }
}

/// Checks soft rectangles of value and gradient.
///
/// # Errors
/// The first that has no meaning, by its number and key, and what is expected.
pub(crate) fn check_regions(regions: &[Region]) -> Result<(), DocumentError> {
    if regions.is_empty() {
        return Err(DocumentError::refused(
            "effects.regions",
            ": expected at least one",
        ));
    }
    for (index, region) in regions.iter().enumerate() {
        let refused = |key: &str, value: String, expected: &str| {
            let path = format!("effects.regions[{index}].{key}");
            Err(DocumentError::refused(
                &path,
                format!("= {value}: expected {expected}"),
            ))
        };
        for (key, range) in [("value", region.value), ("gradient", region.gradient)] {
            if !ascend(range) {
                let shown = format!("[{}, {}]", range[0], range[1]);
                return refused(key, shown, "two numbers, the smaller first");
            }
        }
        let unit = |value: &f64| (0.0..=1.0).contains(value);
        if !region.rgb.iter().all(unit) {
            let [r, g, b] = region.rgb;
            return refused("rgb", format!("[{r}, {g}, {b}]"), "three numbers from 0 to 1");
        }
        for (key, share) in [("opacity", region.opacity), ("softness", region.softness)] {
            if !unit(&share) {
                return refused(key, share.to_string(), "a number from 0 to 1");
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_curves_ascend_within_their_domain() {
        let curve = |points: &[[f64; 2]]| {
            let points = points
                .iter()
                .map(|&[gradient, factor]| GradientOpacityPoint { gradient, factor });
            check_gradient_opacity(&points.collect::<Vec<_>>())
        };
        assert!(curve(&[[0.0, 0.0], [5.0, 1.0], [5.0, 0.5]]).is_ok());
        for (points, words) in [
            (&[][..], "at least one"),
            (&[[0.0, -1.0]], "0:-1: expected a gradient of 0 or more"),
            (&[[5.0, 0.0], [1.0, 1.0]], "1:1: expected gradients that ascend"),
        ] {
            let error = curve(points).unwrap_err();
            assert!(error.contains(words), "{error}");
        }
    }
}
