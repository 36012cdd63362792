//! Inviwo's transfer functions: XML with `Points/Point/(pos, rgba)` and a mask.
//!
//! `<pos content="x"/>` (older files: `<pos x= y=/>` and lower-case names) runs over 0..1 of the data's range, or over
//! data values where `<type content="1"/>` says so; `<rgba x= y= z= w=/>` is sRGB and opacity. Outside `maskMin` and
//! `maskMax` nothing shows. Inviwo's opacities refer to its own sampling rate; here they are per mean voxel spacing.

use std::path::Path;

use roxmltree::Node;
use splatvol_scene::{ColorPoint, OpacityPoint, TransferFunction};

use super::Draft;
use crate::IoError;
use crate::error::Context;
use crate::xml;

/// Reads an `.itf` from the bytes of a file; `path` is only named in errors. See [`super::read_transfer_function`].
///
/// # Errors
/// [`IoError::Format`] names the malformed field.
pub fn decode(
    bytes: &[u8],
    value_range: [f64; 2],
    path: &Path,
) -> Result<(TransferFunction, Vec<String>), IoError> {
    let context = Context::new("Inviwo transfer function", path);
    let text =
        std::str::from_utf8(bytes).map_err(|error| context.field("contents", error, None, "UTF-8 text"))?;
    let document = xml::parse(text.trim_start_matches('\u{feff}'), "contents", &context)?;
    let root = document.root_element();
    let is_absolute = child(root, "type")
        .and_then(|node| node.attribute("content"))
        .is_some_and(|t| t == "1");
    let [low, high] = value_range;
    let data_value = |position: f64| {
        if is_absolute {
            position
        } else {
            low + position * (high - low)
        }
    };

    let (mut colors, mut opacities) = (Vec::new(), Vec::new());
    let points = root
        .descendants()
        .filter(|node| node.tag_name().name().eq_ignore_ascii_case("point"));
    for (index, point) in points.enumerate() {
        let numbers = Numbers {
            index,
            context: &context,
        };
        let position = numbers.required(point, "pos", &["content", "x"])?;
        if !is_absolute && !(0.0..=1.0).contains(&position) {
            return Err(numbers.error("pos", position, "a position from 0 to 1"));
        }
        let [r, g, b, alpha] = ["x", "y", "z", "w"].map(|channel| numbers.unit(point, channel));
        colors.push(ColorPoint::new(data_value(position), [r?, g?, b?]));
        opacities.push(OpacityPoint::new(data_value(position), alpha?));
    }
    if colors.is_empty() {
        return Err(context.unsupported("no points"));
    }
    let mut mask = [f64::NEG_INFINITY, f64::INFINITY];
    for (end, name) in mask.iter_mut().zip(["maskMin", "maskMax"]) {
        if let Some(node) = child(root, name) {
            let text = node.attribute("content").unwrap_or_default();
            let number = text.parse::<f64>().ok().filter(|number| !number.is_nan());
            *end = data_value(number.ok_or_else(|| context.field(name, text, None, "a number"))?);
        }
    }
    opacities.sort_by(|a, b| a.value.total_cmp(&b.value));
    let opacities = masked(opacities, mask);
    let draft = Draft {
        colors,
        opacities,
        unit_distance: None,
        warnings: Vec::new(),
    };
    draft.finish(value_range, &context)
}

fn child<'a>(node: Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
    node.descendants().find(|child| child.tag_name().name() == name)
}

/// Reads the numbers of a point.
struct Numbers<'a> {
    index: usize,
    context: &'a Context<'a>,
}

impl Numbers<'_> {
    fn error(&self, field: &str, value: impl std::fmt::Display, expected: &str) -> IoError {
        self.context
            .field(format!("Point {}: {field}", self.index), value, None, expected)
    }

    /// The number in the first of `attributes` that `name` has.
    fn required(&self, point: Node<'_, '_>, name: &str, attributes: &[&str]) -> Result<f64, IoError> {
        let node = point.children().find(|child| child.tag_name().name() == name);
        let text = node.and_then(|node| attributes.iter().find_map(|attribute| node.attribute(*attribute)));
        let text = text.ok_or_else(|| self.error(name, "(absent)", "a number"))?;
        match text.trim().parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(self.error(name, text, "a finite number")),
        }
    }

    fn unit(&self, point: Node<'_, '_>, channel: &str) -> Result<f64, IoError> {
        let number = self.required(point, "rgba", &[channel])?;
        if (0.0..=1.0).contains(&number) {
            Ok(number)
        } else {
            Err(self.error(&format!("rgba {channel}"), number, "a number from 0 to 1"))
        }
    }
}

/// Opacity 0 outside the mask, unchanged inside; `points` ascend.
fn masked(points: Vec<OpacityPoint>, [low, high]: [f64; 2]) -> Vec<OpacityPoint> {
    let (Some(first), Some(last)) = (points.first().copied(), points.last().copied()) else {
        return points;
    };
    let opacity_at = |value: f64| {
        let after = points.partition_point(|point| point.value <= value);
        match (after.checked_sub(1).map(|i| points[i]), points.get(after)) {
            (Some(a), Some(b)) => {
                a.opacity + (b.opacity - a.opacity) * (value - a.value) / (b.value - a.value)
            }
            (Some(a), None) => a.opacity,
            _ => first.opacity,
        }
    };
    let step = |value: f64, inside_last: bool| {
        let inside = OpacityPoint::new(value, opacity_at(value));
        let outside = OpacityPoint::new(value, 0.0);
        if inside_last {
            [outside, inside]
        } else {
            [inside, outside]
        }
    };
    let mut masked = Vec::new();
    if low > first.value {
        masked.extend(step(low, true));
    }
    masked.extend(points.iter().filter(|point| (low..=high).contains(&point.value)));
    if high < last.value && high >= low {
        masked.extend(step(high, false));
    }
    if masked.is_empty() {
        masked.push(OpacityPoint::new(first.value, 0.0));
    }
    masked
}
