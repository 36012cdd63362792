//! Polygonal data of VTK: their polygons become surfels; data without any are a cloud of points.

use std::path::Path;

use super::LoadedPoints;
use super::columns::{NORMAL, RED, ROLES, X};
use super::gather::{ColorKind, Gather};
use super::scalar_colors::Coloring;
use super::triangles::{self, Triangles};
use crate::error::Context;
use crate::mesh::poly::{PolyData, Scalars};
use crate::mesh::{PolyFormat, legacy_vtk, vtk_xml};
use crate::{Description, IoError, ReadOptions};

/// Reads a .vtk or .vtp file.
pub(super) fn read(path: &Path, format: PolyFormat, options: &ReadOptions) -> Result<LoadedPoints, IoError> {
    let (poly, mut warnings) = match format {
        PolyFormat::LegacyVtk => legacy_vtk::read_poly(path, options),
        PolyFormat::VtkXml => vtk_xml::read_poly(path, options),
    }?;
    let context = &Context::new("VTK PolyData", path);
    let colors = poly
        .scalars
        .as_ref()
        .and_then(|scalars| Coloring::of(scalars, &mut warnings));
    let mut triangles = Triangles::default();
    let of_cell = |values: fn(&Scalars) -> &[f64], cell: usize| {
        let value = values(poly.scalars.as_ref()?).get(cell)?;
        Some(colors?.color(*value))
    };
    for (cell, polygon) in poly.polygons.iter().enumerate() {
        triangles.add_polygon(polygon, of_cell(|scalars| &scalars.polygons, cell));
    }
    for (cell, strip) in poly.strips.iter().enumerate() {
        triangles.add_strip(strip, of_cell(|scalars| &scalars.strips, cell));
    }
    if let (Some(scalars), Some(colors)) = (&poly.scalars, colors)
        && scalars.is_of_points()
    {
        triangles.color_by(scalars.points.clone(), colors);
    }
    if poly.thin > 0 && triangles.len() > 0 {
        warnings.push(format!(
            "{} cells of lines and vertices beside the polygons are left out",
            poly.thin
        ));
    }
    let description = Description {
        format: poly.format.clone(),
        stored_type: match poly.used.as_slice() {
            [] => "points".to_owned(),
            used => format!("points, {}", used.join(", ")),
        },
        files: vec![path.to_owned()],
        warnings,
        ..Description::default()
    };
    let mut loaded = gather(&poly, (triangles.len() > 0, colors), options, context)?.finish(
        ColorKind::Integer,
        description,
        context,
    )?;
    if let (Some(scalars), Some(colors)) = (&poly.scalars, colors) {
        let shown = format!(
            "; coloured by `{}` from {} to {}",
            scalars.name, colors.low, colors.high
        );
        loaded.description.stored_type.push_str(&shown);
    }
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

/// The points. Those of polygons keep their numbers, so that all of them must have a place.
fn gather(
    poly: &PolyData,
    (all, colors): (bool, Option<Coloring>),
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<Gather, IoError> {
    let mut present = [false; ROLES];
    present[X..X + 3].fill(true);
    present[NORMAL..NORMAL + 3].fill(!poly.normals.is_empty());
    // Values of a surface's points are interpolated before they become colours; those of a cloud are colours here.
    let values = poly.scalars.as_ref().map_or(&[][..], |scalars| &scalars.points);
    let colors = colors.filter(|_| !all && !values.is_empty());
    let stored = colors.is_none() && poly.scalars.is_none() && !poly.colors.is_empty();
    present[RED..RED + 3].fill(stored || colors.is_some());
    let mut gather = Gather::new(present, options);
    gather.check_count(poly.points.len() as u64 / 3, context)?;
    for (index, place) in poly.points.chunks_exact(3).enumerate() {
        if all && place.iter().any(|c| !c.is_finite()) {
            let found = format!("{place:?}");
            return Err(context.field(format!("point {index}"), found, None, "finite coordinates"));
        }
        let mut row = [f64::NAN; ROLES];
        row[X..X + 3].copy_from_slice(place);
        if let Some(normal) = poly.normals.get(index * 3..index * 3 + 3) {
            row[NORMAL..NORMAL + 3].copy_from_slice(normal);
        }
        if let Some((colors, value)) = colors.zip(values.get(index)) {
            let [red, green, blue, _] = colors.color(*value);
            row[RED..RED + 3].copy_from_slice(&[red, green, blue].map(f64::from));
        } else if let Some(color) = poly.colors.get(index) {
            row[RED..RED + 3].copy_from_slice(&color.map(f64::from));
        }
        gather.push(&row);
    }
    Ok(gather)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read_points;

    /// A square of two triangles, one of them as a strip, with normals and a colour.
    const LEGACY: &str = "# vtk DataFile Version 3.0\nsquare\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n\
        0 0 0 2 0 0 2 2 0 0 2 0\nVERTICES 1 2\n1 0\nPOLYGONS 1 4\n3 0 1 2\nTRIANGLE_STRIPS 1 4\n3 0 2 3\n\
        POINT_DATA 4\nNORMALS normals float\n0 0 -1 0 0 -1 0 0 -1 0 0 -1\n\
        SCALARS rgb unsigned_char 3\nLOOKUP_TABLE default\n9 8 7 9 8 7 9 8 7 9 8 7\n";
    const XML: &str = r#"<?xml version="1.0"?>
        <VTKFile type="PolyData" version="0.1" byte_order="LittleEndian"><PolyData>
        <Piece NumberOfPoints="4" NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="1">
        <PointData Normals="n"><DataArray type="Float32" Name="Normals" NumberOfComponents="3" format="ascii">
        0 0 -1 0 0 -1 0 0 -1 0 0 -1</DataArray></PointData>
        <Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">0 0 0 2 0 0 2 2 0 0 2 0</DataArray></Points>
        <Polys><DataArray type="Int64" Name="connectivity" format="ascii">0 1 2 3</DataArray>
        <DataArray type="Int64" Name="offsets" format="ascii">4</DataArray></Polys></Piece></PolyData></VTKFile>"#;

    fn read(name: &str, text: &str) -> Result<LoadedPoints, IoError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        assert_eq!(
            crate::data_kind(&path, &crate::DataOptions::default()).unwrap(),
            crate::DataKind::Points
        );
        read_points(&path, &ReadOptions::default())
    }

    #[test]
    fn polygons_and_strips_become_surfels_with_the_normals_and_colours_of_their_points() {
        for (name, text) in [("a.vtk", LEGACY), ("b.vtp", XML)] {
            let loaded = read(name, text).unwrap();
            let attributes = loaded.points.attributes();
            let area: f64 = attributes.radii.iter().map(|r| f64::from(*r).powi(2)).sum();
            assert!((area - 4.0).abs() < 1e-3, "{name}: {area}");
            assert!(
                attributes.normals.iter().all(|n| *n == [0.0, 0.0, -1.0]),
                "{name}"
            );
            let colored = attributes.colors.iter().all(|c| *c == [9, 8, 7, 255]);
            assert!(
                colored && attributes.colors.is_empty() == (name == "b.vtp"),
                "{name}"
            );
        }
        let warnings = read("a.vtk", LEGACY).unwrap().description.warnings;
        assert!(
            warnings[0].starts_with("1 cells of lines and vertices"),
            "{warnings:?}"
        );
    }

    #[test]
    fn polygons_of_points_that_are_not_there_are_refused_by_number() {
        let text = LEGACY.replace("3 0 1 2", "3 0 1 4");
        let error = read("a.vtk", &text).unwrap_err().to_string();
        assert!(
            error.contains("point of cell 0") && error.contains("below 4"),
            "{error}"
        );
        let error = read("b.vtp", &XML.replace("0 1 2 3<", "0 1 2 9<"))
            .unwrap_err()
            .to_string();
        assert!(error.contains("point of cell 0"), "{error}");
    }

    #[test]
    fn data_without_polygons_are_a_cloud() {
        let text = &LEGACY[..LEGACY.find("POLYGONS").unwrap()];
        let loaded = read("a.vtk", text).unwrap();
        assert_eq!(loaded.points.len(), 4);
        assert!(loaded.points.attributes().radii.is_empty());
    }
}
