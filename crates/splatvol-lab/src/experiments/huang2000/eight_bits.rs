//! A minimal splatter whose buffers have 8 bits, as the paper's for pre-classified splatting (section 5.1). It shows
//! the effect of rounding after every splat and every sheet.
//!
//! Grey voxels of a cube, sheets a voxel thick perpendicular to an orthographic view. A splat adds `a w` and `a g w` to
//! opacity and colour of a sheet, w being its section's line integral from a table. A sheet goes behind the picture:
//! `C += (1 - A) c`.

use glam::{DMat3, DVec2, DVec3};
use splatvol::radial::{FootprintTable, RadialKernel, TableSettings};

use super::tables::KERNEL;
use crate::LabError;

/// Footprint look-up.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lookup {
    pub table: TableSettings,
    /// Cells per pixel and axis to whose centres splats are moved; `None` moves none.
    pub cells: Option<f64>,
}

/// The cube and its view.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cube {
    /// Voxels along an edge.
    pub voxels: usize,
    /// Towards the viewer.
    pub towards_viewer: DVec3,
    /// Pixels per voxel.
    pub scale: f64,
    pub opacity: f64,
    pub grey: f64,
}

impl Cube {
    fn edge(&self) -> usize {
        // The diagonal and a kernel on both sides.
        ((self.voxels as f64 * 3.0_f64.sqrt() + 6.0) * self.scale).ceil() as usize
    }

    /// Voxels as x and y in pixels and depth in voxels, by depth.
    fn projected(&self) -> Vec<DVec3> {
        let forward = -self.towards_viewer.normalize();
        let right = forward.cross(DVec3::Z).normalize();
        let camera = DMat3::from_cols(right, forward.cross(right), forward).transpose();
        let last = (self.voxels - 1) as f64;
        let middle = 0.5 * self.edge() as f64;
        let n = self.voxels;
        let project = |index: usize| {
            let voxel = [index % n, index / n % n, index / (n * n)].map(|i| i as f64 - 0.5 * last);
            let seen = camera * DVec3::from_array(voxel);
            DVec3::new(seen.x * self.scale + middle, seen.y * self.scale + middle, seen.z)
        };
        let mut all: Vec<DVec3> = (0..n * n * n).map(project).collect();
        all.sort_by(|a, b| a.z.total_cmp(&b.z));
        all
    }
}

/// Rounding of numbers in buffers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Rounding {
    /// Without rounding.
    None,
    /// Sums to the nearest of 255 levels.
    Nearest,
    /// Each addend is truncated to whole levels, as by shifting integers.
    Down,
}

/// A picture of opacity and colour.
struct Buffer {
    pixels: Vec<DVec2>,
    rounding: Rounding,
}

impl Buffer {
    fn new(count: usize, rounding: Rounding) -> Self {
        Self {
            pixels: vec![DVec2::ZERO; count],
            rounding,
        }
    }

    fn add(&mut self, at: usize, more: DVec2) {
        let before = self.pixels[at];
        let sum = match self.rounding {
            Rounding::None => before + more,
            Rounding::Nearest => (255.0 * (before + more)).round() / 255.0,
            Rounding::Down => before + (255.0 * more).floor() / 255.0,
        };
        self.pixels[at] = sum.min(DVec2::ONE);
    }
}

/// Opacity and colour of every pixel, by buffers of this kind.
pub(super) fn render(cube: &Cube, lookup: Lookup, rounding: Rounding) -> Result<Vec<DVec2>, LabError> {
    let table = FootprintTable::new(KERNEL, lookup.table)?;
    let support = RadialKernel::new(KERNEL).support();
    let edge = cube.edge();
    let voxels = cube.projected();
    let depth = |index: Option<&DVec3>| index.map_or(0.0, |voxel| voxel.z);
    let first = (depth(voxels.first()) - support).floor() as i64;
    let last = (depth(voxels.last()) + support).ceil() as i64;
    let mut picture = Buffer::new(edge * edge, rounding);
    for sheet in first..last {
        let near = sheet as f64;
        let begin = voxels.partition_point(|voxel| voxel.z <= near - support);
        let end = voxels.partition_point(|voxel| voxel.z < near + 1.0 + support);
        let mut buffer = Buffer::new(edge * edge, rounding);
        for voxel in &voxels[begin..end] {
            let depths = [near, near + 1.0].map(|depth| ((depth - voxel.z) / support) as f32);
            splat(cube, (&table, lookup.cells), (*voxel, depths), &mut buffer);
        }
        for (at, sheet) in buffer.pixels.iter().enumerate() {
            let through = 1.0 - picture.pixels[at].x;
            picture.add(at, *sheet * through);
        }
    }
    Ok(picture.pixels)
}

/// Adds a section to a sheet.
fn splat(
    cube: &Cube,
    (table, cells): (&FootprintTable, Option<f64>),
    (voxel, [front, back]): (DVec3, [f32; 2]),
    buffer: &mut Buffer,
) {
    let edge = cube.edge();
    let snap = |at: f64| cells.map_or(at, |cells| ((at * cells).floor() + 0.5) / cells);
    let centre = DVec2::new(snap(voxel.x), snap(voxel.y));
    let radius = RadialKernel::new(KERNEL).support() * cube.scale;
    let section = table.section(front, back);
    let pixels = |centre: f64| {
        let low = (centre - radius - 0.5).ceil().max(0.0) as usize;
        let high = (centre + radius - 0.5).floor().min(edge as f64 - 1.0) as usize;
        low..=high
    };
    for y in pixels(centre.y) {
        for x in pixels(centre.x) {
            let offset = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) - centre;
            let weight = f64::from(section.at((offset.length_squared() / (radius * radius)) as f32));
            let opacity = cube.opacity * weight;
            buffer.add(y * edge + x, DVec2::new(opacity, opacity * cube.grey));
        }
    }
}

/// Mean and largest difference of the colour in 8-bit levels, over pixels that either picture touches.
pub(super) fn difference(a: &[DVec2], b: &[DVec2]) -> [f64; 2] {
    let pairs = a.iter().zip(b).filter(|(a, b)| a.x > 0.0 || b.x > 0.0);
    let differences = pairs.map(|(a, b)| 255.0 * (a.y - b.y).abs());
    let (count, sum, largest) = differences.fold((0_usize, 0.0, 0.0_f64), |(count, sum, largest), d| {
        (count + 1, sum + d, largest.max(d))
    });
    [sum / count.max(1) as f64, largest]
}
