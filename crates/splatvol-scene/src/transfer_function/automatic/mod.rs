//! Automatic choice of a transfer function for any volume.
//!
//! Decided in this order, from a [`survey`] of at most 1 M voxels:
//!
//! | kind | recognised by | shown as |
//! |---|---|---|
//! | constant | one value | a translucent box |
//! | labels | few whole numbers, most neighbours equal | a colour per label |
//! | Hounsfield | air near -1000, tissue and bone above | translucent skin and tissue, ivory bone |
//! | signed | a background of 0 between negative and positive values | a diverging map, opacity by magnitude |
//! | materials | faces of the grid that differ from the rest | background transparent, three classes above it |
//! | continuous | none of these | values above Otsu's threshold |
//!
//! Opacities come from optical depths: a class that rays cross in L voxels on average gets `1 - exp(-tau / L)` per
//! voxel, with `tau = 8 m^2.5`, where m is the class's mean above the background relative to that of the densest
//! class; it is at least 1 where the class's rays seldom meet denser ones. So soft material stays translucent at
//! any resolution where it hides something, thin structures stay visible, and materials of about equal value look
//! like one solid. Meshes that are shells or plates show their whole body instead ([`mesh`]). All of it is
//! deterministic, and does not depend on the order of the file's axes.

mod labels;
mod materials;
mod mesh;
mod oriented;
mod projections;
mod shapes;
mod survey;

use crate::{Classification, ColorMap, ColorPoint, OpacityPoint, TransferFunction, Volume};
use materials::Background;
use survey::Survey;

/// Kind of data, as the automatic choice recognised it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ValueKind {
    /// One value everywhere.
    Constant,
    /// Whole numbers that name things.
    Labels,
    /// CT in Hounsfield units.
    Hounsfield,
    /// Negative and positive values around a background of 0.
    Signed,
    /// Materials before a background.
    Materials,
    /// A field that fills the grid.
    Continuous,
}

/// Why an automatic transfer function looks as it does.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct AutomaticChoice {
    /// Recognised kind of the data.
    pub kind: ValueKind,
    /// One sentence with the numbers behind the choice, in data units.
    pub reason: String,
    /// Classification suited to such data: labels must not be interpolated, so they need pre-classification.
    pub classification: Classification,
    /// Data values between which opacity and colour vary, a good range for other maps too.
    pub range: [f64; 2],
}

/// Curves before validation, and their explanation.
struct Proposal {
    kind: ValueKind,
    reason: String,
    colors: Vec<ColorPoint>,
    opacities: Vec<OpacityPoint>,
}

impl Proposal {
    /// False where statistics of values near the ends of f64 have overflowed.
    fn is_finite(&self) -> bool {
        let mut colors = self.colors.iter().map(|point| point.value);
        let mut opacities = self
            .opacities
            .iter()
            .flat_map(|point| [point.value, point.opacity]);
        colors.all(f64::is_finite) && opacities.all(f64::is_finite)
    }
}

impl TransferFunction {
    /// Transfer function that shows the volume's structure, with the reason; `map` replaces the colours but not the
    /// opacities. `unit_distance` is left to the volume's mean voxel spacing.
    pub fn automatic(volume: &Volume, map: Option<ColorMap>) -> (Self, AutomaticChoice) {
        Self::chosen(volume, map, true)
    }

    /// [`TransferFunction::automatic`] for values of a continuous field, even if few whole numbers are all that occur: they
    /// are never taken for labels.
    pub fn automatic_continuous(volume: &Volume, map: Option<ColorMap>) -> (Self, AutomaticChoice) {
        Self::chosen(volume, map, false)
    }

    /// Value of the background: the most common one on the faces of the grid; where these look like everything else, the
    /// least of all values.
    pub fn background_of(volume: &Volume) -> f64 {
        let found = Background::find(&Survey::new(volume));
        found.map_or(volume.value_range()[0], |background| background.level)
    }

    fn chosen(volume: &Volume, map: Option<ColorMap>, may_be_labels: bool) -> (Self, AutomaticChoice) {
        let proposal = Some(propose(volume, may_be_labels)).filter(Proposal::is_finite);
        let proposal = proposal.unwrap_or_else(|| shapes::ramp(volume.value_range()));
        let range = span(&proposal.opacities, volume);
        let colors = map.map_or(proposal.colors, |map| recolor(map, range, proposal.kind));
        let choice = AutomaticChoice {
            kind: proposal.kind,
            reason: proposal.reason,
            classification: match proposal.kind {
                ValueKind::Labels => Classification::Pre,
                _ => Classification::Post,
            },
            range,
        };
        let transfer_function = Self::new(colors, proposal.opacities, None)
            .expect("proposals have finite values, colours and opacities in 0..1");
        (transfer_function, choice)
    }
}

fn propose(volume: &Volume, may_be_labels: bool) -> Proposal {
    let [min, max] = volume.value_range();
    if min == max {
        return shapes::constant(min);
    }
    let mut survey = Survey::new(volume);
    let labels = may_be_labels.then(|| labels::find(volume, &survey)).flatten();
    if let Some(labels) = labels {
        return labels::proposal(&labels, &survey);
    }
    if shapes::is_hounsfield(&survey, [min, max]) {
        return shapes::hounsfield(&survey);
    }
    let background = Background::find(&survey);
    if let Some(background) = background {
        if shapes::is_signed(&survey, background) {
            return shapes::signed(survey, max.max(-min));
        }
        if let Some(proposal) = shapes::materials(&survey, background, max) {
            return proposal;
        }
        survey.negate();
        let background = Background {
            level: -background.level,
            ..background
        };
        if let Some(proposal) = shapes::materials(&survey, background, -min) {
            return shapes::mirrored(proposal);
        }
        survey.negate();
    }
    shapes::continuous(&survey, [min, max])
}

/// A value with four significant digits, for people.
fn short(value: f64) -> String {
    let size = value.abs();
    if value != 0.0 && !(1e-3..1e6).contains(&size) {
        return format!("{value:.3e}");
    }
    // The digits before the point are all kept.
    let digits = if value == 0.0 {
        0
    } else {
        libm::log10(size).floor() as i32
    };
    let text = format!("{value:.*}", (3 - digits).max(0) as usize);
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// Values between the first and the last point.
fn span(opacities: &[OpacityPoint], volume: &Volume) -> [f64; 2] {
    let values = || opacities.iter().map(|point| point.value);
    let [min, max] = volume.value_range();
    [
        values().fold(f64::INFINITY, f64::min).max(min),
        values().fold(f64::NEG_INFINITY, f64::max).min(max),
    ]
}

fn recolor(map: ColorMap, range: [f64; 2], kind: ValueKind) -> Vec<ColorPoint> {
    let range = if kind == ValueKind::Signed {
        let reach = range[0].abs().max(range[1].abs());
        [-reach, reach]
    } else {
        range
    };
    map.points(range, ColorMap::DEFAULT_POINTS)
}

#[cfg(test)]
mod tests;
