//! Common code of the mesh readers: builds a validated [`Mesh`] from points, cells and an array.

use glam::{DAffine3, DMat3, DVec3};
use splatvol_scene::{Association, CellKind, Cells, Mesh, MeshField, Samples, Topology, with_samples};

use super::LoadedMesh;
use crate::error::Context;
use crate::volume::vtk_array::{self, ArrayHead, Component};
use crate::volume::{Description, ReadOptions, complete_axes};
use crate::{IoError, SampleType};

/// A mesh under construction, from one piece of the file after the other.
#[derive(Debug, Default)]
pub(super) struct Draft {
    pub(super) positions: Vec<DVec3>,
    /// False where the file's coordinates need more than 32 bits.
    pub(super) single_precision: bool,
    pub(super) blocks: Vec<[usize; 3]>,
    pub(super) cells: Cells,
    pub(super) blanked: Vec<bool>,
    pub(super) values: Vec<f32>,
    /// Cells that list too many points.
    pub(super) cut: usize,
    /// Cells of each VTK type that were left out.
    pub(super) left_out: Vec<(u8, usize)>,
}

/// Cells of one piece, as VTK's two file formats store them.
pub(crate) struct StoredCells {
    pub(crate) types: Vec<u8>,
    /// End of each cell's points in the connectivity.
    pub(crate) ends: Vec<u64>,
    pub(crate) connectivity: Vec<u64>,
}

impl Draft {
    /// Adds points of three coordinates each.
    pub(super) fn add_points(&mut self, coordinates: &Samples) {
        self.single_precision = !matches!(coordinates, Samples::F64(_) | Samples::I32(_) | Samples::U32(_));
        let numbers = to_f64(coordinates);
        self.positions
            .extend(numbers.chunks_exact(3).map(DVec3::from_slice));
    }

    /// Adds a block of points at the products of three axes.
    pub(super) fn add_rectilinear(&mut self, axes: [&Samples; 3]) {
        let [x, y, z] = axes.map(to_f64);
        self.single_precision = axes.iter().all(|axis| !matches!(axis, Samples::F64(_)));
        self.blocks.push([x.len(), y.len(), z.len()]);
        for &z in &z {
            for &y in &y {
                self.positions.extend(x.iter().map(|&x| DVec3::new(x, y, z)));
            }
        }
    }

    /// Adds the cells of a piece whose points begin at `first`; returns the indices of the cells kept: the solids.
    pub(super) fn add_cells(
        &mut self,
        stored: &StoredCells,
        first: usize,
        context: &Context<'_>,
    ) -> Result<Vec<usize>, IoError> {
        let points = self.positions.len() - first;
        let mut kept = Vec::new();
        let (mut begin, mut indices) = (0u64, Vec::new());
        for (cell, (&code, &end)) in stored.types.iter().zip(&stored.ends).enumerate() {
            let range = usize::try_from(begin).ok().zip(usize::try_from(end).ok());
            let list = range
                .and_then(|(begin, end)| stored.connectivity.get(begin..end))
                .ok_or_else(|| {
                    let expected = format!("{begin} to {}", stored.connectivity.len());
                    context.field(format!("offset of cell {cell}"), end, None, expected)
                })?;
            begin = end;
            let Some(kind) = CellKind::from_vtk(code) else {
                self.leave_out(code);
                continue;
            };
            // As in VTK: the corners come first, and the rest is not used.
            let used = list.get(..kind.point_count()).unwrap_or(list);
            self.cut += usize::from(used.len() < list.len());
            indices.clear();
            for &index in used {
                let place = usize::try_from(index).ok().filter(|&index| index < points);
                let place = place.and_then(|index| u32::try_from(first + index).ok());
                indices.push(place.ok_or_else(|| {
                    context.field(
                        format!("point of cell {cell}"),
                        index,
                        None,
                        format!("below {points}"),
                    )
                })?);
            }
            self.cells
                .push(kind, &indices)
                .map_err(|error| context.scene(error))?;
            kept.push(cell);
        }
        Ok(kept)
    }

    fn leave_out(&mut self, code: u8) {
        match self.left_out.iter_mut().find(|(other, _)| *other == code) {
            Some((_, count)) => *count += 1,
            None => self.left_out.push((code, 1)),
        }
    }

    /// Adds the values of one component; for cells only those in `kept`, if there is such a list.
    pub(super) fn add_values(
        &mut self,
        samples: Samples,
        (components, component): (usize, Component),
        kept: Option<&[usize]>,
    ) {
        let picked = vtk_array::pick(samples, components, component);
        let values = to_f64(&picked);
        let single = |value: f64| match (value as f32).is_finite() {
            true => value as f32,
            false => f32::NAN,
        };
        match kept {
            None => self.values.extend(values.into_iter().map(single)),
            Some(kept) => self.values.extend(kept.iter().map(|&cell| single(values[cell]))),
        }
    }

    /// The mesh. `choice` is the array and its component, `heads` are all arrays of the file.
    pub(super) fn finish(
        mut self,
        (head, component): (&ArrayHead, Component),
        mut description: Description,
        heads: &[ArrayHead],
        context: &Context<'_>,
    ) -> Result<LoadedMesh, IoError> {
        description.warnings.extend(self.warnings());
        if self.has_flat_blocks() {
            self.thicken(head.association == vtk_array::Association::Point);
            description
                .orientation
                .push_str("; flat grids as layers one cell thick");
        }
        let world_from_local = self.frame(context)?;
        let local_from_world = world_from_local.inverse();
        let local = |p: &DVec3| local_from_world.transform_point3(*p).as_vec3().to_array();
        let positions = self.positions.iter().map(local).collect();
        let field = MeshField {
            name: name(head, component),
            association: match head.association {
                vtk_array::Association::Point => Association::Point,
                vtk_array::Association::Cell => Association::Cell,
            },
            values: std::mem::take(&mut self.values),
        };
        let topology = match self.blocks.is_empty() {
            true => Topology::Unstructured(self.cells),
            false => Topology::Structured(self.blocks),
        };
        let mesh = Mesh::new(positions, topology, self.blanked, field, world_from_local)
            .map_err(|error| context.scene(error))?;
        Ok(LoadedMesh {
            mesh,
            description,
            arrays: heads.iter().map(ArrayHead::describe).collect(),
            others: others(heads, head),
        })
    }

    /// True where a block has one sample along an axis, and the blocks have as many samples as there are positions.
    fn has_flat_blocks(&self) -> bool {
        let product = |dims: &[usize; 3]| dims.iter().try_fold(1usize, |n, &size| n.checked_mul(size));
        let mut sizes = self.blocks.iter().map(product);
        let total = sizes.try_fold(0usize, |sum, size| sum.checked_add(size?));
        total == Some(self.positions.len())
            && self.blocks.iter().flatten().all(|&size| size > 0)
            && self.blocks.iter().flatten().any(|&size| size == 1)
    }

    /// Makes blocks with one sample along an axis a layer of cells, as thick as the samples lie apart along the others.
    fn thicken(&mut self, values_at_points: bool) {
        let blocks = std::mem::take(&mut self.blocks);
        let positions = std::mem::take(&mut self.positions);
        let blanked = std::mem::take(&mut self.blanked);
        let values = std::mem::take(&mut self.values);
        let mut first = 0;
        for dims in blocks {
            let thick = dims.map(|size| size.max(2));
            let place = |at: [usize; 3]| first + at[0] + dims[0] * (at[1] + dims[1] * at[2]);
            for index in 0..thick.iter().product() {
                let at = [
                    index % thick[0],
                    index / thick[0] % thick[1],
                    index / (thick[0] * thick[1]),
                ];
                let source = std::array::from_fn(|axis| at[axis].min(dims[axis] - 1));
                let frame = local_axes(&positions, dims, source, place);
                let offset = (0..3).filter(|&axis| dims[axis] == 1);
                let offset = offset.map(|axis| frame[axis] * (at[axis] as f64 - 0.5));
                self.positions
                    .push(positions[place(source)] + offset.sum::<DVec3>());
                self.blanked.extend(blanked.get(place(source)));
                if values_at_points {
                    self.values.extend(values.get(place(source)));
                }
            }
            first += dims.iter().product::<usize>();
            self.blocks.push(thick);
        }
        if !values_at_points {
            self.values = values;
        }
    }

    fn warnings(&self) -> Vec<String> {
        let mut warnings: Vec<String> = self
            .left_out
            .iter()
            .map(|(code, count)| {
                format!("{count} cells of VTK type {code} are no solid that is read; left out")
            })
            .collect();
        if self.cut > 0 {
            let cells = self.cut;
            warnings.push(format!(
                "{cells} cells list more points than their kind has; the first ones are used"
            ));
        }
        let missing = self.values.iter().filter(|value| value.is_nan()).count();
        if missing > 0 {
            warnings.push(format!(
                "{missing} values are missing: NaN, infinite, or beyond 32-bit floats"
            ));
        }
        warnings
    }

    /// Local space: the world, but centred where coordinates need more than 32 bits, and scaled by a power of two where
    /// squares of lengths would not fit in 32 bits.
    fn frame(&self, context: &Context<'_>) -> Result<DAffine3, IoError> {
        if let Some(position) = self.positions.iter().find(|p| !p.is_finite()) {
            return Err(context.field("points", position, None, "finite coordinates"));
        }
        let first = self.positions.first().copied().unwrap_or_default();
        let (low, high) = self
            .positions
            .iter()
            .fold((first, first), |(low, high), &p| (low.min(p), high.max(p)));
        let size = (high - low).max_element();
        let scale = match size {
            1e-4..1e6 | 0.0 => 1.0,
            _ => size.log2().floor().exp2(),
        };
        let origin = match self.single_precision && scale == 1.0 {
            true => DVec3::ZERO,
            false => 0.5 * low + 0.5 * high,
        };
        Ok(DAffine3::from_scale_rotation_translation(
            DVec3::splat(scale),
            glam::DQuat::IDENTITY,
            origin,
        ))
    }
}

/// Steps along the axes at a sample of a block; along flat axes, one across the others.
fn local_axes(
    positions: &[DVec3],
    dims: [usize; 3],
    at: [usize; 3],
    place: impl Fn([usize; 3]) -> usize,
) -> [DVec3; 3] {
    let step = |axis: usize| {
        let (mut low, mut high) = (at, at);
        low[axis] = at[axis].saturating_sub(1);
        high[axis] = (at[axis] + 1).min(dims[axis] - 1);
        let count = (high[axis] - low[axis]) as f64;
        (positions[place(high)] - positions[place(low)]) / count
    };
    // The known axes first, in their cyclic order, so that the new one completes a right-handed frame.
    let flat = (0..3).find(|&axis| dims[axis] == 1).unwrap_or(0);
    let others = [(flat + 1) % 3, (flat + 2) % 3];
    let mut axes = [DVec3::ZERO; 3];
    let frame = match others.map(|axis| dims[axis] > 1) {
        [true, true] => complete_axes(&[Some(step(others[0])), Some(step(others[1]))]),
        [false, false] => DMat3::IDENTITY,
        [known, _] => {
            let (known, other) = if known {
                (others[0], others[1])
            } else {
                (others[1], others[0])
            };
            let frame = complete_axes(&[Some(step(known))]);
            (axes[known], axes[other], axes[flat]) = (frame.x_axis, frame.y_axis, frame.z_axis);
            return axes;
        }
    };
    (axes[others[0]], axes[others[1]], axes[flat]) = (frame.x_axis, frame.y_axis, frame.z_axis);
    axes
}

fn name(head: &ArrayHead, component: Component) -> String {
    match component {
        Component::Index(_) if head.components == 1 => head.name.clone(),
        Component::Index(index) => format!("{}:{index}", head.name),
        Component::Magnitude => format!("{}:magnitude", head.name),
    }
}

/// Names of the arrays that could be shown instead of `chosen`: scalars first, of the points before those of the cells.
fn others(heads: &[ArrayHead], chosen: &ArrayHead) -> Vec<String> {
    let mut others: Vec<&ArrayHead> = heads
        .iter()
        .filter(|head| head.sample_type.is_some() && !head.is_id && head.name != chosen.name)
        .collect();
    others.sort_by_key(|head| {
        (
            head.components > 1,
            head.association == vtk_array::Association::Cell,
        )
    });
    others.into_iter().map(|head| head.name.clone()).collect()
}

/// The samples as f64.
pub(super) fn to_f64(samples: &Samples) -> Vec<f64> {
    fn widened<T: Copy + Into<f64>>(data: &[T]) -> Vec<f64> {
        data.iter().map(|&value| value.into()).collect()
    }
    with_samples!(samples, data => widened(data))
}

/// `tuples` x `components` as a number of samples within the memory allowed.
pub(super) fn count(
    tuples: u64,
    components: usize,
    sample_type: SampleType,
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<usize, IoError> {
    let bytes = tuples
        .checked_mul(components as u64)
        .and_then(|count| count.checked_mul(sample_type.size() as u64));
    match bytes.filter(|&bytes| bytes <= options.max_bytes) {
        // A usize can count them, or the file could not be in memory.
        Some(bytes) => Ok((bytes / sample_type.size() as u64) as usize),
        None => Err(context.limit(bytes.unwrap_or(u64::MAX), options.max_bytes)),
    }
}

/// Refuses numbers that are not counts or indices.
pub(super) fn to_indices(samples: &Samples, field: &str, context: &Context<'_>) -> Result<Vec<u64>, IoError> {
    let whole = |value: f64| value >= 0.0 && value.fract() == 0.0 && value < 9e15;
    let numbers = to_f64(samples);
    match numbers.iter().find(|&&value| !whole(value)) {
        Some(value) => Err(context.field(field, value, None, "whole numbers from 0 on")),
        None => Ok(numbers.into_iter().map(|value| value as u64).collect()),
    }
}
