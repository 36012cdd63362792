//! Shade: post-classification between two neighbouring planes.
//!
//! On both planes the pixel has the sums `S` (value), `W` (weight) and the analytic gradient of S (the derivative of
//! the EWA filter). Along the pixel's ray `v = S / W` is the cubic Hermite polynomial of both ends' values and derivatives,
//! `O(dz^4)` where the papers' sheets are constant; W runs linearly. The interval is cut where v
//! bends, each piece being classified by the integral tables for a linear value and lit where its material is: the gradient
//! runs linearly between the ends, but for its part along the ray, which is the polynomial's derivative (with the
//! linear part alone, or light interpolated instead of gradients, sheets show as wood grain on slopes).

use splatvol_core::classification::ClassificationTable;

use super::composite::Pixel;
use crate::phong::{Lit, Phong};
use crate::sheets::extremum::Extremum;

/// Coverage from the weight on the volume's own samples (docs/numerics.md): 1 inside, 0 outside, symmetric about 1/2.
#[inline(always)]
fn coverage(weight: f32) -> f32 {
    ((weight - 0.5) / 0.98 + 0.5).clamp(0.0, 1.0)
}

/// Weights below this have no coverage.
pub(crate) const NO_COVERAGE: f32 = 0.01;

/// Weights below this lie so far outside the volume that their values count for nothing.
const FADED: f32 = 0.15;

/// Steps within an interval where one value of the ray is shown.
const VALUE_STEPS: u32 = 8;

/// One end of an interval.
#[derive(Debug, Clone, Copy)]
pub(crate) struct End {
    /// Sum S.
    pub sum: f32,
    /// Sum W.
    pub weight: f32,
    /// The same over the volume's own samples.
    pub own_weight: f32,
    /// Gradient of S, camera space, per world length.
    pub gradient: [f32; 3],
}

/// Constants of the stage.
#[derive(Debug, Clone)]
pub(crate) struct Shader<'a> {
    pub table: &'a ClassificationTable,
    pub lights: Option<Phong>,
    /// Distance between the planes, world length.
    pub spacing: f32,
}

/// A ray's interval.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Interval {
    /// Camera depth of the nearer plane.
    pub depth: f32,
    /// Movement in camera x and y per depth.
    pub ray: [f32; 2],
}

impl Interval {
    /// Path length per depth, squared.
    #[inline(always)]
    fn ray_squared(&self) -> f32 {
        1.0 + self.ray[0] * self.ray[0] + self.ray[1] * self.ray[1]
    }

    /// Change of something with this gradient, per depth.
    #[inline(always)]
    fn along(&self, [x, y, z]: [f32; 3]) -> f32 {
        self.ray[0] * x + self.ray[1] * y + z
    }
}

/// The field between two planes along one ray.
struct Profile {
    /// Hermite coefficients of the value over u in 0..1.
    cubic: [f32; 4],
    weights: [f32; 2],
    own_weights: [f32; 2],
    gradients: [[f32; 3]; 2],
    interval: Interval,
    spacing: f32,
}

impl Profile {
    #[inline(always)]
    fn new(near: &End, far: &End, interval: Interval, spacing: f32) -> Self {
        // v' = (S' - v W') / W; W' matters beyond the volume's faces, where W runs nearly linearly.
        let fall = far.weight - near.weight;
        let value_and_slope = |end: &End, other: &End| {
            if end.weight < FADED.min(other.weight) {
                return (other.sum / other.weight.max(NO_COVERAGE), 0.0);
            }
            let value = end.sum / end.weight;
            (
                value,
                (interval.along(end.gradient) * spacing - value * fall) / end.weight,
            )
        };
        let ((v0, start), (v1, end)) = (value_and_slope(near, far), value_and_slope(far, near));
        let rise = v1 - v0;
        Self {
            cubic: [
                v0,
                start,
                3.0 * rise - 2.0 * start - end,
                start + end - 2.0 * rise,
            ],
            weights: [near.weight, far.weight],
            own_weights: [near.own_weight, far.own_weight],
            gradients: [near.gradient, far.gradient],
            interval,
            spacing,
        }
    }

    /// Gradient of S, camera space, per world length.
    #[inline(always)]
    fn gradient(&self, u: f32) -> [f32; 3] {
        let [_, b, c, d] = self.cubic;
        let slope = b + u * (2.0 * c + u * 3.0 * d);
        let fall = self.weights[1] - self.weights[0];
        let along = (slope * self.weight(u) + self.value(u) * fall) / self.spacing;
        let [near, far] = self.gradients;
        let [x, y, z]: [f32; 3] = std::array::from_fn(|i| near[i] + u * (far[i] - near[i]));
        let missing = (along - self.interval.along([x, y, z])) / self.interval.ray_squared();
        [
            x + missing * self.interval.ray[0],
            y + missing * self.interval.ray[1],
            z + missing,
        ]
    }

    #[inline(always)]
    fn weight(&self, u: f32) -> f32 {
        self.weights[0] + u * (self.weights[1] - self.weights[0])
    }

    #[inline(always)]
    fn coverage(&self, u: f32) -> f32 {
        coverage(self.own_weights[0] + u * (self.own_weights[1] - self.own_weights[0]))
    }

    /// Where coverage is a half.
    #[inline(always)]
    fn border(&self) -> Option<f32> {
        let [near, far] = self.own_weights;
        ((near < 0.5) != (far < 0.5)).then(|| (0.5 - near) / (far - near))
    }

    #[inline(always)]
    fn value(&self, u: f32) -> f32 {
        let [a, b, c, d] = self.cubic;
        a + u * (b + u * (c + u * d))
    }
}

impl Shader<'_> {
    /// Classifies, lights and composites the interval between two planes.
    #[inline(always)]
    pub(crate) fn shade(&self, pixel: &mut Pixel, near: &End, far: &End, interval: Interval) {
        let profile = Profile::new(near, far, interval, self.spacing);
        let (v0, v1) = (profile.value(0.0), profile.value(1.0));
        let quarters = [profile.value(0.25), profile.value(0.5), profile.value(0.75)];
        // The cubic leaves its five samples' range by at most a fraction of their spread.
        let low = quarters.iter().fold(v0.min(v1), |m, v| m.min(*v));
        let high = quarters.iter().fold(v0.max(v1), |m, v| m.max(*v));
        let slack = 0.125 * (high - low);
        if !self.table.is_visible(low - slack, high + slack) {
            return;
        }
        let length = self.spacing * interval.ray_squared().sqrt();
        let pieces = self.pieces([v0, quarters[0], quarters[1], quarters[2], v1], length);
        let share = 1.0 / pieces as f32;
        let mut front = Classified::at(self.table, v0);
        for piece in 0..pieces {
            let start = piece as f32 * share;
            let back = Classified::at(self.table, profile.value(start + share));
            let [extinction, emission @ ..] = self.table.mean(front.value, back.value);
            if extinction > 0.0 {
                let u = start + share * front.centroid(&back, extinction);
                let lit = self
                    .lights
                    .map_or(Lit::PLAIN, |phong| phong.at(profile.gradient(u)));
                let mean = emission.map(|e| e / extinction * lit.diffuse + lit.specular);
                let half_step = std::array::from_fn(|c| 0.5 * (front.color[c] - back.color[c]) * lit.diffuse);
                let optical_depth = extinction * profile.coverage(start + 0.5 * share) * length * share;
                pixel.add_gradient(optical_depth, mean, half_step, interval.depth + u * self.spacing);
            }
            front = back;
        }
    }

    /// Number of pieces: enough that in each the value is linear to half a table cell and the optical depth is small.
    #[inline(always)]
    fn pieces(&self, values: [f32; 5], length: f32) -> usize {
        const MOST: f32 = 8.0;
        let bend = |a: f32, b: f32, c: f32| (a - 2.0 * b + c).abs();
        let [v0, v1, v2, v3, v4] = values;
        let bend = bend(v0, v1, v2).max(bend(v1, v2, v3)).max(bend(v2, v3, v4));
        // Linear interpolation over 1/n of the interval errs by (16 bend) / (8 n^2).
        let for_bend = (8.0 * bend * 1024.0).sqrt();
        let [extinction, ..] = self.table.mean(v0, v4);
        let for_depth = 2.0 * (extinction * length).sqrt();
        for_bend.max(for_depth).clamp(1.0, MOST).ceil() as usize
    }

    /// Largest or smallest covered value of the interval.
    #[inline(always)]
    pub(crate) fn extreme<E: Extremum>(&self, pixel: &mut Pixel, near: &End, far: &End, interval: Interval) {
        let profile = Profile::new(near, far, interval, self.spacing);
        let border = profile.border();
        let steps = (0..=VALUE_STEPS).map(|step| step as f32 / VALUE_STEPS as f32);
        for u in steps.chain(border) {
            if profile.coverage(u) >= 0.5 || Some(u) == border {
                let rank = E::rank(profile.value(u));
                if rank > pixel.total {
                    pixel.total = rank;
                    pixel.depth_sum = interval.depth + u * self.spacing;
                }
            }
        }
    }

    /// Adds the interval to the mean value: integrals of the coverage, and times value and depth, by Simpson's rule.
    #[inline(always)]
    pub(crate) fn mean(&self, pixel: &mut Pixel, near: &End, far: &End, interval: Interval) {
        let profile = Profile::new(near, far, interval, self.spacing);
        for step in 0..=VALUE_STEPS {
            let u = step as f32 / VALUE_STEPS as f32;
            let coverage = profile.coverage(u);
            let share = match step {
                0 | VALUE_STEPS => 1.0,
                _ if step % 2 == 1 => 4.0,
                _ => 2.0,
            };
            let weight = share * coverage;
            pixel.total += weight;
            pixel.color[0] += weight * profile.value(u);
            pixel.color[1] = pixel.color[1].max(coverage);
            pixel.depth_sum += weight * (interval.depth + u * self.spacing);
        }
    }
}

/// An end of a piece.
#[derive(Debug, Clone, Copy)]
struct Classified {
    value: f32,
    extinction: f32,
    color: [f32; 3],
}

impl Classified {
    #[inline(always)]
    fn at(table: &ClassificationTable, value: f32) -> Self {
        Self {
            value,
            extinction: table.extinction(value),
            color: table.color(value),
        }
    }

    /// Where between this end (0) and the other (1) the middle of the material lies, for an extinction that runs
    /// linearly, from where it begins if it is zero at one end.
    #[inline(always)]
    fn centroid(&self, back: &Self, mean: f32) -> f32 {
        let (a, b) = (self.extinction, back.extinction);
        if a <= 0.0 && b <= 0.0 {
            0.5
        } else if a <= 0.0 {
            1.0 - (2.0 * mean / b).min(1.0) / 3.0
        } else if b <= 0.0 {
            (2.0 * mean / a).min(1.0) / 3.0
        } else {
            (a + 2.0 * b) / (3.0 * (a + b))
        }
    }
}
