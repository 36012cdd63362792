//! Kinks of the transfer function: keeps the adaptive integral from stepping over thin features.
//!
//! Two samples of a ray with values a and b do not reveal the course of the transfer function between a and b. It is
//! therefore probed at its points, just before them (steps) and in the middle of its segments, and compared with the
//! straight line between the two samples.

use std::cmp::Ordering;

use splatvol_scene::TransferFunction;

use crate::medium::MediumSample;

/// The probed transfer function, by ascending value.
#[derive(Debug, Clone)]
pub(crate) struct Features {
    probes: Vec<Probe>,
}

#[derive(Debug, Clone, Copy)]
struct Probe {
    value: f64,
    /// Extinction and unlit emission, per world length.
    classified: [f64; 4],
}

impl Features {
    pub(crate) fn new(transfer_function: &TransferFunction, unit_distance: f64) -> Self {
        let colors = transfer_function.colors();
        let opacities = transfer_function.opacities();
        let mut values: Vec<f64> = colors.iter().map(|point| point.value).collect();
        values.extend(opacities.iter().map(|point| point.value));
        // A sharp segment steps where its midpoint says.
        let middle = |a: f64, b: f64, midpoint: f64| a + midpoint * (b - a);
        values.extend(
            colors
                .windows(2)
                .map(|pair| middle(pair[0].value, pair[1].value, pair[0].midpoint)),
        );
        values.extend(
            opacities
                .windows(2)
                .map(|pair| middle(pair[0].value, pair[1].value, pair[0].midpoint)),
        );
        values.sort_by(f64::total_cmp);
        values.dedup();
        let between: Vec<f64> = values.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
        let before: Vec<f64> = values.iter().map(|value| value.next_down()).collect();
        values.extend(between);
        values.extend(before);
        values.sort_by(f64::total_cmp);
        values.dedup();
        let probe = |value: f64| {
            let extinction = transfer_function.extinction(value, unit_distance);
            let [r, g, b] = transfer_function.linear_color(value);
            Probe {
                value,
                classified: [extinction, extinction * r, extinction * g, extinction * b],
            }
        };
        Self {
            probes: values.into_iter().map(probe).collect(),
        }
    }

    /// No features: for media that are not classified along the ray.
    pub(crate) fn none() -> Self {
        Self { probes: Vec::new() }
    }

    /// True where the transfer function, for values between those of two samples, leaves the straight line between
    /// its values there by more than `allowed` (per world length).
    pub(crate) fn hidden_between(&self, a: &MediumSample, b: &MediumSample, allowed: f64) -> bool {
        let (low, high) = if a.value <= b.value { (a, b) } else { (b, a) };
        if low.value.partial_cmp(&high.value) != Some(Ordering::Less) {
            // Equal, or without a value (NaN).
            return false;
        }
        let coverage = a.coverage.max(b.coverage);
        let first = self.probes.partition_point(|probe| probe.value <= low.value);
        let inside = self.probes[first..]
            .iter()
            .take_while(|probe| probe.value < high.value);
        let ends = [self.classified_at(low.value), self.classified_at(high.value)];
        inside.into_iter().any(|probe| {
            let t = (probe.value - low.value) / (high.value - low.value);
            (0..4).any(|c| {
                let line = ends[0][c] + t * (ends[1][c] - ends[0][c]);
                coverage * (probe.classified[c] - line).abs() > allowed
            })
        })
    }

    /// The probed function at a value, linear between probes.
    fn classified_at(&self, value: f64) -> [f64; 4] {
        let after = self.probes.partition_point(|probe| probe.value <= value);
        let (Some(high), true) = (self.probes.get(after), after > 0) else {
            let end = if after == 0 {
                self.probes.first()
            } else {
                self.probes.last()
            };
            return end.map_or([0.0; 4], |probe| probe.classified);
        };
        let low = &self.probes[after - 1];
        let t = (value - low.value) / (high.value - low.value);
        std::array::from_fn(|c| low.classified[c] + t * (high.classified[c] - low.classified[c]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use splatvol_scene::{ColorPoint, OpacityPoint};

    fn sample(value: f64) -> MediumSample {
        MediumSample {
            value,
            coverage: 1.0,
            ..MediumSample::default()
        }
    }

    #[test]
    fn spikes_and_steps_between_samples_are_seen() {
        let color = vec![ColorPoint::new(0.0, [1.0; 3])];
        let opacity = [
            (0.4, 0.0),
            (0.41, 0.5),
            (0.42, 0.0),
            (0.7, 0.0),
            (0.7, 0.3),
            (1.0, 0.3),
        ];
        let points = opacity
            .map(|(value, opacity)| OpacityPoint::new(value, opacity))
            .to_vec();
        let features = Features::new(&TransferFunction::new(color, points, None).unwrap(), 1.0);
        let hidden = |a, b| features.hidden_between(&sample(a), &sample(b), 1e-3);
        assert!(hidden(0.2, 0.6) && hidden(0.6, 0.2), "the spike");
        assert!(hidden(0.6, 0.9), "the step");
        assert!(!hidden(0.45, 0.65) && !hidden(0.75, 0.95), "flat parts");
        assert!(!hidden(0.5, f64::NAN));
    }
}
