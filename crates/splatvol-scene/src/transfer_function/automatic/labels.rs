//! Label volumes: whole numbers that name things, to be shown in one colour each.

use super::survey::Survey;
use super::{Proposal, ValueKind};
use crate::Volume;
use crate::transfer_function::labels::{Label, bands};

/// Most labels that are told apart.
const MOST: usize = 256;

/// Share of equal neighbours above which whole numbers are taken for labels; smooth 8-bit scans stay below a third.
const EQUAL_NEIGHBOURS: f64 = 0.7;

/// Optical depth along the mean path through a label.
const OPTICAL_DEPTH: f64 = 3.0;

/// The values of a label volume, ascending.
pub(super) struct Labels {
    values: Vec<f64>,
    background: f64,
}

/// Finds the labels of a label volume; `None` for other data.
pub(super) fn find(volume: &Volume, survey: &Survey) -> Option<Labels> {
    let whole = |v: &f64| v.fract() == 0.0;
    let [min, max] = volume.value_range();
    if max - min > Volume::WIDEST_WHOLE_RANGE || !whole(&min) || !survey.sorted.iter().all(whole) {
        return None;
    }
    let background = most_common(&survey.sorted)?;
    let (mut equal, mut count) = (0.0, 0usize);
    for (value, share) in survey.values.iter().zip(&survey.equal_neighbours) {
        if value.is_finite() && *value != background {
            equal += f64::from(*share);
            count += 1;
        }
    }
    if count == 0 || equal < EQUAL_NEIGHBOURS * count as f64 {
        return None;
    }
    // A full pass, because small labels escape the survey.
    let values = volume.whole_values(MOST)?;
    Some(Labels { values, background })
}

fn most_common(sorted: &[f64]) -> Option<f64> {
    sorted
        .chunk_by(|a, b| a == b)
        .max_by_key(|run| run.len())
        .and_then(|run| run.first().copied())
}

/// A band of its own colour for every label; the most common one is transparent.
pub(super) fn proposal(labels: &Labels, survey: &Survey) -> Proposal {
    let values = &labels.values;
    let looks: Vec<Label> = values
        .iter()
        .enumerate()
        .map(|(index, &value)| {
            let path = survey.mean_path([value, value + 0.5]).unwrap_or(1.0);
            let is_background = value == labels.background;
            Label {
                value,
                rgb: categorical(index),
                opacity: if is_background {
                    0.0
                } else {
                    -libm::expm1(-OPTICAL_DEPTH / path)
                },
            }
        })
        .collect();
    let (colors, opacities) = bands(&looks);
    Proposal {
        kind: ValueKind::Labels,
        reason: format!(
            "{} whole numbers with mostly equal neighbours: a label volume, a colour per label, {} transparent",
            values.len(),
            labels.background
        ),
        colors,
        opacities,
    }
}

/// Well separated hues by the golden angle, alternately light and dark.
fn categorical(index: usize) -> [f64; 3] {
    let hue = (index as f64 * 0.618_034).fract() * 6.0;
    let (saturation, value) = if index.is_multiple_of(2) {
        (0.42, 0.95)
    } else {
        (0.58, 0.82)
    };
    [5.0, 3.0, 1.0].map(|offset| {
        let k = (offset + hue) % 6.0;
        value * (1.0 - saturation * k.min(4.0 - k).clamp(0.0, 1.0))
    })
}
