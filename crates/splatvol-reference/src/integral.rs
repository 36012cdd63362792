//! The emission-absorption integral along a ray, by adaptive halving.
//!
//! `tau = int kappa dl`, `C = int exp(-tau) e dl`. An interval with samples at its ends and middle is integrated by
//! Simpson's rule, weighted so that a constant colour gives `c (1 - exp(-tau))` exactly; two halves combine as
//! `tau_1 + tau_2`, `C_1 + exp(-tau_1) C_2`. It is halved until its halves agree with the whole and the transfer
//! function hides nothing between the samples. X-ray pictures are the same with `exp(-tau)` replaced by 1 and
//! `1 - exp(-tau)` by tau: plain integrals.

use crate::features::Features;
use crate::medium::MediumSample;

/// Halvings of the initial step at which an interval is accepted as it is: steps of a transfer function never
/// converge, but shrink to 2^-24 of it.
const MAX_HALVINGS: u32 = 24;

/// A transfer function may leave the straight line between samples by this many tolerances: the comparison of
/// halves and whole sees what it samples; this only keeps it from missing what it does not.
const FEATURE_TOLERANCES: f64 = 16.0;

/// Whether material dims the light from behind it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Optics {
    /// Emission and absorption.
    Absorbing,
    /// Plain line integrals.
    Additive,
}

impl Optics {
    /// Share of light that passes an optical depth.
    fn transmittance(self, tau: f64) -> f64 {
        match self {
            Self::Absorbing => (-tau).exp(),
            Self::Additive => 1.0,
        }
    }

    /// Light from an optical depth of unit colour.
    fn emitted(self, tau: f64) -> f64 {
        match self {
            Self::Absorbing => -(-tau).exp_m1(),
            Self::Additive => tau,
        }
    }
}

/// Optical depth and light of a stretch of a ray.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Segment {
    /// Optical depth.
    pub(crate) tau: f64,
    /// Premultiplied linear RGB leaving the front, and the same integral of position along the ray (0..1).
    pub(crate) light: [f64; 4],
}

impl Segment {
    /// This segment in front of another.
    fn then(self, behind: Self, optics: Optics) -> Self {
        let transmittance = optics.transmittance(self.tau);
        Self {
            tau: self.tau + behind.tau,
            light: std::array::from_fn(|c| self.light[c] + transmittance * behind.light[c]),
        }
    }

    /// Simpson's rule over three equidistant samples of a stretch of the given world length.
    fn simpson([a, m, b]: [&RaySample; 3], length: f64, optics: Optics) -> Self {
        let [ka, km, kb] = [a, m, b].map(|sample| sample.medium.extinction);
        let tau = length / 6.0 * (ka + 4.0 * km + kb);
        // Optical depth to the middle: the integral of the parabola through the three samples.
        let tau_to_middle = (length / 24.0 * (5.0 * ka + 8.0 * km - kb)).clamp(0.0, tau);
        let through = [
            1.0,
            4.0 * optics.transmittance(tau_to_middle),
            optics.transmittance(tau),
        ];
        let absorbed = through[0] * ka + through[1] * km + through[2] * kb;
        if absorbed <= 0.0 {
            return Self { tau, light: [0.0; 4] };
        }
        let alpha = optics.emitted(tau);
        let emissions = [a, m, b].map(RaySample::emission);
        let light = std::array::from_fn(|c| {
            let emitted: f64 = (0..3).map(|i| through[i] * emissions[i][c]).sum();
            alpha * emitted / absorbed
        });
        Self { tau, light }
    }
}

/// The medium at a position of the ray, 0..1 along the interval of integration.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RaySample {
    position: f64,
    medium: MediumSample,
}

impl RaySample {
    fn emission(&self) -> [f64; 4] {
        let [r, g, b] = self.medium.emission;
        [r, g, b, self.medium.extinction * self.position]
    }
}

/// One ray's integral.
pub(crate) struct RayIntegral<'a, M: Fn(f64) -> MediumSample> {
    /// The medium at a position, 0..1.
    pub(crate) medium: M,
    /// Kinks of the transfer function.
    pub(crate) features: &'a Features,
    /// World length of the whole.
    pub(crate) length: f64,
    /// Accepted difference between an interval and its halves, in optical depth and light reaching the eye.
    pub(crate) tolerance: f64,
    /// Optical model.
    pub(crate) optics: Optics,
}

/// An interval to integrate: its samples, the number of halvings, and the optical depth in front.
#[derive(Clone, Copy)]
struct Interval {
    samples: [RaySample; 3],
    halvings: u32,
    tau_in_front: f64,
}

impl<M: Fn(f64) -> MediumSample> RayIntegral<'_, M> {
    /// Integral from position 0 to 1, starting from `steps` equal intervals.
    pub(crate) fn integrate(&self, steps: usize) -> Segment {
        let mut total = Segment::default();
        let mut front = self.sample(0.0);
        for step in 0..steps {
            let back = self.sample((step + 1) as f64 / steps as f64);
            let interval = Interval {
                samples: [front, self.sample(0.5 * (front.position + back.position)), back],
                halvings: 0,
                tau_in_front: total.tau,
            };
            total = total.then(self.refine(interval), self.optics);
            front = back;
        }
        total
    }

    fn sample(&self, position: f64) -> RaySample {
        RaySample {
            position,
            medium: (self.medium)(position),
        }
    }

    fn refine(&self, interval: Interval) -> Segment {
        let [a, m, b] = interval.samples;
        let first = self.sample(0.5 * (a.position + m.position));
        let second = self.sample(0.5 * (m.position + b.position));
        let length = self.length * (b.position - a.position);
        let whole = Segment::simpson([&a, &m, &b], length, self.optics);
        let front = Segment::simpson([&a, &first, &m], 0.5 * length, self.optics);
        let back = Segment::simpson([&m, &second, &b], 0.5 * length, self.optics);
        let halves = front.then(back, self.optics);
        let samples = [a, first, m, second, b];
        if interval.halvings == MAX_HALVINGS
            || (self.agree(&whole, &halves, interval.tau_in_front)
                && !self.hides_features(&samples, length, interval.tau_in_front))
        {
            return halves;
        }
        let half = |samples, tau_in_front| Interval {
            samples,
            halvings: interval.halvings + 1,
            tau_in_front,
        };
        let front = self.refine(half([a, first, m], interval.tau_in_front));
        let back = self.refine(half([m, second, b], interval.tau_in_front + front.tau));
        front.then(back, self.optics)
    }

    /// Tolerance behind an optical depth: material behind an opaque part affects nothing but the optical depth itself,
    /// which need not be better than 1 %.
    fn tolerance_behind(&self, tau: f64) -> f64 {
        self.tolerance / self.optics.transmittance(tau.min(4.6))
    }

    fn agree(&self, whole: &Segment, halves: &Segment, tau_in_front: f64) -> bool {
        let transmittance = self.optics.transmittance(tau_in_front);
        let light = (0..4).map(|c| (whole.light[c] - halves.light[c]).abs());
        (whole.tau - halves.tau).abs() <= self.tolerance_behind(tau_in_front)
            && transmittance * light.fold(0.0, f64::max) <= self.tolerance
    }

    fn hides_features(&self, samples: &[RaySample; 5], length: f64, tau_in_front: f64) -> bool {
        let allowed = FEATURE_TOLERANCES * self.tolerance_behind(tau_in_front) / (0.25 * length);
        samples.windows(2).any(|pair| {
            self.features
                .hidden_between(&pair[0].medium, &pair[1].medium, allowed)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn integral(extinction: impl Fn(f64) -> f64, color: impl Fn(f64) -> f64, length: f64) -> Segment {
        let medium = |position: f64| {
            let extinction = extinction(position);
            MediumSample {
                value: f64::NAN,
                coverage: 1.0,
                extinction,
                emission: [extinction * color(position), 0.0, extinction],
            }
        };
        RayIntegral {
            medium,
            features: &Features::none(),
            length,
            tolerance: 1e-9,
            optics: Optics::Absorbing,
        }
        .integrate(7)
    }

    #[test]
    fn homogeneous_medium_is_exact() {
        for tau in [1e-12, 0.3, 5.0, 200.0] {
            let segment = integral(|_| tau / 3.0, |_| 0.4, 3.0);
            let alpha = -(-tau).exp_m1();
            assert!((segment.tau / tau - 1.0).abs() < 1e-12);
            assert!((segment.light[0] - 0.4 * alpha).abs() < 1e-12 * alpha.max(1e-9));
            assert!((segment.light[2] - alpha).abs() < 1e-12);
        }
    }

    #[test]
    fn colour_ramp_in_an_absorbing_medium_is_the_closed_form() {
        // int_0^1 x k exp(-k x) dx = (1 - exp(-k) (1 + k)) / k.
        for k in [0.1, 2.0, 40.0] {
            let segment = integral(|_| k, |x| x, 1.0);
            let exact = (1.0 - (-k).exp() * (1.0 + k)) / k;
            assert!(
                (segment.light[0] - exact).abs() < 1e-7,
                "{k}: {} {exact}",
                segment.light[0]
            );
            assert!((segment.light[3] - exact).abs() < 1e-7, "position");
        }
    }

    #[test]
    fn steps_are_found_where_they_are() {
        let segment = integral(|x| if x < 0.123_456 { 0.0 } else { 3.0 }, |_| 1.0, 1.0);
        assert!(
            (segment.tau - 3.0 * (1.0 - 0.123_456)).abs() < 1e-6,
            "{}",
            segment.tau
        );
    }
}
