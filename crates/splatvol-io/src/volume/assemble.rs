//! Builds a [`Loaded`] volume from a parsed header and decoded samples, with the checks common to all formats.

use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};
use splatvol_scene::{Grid, LengthUnit, Rescale, Samples, Volume};

use super::{Description, Loaded, ReadOptions};
use crate::error::Context;
use crate::source::Source;
use crate::{IoError, SampleType};

/// All data that a reader has gathered, before validation.
pub(crate) struct Draft {
    pub(crate) dims: [usize; 3],
    pub(crate) world_from_voxel: DAffine3,
    pub(crate) rescale: Rescale,
    pub(crate) unit: LengthUnit,
    pub(crate) description: Description,
}

impl Draft {
    /// A grid of unit spacing around the world's origin, to be filled in.
    pub(crate) fn new(dims: [usize; 3], description: Description) -> Self {
        Self {
            dims,
            world_from_voxel: DAffine3::IDENTITY,
            rescale: Rescale::default(),
            unit: LengthUnit::Unknown,
            description,
        }
    }

    pub(crate) fn warn(&mut self, warning: impl Into<String>) {
        self.description.warnings.push(warning.into());
    }

    /// Records the number of time points, and warns if the first of several is read that nobody asked for.
    pub(crate) fn set_times(&mut self, times: usize, options: &ReadOptions) {
        self.description.times = times;
        if times > 1 && options.time.is_none() {
            self.warn(format!("time point 0 of {times} is read"));
        }
    }

    /// The grid, so that bad geometry is reported before any data are read.
    pub(crate) fn grid(&self, context: &Context<'_>) -> Result<Grid, IoError> {
        Grid::from_affine(self.dims, self.world_from_voxel).map_err(|error| context.scene(error))
    }

    /// The volume. Missing (NaN or infinite) samples are counted in a warning.
    pub(crate) fn finish(mut self, samples: Samples, context: &Context<'_>) -> Result<Loaded, IoError> {
        let grid = self.grid(context)?;
        let volume =
            Volume::new(grid, samples, self.rescale, self.unit).map_err(|error| context.scene(error))?;
        let missing = volume.statistics().non_finite;
        if missing > 0 {
            self.warn(format!(
                "{missing} samples are NaN or infinite; they count as missing"
            ));
        }
        Ok(Loaded {
            volume,
            description: self.description,
        })
    }
}

/// Dimensions x y z from as many numbers as the file has axes (1 to 3; absent axes have one sample), each from 1 to
/// [`Grid::MAX_DIM`].
pub(crate) fn checked_dims(
    sizes: &[i64],
    field: &'static str,
    offset: impl Into<Option<u64>>,
    context: &Context<'_>,
) -> Result<[usize; 3], IoError> {
    let mut dims = [1; 3];
    let legal = |size: &i64| (1..=Grid::MAX_DIM as i64).contains(size);
    if sizes.is_empty() || sizes.len() > 3 || !sizes.iter().all(legal) {
        let expected = format!("1 to 3 sizes, each from 1 to {}", Grid::MAX_DIM);
        return Err(context.field(field, join(sizes), offset, expected));
    }
    for (dim, &size) in dims.iter_mut().zip(sizes) {
        *dim = size as usize;
    }
    Ok(dims)
}

/// Number of samples of `dims` with `components` each, checked against the memory limit.
pub(crate) fn sample_count(
    dims: [usize; 3],
    components: usize,
    sample_type: SampleType,
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<usize, IoError> {
    let count = dims
        .iter()
        .try_fold(components, |product, &dim| product.checked_mul(dim));
    let bytes = count.map_or(u64::MAX, |count| sample_type.byte_count(count));
    match count {
        Some(count) if bytes <= options.max_bytes => Ok(count),
        _ => Err(context.limit(bytes, options.max_bytes)),
    }
}

/// All bytes of a file, and the options for samples beside them in memory.
pub(crate) fn read_whole(
    path: &Path,
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<(Vec<u8>, ReadOptions), IoError> {
    let mut source = Source::open(path)?;
    let length = source.at_most();
    match options.max_bytes.checked_sub(length) {
        None => Err(context.limit(length, options.max_bytes)),
        Some(left) => {
            let options = ReadOptions {
                max_bytes: left,
                ..options.clone()
            };
            Ok((source.all_bytes(context)?, options))
        }
    }
}

/// The channel to take among the named ones, and a warning if the caller did not choose it.
pub(crate) fn choose_channel(
    channels: &[String],
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<(usize, Option<String>), IoError> {
    let list = || {
        let named = channels.iter().enumerate();
        named
            .map(|(i, name)| format!("{i}: {name}"))
            .collect::<Vec<_>>()
            .join(", ")
    };
    match options.channel {
        Some(channel) if channel >= channels.len() => {
            let what = format!("channel {channel} was asked for; to choose from: {}", list());
            Err(context.unsupported(what))
        }
        Some(channel) => Ok((channel, None)),
        None if channels.len() == 1 => Ok((0, None)),
        None => Ok((0, Some(format!("channel 0 is read; to choose from: {}", list())))),
    }
}

/// The component to take from samples of `count` components; `kind` names them: "vectors", "colours".
pub(crate) fn choose_component(
    count: usize,
    kind: &str,
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<usize, IoError> {
    match options.component.or(options.channel) {
        None if count == 1 => Ok(0),
        Some(component) if component < count => Ok(component),
        Some(component) => {
            let what = format!("component {component} was asked for, the samples have {count}");
            Err(context.unsupported(what))
        }
        None => Err(context.unsupported(format!(
            "samples are {kind} of {count} components; choose one (component 0 to {})",
            count - 1
        ))),
    }
}

/// The time point to take out of `count`.
pub(crate) fn choose_time(
    count: usize,
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<usize, IoError> {
    let time = options.time.unwrap_or(0);
    if time < count {
        return Ok(time);
    }
    let what = format!("time point {time} was asked for, the file has {count}");
    Err(context.unsupported(what))
}

/// World (RAS+: x right, y anterior, z superior) from LPS (x left, y posterior, z superior), the convention of
/// DICOM, ITK and most NRRD files.
pub(crate) fn ras_from_lps() -> DAffine3 {
    DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(-1.0, -1.0, 1.0)))
}

/// Columns of the matrix from voxel to space, for 1 to 3 steps per voxel. Absent axes get a direction across the
/// present ones, of their mean length.
pub(crate) fn complete_axes(steps: &[Option<DVec3>]) -> DMat3 {
    let units = [DVec3::X, DVec3::Y, DVec3::Z];
    let known: Vec<DVec3> = steps
        .iter()
        .zip(units)
        .map(|(step, unit)| step.unwrap_or(unit))
        .collect();
    match known[..] {
        [x, y, z] => DMat3::from_cols(x, y, z),
        [x, y] => {
            let length = (x.length() * y.length()).sqrt();
            DMat3::from_cols(x, y, x.cross(y).normalize_or_zero() * length)
        }
        _ => {
            let x = known.first().copied().unwrap_or(DVec3::X);
            let (y, z) = x.normalize_or(DVec3::X).any_orthonormal_pair();
            DMat3::from_cols(x, y * x.length(), z * x.length())
        }
    }
}

/// The directions of the voxel axes in three letters: `LPS` where x runs left, y posterior and z superior. Oblique axes
/// get the letters that fit best. It is meaningful only if world space is RAS+.
pub fn axis_codes(grid: &Grid) -> String {
    const PERMUTATIONS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let axes = grid.direction();
    let fit = |order: &[usize; 3]| -> f64 { (0..3).map(|axis| axes.col(axis)[order[axis]].abs()).sum() };
    let best = PERMUTATIONS.into_iter().max_by(|a, b| fit(a).total_cmp(&fit(b)));
    let letters = [['L', 'R'], ['P', 'A'], ['I', 'S']];
    let order = best.unwrap_or([0, 1, 2]);
    let letter = |axis: usize| letters[order[axis]][usize::from(axes.col(axis)[order[axis]] > 0.0)];
    (0..3).map(letter).collect()
}

/// The unit of this name; [`LengthUnit::Unknown`] for a name without meaning, `None` for a unit that has no label.
pub(crate) fn length_unit(name: &str) -> Option<LengthUnit> {
    match name.trim().to_lowercase().as_str() {
        "mm" | "millimeter" | "millimeters" | "millimetre" | "millimetres" => Some(LengthUnit::Millimetre),
        "um" | "µm" | "μm" | "micron" | "microns" | "micrometer" | "micrometers" | "micrometre"
        | "micrometres" => Some(LengthUnit::Micrometre),
        "nm" | "nanometer" | "nanometers" | "nanometre" | "nanometres" => Some(LengthUnit::Nanometre),
        "m" | "meter" | "meters" | "metre" | "metres" => Some(LengthUnit::Metre),
        "" | "?" | "???" | "none" => Some(LengthUnit::Unknown),
        _ => None,
    }
}

fn join(numbers: &[i64]) -> String {
    numbers.iter().map(i64::to_string).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn sizes_are_positive_and_their_product_is_bounded() {
        let context = Context::new("test", Path::new("a"));
        let dims = |sizes: &[i64]| checked_dims(sizes, "sizes", 7, &context);
        assert_eq!(dims(&[4, 5]).unwrap(), [4, 5, 1]);
        for bad in [&[][..], &[0, 1, 1], &[-1, 2, 3], &[1 << 40, 1, 1], &[1, 1, 1, 1]] {
            assert!(dims(bad).is_err(), "{bad:?}");
        }
        let options = ReadOptions {
            max_bytes: 100,
            ..ReadOptions::default()
        };
        let count = |dims, components| sample_count(dims, components, SampleType::U16, &options, &context);
        assert_eq!(count([5, 5, 1], 2).unwrap(), 50);
        assert!(matches!(
            count([5, 5, 3], 1),
            Err(IoError::Limit { expected: 150, .. })
        ));
        assert!(matches!(
            count([65535; 3], usize::MAX),
            Err(IoError::Limit { .. })
        ));
    }
}
