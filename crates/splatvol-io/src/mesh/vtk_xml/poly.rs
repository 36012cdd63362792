//! .vtp: `PolyData` of VTK XML. The points and cells of its pieces follow each other.

use std::path::Path;

use roxmltree::Node;

use super::{Element, File, Kind};
use crate::IoError;
use crate::error::Context;
use crate::mesh::assemble::{to_f64, to_indices};
use crate::mesh::poly::{Lists, Look, PolyData};
use crate::source::read_file;
use crate::volume::ReadOptions;
use crate::volume::vti::document::{self, Arrays};

/// The polygons of a .vtp file.
pub(crate) fn read(path: &Path, options: &ReadOptions) -> Result<(PolyData, Vec<String>), IoError> {
    let context = &Context::new("VTK XML", path);
    let bytes = read_file(path, context)?;
    let parts = document::split(&bytes, context)?;
    let document = document::parse(&parts, context)?;
    let root = document.root_element();
    let file = File {
        // Points and cells are declared as those of unstructured grids are.
        kind: Kind::Unstructured,
        coding: document::coding(root, context)?,
        appended: parts.appended,
        length: bytes.len() as u64,
        options,
        context,
    };
    let grid = document::only_child(root, "PolyData", context)?;
    let mut poly = PolyData {
        format: "VTK XML PolyData".to_owned(),
        ..PolyData::default()
    };
    for piece in grid.children().filter(|node| node.has_tag_name("Piece")) {
        let arrays = Arrays::of_piece(piece, document::offsets(&document), context)?;
        let element = Element {
            file: &file,
            arrays: &arrays,
        };
        element.add_piece(piece, &mut poly)?;
    }
    Ok((poly.complete(), Vec::new()))
}

impl<'d> Element<'_, 'd> {
    fn add_piece(&self, piece: Node<'d, 'd>, poly: &mut PolyData) -> Result<(), IoError> {
        let first = poly.points.len() / 3;
        let points = self.declared(piece, "NumberOfPoints")?;
        if points == 0 {
            return Ok(());
        }
        poly.points.extend(to_f64(&self.points(piece, points)?));
        let place = (first, points as usize);
        self.lists(piece, ("Polys", "NumberOfPolys"), place, &mut poly.polygons)?;
        self.lists(piece, ("Strips", "NumberOfStrips"), place, &mut poly.strips)?;
        for thin in ["NumberOfVerts", "NumberOfLines"] {
            if piece.has_attribute(thin) {
                poly.thin += self.declared(piece, thin)?;
            }
        }
        for wanted in [Look::Normals, Look::Colors] {
            let heads = &self.arrays.heads;
            let found = heads.iter().position(|head| Look::of(head) == Some(wanted));
            if let Some(index) = found {
                let (samples, _) = self.values(index, points)?;
                poly.add_look(wanted, &heads[index], &samples);
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
