//! 3-D Gaussians as bytes.

use serde::{Deserialize, Serialize};
use splatvol::gaussians::harmonics_count;
use splatvol::{GaussianAttributes, Gaussians, SceneError};

use super::column::{Column, Packer, Precision};
use super::points::{affine, columns, counted};

/// The columns of 3-D Gaussians.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct GaussiansData {
    /// Number of Gaussians.
    pub count: usize,
    /// Degree of the harmonics.
    pub degree: u32,
    antialiased: bool,
    /// World from local: images of the three axes, and of the origin.
    pub world_from_local: [[f64; 3]; 4],
    means: [Column; 3],
    scales: [Column; 3],
    rotations: [Column; 4],
    opacities: Column,
    /// Three for each coefficient.
    harmonics: Vec<[Column; 3]>,
}

impl GaussiansData {
    /// Packs Gaussians; returns their bytes, too.
    pub fn pack(gaussians: &Gaussians, precision: Precision) -> (Self, Vec<u8>) {
        let of = gaussians.attributes();
        let Precision { places, rest } = precision;
        let coefficients = harmonics_count(gaussians.degree());
        let mut packer = Packer::default();
        let data = Self {
            count: gaussians.len(),
            degree: gaussians.degree(),
            antialiased: gaussians.antialiased(),
            world_from_local: columns(gaussians.world_from_local()),
            means: packer.vectors(&of.means, |packer, values| packer.even(values, places)),
            scales: packer.vectors(&of.scales, |packer, values| packer.logarithmic(values, rest)),
            rotations: packer.vectors(&of.rotations, |packer, values| packer.symmetric(values, rest)),
            opacities: packer.even(of.opacities.iter().copied(), rest),
            harmonics: (0..coefficients)
                .map(|i| {
                    let own = of.harmonics.iter().skip(i).step_by(coefficients).copied();
                    let own: Vec<[f32; 3]> = own.collect();
                    packer.vectors(&own, |packer, values| packer.symmetric(values, rest))
                })
                .collect(),
        };
        (data, packer.bytes)
    }

    /// Takes Gaussians from the front of bytes.
    ///
    /// # Errors
    /// Too few bytes, and numbers that are no Gaussians.
    pub fn unpack(&self, bytes: &mut &[u8]) -> Result<Gaussians, SceneError> {
        let count = counted(self.count, bytes)?;
        let coefficients = self.harmonics.len();
        if self.degree > Gaussians::MAX_DEGREE || coefficients != harmonics_count(self.degree) {
            return Err(SceneError::invalid(
                "harmonics",
                (coefficients, self.degree),
                "(degree + 1)^2 of a degree up to 3",
            ));
        }
        let mut attributes = GaussianAttributes {
            means: Column::vectors(&self.means, count, bytes)?,
            scales: Column::vectors(&self.scales, count, bytes)?,
            rotations: Column::vectors(&self.rotations, count, bytes)?,
            opacities: self.opacities.numbers(count, bytes)?,
            harmonics: vec![[0.0; 3]; count * coefficients],
        };
        for (i, columns) in self.harmonics.iter().enumerate() {
            let own = Column::vectors(columns, count, bytes)?;
            let places = attributes.harmonics.iter_mut().skip(i).step_by(coefficients);
            places.zip(own).for_each(|(place, value)| *place = value);
        }
        let gaussians = Gaussians::new(attributes, self.degree, affine(self.world_from_local))?;
        Ok(gaussians.with_antialiasing(self.antialiased))
    }
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DVec3};

    use super::*;

    fn cloud(count: usize, degree: u32) -> Gaussians {
        let wave = |i: usize, rate: f32| (i as f32 * rate).sin();
        let attributes = GaussianAttributes {
            means: (0..count)
                .map(|i| [wave(i, 0.3), 4.0 * wave(i, 0.7), wave(i, 2.0)])
                .collect(),
            scales: (0..count).map(|i| [0.01, 0.02 + 0.001 * i as f32, 0.0]).collect(),
            rotations: (0..count).map(|i| [wave(i, 0.5), 0.0, 0.2, 1.0]).collect(),
            opacities: (0..count).map(|i| (i % 7) as f32 / 6.0).collect(),
            harmonics: (0..count * harmonics_count(degree))
                .map(|i| [wave(i, 0.9), 0.0, wave(i, 0.4)])
                .collect(),
        };
        let frame = DAffine3::from_rotation_x(0.5) * DAffine3::from_scale(DVec3::splat(3.0));
        Gaussians::new(attributes, degree, frame)
            .unwrap()
            .with_antialiasing(degree == 1)
    }

    #[test]
    fn gaussians_come_back_as_near_as_their_bits_allow() {
        for degree in 0..=3 {
            let gaussians = cloud(120, degree);
            let (data, bytes) = GaussiansData::pack(&gaussians, Precision { places: 24, rest: 16 });
            let data: GaussiansData = serde_json::from_str(&serde_json::to_string(&data).unwrap()).unwrap();
            let mut rest = &bytes[..];
            let again = data.unpack(&mut rest).unwrap();
            assert!(rest.is_empty());
            assert_eq!(
                (again.degree(), again.antialiased(), again.world_from_local()),
                (degree, degree == 1, gaussians.world_from_local())
            );
            let all = |of: &Gaussians| -> Vec<f32> {
                let of = of.attributes();
                let vectors = [&of.means, &of.scales, &of.harmonics];
                let numbers = vectors.into_iter().flatten().flatten();
                let numbers = numbers.chain(of.rotations.iter().flatten()).chain(&of.opacities);
                numbers.copied().collect()
            };
            let [a, b] = [&again, &gaussians].map(all);
            let worst = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(a.len() == b.len() && worst < 4e-5, "{worst}");
        }
    }

    #[test]
    fn what_is_no_cloud_of_gaussians_is_refused() {
        let (data, bytes) = GaussiansData::pack(&cloud(40, 1), Precision { places: 16, rest: 8 });
        for short in 0..bytes.len() {
            assert!(data.unpack(&mut &bytes[..short]).is_err());
        }
        for (count, degree) in [(0, 1), (usize::MAX, 1), (40, 2), (40, u32::MAX)] {
            let other = GaussiansData {
                count,
                degree,
                ..data.clone()
            };
            assert!(other.unpack(&mut &bytes[..]).is_err(), "{count} {degree}");
        }
    }
}
