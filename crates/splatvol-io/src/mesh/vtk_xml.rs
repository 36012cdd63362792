//! VTK XML files of rectilinear (.vtr), structured (.vts) and unstructured (.vtu) grids, after `vtkXMLDataReader`.
//!
//! Every coding of [`crate::volume::vti`] is read. The pieces of a structured file become blocks, those of an
//! unstructured one follow each other.

mod poly;

use std::path::Path;
use std::rc::Rc;

use glam::DVec3;
use roxmltree::{Document, Node};
use splatvol_scene::Samples;

use super::LoadedMesh;
use super::assemble::{Draft, StoredCells, count, to_indices};
use crate::error::Context;
use crate::source::read_file;
use crate::volume::vti::document::{self, Arrays, Coding, Place};
use crate::volume::vti::{describe, payload};
use crate::volume::vtk_array::{self, ArrayHead, Association, Component};
use crate::volume::{Description, ReadOptions};
use crate::{IoError, SampleType};

pub(crate) use poly::{has_flat_cells, read as read_poly};

/// Reads a .vtr, .vts or .vtu file.
///
/// # Errors
/// Malformed XML, another data set, geometry that contradicts itself, an array that is absent, or data that do not fit
/// their declaration.
pub fn read(path: &Path, options: &ReadOptions) -> Result<LoadedMesh, IoError> {
    open(path, options, Kind::of, |document, file| {
        let grid = document::only_child(document.root_element(), file.kind.name(), file.context)?;
        file.read_pieces(document, grid, path)
    })
}

/// Parses a file; `read` gets its document and what its pieces have in common. `kind` is what its root is read as.
fn open<T>(
    path: &Path,
    options: &ReadOptions,
    kind: impl FnOnce(Node<'_, '_>, &Context<'_>) -> Result<Kind, IoError>,
    read: impl FnOnce(&Document<'_>, &File<'_>) -> Result<T, IoError>,
) -> Result<T, IoError> {
    let context = &Context::new("VTK XML", path);
    let bytes = read_file(path, context)?;
    let parts = document::split(&bytes, context)?;
    let document = document::parse(&parts, context)?;
    let root = document.root_element();
    let file = File {
        kind: kind(root, context)?,
        coding: document::coding(root, context)?,
        appended: parts.appended,
        length: bytes.len() as u64,
        options,
        context,
    };
    read(&document, &file)
}

/// The data set of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Rectilinear,
    Structured,
    Unstructured,
}

impl Kind {
    fn of(root: Node, context: &Context<'_>) -> Result<Self, IoError> {
        let name = root.attribute("type").unwrap_or_default();
        [Self::Rectilinear, Self::Structured, Self::Unstructured]
            .into_iter()
            .find(|kind| kind.name() == name)
            .ok_or_else(|| {
                context.field(
                    "type",
                    name,
                    None,
                    "RectilinearGrid, StructuredGrid or UnstructuredGrid",
                )
            })
    }

    fn name(self) -> &'static str {
        match self {
            Self::Rectilinear => "RectilinearGrid",
            Self::Structured => "StructuredGrid",
            Self::Unstructured => "UnstructuredGrid",
        }
    }
}

/// State common to the pieces of a file.
struct File<'a> {
    kind: Kind,
    coding: Coding,
    appended: Option<&'a [u8]>,
    /// Bytes of the file.
    length: u64,
    options: &'a ReadOptions,
    context: &'a Context<'a>,
}

/// Bytes of the points of a rectilinear grid that need no justification.
const FREE_POINTS: u64 = 64 << 20;
/// Bytes of points that a byte of the file may stand for.
const POINTS_PER_BYTE: u64 = 256;

impl File<'_> {
    /// Refuses a rectilinear grid whose points, which three short axes stand for, are far more than the file holds.
    fn check_expanded(&self, sizes: [u64; 3]) -> Result<(), IoError> {
        let points = sizes.into_iter().fold(1u64, u64::saturating_mul);
        let needed = points.saturating_mul(size_of::<DVec3>() as u64);
        let most = FREE_POINTS.max(self.length.saturating_mul(POINTS_PER_BYTE));
        match needed <= most {
            true => Ok(()),
            false => Err(self.context.too_small("points", needed, most)),
        }
    }

    fn read_pieces<'d>(
        &self,
        document: &'d Document<'d>,
        grid: Node<'d, 'd>,
        path: &Path,
    ) -> Result<LoadedMesh, IoError> {
        let mut draft = Draft::default();
        let mut description = Description {
            format: format!("VTK XML {}", self.kind.name()),
            orientation: "coordinates as stored".to_owned(),
            files: vec![path.to_owned()],
            ..Description::default()
        };
        let mut choice: Option<(ArrayHead, Component)> = None;
        let mut list = Vec::new();
        let offsets = document::offsets(document);
        for piece in grid.children().filter(|node| node.has_tag_name("Piece")) {
            let arrays = Arrays::of_piece(piece, Rc::clone(&offsets), self.context)?;
            let (index, component) = match &choice {
                None => {
                    let found = vtk_array::choose_scalar(&arrays.heads, self.options, self.context)?;
                    list.clone_from(&arrays.heads);
                    choice = Some((arrays.heads[found.0].clone(), found.1));
                    found
                }
                Some((wanted, component)) => (self.same(&arrays, wanted)?, *component),
            };
            let head = &arrays.heads[index];
            let element = Element {
                file: self,
                arrays: &arrays,
            };
            // Values first: their bytes are checked before three short axes are expanded to points.
            let tuples = element.tuples(piece, head.association)?;
            let (samples, warning) = element.values(index, tuples)?;
            description.warnings.extend(warning);
            description.stored_type = element.describe(index)?;
            let kept = element.geometry(piece, &mut draft)?;
            let kept = kept.filter(|_| head.association == Association::Cell);
            draft.add_values(samples, (head.components, component), kept.as_deref());
        }
        let (head, component) =
            choice.ok_or_else(|| self.context.field("Piece", "", None, "an element <Piece>"))?;
        draft.finish((&head, component), description, &list, self.context)
    }

    /// The array of another piece.
    fn same(&self, arrays: &Arrays<'_>, wanted: &ArrayHead) -> Result<usize, IoError> {
        let same = |head: &ArrayHead| {
            head.name == wanted.name
                && head.association == wanted.association
                && head.components == wanted.components
        };
        arrays.heads.iter().position(same).ok_or_else(|| {
            let text = format!("a piece without the array {}", wanted.describe());
            self.context.unsupported(text)
        })
    }
}

/// One piece while it is read.
struct Element<'a, 'd> {
    file: &'a File<'a>,
    arrays: &'a Arrays<'d>,
}

impl<'d> Element<'_, 'd> {
    /// Number of tuples of an array.
    fn tuples(&self, piece: Node<'d, 'd>, association: Association) -> Result<u64, IoError> {
        if self.file.kind == Kind::Unstructured {
            return self.declared(
                piece,
                match association {
                    Association::Point => "NumberOfPoints",
                    Association::Cell => "NumberOfCells",
                },
            );
        }
        let sizes = self.sizes(piece)?;
        let tuples = match association {
            Association::Point => sizes,
            // A flat axis has one cell.
            Association::Cell => sizes.map(|size| (size - 1).max(1)),
        };
        let product = tuples.into_iter().try_fold(1u64, |n, size| n.checked_mul(size));
        let found = || format!("{sizes:?} points");
        product.ok_or_else(|| {
            self.file
                .context
                .field("Extent", found(), None, "fewer than 2^64 points")
        })
    }

    fn declared(&self, piece: Node<'d, 'd>, field: &str) -> Result<u64, IoError> {
        let text = piece.attribute(field).unwrap_or_default();
        let number = text.trim().parse::<u64>();
        number.map_err(|_| self.file.context.field(field, text, None, "a whole number"))
    }

    /// Points along the axes of a structured piece.
    fn sizes(&self, piece: Node<'d, 'd>) -> Result<[u64; 3], IoError> {
        let (node, field) = match piece.has_attribute("Extent") {
            true => (piece, "Extent"),
            false => (piece.parent_element().unwrap_or(piece), "WholeExtent"),
        };
        let extent = document::extent(node, field, self.file.context)?;
        Ok(extent.map(|[first, last]| (last.saturating_sub(first) as u64).saturating_add(1)))
    }

    fn values(&self, index: usize, tuples: u64) -> Result<(Samples, Option<String>), IoError> {
        let File { options, context, .. } = self.file;
        let head = &self.arrays.heads[index];
        let sample_type = head
            .sample_type
            .ok_or_else(|| context.unsupported("an array without a type"))?;
        let total = count(tuples, head.components, sample_type, options, context)?;
        self.decode(&self.arrays.place(index, context)?, sample_type, total)
    }

    fn describe(&self, index: usize) -> Result<String, IoError> {
        let place = self.arrays.place(index, self.file.context)?;
        let type_name = &self.arrays.heads[index].type_name;
        Ok(format!("{type_name}{}", describe(&place, self.file.coding)))
    }

    /// Adds the piece's geometry; returns the cells kept if some may be left out.
    fn geometry(&self, piece: Node<'d, 'd>, draft: &mut Draft) -> Result<Option<Vec<usize>>, IoError> {
        let context = self.file.context;
        match self.file.kind {
            Kind::Unstructured => return self.unstructured(piece, draft).map(Some),
            Kind::Rectilinear => {
                let sizes = self.sizes(piece)?;
                let arrays = self.children(document::only_child(piece, "Coordinates", context)?);
                let [x, y, z] = arrays[..] else {
                    return Err(context.field("Coordinates", arrays.len(), None, "three arrays"));
                };
                self.file.check_expanded(sizes)?;
                let axis = |node, axis: usize| self.numbers(node, sizes[axis], 1);
                draft.add_rectilinear([&axis(x, 0)?, &axis(y, 1)?, &axis(z, 2)?]);
            }
            Kind::Structured => {
                draft.add_points(&self.points(piece, self.tuples(piece, Association::Point)?)?);
                draft.blocks.push(self.sizes(piece)?.map(|size| size as usize));
            }
        }
        Ok(None)
    }

    fn unstructured(&self, piece: Node<'d, 'd>, draft: &mut Draft) -> Result<Vec<usize>, IoError> {
        let first = draft.positions.len();
        draft.add_points(&self.points(piece, self.declared(piece, "NumberOfPoints")?)?);
        draft.add_cells(&self.cells(piece)?, first, self.file.context)
    }

    /// Cells of an unstructured piece.
    fn cells(&self, piece: Node<'d, 'd>) -> Result<StoredCells, IoError> {
        let context = self.file.context;
        let cells = self.declared(piece, "NumberOfCells")?;
        let lists = document::only_child(piece, "Cells", context)?;
        let list = |name: &'static str, length: u64| {
            let node = self
                .children(lists)
                .into_iter()
                .find(|node| node.attribute("Name") == Some(name))
                .ok_or_else(|| context.field("Cells", "", None, format!("an array `{name}`")))?;
            to_indices(&self.numbers(node, length, 1)?, name, context)
        };
        let ends = list("offsets", cells)?;
        let connectivity = list("connectivity", ends.last().copied().unwrap_or(0))?;
        let types = list("types", cells)?;
        let types = types
            .into_iter()
            .map(|code| u8::try_from(code).unwrap_or(0))
            .collect();
        Ok(StoredCells {
            types,
            ends,
            connectivity,
        })
    }

    fn points(&self, piece: Node<'d, 'd>, points: u64) -> Result<Samples, IoError> {
        let context = self.file.context;
        let arrays = self.children(document::only_child(piece, "Points", context)?);
        let array = arrays
            .first()
            .ok_or_else(|| context.field("Points", "", None, "an array of points"))?;
        self.numbers(*array, points, 3)
    }

    fn children(&self, parent: Node<'d, 'd>) -> Vec<Node<'d, 'd>> {
        let arrays = parent.children().filter(|node| node.has_tag_name("DataArray"));
        arrays.collect()
    }

    fn numbers(&self, node: Node<'d, 'd>, tuples: u64, components: usize) -> Result<Samples, IoError> {
        let File { options, context, .. } = self.file;
        let type_name = node.attribute("type").unwrap_or_default();
        let sample_type: SampleType = document::sample_type(type_name)
            .ok_or_else(|| context.field("type", type_name, None, "a numeric type"))?;
        let total = count(tuples, components, sample_type, options, context)?;
        let place = self.arrays.place_of(node, context)?;
        self.decode(&place, sample_type, total)
            .map(|(samples, _)| samples)
    }

    fn decode(
        &self,
        place: &Place<'_>,
        sample_type: SampleType,
        count: usize,
    ) -> Result<(Samples, Option<String>), IoError> {
        let File {
            coding,
            appended,
            context,
            ..
        } = *self.file;
        payload::samples(place, (sample_type, count), coding, appended, context)
    }
}
