//! Smallest and largest samples of blocks, and samples that stand for a level: found by the tasks, which leave them in
//! files that also say that a task is done; put together in arrays when a level is complete.

use std::path::{Path, PathBuf};

use splatvol_scene::chunks::block_ends;
use splatvol_scene::volume::widen;
use splatvol_scene::{ElementType, Samples, VoxelBox, with_samples};

use super::chunks::coded;
use super::files;
use super::metadata::ArrayMetadata;
use super::plan::{LevelPlan, Plan};
use super::{OmeVersion, PyramidOptions};
use crate::IoError;
use crate::volume::zarr::{own, spread};

/// Edge of the chunks of an index.
const EDGE: usize = 64;

/// What a task finds in its box.
pub(super) struct Found {
    /// Smallest and largest samples of its blocks, and of those around each; NaN where samples are missing.
    bounds: Vec<[f64; 2]>,
    /// Samples that stand for the level.
    spread: Vec<f64>,
}

/// What is found in a box; `samples` are its own and those around it.
pub(super) fn of_box(level: &LevelPlan, own: VoxelBox, (samples, of): (&Samples, VoxelBox)) -> Found {
    let spread = with_samples!(samples, data => spread::within(level.dims, own)
        .map(|(_, [x, y, z])| widen(of.row(data, [y, z])[x - of.first[0]]))
        .collect());
    Found {
        bounds: of_blocks(level, own, (samples, of)),
        spread,
    }
}

fn of_blocks(level: &LevelPlan, own: VoxelBox, (samples, of): (&Samples, VoxelBox)) -> Vec<[f64; 2]> {
    let mut found = Vec::new();
    let block = (level.block(), 1);
    with_samples!(samples, data => block_ends((data, of), own, block, |_, ends| found.push(ends)));
    found
}

/// The files that tasks leave.
pub(super) struct Done {
    folder: PathBuf,
}

impl Done {
    pub(super) fn new(folder: &Path, level: usize) -> Self {
        Self {
            folder: folder.join(level.to_string()),
        }
    }

    fn path(&self, task: usize) -> PathBuf {
        self.folder.join(task.to_string())
    }

    /// Says that a task is done.
    pub(super) fn write(&self, task: usize, found: &Found) -> Result<(), IoError> {
        let numbers = found.bounds.iter().flatten().chain(&found.spread);
        let mut bytes: Vec<u8> = numbers.flat_map(|number| number.to_le_bytes()).collect();
        let sum = crc32c::crc32c(&bytes);
        bytes.extend(sum.to_le_bytes());
        files::write(&self.path(task), &bytes)
    }

    /// What a task left, if it is done.
    pub(super) fn read(&self, task: usize, (level, own): (&LevelPlan, VoxelBox)) -> Option<Found> {
        let bytes = std::fs::read(self.path(task)).ok()?;
        let (numbers, sum) = bytes.split_last_chunk::<4>()?;
        let blocks = level.blocks_in(own).count();
        let spread = spread::within(level.dims, own).count();
        if numbers.len() != 8 * (2 * blocks + spread) || crc32c::crc32c(numbers) != u32::from_le_bytes(*sum) {
            return None;
        }
        let numbers = numbers.as_chunks::<8>().0.iter();
        let mut bounds: Vec<f64> = numbers.map(|number| f64::from_le_bytes(*number)).collect();
        let spread = bounds.split_off(2 * blocks);
        Some(Found {
            bounds: bounds.as_chunks::<2>().0.to_vec(),
            spread,
        })
    }
}

/// Writes the samples that stand for a level, all of whose tasks are done.
pub(super) fn write_spread(
    folder: &Path,
    (plan, level): (&Plan, usize),
    done: &Done,
    element: ElementType,
    options: &PyramidOptions,
) -> Result<(), IoError> {
    let of = &plan.levels[level];
    let rows = spread::count(of.dims).div_ceil(spread::ROW);
    let mut values = vec![0.0; rows * spread::ROW];
    for index in 0..plan.tasks(level) {
        let own = plan.task(level, index).own;
        let found = done.read(index, (of, own)).map(|found| found.spread);
        let places = spread::within(of.dims, own);
        for ((number, _), value) in places.zip(found.unwrap_or_default()) {
            values[number] = value;
        }
    }
    let metadata = ArrayMetadata {
        shape: &[rows, spread::ROW],
        chunk: &[rows, spread::ROW],
        shard: None,
        element,
        names: &["row", "sample"],
        attributes: own::complete(),
    };
    metadata.write(folder, options)?;
    let name = match options.version {
        OmeVersion::V05 => "c/0/0",
        OmeVersion::V04 => "0/0",
    };
    files::write(
        &folder.join(name),
        &coded(&mut of_type(element, &values), options),
    )
}

/// Writes the index of a level, all of whose tasks are done.
pub(super) fn write_index(
    folder: &Path,
    (plan, level): (&Plan, usize),
    done: &Done,
    element: ElementType,
    options: &PyramidOptions,
) -> Result<(), IoError> {
    let of = &plan.levels[level];
    let counts = of.block_counts();
    let count: usize = counts.iter().product();
    let mut ends = vec![[f64::NAN; 2]; count];
    for index in 0..plan.tasks(level) {
        let task = plan.task(level, index);
        let found = done.read(index, (of, task.own)).map(|found| found.bounds);
        for ([x, y, z], bounds) in of.blocks_in(task.own).zip(found.unwrap_or_default()) {
            ends[(z * counts[1] + y) * counts[0] + x] = bounds;
        }
    }
    let [x, y, z] = of.block();
    let edges = counts.map(|count| count.min(EDGE));
    let metadata = ArrayMetadata {
        shape: &[2, counts[2], counts[1], counts[0]],
        chunk: &[1, edges[2], edges[1], edges[0]],
        shard: None,
        element,
        names: &["end", "z", "y", "x"],
        attributes: own::bounds_of([z, y, x]),
    };
    metadata.write(folder, options)?;
    let prefix = if options.version == OmeVersion::V05 {
        "c/"
    } else {
        ""
    };
    let pieces: [usize; 3] = std::array::from_fn(|axis| counts[axis].div_ceil(edges[axis]));
    for (end, piece) in [0, 1]
        .into_iter()
        .flat_map(|end| (0..pieces.iter().product()).map(move |piece| (end, piece)))
    {
        let at = [
            piece % pieces[0],
            piece / pieces[0] % pieces[1],
            piece / (pieces[0] * pieces[1]),
        ];
        let value = |i: usize| {
            let within = [i % edges[0], i / edges[0] % edges[1], i / (edges[0] * edges[1])];
            let [x, y, z]: [usize; 3] = std::array::from_fn(|axis| at[axis] * edges[axis] + within[axis]);
            let inside = x < counts[0] && y < counts[1] && z < counts[2];
            if inside {
                ends[(z * counts[1] + y) * counts[0] + x][end]
            } else {
                0.0
            }
        };
        let values: Vec<f64> = (0..edges.iter().product()).map(value).collect();
        let mut samples = of_type(element, &values);
        let [x, y, z] = at;
        files::write(
            &folder.join(format!("{prefix}{end}/{z}/{y}/{x}")),
            &coded(&mut samples, options),
        )?;
    }
    Ok(())
}

/// Values that are all of the type.
fn of_type(element: ElementType, values: &[f64]) -> Samples {
    macro_rules! narrow {
        ($($variant:ident)*) => {
            match element {
                $(ElementType::$variant => Samples::$variant(values.iter().map(|&value| value as _).collect()),)*
            }
        };
    }
    narrow!(U8 I8 U16 I16 U32 I32 F32 F64)
}
