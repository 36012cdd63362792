//! PLY files: clouds of vertices, and meshes, whose faces become surfels.

use std::path::Path;

use super::LoadedPoints;
use super::columns::{INTENSITY, RED, ROLES, X, columns_of_roles};
use super::gather::{ColorKind, Gather};
use super::triangles::{self, Triangles};
use crate::error::Context;
use crate::ply::{Element, Header, Reader, Scalar};
use crate::source::Rest;
use crate::{Description, IoError, ReadOptions};

/// Customary names of the list of a face's corners.
const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];
/// Stands for a vertex without a place.
const NOWHERE: u32 = u32::MAX;

/// Reads the element `vertex`; where there are faces, their surface.
///
/// # Errors
/// A malformed or truncated file, one without vertices, or one of 3-D Gaussians.
pub fn read(path: &Path, options: &ReadOptions) -> Result<LoadedPoints, IoError> {
    let context = &Context::new("PLY", path);
    let mut reader = Reader::open(path)?;
    let header = reader.header();
    let vertex = header
        .element("vertex")
        .ok_or_else(|| context.field("element", "(absent)", None, "an element \"vertex\""))?
        .clone();
    if header.element("chunk").is_some() || (vertex.has("f_dc_0") && vertex.has("scale_0")) {
        return Err(context.unsupported("these are 3-D Gaussians, not points; read them as Gaussians"));
    }
    let columns = columns_of_roles(vertex.properties.iter().map(|p| p.name.as_str()));
    let mut columns = columns.map(|column| column.filter(|&c| vertex.has(&vertex.properties[c].name)));
    // An intensity beside a confidence belongs to a range scan and is not a colour.
    columns[INTENSITY] = None;
    if let Some(missing) = (0..3).find(|&axis| columns[X + axis].is_none()) {
        let expected = format!(
            "a scalar property \"{}\" of element \"vertex\"",
            ["x", "y", "z"][missing]
        );
        return Err(context.field("property", "(absent)", None, expected));
    }
    let face = faces(reader.header());
    let mut description = describe(&reader, &vertex, path, face.is_some());
    let mut gather = Gather::new(columns.map(|column| column.is_some()), options);
    gather.check_count(vertex.count, context)?;
    let roles: Vec<usize> = (0..ROLES).filter(|&role| columns[role].is_some()).collect();
    let names: Vec<&str> = roles
        .iter()
        .filter_map(|&role| Some(vertex.properties[columns[role]?].name.as_str()))
        .collect();
    // Index of each vertex among those that have a place.
    let mut indices = Vec::new();
    reader.rows("vertex", &names, |_, values| {
        let mut row = [f64::NAN; ROLES];
        for (&role, &value) in roles.iter().zip(values) {
            row[role] = value;
        }
        if face.is_some() {
            let has_place = row[X..X + 3].iter().all(|c| c.is_finite());
            indices.push(if has_place { gather.len() as u32 } else { NOWHERE });
        }
        gather.push(&row);
        Ok(())
    })?;
    let triangles = match &face {
        Some(face) => read_faces(&mut reader, face, &indices, context)?,
        None => Triangles::default(),
    };
    if reader.finish()? == Rest::Excess {
        description
            .warnings
            .push("there are more data than the header declares".to_owned());
    }
    let mut loaded = gather.finish(color_kind(&vertex, columns[RED]), description, context)?;
    if triangles.len() > 0 {
        loaded.points = triangles::surfels(&loaded.points, &triangles, options, context)?;
        let made = format!(
            "; {} triangles as {} surfels",
            triangles.len(),
            loaded.points.len()
        );
        loaded.description.stored_type.push_str(&made);
    }
    Ok(loaded)
}

/// The element of faces and the name of its list of corners, where there are any after the vertices.
fn faces(header: &Header) -> Option<(Element, &'static str)> {
    let mut after = header.elements.iter().skip_while(|e| e.name != "vertex");
    let face = after.find(|e| e.name == "face" && e.count > 0)?;
    Some((face.clone(), face.list(&CORNERS)?))
}

fn read_faces(
    reader: &mut Reader<'_>,
    (face, list): &(Element, &'static str),
    indices: &[u32],
    context: &Context<'_>,
) -> Result<Triangles, IoError> {
    let mut triangles = Triangles::default();
    let names = ["red", "green", "blue"];
    let colors = names.iter().all(|name| face.scalar(name) == Some(Scalar::U8));
    let columns = if colors { names.as_slice() } else { &[] };
    let mut corners = Vec::new();
    reader.rows_and_lists("face", (columns, *list), |number, row, list| {
        corners.clear();
        for &index in list {
            let corner = indices
                .get(index as usize)
                .filter(|_| index >= 0.0 && index.fract() == 0.0);
            corners.push(*corner.ok_or_else(|| {
                let expected = format!("a vertex, below {}", indices.len());
                context.field(format!("corner of face {number}"), index, None, expected)
            })?);
        }
        if !corners.contains(&NOWHERE) {
            let color = <[f64; 3]>::try_from(row)
                .ok()
                .map(|[r, g, b]| [r as u8, g as u8, b as u8, 255]);
            triangles.add_polygon(&corners, color);
        }
        Ok(())
    })?;
    Ok(triangles)
}

fn color_kind(vertex: &Element, red: Option<usize>) -> ColorKind {
    let scalar = red.and_then(|column| vertex.scalar(&vertex.properties[column].name));
    match scalar.map(|scalar| scalar.name()) {
        Some("float" | "double") => ColorKind::Float,
        _ => ColorKind::Integer,
    }
}

fn describe(reader: &Reader<'_>, vertex: &Element, path: &Path, faces: bool) -> Description {
    let properties: Vec<&str> = vertex.properties.iter().map(|p| p.name.as_str()).collect();
    let others = reader
        .header()
        .elements
        .iter()
        .filter(|e| e.name != "vertex" && e.count > 0 && !(faces && e.name == "face"));
    let others: Vec<String> = others.map(|e| format!("{} x {}", e.count, e.name)).collect();
    let kind = if others.is_empty() {
        String::new()
    } else {
        format!(" (passed over: {})", others.join(", "))
    };
    Description {
        format: format!("PLY{kind}"),
        stored_type: format!("{}, {}", reader.header().encoding.name(), properties.join(" ")),
        orientation: String::new(),
        files: vec![path.to_owned()],
        ..Description::default()
    }
}
