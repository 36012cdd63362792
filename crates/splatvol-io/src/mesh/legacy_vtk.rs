//! Legacy VTK files (.vtk) of rectilinear, structured and unstructured grids, after "VTK file formats" (versions 1.0 to
//! 5.1). Cells come as counts and indices up to version 4.2, as offsets and connectivity from 5.0 on.

mod poly;

use std::path::Path;

use splatvol_scene::Samples;

use super::LoadedMesh;
use super::assemble::{Draft, StoredCells, count, to_indices};
use crate::error::Context;
use crate::files;
use crate::source::read_file;
use crate::volume::legacy_vtk::attributes::{self, Array, Attributes, Coding, ElementType, Scan};
use crate::volume::legacy_vtk::cursor::Cursor;
use crate::volume::legacy_vtk::{decode, header};
use crate::volume::vtk_array::{self, ArrayHead, TupleCounts};
use crate::volume::{Description, ReadOptions};
use crate::{IoError, SampleType};

pub(crate) use poly::{has_flat_cells, read as read_poly};

/// Reads a .vtk file.
///
/// # Errors
/// A malformed header, another data set, geometry that contradicts itself, an array that is absent, or too few data.
pub fn read(path: &Path, options: &ReadOptions) -> Result<LoadedMesh, IoError> {
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
    let geometry = reader.geometry()?;
    let mut scan = Scan {
        cursor: reader.cursor,
        coding,
        counts: TupleCounts {
            points: Some(geometry.draft.positions.len() as u64),
            cells: Some(geometry.cell_count()),
        },
        wanted: options.array.as_deref(),
        stops_early: false,
        found: Attributes::default(),
    };
    let end = scan.run();
    let Attributes { heads, arrays } = scan.found;
    let (index, component) = match (vtk_array::choose_scalar(&heads, options, context), &end) {
        (Err(_), Err(_)) => return Err(end.err().unwrap_or_else(|| context.unsupported("no attributes"))),
        (choice, _) => choice?,
    };
    let head = &heads[index];
    let mut warnings: Vec<String> = Vec::new();
    if let Err(error) = end {
        warnings.push(format!("only the first arrays could be found: {error}"));
    }
    let (samples, warning) = reader.array(head, &arrays[index], geometry.tuples(head))?;
    warnings.extend(warning);
    let Geometry { mut draft, kept, .. } = geometry;
    let kept = kept.filter(|_| head.association == vtk_array::Association::Cell);
    draft.add_values(samples, (head.components, component), kept.as_deref());
    let coding_name = match coding {
        Coding::Ascii => "ascii",
        Coding::Binary => "big-endian",
    };
    let description = Description {
        format: format!("legacy VTK {version}"),
        stored_type: format!("{}, {coding_name}", head.type_name),
        orientation: "coordinates as stored".to_owned(),
        files: vec![path.to_owned()],
        warnings,
        ..Description::default()
    };
    draft.finish((head, component), description, &heads, context)
}

/// Geometry section of a file, before the attributes.
struct Geometry {
    draft: Draft,
    /// Cells that are kept, where any may have been left out.
    kept: Option<Vec<usize>>,
    /// Cells that the file holds.
    cells: u64,
}

impl Geometry {
    fn cell_count(&self) -> u64 {
        self.cells
    }

    fn tuples(&self, head: &ArrayHead) -> u64 {
        match head.association {
            vtk_array::Association::Point => self.draft.positions.len() as u64,
            vtk_array::Association::Cell => self.cells,
        }
    }
}

struct Reader<'a> {
    cursor: Cursor<'a>,
    bytes: &'a [u8],
    coding: Coding,
    options: &'a ReadOptions,
    context: &'a Context<'a>,
}

/// Sections found so far.
#[derive(Default)]
struct Sections {
    data_set: String,
    dims: Option<[usize; 3]>,
    points: Option<Samples>,
    axes: [Option<Samples>; 3],
    connectivity: Option<(Vec<u64>, Vec<u64>)>,
    types: Option<Vec<u8>>,
    /// Those of polygonal data: ends and connectivity.
    polygons: Option<(Vec<u64>, Vec<u64>)>,
    strips: Option<(Vec<u64>, Vec<u64>)>,
    /// Vertices and lines of polygonal data.
    thin: u64,
}

impl Reader<'_> {
    fn geometry(&mut self) -> Result<Geometry, IoError> {
        self.sections()?.finish(self.context)
    }

    /// Everything before the attributes.
    fn sections(&mut self) -> Result<Sections, IoError> {
        let mut found = Sections::default();
        loop {
            self.cursor.skip_blanks();
            let start = self.cursor;
            let Some(keyword) = self.cursor.word() else { break };
            match keyword.to_ascii_uppercase().as_str() {
                "DATASET" => found.data_set = self.cursor.word().unwrap_or_default().to_ascii_uppercase(),
                "DIMENSIONS" => found.dims = Some(self.cursor.numbers("DIMENSIONS")?),
                "POINTS" => found.points = Some(self.numbers("POINTS", 3)?),
                "X_COORDINATES" => found.axes[0] = Some(self.numbers("X_COORDINATES", 1)?),
                "Y_COORDINATES" => found.axes[1] = Some(self.numbers("Y_COORDINATES", 1)?),
                "Z_COORDINATES" => found.axes[2] = Some(self.numbers("Z_COORDINATES", 1)?),
                "CELLS" => found.connectivity = Some(self.cells()?),
                "POLYGONS" => found.polygons = Some(self.cells()?),
                "TRIANGLE_STRIPS" => found.strips = Some(self.cells()?),
                "VERTICES" | "LINES" => found.thin += self.cells()?.0.len() as u64,
                "CELL_TYPES" => {
                    let types = self.counted("CELL_TYPES", "int", 1)?;
                    found.types = Some(
                        types
                            .iter()
                            .map(|&code| u8::try_from(code).unwrap_or(0))
                            .collect(),
                    );
                }
                "METADATA" => self.cursor.skip_metadata()?,
                "FIELD" => {
                    self.cursor.word();
                    let count = self.cursor.number("FIELD")?;
                    attributes::skip_field(&mut self.cursor, self.coding, count)?;
                }
                "POINT_DATA" | "CELL_DATA" => {
                    self.cursor = start;
                    break;
                }
                _ => {
                    return Err(start.error("keyword", &keyword, "a section of the data set, or POINT_DATA"));
                }
            }
        }
        Ok(found)
    }

    /// The numbers of a section: `count type` on its line, then the data.
    fn numbers(&mut self, field: &'static str, components: usize) -> Result<Samples, IoError> {
        let tuples = self.cursor.number(field)?;
        let start = self.cursor;
        let type_name = self.cursor.line(field)?;
        let element = ElementType::from_name(&type_name);
        if element.sample_type().is_none() || type_name.is_empty() {
            return Err(start.error(field, &type_name, "a numeric type"));
        }
        self.data(element, tuples, components)
    }

    /// Whole numbers of a type that the line does not name.
    fn counted(
        &mut self,
        field: &'static str,
        type_name: &str,
        components: usize,
    ) -> Result<Vec<u64>, IoError> {
        let tuples = self.cursor.number(field)?;
        self.cursor.line(field)?;
        let samples = self.data(ElementType::from_name(type_name), tuples, components)?;
        to_indices(&samples, field, self.context)
    }

    fn data(&mut self, element: ElementType, tuples: u64, components: usize) -> Result<Samples, IoError> {
        let sample_type = element.sample_type().unwrap_or(SampleType::U8);
        let total = count(tuples, components, sample_type, self.options, self.context)?;
        let array = Array {
            element,
            start: self.cursor.position(),
        };
        let (samples, _) = decode(
            &array,
            self.bytes,
            (sample_type, total),
            self.coding,
            self.context,
        )?;
        match (self.coding, element) {
            (Coding::Ascii, _) => self.cursor.skip_words(total as u64)?,
            (Coding::Binary, ElementType::Bit) => self.cursor.skip_bytes(total.div_ceil(8) as u64)?,
            (Coding::Binary, _) => self.cursor.skip_bytes(sample_type.byte_count(total))?,
        }
        Ok(samples)
    }

    /// Ends and connectivity of the cells.
    fn cells(&mut self) -> Result<(Vec<u64>, Vec<u64>), IoError> {
        let [first, second] = self.cursor.numbers::<u64, 2>("CELLS")?;
        self.cursor.line("CELLS")?;
        let mut ahead = self.cursor;
        ahead.skip_blanks();
        if ahead.rest().len() >= 7 && ahead.rest()[..7].eq_ignore_ascii_case(b"OFFSETS") {
            let mut offsets = self.named("OFFSETS", first)?;
            let connectivity = self.named("CONNECTIVITY", second)?;
            if offsets.first() != Some(&0) {
                let found = offsets.first().copied().unwrap_or_default();
                return Err(self
                    .cursor
                    .error("OFFSETS", &found.to_string(), "0 as the first offset"));
            }
            offsets.remove(0);
            return Ok((offsets, connectivity));
        }
        let list = self.data(ElementType::Number(SampleType::I32), second, 1)?;
        let list = to_indices(&list, "CELLS", self.context)?;
        let (mut ends, mut connectivity, mut rest) = (Vec::new(), Vec::new(), list.as_slice());
        while let Some((&length, after)) = rest.split_first() {
            let points = usize::try_from(length)
                .ok()
                .and_then(|length| after.split_at_checked(length));
            let (points, after) = points.ok_or_else(|| {
                let expected = format!("at most {} points", after.len());
                self.cursor
                    .error(&format!("cell {}", ends.len()), &length.to_string(), expected)
            })?;
            connectivity.extend_from_slice(points);
            ends.push(connectivity.len() as u64);
            rest = after;
        }
        if ends.len() as u64 != first {
            return Err(self
                .cursor
                .error("CELLS", &first.to_string(), format!("{}, as listed", ends.len())));
        }
        Ok((ends, connectivity))
    }

    /// `OFFSETS type` or `CONNECTIVITY type` and its numbers.
    fn named(&mut self, field: &'static str, length: u64) -> Result<Vec<u64>, IoError> {
        let start = self.cursor;
        let word = self.cursor.word().unwrap_or_default();
        if !word.eq_ignore_ascii_case(field) {
            return Err(start.error(field, &word, "this section"));
        }
        let type_name = self.cursor.line(field)?;
        let samples = self.data(ElementType::from_name(&type_name), length, 1)?;
        to_indices(&samples, field, self.context)
    }

    fn array(
        &self,
        head: &ArrayHead,
        array: &Array,
        tuples: u64,
    ) -> Result<(Samples, Option<String>), IoError> {
        let sample_type = head
            .sample_type
            .ok_or_else(|| self.context.unsupported("an array without a type"))?;
        let total = count(tuples, head.components, sample_type, self.options, self.context)?;
        decode(array, self.bytes, (sample_type, total), self.coding, self.context)
    }
}

impl Sections {
    fn finish(self, context: &Context<'_>) -> Result<Geometry, IoError> {
        let absent = |field: &str| context.field(field, "", None, "this section, which is missing");
        let mut draft = Draft::default();
        let mut kept = None;
        match self.data_set.as_str() {
            "RECTILINEAR_GRID" => {
                let [Some(x), Some(y), Some(z)] = &self.axes else {
                    return Err(absent("X_COORDINATES, Y_COORDINATES or Z_COORDINATES"));
                };
                let found = [x.len(), y.len(), z.len()];
                if self.dims != Some(found) {
                    return Err(context.field(
                        "DIMENSIONS",
                        format!("{:?}", self.dims),
                        None,
                        format!("{found:?}"),
                    ));
                }
                let product = found
                    .iter()
                    .try_fold(1usize, |product, &size| product.checked_mul(size));
                // A few coordinates make many points: either the file has data for them, or they are too many.
                let points = product.unwrap_or(usize::MAX) as u64;
                if points > context_limit(context)? {
                    return Err(context.field(
                        "DIMENSIONS",
                        format!("{found:?}"),
                        None,
                        "no more points than data",
                    ));
                }
                draft.add_rectilinear([x, y, z]);
            }
            "STRUCTURED_GRID" => {
                draft.add_points(self.points.as_ref().ok_or_else(|| absent("POINTS"))?);
                draft.blocks.push(self.dims.ok_or_else(|| absent("DIMENSIONS"))?);
            }
            "UNSTRUCTURED_GRID" => {
                draft.add_points(self.points.as_ref().ok_or_else(|| absent("POINTS"))?);
                let (ends, connectivity) = self.connectivity.ok_or_else(|| absent("CELLS"))?;
                let types = self.types.ok_or_else(|| absent("CELL_TYPES"))?;
                if types.len() != ends.len() {
                    return Err(context.field("CELL_TYPES", types.len(), None, format!("{}", ends.len())));
                }
                let stored = StoredCells {
                    types,
                    ends,
                    connectivity,
                };
                kept = Some(draft.add_cells(&stored, 0, context)?);
                let cells = stored.types.len() as u64;
                return Ok(Geometry { draft, kept, cells });
            }
            other => {
                let expected = "RECTILINEAR_GRID, STRUCTURED_GRID or UNSTRUCTURED_GRID";
                return Err(context.field("DATASET", other, None, expected));
            }
        }
        let cells = |dims: &[usize; 3]| {
            dims.iter()
                .try_fold(1u64, |n, &size| n.checked_mul(cells_along(size as u64)?))
        };
        let cells = draft.blocks.first().and_then(cells).unwrap_or(0);
        Ok(Geometry { draft, kept, cells })
    }
}

/// Cells along an axis; a flat one has one.
fn cells_along(points: u64) -> Option<u64> {
    Some(points.checked_sub(1)?.max(1))
}

/// Length of the file: no array that a structured file holds has more tuples.
fn context_limit(context: &Context<'_>) -> Result<u64, IoError> {
    let length = files::metadata(context.path).map(|metadata| metadata.len());
    length.map_err(|source| IoError::Open {
        source,
        path: context.path.to_owned(),
    })
}
