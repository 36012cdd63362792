//! Meshes: the same field on grids of all kinds.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use splatvol::mesh::{Association, MeshField, Topology};
use splatvol::{
    Classification, Clip, EngineConfig, Filter, FlatSettings, Grid, Isosurface, Item, Mesh, RenderSettings,
    Renderer, Scene, TransferFunction,
};
use splatvol_testing::fields::{Ball, Constant, Field};
use splatvol_testing::{Comparison, sample};
use splatvol_testing::{checked, transfer::linear_extinction};

use super::support::{picture, unlit};
use crate::common::{orthographic, perspective};

/// A field on a structured grid of `dims` points, whose places are those of the indices under a map.
pub(crate) fn structured(field: &impl Field, dims: [usize; 3], place: impl Fn(DVec3) -> DVec3) -> Mesh {
    let [nx, ny, nz] = dims;
    let points: Vec<DVec3> = (0..nx * ny * nz)
        .map(|i| {
            place(DVec3::new(
                (i % nx) as f64,
                (i / nx % ny) as f64,
                (i / nx / ny) as f64,
            ))
        })
        .collect();
    let values = MeshField {
        name: "value".to_owned(),
        association: Association::Point,
        values: points.iter().map(|p| field.value(*p) as f32).collect(),
    };
    let positions = points.iter().map(|p| p.as_vec3().to_array()).collect();
    let topology = Topology::Structured(vec![dims]);
    Mesh::new(positions, topology, Vec::new(), values, DAffine3::IDENTITY).unwrap()
}

fn item(mesh: Mesh, transfer_function: TransferFunction) -> Item {
    Item::mesh(mesh, transfer_function)
}

/// Coordinates along an axis, from -1 to 1, `ratio` times as dense in the middle as at the ends.
pub(crate) fn graded(index: f64, count: usize) -> f64 {
    let t = 2.0 * index / (count - 1) as f64 - 1.0;
    t * (0.75 + 0.25 * t * t)
}

/// A regular and a rectilinear grid of one field give the same picture.
#[test]
fn a_rectilinear_grid_shows_what_a_regular_one_shows() {
    let field = Ball {
        centre: DVec3::new(0.1, -0.05, 0.0),
        radius: 0.8,
    };
    let look = linear_extinction([0.0, 1.0], 4.0, [0.9, 0.5, 0.2]);
    let grid = Grid::centred([81, 81, 81], DVec3::splat(2.0 / 80.0)).unwrap();
    let scene = Scene::new(sample(&field, &grid), look.clone());
    let dims = [91, 89, 93];
    let mesh = structured(&field, dims, |i| {
        DVec3::from_array(std::array::from_fn(|a| graded(i[a], dims[a])))
    });
    let settings = checked(FlatSettings {
        classification: Classification::Pre,
        filter: Filter::Ewa { pixel_sigma: 0.55 },
        ..unlit(96, 96).into()
    });
    let camera = perspective(DVec3::ZERO, DVec3::new(0.4, 1.0, 0.3), 6.0, 25.0);
    let regular = Renderer::new(EngineConfig::default())
        .unwrap()
        .render(&scene, &camera, &settings)
        .unwrap();
    let found = picture(vec![item(mesh, look)], &camera, &settings);
    let figures = Comparison::of(&found.image, &regular.image);
    println!("rectilinear against regular: {:.1} dB", figures.psnr);
    assert!(figures.psnr > 40.0, "{}", figures.psnr);
}

/// Post-classified meshes match the volume's picture: lit, through a band of values and as an isosurface, on a graded
/// grid, and cut by a plane.
#[test]
fn samples_of_meshes_are_classified_as_those_of_volumes_are() {
    let field = Ball {
        centre: DVec3::new(0.1, -0.05, 0.0),
        radius: 0.8,
    };
    let grid = Grid::centred([81, 81, 81], DVec3::splat(2.0 / 80.0)).unwrap();
    let dims = [91, 89, 93];
    let volume = Arc::new(sample(&field, &grid));
    let mesh = Arc::new(structured(&field, dims, |i| {
        DVec3::from_array(std::array::from_fn(|a| graded(i[a], dims[a])))
    }));
    let plain = linear_extinction([0.0, 1.0], 4.0, [0.9, 0.5, 0.2]);
    let band = TransferFunction::isosurface(0.5, 0.2, [0.3, 0.6, 0.9]).unwrap();
    let surface = Isosurface {
        value: 0.4,
        rgb: [0.8, 0.3, 0.2],
        opacity: 1.0,
    };
    let pairs = [
        (
            "material",
            Item::volume(volume.clone(), plain.clone()),
            Item::mesh(mesh.clone(), plain),
            40.0,
        ),
        (
            "band",
            Item::volume(volume.clone(), band.clone()),
            Item::mesh(mesh.clone(), band),
            33.0,
        ),
        (
            "isosurface",
            Item::isosurfaces(volume, &[surface]).unwrap(),
            Item::mesh_isosurfaces(mesh, &[surface]).unwrap(),
            33.0,
        ),
    ];
    let settings = RenderSettings {
        size: splatvol::ImageSize::new(96, 96).unwrap(),
        ..RenderSettings::default()
    };
    let camera = perspective(DVec3::ZERO, DVec3::new(0.4, 1.0, 0.3), 6.0, 25.0);
    let clip = Clip::plane(DVec3::new(0.2, 0.0, 0.0), DVec3::new(-1.0, 0.3, 0.2)).unwrap();
    for (name, regular, item, least) in pairs {
        for cut in [false, true] {
            let shown = |mut item: Item| {
                if cut {
                    item.clips.push(clip.clone());
                }
                picture(vec![item], &camera, &settings)
            };
            let (regular, found) = (shown(regular.clone()), shown(item.clone()));
            let figures = Comparison::of(&found.image, &regular.image);
            println!("{name}, cut {cut}: {:.1} dB", figures.psnr);
            assert!(figures.psnr > least, "{name}, cut {cut}: {}", figures.psnr);
        }
    }
}

/// A constant field is a constant optical depth per length on stretched, sheared and curved grids, in X-rays.
#[test]
fn constant_fields_are_constant_in_pictures() {
    let look = linear_extinction([0.0, 1.0], 1.0, [1.0; 3]);
    let dims = [24, 26, 28];
    let unit = |i: DVec3| 2.0 * i / DVec3::new(23.0, 25.0, 27.0) - 1.0;
    type Map = fn(DVec3) -> DVec3;
    let maps: [(&str, Map); 3] = [
        ("stretched 1:1:5", |p| DVec3::new(p.x, p.y, 5.0 * p.z)),
        ("sheared", |p| DVec3::new(p.x + 0.6 * p.z, p.y - 0.3 * p.x, p.z)),
        ("curved", |p| {
            let (sin, cos) = (0.8 * p.x).sin_cos();
            DVec3::new((2.5 + p.y) * sin, (2.5 + p.y) * cos - 2.5, p.z)
        }),
    ];
    for (name, map) in maps {
        let mesh = structured(&Constant(1.0), dims, |i| map(unit(i)));
        let length = map(DVec3::new(0.0, 0.0, 1.0)) - map(DVec3::new(0.0, 0.0, -1.0));
        let camera = orthographic(DVec3::ZERO, length.normalize(), 0.8);
        let settings = checked(FlatSettings {
            compositing: splatvol::Compositing::Xray,
            ..unlit(48, 48).into()
        });
        let frame = picture(vec![item(mesh, look.clone())], &camera, &settings);
        let depths: Vec<f64> = frame.optical_depth.iter().map(|d| f64::from(*d)).collect();
        let mean = depths.iter().sum::<f64>() / depths.len() as f64;
        let ripple = depths.iter().map(|d| (d / mean - 1.0).abs()).fold(0.0, f64::max);
        println!(
            "{name}: ripple {:.3} %, depth {mean:.3} of {:.3}",
            100.0 * ripple,
            length.length()
        );
        assert!(ripple < 0.01, "{name}: {ripple}");
    }
}
