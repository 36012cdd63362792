//! Samples of a volume as bytes. Packing loses nothing.

use serde::{Deserialize, Serialize};
use splatvol::volume::Samples;
use splatvol::{Grid, LengthUnit, Rescale, SceneError, Volume, with_samples};

use super::planes;
use super::points::{affine, columns};

/// A volume without its samples, and how these are packed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct VolumeData {
    /// Samples along x, y, z.
    pub dims: [usize; 3],
    /// World from voxel: images of the three axes, and of the origin.
    pub world_from_voxel: [[f64; 3]; 4],
    /// Type of a sample: `u8`, `i16`...
    #[serde(rename = "type")]
    pub sample_type: String,
    /// `real = slope * stored + intercept`.
    pub slope: f64,
    /// Offset in real units.
    pub intercept: f64,
    /// Unit of world lengths.
    pub unit: LengthUnit,
    /// Whether bytes are differences.
    pub delta: bool,
}

/// Samples of a type from planes of their bytes.
macro_rules! from_planes {
    ($name:expr, $planes:expr, $($text:literal => $kind:ident $variant:ident,)*) => {
        match $name {
            $($text => {
                let sample = |i: usize| $kind::from_le_bytes(std::array::from_fn(|byte| $planes[byte][i]));
                let count = $planes.first().map_or(0, |plane| plane.len());
                Some(Samples::$variant((0..count).map(sample).collect::<Vec<_>>().into()))
            })*
            _ => None,
        }
    };
}

impl VolumeData {
    /// Describes a volume.
    pub fn of(volume: &Volume, delta: bool) -> Self {
        Self {
            dims: volume.grid().dims(),
            world_from_voxel: columns(&volume.grid().world_from_voxel()),
            sample_type: volume.samples().type_name().to_owned(),
            slope: volume.rescale().slope,
            intercept: volume.rescale().intercept,
            unit: volume.unit(),
            delta,
        }
    }

    /// The volume's samples, packed.
    pub fn pack(&self, volume: &Volume) -> Vec<u8> {
        let samples = volume.samples();
        let mut bytes = Vec::with_capacity(samples.len() * samples.bytes_per_sample());
        for place in 0..samples.bytes_per_sample() {
            with_samples!(samples, data => {
                let plane = data.iter().map(|sample| sample.to_le_bytes()[place]);
                planes::push(&mut bytes, plane, self.delta);
            });
        }
        bytes
    }

    /// Bytes of the packed samples; `None` where they cannot be counted.
    pub fn byte_count(&self) -> Option<usize> {
        let [x, y, z] = self.dims;
        x.checked_mul(y)?
            .checked_mul(z)?
            .checked_mul(self.bytes_per_sample()?)
    }

    fn bytes_per_sample(&self) -> Option<usize> {
        match self.sample_type.as_str() {
            "u8" | "i8" => Some(1),
            "u16" | "i16" => Some(2),
            "u32" | "i32" | "f32" => Some(4),
            "f64" => Some(8),
            _ => None,
        }
    }

    /// The volume of packed samples.
    ///
    /// # Errors
    /// Types that there are not, bytes that do not fit the dims, and everything that is no volume.
    pub fn unpack(&self, bytes: &[u8]) -> Result<Volume, SceneError> {
        let (Some(size), Some(expected)) = (self.bytes_per_sample(), self.byte_count()) else {
            return Err(SceneError::invalid(
                "type of samples",
                (&self.sample_type, self.dims),
                "u8, i8, u16, i16, u32, i32, f32 or f64",
            ));
        };
        if bytes.len() != expected {
            return Err(SceneError::invalid(
                "bytes of the samples",
                bytes.len(),
                "as many as dims and type ask for",
            ));
        }
        let grid = Grid::from_affine(self.dims, affine(self.world_from_voxel))?;
        let planes: Vec<Vec<u8>> = bytes
            .chunks_exact(expected / size)
            .map(|plane| planes::read(plane, self.delta))
            .collect();
        let samples = from_planes!(self.sample_type.as_str(), planes,
            "u8" => u8 U8, "i8" => i8 I8, "u16" => u16 U16, "i16" => i16 I16,
            "u32" => u32 U32, "i32" => i32 I32, "f32" => f32 F32, "f64" => f64 F64,
        );
        let samples = samples
            .ok_or_else(|| SceneError::invalid("type of samples", &self.sample_type, "one that there is"))?;
        let rescale = Rescale {
            slope: self.slope,
            intercept: self.intercept,
        };
        Volume::new(grid, samples, rescale, self.unit)
    }
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DVec3};

    use super::*;

    fn volume(samples: Samples) -> Volume {
        let mut grid = DAffine3::from_scale(DVec3::new(0.5, 1.0, 2.0));
        grid.translation = DVec3::new(-3.0, 0.1, 7.0);
        let rescale = Rescale {
            slope: 0.25,
            intercept: -7.0,
        };
        Volume::new(
            Grid::from_affine([3, 2, 2], grid).unwrap(),
            samples,
            rescale,
            LengthUnit::Millimetre,
        )
        .unwrap()
    }

    #[test]
    fn every_type_comes_back_as_it_was() {
        let numbers: [f64; 12] = [0.0, 1.0, 127.0, 3.0, 120.0, 5.0, 0.0, 0.0, 9.0, 100.0, 11.0, 12.0];
        let all = [
            Samples::U8(numbers.map(|n| n as u8 * 2).to_vec().into()),
            Samples::I8(numbers.map(|n| -(n as i8)).to_vec().into()),
            Samples::U16(numbers.map(|n| n as u16 * 500).to_vec().into()),
            Samples::I16(numbers.map(|n| n as i16 * -250).to_vec().into()),
            Samples::U32(numbers.map(|n| n as u32 * 30_000_000).to_vec().into()),
            Samples::I32(numbers.map(|n| n as i32 * -15_000_000).to_vec().into()),
            Samples::F32(numbers.map(|n| n as f32 / 7.0).to_vec().into()),
            Samples::F64(numbers.map(|n| n / 7.0).to_vec().into()),
        ];
        for (samples, delta) in all
            .into_iter()
            .flat_map(|samples| [(samples.clone(), false), (samples, true)])
        {
            let volume = volume(samples);
            let data = VolumeData::of(&volume, delta);
            let bytes = data.pack(&volume);
            assert_eq!(Some(bytes.len()), data.byte_count());
            let text = serde_json::to_string(&data).unwrap();
            let again = serde_json::from_str::<VolumeData>(&text)
                .unwrap()
                .unpack(&bytes)
                .unwrap();
            assert_eq!(again.samples(), volume.samples());
            assert_eq!(again.grid(), volume.grid());
            assert_eq!((again.rescale(), again.unit()), (volume.rescale(), volume.unit()));
        }
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let volume = volume(Samples::U16(vec![1; 12].into()));
        let data = VolumeData::of(&volume, true);
        let bytes = data.pack(&volume);
        assert!(data.unpack(&bytes[1..]).is_err() && data.unpack(&[]).is_err());
        let other = |change: fn(&mut VolumeData)| {
            let mut data = data.clone();
            change(&mut data);
            data.unpack(&bytes)
        };
        assert!(other(|data| data.sample_type = "u24".to_owned()).is_err());
        assert!(other(|data| data.dims = [usize::MAX, 2, 2]).is_err());
        assert!(other(|data| data.dims = [0; 3]).is_err());
        assert!(other(|data| data.slope = 0.0).is_err());
        assert!(other(|data| data.world_from_voxel = [[0.0; 3]; 4]).is_err());
    }
}
