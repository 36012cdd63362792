//! The curves proposed for each kind of data.

use super::materials::{Background, thresholds};
use super::survey::{Survey, quantile};
use super::{Proposal, ValueKind, short};
use crate::{ColorMap, ColorPoint, OpacityPoint};

/// Soft to dense: terracotta, amber, ivory.
pub(super) const PALETTE: [[f64; 3]; 4] = [
    [0.72, 0.36, 0.28],
    [0.84, 0.47, 0.34],
    [0.94, 0.73, 0.46],
    [0.98, 0.96, 0.92],
];

/// Optical depth along the mean path through the densest class.
const DENSE_OPTICAL_DEPTH: f64 = 8.0;

/// Optical depth along the mean path below which a class is left out: it would be haze, and cost time.
const LEAST_OPTICAL_DEPTH: f64 = 0.1;

/// Optical depth along the mean path that a class has at least where it stands alone: it hides nothing.
const LONELY_OPTICAL_DEPTH: f64 = 1.0;

/// Shares of a class's rays that meet denser classes: up to the first it stands alone, from the second it does not.
const LONELY: [f64; 2] = [0.4, 0.55];

/// Part of a class on either side of a threshold over which its opacity changes to the next one's.
const TRANSITION: f64 = 0.15;

/// Share of samples below which a class is taken for noise.
const LEAST_SHARE: f64 = 2e-4;

/// Opacity per voxel that gives optical depth `tau` along `path` voxels.
fn opacity(tau: f64, path: Option<f64>) -> f64 {
    path.map_or(0.5, |path| -libm::expm1(-tau / path))
}

/// One value everywhere: a translucent box.
pub(super) fn constant(value: f64) -> Proposal {
    Proposal {
        kind: ValueKind::Constant,
        reason: format!("every sample is {value}: shown as a translucent box"),
        colors: vec![ColorPoint::new(value, PALETTE[2])],
        opacities: vec![OpacityPoint::new(value, 0.02)],
    }
}

/// Values of which no statistics can be made: large ones are opaque.
pub(super) fn ramp([min, max]: [f64; 2]) -> Proposal {
    let [first, .., last] = PALETTE;
    Proposal {
        kind: ValueKind::Continuous,
        reason: format!("values from {min} to {max} are too large for statistics: shown by a ramp"),
        colors: vec![ColorPoint::new(min, first), ColorPoint::new(max, last)],
        opacities: vec![OpacityPoint::new(min, 0.0), OpacityPoint::new(max, 0.5)],
    }
}

/// Air near -1000, and something as dense as bone.
pub(super) fn is_hounsfield(survey: &Survey, [min, max]: [f64; 2]) -> bool {
    (-4096.0..=-900.0).contains(&min) && (300.0..32_768.0).contains(&max) && survey.quantile(0.1) < -800.0
}

/// CT in Hounsfield units: air -1000, fat -100, water 0, muscle 50, contrast medium and cancellous bone 150 to 400,
/// compact bone above.
pub(super) fn hounsfield(survey: &Survey) -> Proposal {
    let soft = opacity(0.7, survey.mean_path([-300.0, 130.0])).min(0.95);
    let medium = opacity(2.0, survey.mean_path([130.0, 350.0])).max(soft).min(0.95);
    let dense = opacity(DENSE_OPTICAL_DEPTH, survey.mean_path([350.0, f64::INFINITY]))
        .clamp(0.3f64.max(medium), 0.95);
    let points = |list: &[(f64, f64)]| list.iter().map(|&(v, o)| OpacityPoint::new(v, o)).collect();
    Proposal {
        kind: ValueKind::Hounsfield,
        reason: String::from(
            "values look like CT in Hounsfield units: air transparent, soft tissue translucent, bone (above 350) ivory",
        ),
        colors: vec![
            ColorPoint::new(-300.0, [0.76, 0.50, 0.40]),
            ColorPoint::new(60.0, [0.86, 0.55, 0.43]),
            ColorPoint::new(180.0, [0.80, 0.36, 0.26]),
            ColorPoint::new(350.0, [0.95, 0.85, 0.68]),
            ColorPoint::new(900.0, [0.99, 0.97, 0.93]),
        ],
        opacities: points(&[
            (-450.0, 0.0),
            (-200.0, soft),
            (110.0, soft),
            (170.0, medium),
            (280.0, medium),
            (450.0, dense),
        ]),
    }
}

/// A background of zero between negative and positive values.
pub(super) fn is_signed(survey: &Survey, background: Background) -> bool {
    let (low, high) = (survey.quantile(0.001), survey.quantile(0.999));
    low < 0.0
        && high > 0.0
        && low.abs().min(high) > 0.1 * low.abs().max(high)
        && background.level.abs() < 0.05 * (high - low)
}

/// Opacity by magnitude, from 0 at the noise; blue below zero, red above.
pub(super) fn signed(mut survey: Survey, largest: f64) -> Proposal {
    survey.make_absolute();
    let border = Background::find(&survey).map_or(0.0, |background| background.noise);
    // Statistical maps are noise all over inside a mask. The median magnitude there is 0.67 standard deviations; of
    // those, one and a half are noise, and so is the lowest of the classes above.
    let unmasked = &survey.sorted[survey.sorted.partition_point(|&v| v == 0.0)..];
    let inside = 1.5 / Background::DEVIATIONS * 1.4826 * quantile(unmasked, 0.5);
    let noise = if inside.is_finite() {
        border.max(inside)
    } else {
        border
    };
    let classes = Classes::new(&survey, Background { level: 0.0, noise }, largest);
    let positive = classes.opacity_points();
    let negative = positive.iter().map(|p| OpacityPoint::new(-p.value, p.opacity));
    let [_, _, strong] = classes.thresholds;
    let map = ColorMap::from_name("coolwarm").expect("coolwarm is a table of this crate");
    Proposal {
        kind: ValueKind::Signed,
        reason: format!(
            "values lie on both sides of a background of 0: transparent below a magnitude of {}, strongest above {}",
            short(positive[0].value),
            short(strong)
        ),
        colors: map.points([-strong, strong], 33),
        opacities: negative.chain(positive.iter().copied()).collect(),
    }
}

/// Three classes above a background; `None` where nothing to speak of lies above it.
pub(super) fn materials(survey: &Survey, background: Background, max: f64) -> Option<Proposal> {
    if survey.share_above(background.ceiling(max)) < LEAST_SHARE {
        return None;
    }
    let classes = Classes::new(survey, background, max);
    let [soft, middle, dense] = classes.thresholds;
    Some(Proposal {
        kind: ValueKind::Materials,
        reason: format!(
            "background {} with noise {} at the faces of the grid: three classes from {}, {} and {}",
            short(background.level),
            short(background.noise),
            short(soft),
            short(middle),
            short(dense)
        ),
        colors: classes.color_points(),
        opacities: classes.opacity_points(),
    })
}

/// No background: what lies above Otsu's threshold of all samples is solid.
pub(super) fn continuous(survey: &Survey, [min, max]: [f64; 2]) -> Proposal {
    let (low, high) = (survey.quantile(0.001), survey.quantile(0.9997));
    let [low, high] = if low < high { [low, high] } else { [min, max] };
    let threshold = thresholds(survey, [low, high], 2)[0]
        .max(low + 0.02 * (high - low))
        .min(high);
    let width = 0.02 * (high - low);
    // Colours are for the bulk; a few large values would press it into the first one.
    let top = survey.quantile(0.99).max(threshold + width);
    let at = |t: f64| threshold + t * (top - threshold);
    Proposal {
        kind: ValueKind::Continuous,
        reason: format!(
            "no background at the faces of the grid: solid above Otsu's threshold {}",
            short(threshold)
        ),
        colors: [0.0, 0.33, 0.66, 1.0]
            .into_iter()
            .zip(PALETTE)
            .map(|(t, rgb)| ColorPoint::new(at(t), rgb))
            .collect(),
        opacities: vec![
            OpacityPoint::new(threshold - width, 0.0),
            OpacityPoint::new(threshold + width, 0.5),
            OpacityPoint::new(high.max(threshold + 2.0 * width), 0.7),
        ],
    }
}

/// The proposal for negated values.
pub(super) fn mirrored(mut proposal: Proposal) -> Proposal {
    proposal
        .colors
        .iter_mut()
        .for_each(|point| point.value = -point.value);
    proposal
        .opacities
        .iter_mut()
        .for_each(|point| point.value = -point.value);
    proposal
        .reason
        .push_str(" (of the negated values: the background is bright)");
    proposal
}

/// Three classes, soft to dense, above a background.
struct Classes {
    /// Values below which everything is transparent, and where the classes begin.
    floor: f64,
    thresholds: [f64; 3],
    high: f64,
    opacities: [f64; 3],
}

impl Classes {
    fn new(survey: &Survey, background: Background, max: f64) -> Self {
        let floor = background.ceiling(max);
        let robust = survey.quantile(0.9997);
        let high = if robust > floor { robust } else { max };
        // The lowest of four classes is noise and partial volume; it stays transparent.
        let cuts = thresholds(survey, [floor, high], 4);
        let thresholds = [cuts[0], cuts[1], cuts[2]];
        let ends = [thresholds[1], thresholds[2], f64::INFINITY];
        let means: [f64; 3] =
            std::array::from_fn(|i| survey.mean([thresholds[i], ends[i]]).unwrap_or(thresholds[i]));
        let mut opacities: [f64; 3] = std::array::from_fn(|i| {
            let relative = (means[i] - background.level) / (means[2] - background.level);
            let tau = DENSE_OPTICAL_DEPTH * libm::pow(relative.clamp(0.0, 1.0), 2.5);
            if tau < LEAST_OPTICAL_DEPTH {
                return 0.0;
            }
            let range = [thresholds[i], ends[i]];
            let [alone, together] = LONELY;
            let loneliness = (together - survey.share_before_denser(range)) / (together - alone);
            let tau = tau.max(LONELY_OPTICAL_DEPTH * loneliness.clamp(0.0, 1.0));
            opacity(tau, survey.mean_path(range)).min(0.95)
        });
        for i in 1..3 {
            opacities[i] = opacities[i].max(opacities[i - 1]);
        }
        Self {
            floor,
            thresholds,
            high,
            opacities,
        }
    }

    fn opacity_points(&self) -> Vec<OpacityPoint> {
        let [soft, middle, dense] = self.thresholds;
        let into = |from: f64, to: f64| from + TRANSITION * (to - from);
        let points = [
            (soft - TRANSITION * (soft - self.floor), 0.0),
            (into(soft, middle), self.opacities[0]),
            (into(middle, soft), self.opacities[0]),
            (into(middle, dense), self.opacities[1]),
            (into(dense, middle), self.opacities[1]),
            (into(dense, self.high), self.opacities[2]),
        ];
        // Of several transparent points, only the last matters.
        let visible = points.iter().position(|&(_, opacity)| opacity > 0.0).unwrap_or(1);
        points[visible - 1..]
            .iter()
            .map(|&(value, opacity)| OpacityPoint::new(value, opacity))
            .collect()
    }

    fn color_points(&self) -> Vec<ColorPoint> {
        let [soft, middle, dense] = self.thresholds;
        let values = [
            soft,
            0.5 * (soft + middle),
            0.5 * (middle + dense),
            0.5 * (dense + self.high),
        ];
        values
            .into_iter()
            .zip(PALETTE)
            .map(|(value, rgb)| ColorPoint::new(value, rgb))
            .collect()
    }
}
