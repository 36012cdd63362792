//! .vtp: `PolyData` of VTK XML, and .vtu of flat cells. The points and cells of their pieces follow each other.

use std::path::Path;
use std::rc::Rc;

use roxmltree::Node;

use super::{Element, Kind};
use crate::IoError;
use crate::error::Context;
use crate::mesh::assemble::{to_f64, to_indices};
use crate::mesh::poly::{self, Choice, Lists, Look, PolyData, flat};
use crate::volume::ReadOptions;
use crate::volume::vti::document::{self, Arrays};

/// The polygons of a .vtp file, or of a .vtu file of flat cells.
pub(crate) fn read(path: &Path, options: &ReadOptions) -> Result<(PolyData, Vec<String>), IoError> {
    let mut poly = PolyData::default();
    let mut choice = None;
    let name = each_piece(path, options, |element, piece| {
        element.add_piece(piece, &mut poly, &mut choice)
    })?;
    poly.format = format!("VTK XML {name}");
    Ok((poly.complete(), Vec::new()))
}

/// True for an unstructured grid of flat cells. What cannot be read is none: the reader of meshes says why.
pub(crate) fn has_flat_cells(path: &Path) -> bool {
    let mut types = Vec::new();
    let result = each_piece(path, &ReadOptions::default(), |element, piece| {
        types.extend(element.cells(piece)?.types);
        Ok(())
    });
    result.is_ok() && flat::are_surface(&types)
}

/// Visits the pieces of a file, and returns the name of its data set. Points and cells are declared as those of unstructured
/// grids are.
fn each_piece(
    path: &Path,
    options: &ReadOptions,
    mut visit: impl for<'d> FnMut(&Element<'_, 'd>, Node<'d, 'd>) -> Result<(), IoError>,
) -> Result<&'static str, IoError> {
    let kind = |_: Node<'_, '_>, _: &Context<'_>| Ok(Kind::Unstructured);
    super::open(path, options, kind, |document, file| {
        let root = document.root_element();
        let name = match root.attribute("type") {
            Some("UnstructuredGrid") => "UnstructuredGrid",
            _ => "PolyData",
        };
        let grid = document::only_child(root, name, file.context)?;
        let offsets = document::offsets(document);
        for piece in grid.children().filter(|node| node.has_tag_name("Piece")) {
            let arrays = Arrays::of_piece(piece, Rc::clone(&offsets), file.context)?;
            let element = Element {
                file,
                arrays: &arrays,
            };
            visit(&element, piece)?;
        }
        Ok(name)
    })
}

/// The cells of a piece.
struct PieceCells {
    count: u64,
    /// The cell of every polygon.
    of_polygons: Vec<usize>,
    /// Strips, which are the last cells.
    strips: usize,
}

impl<'d> Element<'_, 'd> {
    fn add_piece(
        &self,
        piece: Node<'d, 'd>,
        poly: &mut PolyData,
        choice: &mut Option<Choice>,
    ) -> Result<(), IoError> {
        let first = poly.points.len() / 3;
        let points = self.declared(piece, "NumberOfPoints")?;
        if points == 0 {
            return Ok(());
        }
        poly.points.extend(to_f64(&self.points(piece, points)?));
        let place = (first, points as usize);
        let cells = self.add_cells(piece, place, poly)?;
        for wanted in [Look::Normals, Look::Colors] {
            let heads = &self.arrays.heads;
            let found = heads.iter().position(|head| Look::of(head) == Some(wanted));
            if let Some(index) = found {
                let (samples, _) = self.values(index, points)?;
                poly.add_look(wanted, &heads[index], &samples);
            }
        }
        self.add_scalars((points, &cells), poly, choice)
    }

    /// Adds a piece's cells.
    fn add_cells(
        &self,
        piece: Node<'d, 'd>,
        place: (usize, usize),
        poly: &mut PolyData,
    ) -> Result<PieceCells, IoError> {
        let known = [poly.polygons.len(), poly.strips.len()];
        if piece.has_attribute("NumberOfCells") {
            let stored = self.cells(piece)?;
            let (of_polygons, thin) = flat::add(&stored, place, &mut poly.polygons, self.file.context)?;
            poly.thin += thin;
            return Ok(PieceCells {
                count: stored.types.len() as u64,
                of_polygons,
                strips: 0,
            });
        }
        self.lists(piece, ("Polys", "NumberOfPolys"), place, &mut poly.polygons)?;
        self.lists(piece, ("Strips", "NumberOfStrips"), place, &mut poly.strips)?;
        let mut thin = 0;
        for name in ["NumberOfVerts", "NumberOfLines"] {
            if piece.has_attribute(name) {
                thin += self.declared(piece, name)?;
            }
        }
        poly.thin = poly.thin.saturating_add(thin);
        let [polygons, strips] = [poly.polygons.len() - known[0], poly.strips.len() - known[1]];
        // Cells are in this order: vertices and lines, polygons, strips.
        let first = usize::try_from(thin).unwrap_or(usize::MAX);
        Ok(PieceCells {
            count: thin.saturating_add((polygons + strips) as u64),
            of_polygons: (0..polygons)
                .map(|polygon| first.saturating_add(polygon))
                .collect(),
            strips,
        })
    }

    /// Adds a piece's values of the array that colours. A piece without it leaves the surface without.
    fn add_scalars(
        &self,
        (points, cells): (u64, &PieceCells),
        poly: &mut PolyData,
        choice: &mut Option<Choice>,
    ) -> Result<(), IoError> {
        let heads = &self.arrays.heads;
        if choice.is_none() {
            *choice = poly::choose(heads, self.file.options, self.file.context)?;
        }
        let Some(choice) = choice else { return Ok(()) };
        let Some(index) = choice.position(heads) else {
            return Ok(());
        };
        let tuples = if choice.is_of_points() {
            points
        } else {
            cells.count
        };
        let (samples, _) = self.values(index, tuples)?;
        let values = choice.pick(samples);
        let scalars = poly.scalars.get_or_insert_with(|| choice.scalars());
        match choice.is_of_points() {
            true => scalars.points.extend(values),
            false => {
                let strips = values.len() - cells.strips;
                scalars
                    .polygons
                    .extend(cells.of_polygons.iter().map(|&cell| values[cell]));
                scalars.strips.extend(&values[strips..]);
            }
        }
        Ok(())
    }

    /// Adds a piece's cells of one sort; `count` is the attribute that says how many there are.
    fn lists(
        &self,
        piece: Node<'d, 'd>,
        (tag, count): (&'static str, &'static str),
        place: (usize, usize),
        to: &mut Lists,
    ) -> Result<(), IoError> {
        let context = self.file.context;
        if !piece.has_attribute(count) || self.declared(piece, count)? == 0 {
            return Ok(());
        }
        let cells = self.declared(piece, count)?;
        let parent = document::only_child(piece, tag, context)?;
        let list = |name: &'static str, length: u64| {
            let mut children = self.children(parent).into_iter();
            let node = children
                .find(|node| node.attribute("Name") == Some(name))
                .ok_or_else(|| context.field(tag, "", None, format!("an array `{name}`")))?;
            to_indices(&self.numbers(node, length, 1)?, name, context)
        };
        let ends = list("offsets", cells)?;
        let connectivity = list("connectivity", ends.last().copied().unwrap_or(0))?;
        to.add((&ends, &connectivity), place, context)
    }
}
