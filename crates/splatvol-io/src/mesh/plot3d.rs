//! PLOT3D: a grid (.xyz, .x, .g) and its solution (.q), after NASA's PLOT3D manual (TM 101067, section 8).
//!
//! The files do not record their own layout. Byte order, Fortran record marks, one grid or several, two dimensions or three, 32
//! or 64 bits and IBLANK are chosen so that the dimensions agree with the length of the file. Files of text have the same
//! numbers in the same order, and are told apart by how many there are.
//!
//! The solution holds density rho, momentum rho u, and energy per volume e; with gamma = 1.4 they give velocity u and
//! pressure `(gamma - 1) (e - rho u^2 / 2)`.

mod companion;
mod layout;
mod text;

use std::path::Path;

use glam::DVec3;
use splatvol_scene::Samples;

use super::LoadedMesh;
use super::assemble::Draft;
use crate::error::Context;
use crate::source::read_file;
use crate::volume::vtk_array::{self, ArrayHead, Association};
use crate::volume::{Description, ReadOptions};
use crate::{Endian, IoError, SampleType};
use layout::{Content, Layout};

/// Ratio of specific heats of air.
const GAMMA: f64 = 1.4;

/// The scalars and vectors of a solution, and their components.
const ARRAYS: [(&str, usize); 5] = [
    ("density", 1),
    ("momentum", 3),
    ("energy", 1),
    ("pressure", 1),
    ("velocity", 3),
];

/// True where a file of `length` bytes that begins with `start` has one of PLOT3D's layouts; nearly, if it has a customary
/// extension. Flat grids and text need an extension of PLOT3D's own; text that may be a table also needs its companion.
pub(super) fn recognises(path: &Path, start: &[u8], length: u64) -> bool {
    let is_own = companion::has_own_extension(path);
    if text::is_text(start) {
        return is_own && text::is_plausible(start, length) && companion::is_text(path);
    }
    let near = companion::is_customary(path);
    let layout = |content| match near {
        true => Layout::near(start, length, content),
        false => Layout::find(start, length, content),
    };
    let mut layouts = [Content::Grid, Content::Solution].into_iter().filter_map(layout);
    layouts.any(|layout| is_own || !layout.is_flat())
}

/// True if `grid` is a grid and `solution` a solution of its dimensions, whatever their names. Files that cannot be read are
/// neither.
pub fn is_plot3d_pair(grid: impl AsRef<Path>, solution: impl AsRef<Path>) -> bool {
    let blocks = |path: &Path, content| {
        let context = &Context::new("PLOT3D", path);
        let found = companion::is_candidate(path).then(|| load(path, content, context).ok());
        Some(found??.layout.blocks)
    };
    let grid = blocks(grid.as_ref(), Content::Grid);
    grid.is_some() && grid == blocks(solution.as_ref(), Content::Solution)
}

/// A file's numbers and their layout.
struct Loaded {
    layout: Layout,
    bytes: Vec<u8>,
    warning: Option<String>,
}

fn load(path: &Path, content: Content, context: &Context<'_>) -> Result<Loaded, IoError> {
    let bytes = read_file(path, context)?;
    if text::is_text(&bytes) {
        let (layout, bytes) = text::read(&bytes, content, context)?;
        return Ok(Loaded {
            layout,
            bytes,
            warning: None,
        });
    }
    let (layout, warning) = Layout::of(&bytes, content, context)?;
    Ok(Loaded {
        layout,
        bytes,
        warning,
    })
}

/// Reads a grid and its solution; `path` is either. The other is [`ReadOptions::solution`] or lies beside it under the
/// matching name: `comb.xyz` and `comb.q`, `combxyz.bin` and `combq.bin`, `comb_grid.bin` and `comb_q.bin`.
///
/// # Errors
/// No other file, lengths that fit no layout, dimensions that differ, or an array that is absent.
pub fn read(path: &Path, options: &ReadOptions) -> Result<LoadedMesh, IoError> {
    let context = &Context::new("PLOT3D", path);
    let (grid_path, solution_path) = companion::pair(path, options.solution.as_deref(), context)?;
    let grid_context = &Context::new("PLOT3D grid", &grid_path);
    let stored = load(&grid_path, Content::Grid, grid_context)?;
    let grid = stored.layout;
    let mut warnings: Vec<String> = Vec::new();
    warnings.extend(stored.warning.map(|text| format!("grid: {text}")));
    let mut draft = grid.draft(&stored.bytes);
    drop(stored.bytes);
    let context = &Context::new("PLOT3D solution", &solution_path);
    let Loaded {
        layout: solution,
        bytes,
        warning,
    } = load(&solution_path, Content::Solution, context)?;
    warnings.extend(warning.map(|text| format!("solution: {text}")));
    if solution.blocks != grid.blocks {
        let (found, expected) = (
            format!("{:?}", solution.blocks),
            format!("{:?}, as the grid", grid.blocks),
        );
        return Err(context.field("dimensions", found, None, expected));
    }
    let sample_type = if solution.wide {
        SampleType::F64
    } else {
        SampleType::F32
    };
    let heads: Vec<ArrayHead> = ARRAYS
        .iter()
        .map(|&(name, n)| head(name, n, sample_type))
        .collect();
    let (index, component) = vtk_array::choose_scalar(&heads, &plain_names(options), context)?;
    for block in 0..solution.blocks.len() {
        let values = solution.values(&bytes, block, index);
        draft.add_values(
            Samples::F64(values.into()),
            (heads[index].components, component),
            None,
        );
    }
    let description = Description {
        format: "PLOT3D".to_owned(),
        stored_type: solution.describe(),
        orientation: "coordinates as stored".to_owned(),
        files: vec![grid_path.clone(), solution_path.clone()],
        warnings,
        ..Description::default()
    };
    draft.finish((&heads[index], component), description, &heads, grid_context)
}

fn head(name: &str, components: usize, sample_type: SampleType) -> ArrayHead {
    ArrayHead {
        association: Association::Point,
        name: name.to_owned(),
        components,
        type_name: sample_type.name().to_owned(),
        sample_type: Some(sample_type),
        active: false,
        is_id: false,
    }
}

/// `Density`, `StagnationEnergy` and the like, as other programs call them.
fn plain_names(options: &ReadOptions) -> ReadOptions {
    let lower = |name: &String| name.to_ascii_lowercase().replace("stagnation", "");
    ReadOptions {
        array: options.array.as_ref().map(lower),
        ..options.clone()
    }
}

impl Layout {
    /// Points, blocks and blanking of a grid.
    fn draft(&self, bytes: &[u8]) -> Draft {
        let mut draft = Draft {
            single_precision: !self.wide,
            blocks: self.blocks.clone(),
            ..Draft::default()
        };
        for block in 0..self.blocks.len() {
            let (start, count) = (self.start(block, Content::Grid), self.points(block));
            let coordinate = |axis: usize, point: usize| self.real(bytes, start, axis * count + point);
            let height = |point| match self.plane {
                true => 0.0,
                false => coordinate(2, point),
            };
            let point = |point| DVec3::new(coordinate(0, point), coordinate(1, point), height(point));
            draft.positions.extend((0..count).map(point));
            if self.blanked {
                let marks = start + self.axes() * count * self.real_size();
                // 0 is a point inside a body. Others are valid: 1, walls (2), points that another grid gives
                // (negative).
                let blank = |point| self.integer(bytes, marks + 4 * point) == 0;
                draft.blanked.extend((0..count).map(blank));
            }
        }
        draft
    }

    /// Values of array `index` of [`ARRAYS`] in a block, components interleaved.
    fn values(&self, bytes: &[u8], block: usize, index: usize) -> Vec<f64> {
        let (start, count) = (self.start(block, Content::Solution), self.points(block));
        let stored = |variable: usize, point: usize| self.real(bytes, start, variable * count + point);
        let energy = self.variables() - 1;
        let across = |point| match self.plane {
            true => 0.0,
            false => stored(3, point),
        };
        let momentum = |point| DVec3::new(stored(1, point), stored(2, point), across(point));
        let pressure = |point| {
            let kinetic = 0.5 * momentum(point).length_squared() / stored(0, point);
            (GAMMA - 1.0) * (stored(energy, point) - kinetic)
        };
        let velocity = |point| (momentum(point) / stored(0, point)).to_array();
        match ARRAYS[index].0 {
            "density" => (0..count).map(|point| stored(0, point)).collect(),
            "energy" => (0..count).map(|point| stored(energy, point)).collect(),
            "pressure" => (0..count).map(pressure).collect(),
            "velocity" => (0..count).flat_map(velocity).collect(),
            _ => (0..count).flat_map(|point| momentum(point).to_array()).collect(),
        }
    }

    fn describe(&self) -> String {
        let grids = self.blocks.len();
        if self.text {
            return format!("text, {grids} grid(s)");
        }
        let order = match self.endian {
            Endian::Little => "little-endian",
            Endian::Big => "big-endian",
        };
        let records = if self.records { ", Fortran records" } else { "" };
        let bits = 8 * self.real_size();
        format!("f{bits}, {order}{records}, {grids} grid(s)")
    }
}
