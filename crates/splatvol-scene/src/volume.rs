//! Samples on a grid, kept in the type they came in.
//!
//! Real values are `slope * stored + intercept` ([`Rescale`]). Samples that are NaN or infinite are *missing*:
//! they carry no weight in the reconstruction, exactly as if they lay outside the volume, and they are counted in
//! [`Statistics::non_finite`].

use std::sync::Arc;

use glam::DAffine3;

use crate::{ChunkedVolume, Grid, LengthUnit, SampleSource, SceneError, Storage};

/// Stored samples, x fastest.
#[derive(Debug, Clone, PartialEq)]
pub enum Samples {
    /// Unsigned, 8 bits.
    U8(Storage<u8>),
    /// Signed, 8 bits.
    I8(Storage<i8>),
    /// Unsigned, 16 bits.
    U16(Storage<u16>),
    /// Signed, 16 bits.
    I16(Storage<i16>),
    /// Unsigned, 32 bits.
    U32(Storage<u32>),
    /// Signed, 32 bits.
    I32(Storage<i32>),
    /// Floating point, 32 bits.
    F32(Storage<f32>),
    /// Floating point, 64 bits.
    F64(Storage<f64>),
}

/// Runs `$body` with `$data` bound to the typed slice inside a [`Samples`]: the one place where sample types are
/// told apart.
#[macro_export]
macro_rules! with_samples {
    ($samples:expr, $data:ident => $body:expr) => {
        match $samples {
            $crate::Samples::U8($data) => {
                let $data = &$data[..];
                $body
            }
            $crate::Samples::I8($data) => {
                let $data = &$data[..];
                $body
            }
            $crate::Samples::U16($data) => {
                let $data = &$data[..];
                $body
            }
            $crate::Samples::I16($data) => {
                let $data = &$data[..];
                $body
            }
            $crate::Samples::U32($data) => {
                let $data = &$data[..];
                $body
            }
            $crate::Samples::I32($data) => {
                let $data = &$data[..];
                $body
            }
            $crate::Samples::F32($data) => {
                let $data = &$data[..];
                $body
            }
            $crate::Samples::F64($data) => {
                let $data = &$data[..];
                $body
            }
        }
    };
}

impl Samples {
    /// Number of samples.
    pub fn len(&self) -> usize {
        with_samples!(self, data => data.len())
    }

    /// True where there is no sample.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Name of the element type: `u8`, `i16`, `f32`...
    pub fn type_name(&self) -> &'static str {
        match self {
            Self::U8(_) => "u8",
            Self::I8(_) => "i8",
            Self::U16(_) => "u16",
            Self::I16(_) => "i16",
            Self::U32(_) => "u32",
            Self::I32(_) => "i32",
            Self::F32(_) => "f32",
            Self::F64(_) => "f64",
        }
    }

    /// The same samples, owned by all clones together: see [`Storage::into_shared`].
    #[must_use]
    pub fn into_shared(self) -> Self {
        match self {
            Self::U8(samples) => Self::U8(samples.into_shared()),
            Self::I8(samples) => Self::I8(samples.into_shared()),
            Self::U16(samples) => Self::U16(samples.into_shared()),
            Self::I16(samples) => Self::I16(samples.into_shared()),
            Self::U32(samples) => Self::U32(samples.into_shared()),
            Self::I32(samples) => Self::I32(samples.into_shared()),
            Self::F32(samples) => Self::F32(samples.into_shared()),
            Self::F64(samples) => Self::F64(samples.into_shared()),
        }
    }

    /// Bytes per sample.
    pub fn bytes_per_sample(&self) -> usize {
        match self {
            Self::U8(_) | Self::I8(_) => 1,
            Self::U16(_) | Self::I16(_) => 2,
            Self::U32(_) | Self::I32(_) | Self::F32(_) => 4,
            Self::F64(_) => 8,
        }
    }
}

/// `real = slope * stored + intercept`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rescale {
    /// Factor; not zero.
    pub slope: f64,
    /// Offset in real units.
    pub intercept: f64,
}

impl Rescale {
    /// Real value of a stored one.
    #[inline]
    pub fn apply(&self, stored: f64) -> f64 {
        self.slope * stored + self.intercept
    }
}

impl Default for Rescale {
    fn default() -> Self {
        Self {
            slope: 1.0,
            intercept: 0.0,
        }
    }
}

/// Statistics of the samples from one pass, in real (rescaled) values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Statistics {
    /// Smallest finite value.
    pub min: f64,
    /// Largest finite value.
    pub max: f64,
    /// Mean of the finite values.
    pub mean: f64,
    /// Samples that are NaN or infinite, hence missing.
    pub non_finite: usize,
}

/// A validated scalar volume. One that is larger than memory has the samples of a coarse level here, an overview from
/// which looks and cameras are chosen, and reads its own from chunks when it is drawn.
#[derive(Debug, Clone)]
pub struct Volume {
    grid: Grid,
    samples: Samples,
    rescale: Rescale,
    unit: LengthUnit,
    statistics: Statistics,
    chunks: Option<Arc<ChunkedVolume>>,
}

impl Volume {
    /// Volume of `samples` (x fastest) on `grid`.
    ///
    /// # Errors
    /// A sample count that does not fit the dims, a rescale that is zero or not finite, or no finite sample.
    pub fn new(grid: Grid, samples: Samples, rescale: Rescale, unit: LengthUnit) -> Result<Self, SceneError> {
        if samples.len() != grid.sample_count() {
            return Err(SceneError::SampleCount {
                dims: grid.dims(),
                expected: grid.sample_count(),
                found: samples.len(),
            });
        }
        if !(rescale.slope.is_finite() && rescale.slope != 0.0) {
            return Err(SceneError::invalid("slope", rescale.slope, "finite and not zero"));
        }
        if !rescale.intercept.is_finite() {
            return Err(SceneError::invalid("intercept", rescale.intercept, "finite"));
        }
        let statistics = statistics(&samples, rescale)?;
        Ok(Self {
            grid,
            samples,
            rescale,
            unit,
            statistics,
            chunks: None,
        })
    }

    /// The volume of which this is an overview.
    #[must_use]
    pub fn over_chunks(self, chunks: ChunkedVolume) -> Self {
        Self {
            chunks: Some(Arc::new(chunks)),
            ..self
        }
    }

    /// The chunks from which the volume is read when it is drawn; the samples here are an overview then.
    pub fn chunks(&self) -> Option<&Arc<ChunkedVolume>> {
        self.chunks.as_ref()
    }

    /// The samples that are drawn.
    pub fn source(self: &Arc<Self>) -> Arc<dyn SampleSource> {
        match &self.chunks {
            Some(chunks) => Arc::<ChunkedVolume>::clone(chunks),
            None => Arc::<Self>::clone(self),
        }
    }

    /// Grid of the samples that are drawn, at full resolution.
    pub fn finest_grid(&self) -> &Grid {
        match &self.chunks {
            Some(chunks) => chunks.grid(0),
            None => &self.grid,
        }
    }

    /// Moves the volume: its map from voxel to world becomes `world_from_old * world_from_voxel`.
    ///
    /// # Errors
    /// Same as [`Grid::from_affine`]; the volume then keeps its placement.
    pub fn transform(&mut self, world_from_old: DAffine3) -> Result<(), SceneError> {
        let grid = Grid::from_affine(self.grid.dims(), world_from_old * self.grid.world_from_voxel())?;
        if let Some(chunks) = &mut self.chunks {
            *chunks = Arc::new(chunks.transformed(world_from_old)?);
        }
        self.grid = grid;
        Ok(())
    }

    /// The same volume, its samples owned by all clones together: see [`Storage::into_shared`].
    #[must_use]
    pub fn into_shared(self) -> Self {
        Self {
            samples: self.samples.into_shared(),
            ..self
        }
    }

    /// Grid of the samples.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The stored samples, x fastest.
    pub fn samples(&self) -> &Samples {
        &self.samples
    }

    /// Conversion of stored samples to real values.
    pub fn rescale(&self) -> Rescale {
        self.rescale
    }

    /// Unit of world lengths.
    pub fn unit(&self) -> LengthUnit {
        self.unit
    }

    /// Range, mean and missing samples, in real values.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// Smallest and largest finite real value.
    pub fn value_range(&self) -> [f64; 2] {
        [self.statistics.min, self.statistics.max]
    }

    /// Real value of sample `index` (x fastest); NaN or infinite where missing.
    pub fn value(&self, index: usize) -> f64 {
        self.rescale
            .apply(with_samples!(&self.samples, data => widen(data[index])))
    }

    /// Counts of the finite samples in `bins` equal bins over [`Volume::value_range`].
    pub fn histogram(&self, bins: usize) -> Vec<u64> {
        with_samples!(&self.samples, data => {
            let values = data.iter().map(|&sample| self.rescale.apply(widen(sample)));
            histogram(values, self.value_range(), bins)
        })
    }

    /// Widest range of values that [`Volume::whole_values`] searches.
    pub const WIDEST_WHOLE_RANGE: f64 = 65_535.0;

    /// The values that occur, ascending, where they are whole numbers as labels are; `None` if there are more than `most`, or if
    /// they lie too far apart. Samples that are no whole numbers count as the next lower one.
    pub fn whole_values(&self, most: usize) -> Option<Vec<f64>> {
        let [min, max] = self.value_range();
        if max - min > Self::WIDEST_WHOLE_RANGE || min.fract() != 0.0 {
            return None;
        }
        // One bin per whole number, the last shared by the largest alone.
        let bins = (max - min) as usize + 1;
        let width = (max - min) / bins as f64;
        let counts = self.histogram(bins).into_iter().enumerate();
        let mut values: Vec<f64> = counts
            .filter(|&(_, count)| count > 0)
            .map(|(bin, _)| (min + (bin as f64 + 1.0) * width).floor())
            .collect();
        values.dedup();
        (values.len() <= most).then_some(values)
    }
}

/// Counts of the finite values in `bins` equal bins over their range; of none, none.
pub(crate) fn histogram(values: impl Iterator<Item = f64>, [low, high]: [f64; 2], bins: usize) -> Vec<u64> {
    let mut counts = vec![0; bins];
    let scale = if high > low {
        bins as f64 / (high - low)
    } else {
        0.0
    };
    for value in values.filter(|value| value.is_finite()) {
        let bin = ((value - low) * scale) as usize;
        if let Some(count) = counts.get_mut(bin.min(bins.saturating_sub(1))) {
            *count += 1;
        }
    }
    counts
}

/// Lossless (from the types of [`Samples`]) conversion to f64.
#[inline(always)]
pub fn widen<T: Into<f64>>(sample: T) -> f64 {
    sample.into()
}

fn statistics(samples: &Samples, rescale: Rescale) -> Result<Statistics, SceneError> {
    let (mut low, mut high, mut sum, mut finite) = (f64::INFINITY, f64::NEG_INFINITY, 0.0, 0usize);
    with_samples!(samples, data => for &sample in data {
        let value = widen(sample);
        if value.is_finite() {
            low = low.min(value);
            high = high.max(value);
            sum += value;
            finite += 1;
        }
    });
    if finite == 0 {
        return Err(SceneError::NoFiniteSample { count: samples.len() });
    }
    let ends = [rescale.apply(low), rescale.apply(high)];
    // The mean is kept inside the range: sums of huge values may overflow to infinity.
    let mean = rescale.apply((sum / finite as f64).clamp(low, high));
    let (min, max) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
    if !(max - min).is_finite() {
        return Err(SceneError::invalid("value range", [min, max], "a finite width"));
    }
    Ok(Statistics {
        min,
        max,
        mean,
        non_finite: samples.len() - finite,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn volume(samples: Samples, rescale: Rescale) -> Result<Volume, SceneError> {
        let grid = Grid::centred([samples.len().max(1), 1, 1], DVec3::ONE)?;
        Volume::new(grid, samples, rescale, LengthUnit::Unknown)
    }

    #[test]
    fn missing_samples_are_counted_and_left_out() {
        let samples = Samples::F32(vec![1.0, f32::NAN, 5.0, f32::NEG_INFINITY].into());
        let volume = volume(
            samples,
            Rescale {
                slope: -2.0,
                intercept: 1.0,
            },
        )
        .unwrap();
        assert_eq!(
            volume.statistics(),
            Statistics {
                min: -9.0,
                max: -1.0,
                mean: -5.0,
                non_finite: 2
            }
        );
        assert_eq!(volume.histogram(4), [1, 0, 0, 1]);
    }

    #[test]
    fn a_volume_of_nothing_is_refused() {
        let error = volume(Samples::F64(vec![f64::NAN; 3].into()), Rescale::default()).unwrap_err();
        assert_eq!(error, SceneError::NoFiniteSample { count: 3 });
        let error = volume(
            Samples::U8(vec![1].into()),
            Rescale {
                slope: 0.0,
                intercept: 0.0,
            },
        )
        .unwrap_err();
        assert!(error.to_string().starts_with("slope: 0.0"));
    }
}
