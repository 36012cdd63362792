//! Prefilter for meshes: values whose kernels interpolate the samples. It compensates in advance for the smoothing
//! by the kernels, as `crate::prefilter` does for grids.
//!
//! The field of coefficients a is `(A a)_i = sum_j m_j N(p_i; p_j, V_j) a_j / sum_j m_j N(p_i; p_j, V_j)`. A few
//! steps of `a <- a + f - A a` (van Cittert 1931) converge to the samples f where kernels overlap little. Modes
//! that they cannot resolve stay unchanged, so that noise does not grow without bounds.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::tree::Tree;
use super::{MeshKernels, Sample};

/// Steps: after them, a detail that kernels halve has an error of a sixteenth.
const STEPS: usize = 3;

impl MeshKernels {
    /// Coefficients in place of the values, one per kernel, the same for any number of threads. Where cells are so
    /// degenerate that all kernels overlap, they are the values.
    pub fn coefficients(&self) -> Vec<f32> {
        let samples: Vec<Sample> = (0..self.len()).into_par_iter().map(|i| self.sample(i)).collect();
        let tree = Tree::new(&samples);
        if !tree.is_affordable() {
            return self.values.clone();
        }
        let places = tree.places(|_| true);
        let masses: Vec<f64> = samples.iter().map(|sample| sample.mass).collect();
        let weights = tree.sums(&places, &masses);
        let mut found: Vec<f64> = self.values.iter().map(|&value| f64::from(value)).collect();
        for _ in 0..STEPS {
            // The tree sums positive kernels only. A mean shifts with its values, so these are counted from the
            // least.
            let least = found.iter().copied().fold(f64::INFINITY, f64::min);
            let above = |(mass, value): (&f64, &f64)| mass * (value - least);
            let carried: Vec<f64> = masses.iter().zip(&found).map(above).collect();
            let sums = tree.sums(&places, &carried);
            for ((&place, sum), weight) in places.iter().zip(sums).zip(&weights) {
                let place = place as usize;
                if *weight > 0.0 {
                    found[place] += f64::from(self.values[place]) - (sum / weight + least);
                }
            }
        }
        found.into_iter().map(|value| value as f32).collect()
    }

    fn sample(&self, index: usize) -> Sample {
        let [xx, xy, xz, yy, yz, zz] = self.covariances[index].map(f64::from);
        Sample {
            position: DVec3::from_array(self.positions[index].map(f64::from)),
            covariance: DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]),
            mass: f64::from(self.masses[index]),
            gradient: DVec3::ZERO,
            value: self.values[index],
            valid: true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For samples of a wave on a line of unit cells, the field's error is a sixth of that without coefficients.
    #[test]
    fn coefficients_bring_the_field_to_the_samples() {
        let (count, sigma) = (60usize, 0.7f64);
        let wave: Vec<f32> = (0..count).map(|i| (i as f64 * 1.3).sin() as f32).collect();
        let side = 3;
        let all = count * side * side;
        let at = |i: usize| [i / (side * side), i / side % side, i % side];
        let kernels = MeshKernels {
            positions: (0..all).map(|i| at(i).map(|x| x as f32)).collect(),
            covariances: vec![[1.0, 0.0, 0.0, 1.0, 0.0, 1.0].map(|v: f64| (v * sigma * sigma) as f32); all],
            masses: vec![1.0; all],
            values: (0..all).map(|i| wave[at(i)[0]]).collect(),
            gradients: vec![[0.0; 3]; all],
            ..MeshKernels::default()
        };
        let error = |values: &[f32]| {
            let along = |i: usize| {
                let near = i.saturating_sub(6)..(i + 7).min(count);
                let weight = |j: usize| (-0.5 * ((i as f64 - j as f64) / sigma).powi(2)).exp();
                let sum: f64 = near.clone().map(|j| weight(j) * f64::from(values[9 * j])).sum();
                sum / near.map(weight).sum::<f64>() - f64::from(wave[i])
            };
            (6..count - 6).map(|i| along(i).abs()).fold(0.0, f64::max)
        };
        let (plain, found) = (error(&kernels.values), error(&kernels.coefficients()));
        println!("plain {plain:.3}, with coefficients {found:.3}");
        assert!(plain > 0.2 && found < plain / 6.0, "{plain} {found}");
    }
}
