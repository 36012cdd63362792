use glam::DAffine3;

use super::*;
use std::path::Path;

fn made(positions: &[[f32; 3]], faces: &[&[u32]], attributes: PointAttributes) -> Points {
    let points = Points::new(positions.to_vec(), attributes, DAffine3::IDENTITY).unwrap();
    let mut triangles = Triangles::default();
    for face in faces {
        triangles.add_polygon(face, None);
    }
    let context = Context::new("PLY", Path::new("a.ply"));
    surfels(&points, &triangles, &ReadOptions::default(), &context).unwrap()
}

/// The area that surfels stand for.
fn area(points: &Points) -> f64 {
    let radii = &points.attributes().radii;
    radii.iter().map(|r| f64::from(*r).powi(2)).sum()
}

const SQUARE: [[f32; 3]; 4] = [[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [2.0, 2.0, 1.0], [0.0, 2.0, 1.0]];

fn cube() -> Vec<[f32; 3]> {
    let bit = |index: u32, axis: u32| (index >> axis & 1) as f32;
    (0..8)
        .map(|index| [bit(index, 0), bit(index, 1), bit(index, 2)])
        .collect()
}

#[test]
fn surfels_have_the_area_and_the_normal_of_their_triangles() {
    let square = made(&SQUARE, &[&[0, 1, 2, 3]], PointAttributes::default());
    assert!((area(&square) - 4.0).abs() < 1e-3, "{}", area(&square));
    assert!(square.len() > 10_000, "{}", square.len());
    let attributes = square.attributes();
    assert!(attributes.normals.iter().all(|n| *n == [0.0, 0.0, 1.0]));
    assert!(
        square
            .positions()
            .iter()
            .all(|p| p[2] == 1.0 && (0.0..2.0).contains(&p[0]))
    );
}

#[test]
fn closed_surfaces_face_outward_however_their_triangles_are_wound() {
    // Every other face is wound inward.
    let faces: [&[u32]; 6] = [
        &[0, 1, 3, 2],
        &[4, 5, 7, 6],
        &[0, 1, 5, 4],
        &[2, 3, 7, 6],
        &[0, 2, 6, 4],
        &[1, 3, 7, 5],
    ];
    let cube = made(&cube(), &faces, PointAttributes::default());
    for (place, normal) in cube.positions().iter().zip(&cube.attributes().normals) {
        let out: f32 = (0..3).map(|axis| (place[axis] - 0.5) * normal[axis]).sum();
        assert!(out > 0.4, "{place:?} {normal:?}");
    }
}

#[test]
fn open_surfaces_keep_the_side_that_most_of_them_has() {
    let positions = [
        [0.0, 0.0, 0.0],
        [4.0, 0.0, 0.0],
        [4.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [5.0, 0.0, 0.0],
        [5.0, 1.0, 0.0],
    ];
    // The small one is wound the other way.
    let strip = made(
        &positions,
        &[&[0, 3, 2, 1], &[1, 4, 5, 2]],
        PointAttributes::default(),
    );
    assert!(strip.attributes().normals.iter().all(|n| *n == [0.0, 0.0, -1.0]));
}

#[test]
fn normals_and_colours_of_corners_are_interpolated() {
    let attributes = PointAttributes {
        normals: vec![[1.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0]],
        colors: vec![[200, 0, 0, 255], [0, 0, 0, 255], [0, 0, 0, 255], [200, 0, 0, 255]],
        ..PointAttributes::default()
    };
    let square = made(&SQUARE, &[&[0, 1, 2, 3]], attributes);
    let own = square.attributes();
    for (place, (normal, color)) in square.positions().iter().zip(own.normals.iter().zip(&own.colors)) {
        let left = 1.0 - place[0] / 2.0;
        let tilted = left * 0.5_f32.sqrt();
        assert!(
            (f32::from(color[0]) - 200.0 * left).abs() <= 1.0,
            "{place:?} {color:?}"
        );
        assert!(
            (normal[0] - tilted / tilted.hypot(tilted + 1.0 - left)).abs() < 1e-3,
            "{place:?} {normal:?}"
        );
    }
}

#[test]
fn slivers_become_compact_pieces_and_their_number_is_bounded() {
    let sliver = Piece([DVec3::ZERO, DVec3::new(1.7, 0.03, 0.0), DVec3::new(2.0, 0.0, 0.0)]);
    let limit = Limit::of_surface(256.0 * 0.05);
    let mut patches = Vec::new();
    split::split(sliver, limit, &mut patches);
    assert_eq!(patches.len() as f64, limit.patches(sliver));
    assert!((100..200).contains(&patches.len()), "{}", patches.len());
    let whole: f64 = patches.iter().map(|patch| patch.area).sum();
    assert!((whole - sliver.area()).abs() < 1e-9, "{whole}");
    let weighted = patches.iter().map(|patch| patch.centroid * patch.area / whole);
    assert!(weighted.sum::<DVec3>().distance(sliver.centroid()) < 1e-3);

    // 4096 needles across each other would be a million pieces of the finest length.
    let mut positions = Vec::new();
    let mut faces = Vec::new();
    for index in 0..4096_u32 {
        let height = index as f32 / 4096.0;
        positions.extend([[0.0, 0.0, height], [1.0, 0.5, height], [1.0, 0.51, 1.0 - height]]);
        faces.push([3 * index, 3 * index + 1, 3 * index + 2]);
    }
    let faces: Vec<&[u32]> = faces.iter().map(|face| face.as_slice()).collect();
    let needles = made(&positions, &faces, PointAttributes::default());
    assert!(needles.len() as f64 <= FREE, "{}", needles.len());
}

#[test]
fn triangles_without_an_area_are_refused() {
    let points = Points::new(SQUARE.to_vec(), PointAttributes::default(), DAffine3::IDENTITY).unwrap();
    let mut triangles = Triangles::default();
    triangles.add_polygon(&[0, 0, 1], None);
    let context = Context::new("PLY", Path::new("a.ply"));
    let error = surfels(&points, &triangles, &ReadOptions::default(), &context).unwrap_err();
    assert!(error.to_string().contains("an area"), "{error}");
}

#[test]
fn strips_turn_every_other_triangle() {
    let mut strip = Triangles::default();
    strip.add_strip(&[5, 6, 7, 8], None);
    assert_eq!(strip.corners, [[5, 6, 7], [7, 6, 8]]);
}
