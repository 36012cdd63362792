//! `POLYDATA` of legacy VTK, and `UNSTRUCTURED_GRID` of flat cells.

use std::path::Path;

use super::Reader;
use crate::IoError;
use crate::error::Context;
use crate::mesh::assemble::StoredCells;
use crate::mesh::assemble::to_f64;
use crate::mesh::poly::{self, Lists, Look, PolyData, flat};
use crate::source::read_file;
use crate::volume::ReadOptions;
use crate::volume::legacy_vtk::attributes::{Attributes, Scan};
use crate::volume::legacy_vtk::cursor::Cursor;
use crate::volume::legacy_vtk::header;
use crate::volume::vtk_array::TupleCounts;

/// True for an unstructured grid of flat cells. What cannot be read is none: the reader of meshes says why.
pub(crate) fn has_flat_cells(path: &Path) -> bool {
    let context = &Context::new("legacy VTK", path);
    let types = || {
        let bytes = read_file(path, context).ok()?;
        let mut cursor = Cursor::new(&bytes, context);
        let (_, coding) = header(&mut cursor).ok()?;
        let mut reader = Reader {
            cursor,
            bytes: &bytes,
            coding,
            options: &ReadOptions::default(),
            context,
        };
        reader.sections().ok()?.types
    };
    types().is_some_and(|types| flat::are_surface(&types))
}

/// The polygons of a .vtk file, and a warning about attributes that cannot be read.
pub(crate) fn read(path: &Path, options: &ReadOptions) -> Result<(PolyData, Vec<String>), IoError> {
    let context = &Context::new("legacy VTK", path);
    let bytes = read_file(path, context)?;
    let mut cursor = Cursor::new(&bytes, context);
    let (version, coding) = header(&mut cursor)?;
    let mut reader = Reader {
        cursor,
        bytes: &bytes,
        coding,
        options,
        context,
    };
    let found = reader.sections()?;
    let points = found
        .points
        .ok_or_else(|| context.field("POINTS", "", None, "this section, which is missing"))?;
    let points = to_f64(&points);
    let count = points.len() / 3;
    let mut cells = found.thin;
    let mut lists = |stored: Option<(Vec<u64>, Vec<u64>)>| {
        let mut lists = Lists::default();
        if let Some((ends, connectivity)) = stored {
            lists.add((&ends, &connectivity), (0, count), context)?;
        }
        cells += lists.len() as u64;
        Ok::<_, IoError>(lists)
    };
    let mut poly = PolyData {
        polygons: lists(found.polygons)?,
        strips: lists(found.strips)?,
        points,
        thin: found.thin,
        format: format!("legacy VTK {version}"),
        ..PolyData::default()
    };
    // The cell of every polygon, in the order of the file: vertices and lines, polygons, strips.
    let thin = found.thin as usize;
    let mut cell_of: Vec<usize> = (thin..thin + poly.polygons.len()).collect();
    if let (Some((ends, connectivity)), Some(types)) = (found.connectivity, found.types) {
        if types.len() != ends.len() {
            return Err(context.field("CELL_TYPES", types.len(), None, format!("{}", ends.len())));
        }
        cells += types.len() as u64;
        let stored = StoredCells {
            types,
            ends,
            connectivity,
        };
        (cell_of, poly.thin) = flat::add(&stored, (0, count), &mut poly.polygons, context)?;
    }
    let mut scan = Scan {
        cursor: reader.cursor,
        coding,
        counts: TupleCounts {
            points: Some(count as u64),
            cells: Some(cells),
        },
        wanted: None,
        stops_early: false,
        found: Attributes::default(),
    };
    let end = scan.run();
    let Attributes { heads, arrays } = scan.found;
    for wanted in [Look::Normals, Look::Colors] {
        let found = heads.iter().position(|head| Look::of(head) == Some(wanted));
        if let Some(index) = found {
            let (samples, _) = reader.array(&heads[index], &arrays[index], count as u64)?;
            poly.add_look(wanted, &heads[index], &samples);
        }
    }
    if let Some(choice) = poly::choose(&heads, options, context)?
        && let Some(index) = choice.position(&heads)
    {
        let tuples = if choice.is_of_points() {
            count as u64
        } else {
            cells
        };
        let (samples, _) = reader.array(&heads[index], &arrays[index], tuples)?;
        let values = choice.pick(samples);
        let mut scalars = choice.scalars();
        match choice.is_of_points() {
            true => scalars.points = values,
            false => {
                scalars.polygons.extend(cell_of.iter().map(|&cell| values[cell]));
                scalars
                    .strips
                    .extend(values[cells as usize - poly.strips.len()..].iter());
            }
        }
        poly.scalars = Some(scalars);
    }
    let warnings = end
        .err()
        .map(|error| format!("only the first arrays could be found: {error}"));
    Ok((poly.complete(), warnings.into_iter().collect()))
}
