//! Vertices of PLY files: clouds, and meshes without their faces.

use std::path::Path;

use super::LoadedPoints;
use super::columns::{INTENSITY, RED, ROLES, X, columns_of_roles};
use super::gather::{ColorKind, Gather};
use crate::error::Context;
use crate::ply::{Element, Reader};
use crate::source::Rest;
use crate::{Description, IoError, ReadOptions};

/// Reads the element `vertex`.
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
    // An intensity beside a confidence belongs to a range scan and is no colour.
    columns[INTENSITY] = None;
    if let Some(missing) = (0..3).find(|&axis| columns[X + axis].is_none()) {
        let expected = format!(
            "a scalar property \"{}\" of element \"vertex\"",
            ["x", "y", "z"][missing]
        );
        return Err(context.field("property", "(absent)", None, expected));
    }
    let mut description = describe(&reader, &vertex, path);
    let mut gather = Gather::new(columns.map(|column| column.is_some()), options);
    gather.check_count(vertex.count, context)?;
    let roles: Vec<usize> = (0..ROLES).filter(|&role| columns[role].is_some()).collect();
    let names: Vec<&str> = roles
        .iter()
        .filter_map(|&role| Some(vertex.properties[columns[role]?].name.as_str()))
        .collect();
    reader.rows("vertex", &names, |_, values| {
        let mut row = [f64::NAN; ROLES];
        for (&role, &value) in roles.iter().zip(values) {
            row[role] = value;
        }
        gather.push(&row);
        Ok(())
    })?;
    if reader.finish()? == Rest::Excess {
        description
            .warnings
            .push("there are more data than the header declares".to_owned());
    }
    gather.finish(color_kind(&vertex, columns[RED]), description, context)
}

fn color_kind(vertex: &Element, red: Option<usize>) -> ColorKind {
    let scalar = red.and_then(|column| vertex.scalar(&vertex.properties[column].name));
    match scalar.map(|scalar| scalar.name()) {
        Some("float" | "double") => ColorKind::Float,
        _ => ColorKind::Integer,
    }
}

fn describe(reader: &Reader<'_>, vertex: &Element, path: &Path) -> Description {
    let properties: Vec<&str> = vertex.properties.iter().map(|p| p.name.as_str()).collect();
    let others = reader
        .header()
        .elements
        .iter()
        .filter(|e| e.name != "vertex" && e.count > 0);
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
