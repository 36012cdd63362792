//! Teaches: several things in one picture, each with its own look: an isosurface that is cut open, translucent material
//! inside it, points, and 3-D Gaussians.
//!
//! `cargo run --release --example 04_scene [scene.png]`

use splatvol::glam::{DAffine3, DVec3};
use splatvol::samples::{Sample, SampleSize};
use splatvol::{
    Bounds, Camera, Clip, EngineConfig, GaussianAttributes, Gaussians, ImageSize, Isosurface, Item, Keep,
    PointAttributes, PointLook, Points, Projection, RenderSettings, Renderer, Scene, SceneError, View, io,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let output = std::env::args().nth(1).unwrap_or_else(|| "scene.png".to_owned());

    let ball = Sample::Ball.generate(Some(SampleSize::Longest(32)))?;
    let bounds = ball.grid().bounds();
    let radius = 0.5 * bounds.diagonal() / 3f64.sqrt();

    let scene = Scene::of_items(vec![
        shell(ball, &bounds)?,
        inside(radius)?,
        ring(1.2 * radius)?,
        fuzz(radius)?,
    ])?;
    let settings = RenderSettings::default().with_size(ImageSize::new(480, 360)?);
    let aspect = settings.size.aspect();
    let camera = Camera::framing(&scene.bounds()?, View::Iso, Projection::default(), aspect)?;
    let frame = Renderer::new(EngineConfig::default())?.render(&scene, &camera, &settings)?;
    io::write_frame(&output, &frame, &[])?;
    println!("wrote {output}");
    Ok(())
}

/// A surface of the ball, exact and infinitely thin, without the eighth that faces the camera.
fn shell(ball: splatvol::Volume, bounds: &Bounds) -> Result<Item, SceneError> {
    let surface = Isosurface {
        value: 0.15,
        rgb: [0.85, 0.75, 0.6],
        opacity: 1.0,
    };
    let mut shell = Item::isosurfaces(ball, &[surface])?;
    let centre = bounds.centre();
    let eighth = Bounds {
        min: DVec3::new(bounds.min.x, centre.y, centre.z),
        max: DVec3::new(centre.x, bounds.max.y, bounds.max.z),
    };
    shell.clips.push(Clip::of_box(&eighth, Keep::Outside)?);
    Ok(shell)
}

/// A head, translucent where it is soft, made small enough to lie in the ball.
fn inside(radius: f64) -> Result<Item, Box<dyn std::error::Error>> {
    let head = Sample::Head.generate(Some(SampleSize::Longest(80)))?;
    let bounds = head.grid().bounds();
    let scale = DAffine3::from_scale(DVec3::splat(2.2 * radius / bounds.diagonal()));
    let place = scale * DAffine3::from_translation(-bounds.centre());
    Ok(Item::automatic(head).at(place))
}

/// Points around the ball: discs with normals, green on one side and blue on the other.
fn ring(radius: f64) -> Result<Item, SceneError> {
    let count = 4000;
    let mut attributes = PointAttributes::default();
    let mut positions = Vec::new();
    for i in 0..count {
        // The golden angle spreads points evenly around the tube while they go around the ring once.
        let along = f64::from(i) / f64::from(count) * std::f64::consts::TAU;
        let around = f64::from(i) * 2.399_963;
        let (out, up) = (around.cos(), around.sin());
        let normal = [along.cos() * out, along.sin() * out, up];
        let tube = 0.06 * radius;
        let centre = [along.cos() * radius, along.sin() * radius, 0.0];
        positions.push(std::array::from_fn(|axis| {
            (centre[axis] + tube * normal[axis]) as f32
        }));
        attributes.normals.push(normal.map(|component| component as f32));
        let share = 0.5 + 0.5 * along.sin();
        attributes
            .colors
            .push([40, 90 + (120.0 * share) as u8, 210 - (140.0 * share) as u8, 255]);
    }
    attributes.radii = vec![0.018 * radius as f32; positions.len()];
    let points = Points::new(positions, attributes, DAffine3::IDENTITY)?;
    Ok(Item::points(points, PointLook::default()))
}

/// A cloud of soft Gaussians above the ball.
fn fuzz(radius: f64) -> Result<Item, SceneError> {
    let mut cloud = GaussianAttributes::default();
    for i in 0..40u8 {
        let angle = f64::from(i) * 2.399_963;
        let out = radius * (f64::from(i) / 40.0).sqrt();
        cloud
            .means
            .push([angle.cos() * out, angle.sin() * out, 0.75 * radius].map(|c| c as f32));
        cloud
            .scales
            .push([0.09, 0.09, 0.03].map(|scale| scale * radius as f32));
        cloud.rotations.push([0.0, 0.0, 0.0, 1.0]);
        cloud.opacities.push(0.35);
        // Degree 0 of the harmonics: colour = 0.5 + 0.282 c.
        cloud.harmonics.push([1.2, 1.2, 1.6]);
    }
    Ok(Item::gaussians(Gaussians::new(cloud, 0, DAffine3::IDENTITY)?))
}
