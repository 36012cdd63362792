//! Points on spheres, clouds of Gaussians, and pictures of them.

use glam::{DAffine3, DVec3};
use splatvol::{
    Camera, EngineConfig, Frame, GaussianAttributes, Gaussians, ImageSize, Item, PointAttributes, PointLook,
    Points, RenderSettings, Renderer, Scene,
};
use splatvol_testing::Random;

/// Even points on the unit sphere (Fibonacci's spiral), with normals.
pub(crate) fn sphere(count: usize) -> Points {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let positions: Vec<[f32; 3]> = (0..count)
        .map(|i| {
            let z = 1.0 - 2.0 * (i as f64 + 0.5) / count as f64;
            let (sin, cos) = (golden * i as f64).sin_cos();
            let radius = (1.0 - z * z).sqrt();
            DVec3::new(radius * cos, radius * sin, z).as_vec3().to_array()
        })
        .collect();
    let area = 4.0 * std::f64::consts::PI / count as f64;
    let attributes = PointAttributes {
        normals: positions.clone(),
        radii: vec![area.sqrt() as f32; count],
        ..Default::default()
    };
    Points::new(positions, attributes, DAffine3::IDENTITY).unwrap()
}

/// Points that look like this, of this size.
pub(crate) fn item(points: Points, look: PointLook, scale: f64) -> Item {
    Item::points(points, look).at(DAffine3::from_scale(DVec3::splat(scale)))
}

/// Gaussians at random places within the unit cube.
pub(crate) fn cloud(count: usize, widths: [f64; 2], seed: u64) -> Gaussians {
    let mut random = Random::new(seed);
    let mut attributes = GaussianAttributes::default();
    for _ in 0..count {
        let mean = random.point(DVec3::splat(-1.0), DVec3::ONE);
        attributes.means.push(mean.as_vec3().to_array());
        let width = |random: &mut Random| random.range(widths[0], widths[1]) as f32;
        attributes
            .scales
            .push([width(&mut random), width(&mut random), width(&mut random)]);
        let axis = random.direction().as_vec3();
        attributes
            .rotations
            .push([axis.x, axis.y, axis.z, random.range(-1.0, 1.0) as f32]);
        attributes.opacities.push(random.range(0.2, 0.95) as f32);
        let level = |random: &mut Random| random.range(-1.7, 1.7) as f32;
        attributes
            .harmonics
            .push([level(&mut random), level(&mut random), level(&mut random)]);
    }
    Gaussians::new(attributes, 0, DAffine3::IDENTITY).unwrap()
}

/// The default settings without light.
pub(crate) fn unlit(width: u32, height: u32) -> RenderSettings {
    RenderSettings {
        size: ImageSize::new(width, height).unwrap(),
        lighting: None,
        ..RenderSettings::default()
    }
}

/// A picture by an engine of its own.
pub(crate) fn picture(items: Vec<Item>, camera: &Camera, settings: &RenderSettings) -> Frame {
    pictured(&Scene::of_items(items).unwrap(), camera, settings, None)
}

/// A picture by this many threads.
pub(crate) fn pictured(
    scene: &Scene,
    camera: &Camera,
    settings: &RenderSettings,
    threads: Option<usize>,
) -> Frame {
    let config = EngineConfig {
        threads,
        ..EngineConfig::default()
    };
    Renderer::new(config)
        .unwrap()
        .render(scene, camera, settings)
        .unwrap()
}
