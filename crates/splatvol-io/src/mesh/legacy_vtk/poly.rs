//! `POLYDATA` of legacy VTK.

use std::path::Path;

use super::Reader;
use crate::IoError;
use crate::error::Context;
use crate::mesh::assemble::to_f64;
use crate::mesh::poly::{Lists, Look, PolyData};
use crate::source::read_file;
use crate::volume::ReadOptions;
use crate::volume::legacy_vtk::attributes::{Attributes, Scan};
use crate::volume::legacy_vtk::cursor::Cursor;
use crate::volume::legacy_vtk::header;
use crate::volume::vtk_array::TupleCounts;

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
    let warnings = end
        .err()
        .map(|error| format!("only the first arrays could be found: {error}"));
    Ok((poly.complete(), warnings.into_iter().collect()))
}
