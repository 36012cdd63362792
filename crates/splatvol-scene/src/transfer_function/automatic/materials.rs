//! Background and materials of a scalar field.
//!
//! The background is what the faces of the grid show (their mode, with the spread around it as noise). What lies
//! above it is cut into three classes by Otsu's criterion (Otsu 1979: largest between-class variance) on the histogram
//! of homogeneous samples: weights fall with the gradient, because partial-volume voxels fill the valleys.

use super::survey::{Survey, quantile};

const BINS: usize = 128;

/// Value and noise of the background.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Background {
    /// Most common value on the faces.
    pub(super) level: f64,
    /// Standard deviation around it.
    pub(super) noise: f64,
}

impl Background {
    /// Standard deviations of noise that still count as background.
    pub(super) const DEVIATIONS: f64 = 4.0;

    /// Finds the background, `None` where the faces look like everything else.
    pub(super) fn find(survey: &Survey) -> Option<Self> {
        let level = half_sample_mode(&survey.border)?;
        let mut deviations: Vec<f64> = survey.border.iter().map(|v| (v - level).abs()).collect();
        deviations.sort_unstable_by(f64::total_cmp);
        // 1.4826 makes the median deviation of a normal distribution its standard deviation.
        let noise = 1.4826 * quantile(&deviations, 0.5);
        let range = survey.quantile(0.9997) - survey.quantile(0.001);
        (noise <= 0.09 * range).then_some(Self { level, noise })
    }

    /// Value above which there is no background any more, for data up to `max`: some standard deviations, and
    /// a thousandth of the range where the noise is quantised away.
    pub(super) fn ceiling(&self, max: f64) -> f64 {
        self.level + (Self::DEVIATIONS * self.noise).max(1e-3 * (max - self.level))
    }
}

/// Robust mode (Robertson and Cryer 1974): the densest half, the densest half of that, and so on.
fn half_sample_mode(sorted: &[f64]) -> Option<f64> {
    let mut part = sorted;
    while part.len() > 2 {
        let half = part.len().div_ceil(2);
        let width = |start: usize| part[start + half - 1] - part[start];
        let start = (0..=part.len() - half).min_by(|&a, &b| width(a).total_cmp(&width(b)))?;
        part = &part[start..start + half];
    }
    part.first().copied()
}

/// Weighted histogram of the samples in `range`.
fn homogeneous_histogram(survey: &Survey, range: [f64; 2]) -> Vec<f64> {
    let mut gradients: Vec<f64> = survey
        .values
        .iter()
        .zip(&survey.gradients)
        .filter(|(v, g)| (range[0]..=range[1]).contains(*v) && g.is_finite())
        .map(|(_, &g)| g)
        .collect();
    gradients.sort_unstable_by(f64::total_cmp);
    let reference = quantile(&gradients, 0.5).max(f64::MIN_POSITIVE);
    let mut histogram = vec![0.0; BINS];
    let scale = BINS as f64 / (range[1] - range[0]);
    for (&value, &gradient) in survey.values.iter().zip(&survey.gradients) {
        if (range[0]..=range[1]).contains(&value) && gradient.is_finite() {
            let bin = (((value - range[0]) * scale) as usize).min(BINS - 1);
            histogram[bin] += 1.0 / (1.0 + (gradient / reference).powi(2));
        }
    }
    histogram
}

/// The thresholds that separate the samples in `range` best into `classes` (at least 1) classes, ascending: Otsu's
/// criterion, maximised exactly by dynamic programming over the bins.
pub(super) fn thresholds(survey: &Survey, range: [f64; 2], classes: usize) -> Vec<f64> {
    let sums = Sums::new(&homogeneous_histogram(survey, range));
    // best[end]: score of the bins before `end` in as many classes as there were rounds.
    let mut best: Vec<f64> = (0..=BINS).map(|end| sums.score(0, end)).collect();
    let mut cuts_by_round = Vec::new();
    for _ in 1..classes {
        let (mut next, mut cuts) = (vec![f64::NEG_INFINITY; BINS + 1], vec![0; BINS + 1]);
        for end in 1..=BINS {
            for (cut, before) in best[..end].iter().enumerate() {
                let score = before + sums.score(cut, end);
                if score > next[end] {
                    (next[end], cuts[end]) = (score, cut);
                }
            }
        }
        best = next;
        cuts_by_round.push(cuts);
    }
    let mut end = BINS;
    let mut thresholds: Vec<f64> = cuts_by_round
        .iter()
        .rev()
        .map(|cuts| {
            end = cuts[end];
            range[0] + (range[1] - range[0]) * end as f64 / BINS as f64
        })
        .collect();
    thresholds.reverse();
    thresholds
}

/// Running sums of a histogram: weight and weight times bin.
struct Sums {
    weight: Vec<f64>,
    moment: Vec<f64>,
}

impl Sums {
    fn new(histogram: &[f64]) -> Self {
        let (mut weight, mut moment) = (vec![0.0], vec![0.0]);
        for (bin, &w) in histogram.iter().enumerate() {
            weight.push(weight[bin] + w);
            moment.push(moment[bin] + w * (bin as f64 + 0.5));
        }
        Self { weight, moment }
    }

    /// Weight times squared mean of a class: their sum over classes is the between-class variance up to a constant.
    fn score(&self, from: usize, to: usize) -> f64 {
        let (weight, moment) = (
            self.weight[to] - self.weight[from],
            self.moment[to] - self.moment[from],
        );
        if weight > 0.0 {
            moment * moment / weight
        } else {
            0.0
        }
    }
}
