//! A scene of one volume gives the volume's picture, wherever it lies.

use glam::{DAffine3, DQuat, DVec3};
use splatvol::{
    Clip, EngineConfig, FlatSettings, Frame, Grid, Item, Keep, Motion, MotionBlur, PointLook, RenderSettings,
    Renderer, Scene, TransferFunction, Volume,
};
use splatvol_testing::transfer::linear_extinction;
use splatvol_testing::{Comparison, sample};
use splatvol_testing::{checked, fields::Noise};

use super::support::{item, sphere, unlit};
use crate::common::perspective;

fn noise() -> Volume {
    let grid = Grid::centred([24, 20, 28], DVec3::new(1.0, 1.3, 0.8)).unwrap();
    sample(&Noise::new(5, 20, DVec3::splat(0.6)), &grid)
}

fn look(unit_distance: Option<f64>) -> TransferFunction {
    let mut look = linear_extinction([-1.0, 1.0], 0.2, [0.9, 0.5, 0.2]);
    look.unit_distance = unit_distance;
    look
}

fn place(scale: f64) -> DAffine3 {
    DAffine3::from_scale_rotation_translation(
        DVec3::splat(scale),
        DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7),
        DVec3::new(3.0, -8.0, 5.0),
    )
}

fn bytes(frame: &Frame) -> Vec<u32> {
    let pixels = frame.image.pixels.iter().flatten();
    pixels.chain(&frame.depth).map(|value| value.to_bits()).collect()
}

/// A placed item and a volume whose grid lies there give the same bytes, from every engine for grids, even if the
/// renderer saw it elsewhere before.
#[test]
fn a_placed_volume_is_the_volume_of_a_grid_at_that_place() {
    let settings = [
        RenderSettings::balanced(),
        RenderSettings::best(),
        RenderSettings::swan1997(),
    ];
    let mut reused = Renderer::new(EngineConfig::default()).unwrap();
    for (scale, distance) in [(1.0, None), (2.5, Some(1.7))] {
        let place = place(scale);
        let mut moved = noise();
        moved.transform(place).unwrap();
        let there = Scene::new(
            moved,
            look(distance.map(|d: f64| d * Item::volume(noise(), look(None)).at(place).scale())),
        );
        let placed = Scene::from(Item::volume(noise(), look(distance)).at(place));
        let centre = place.transform_point3(DVec3::ZERO);
        let camera = perspective(centre, DVec3::new(0.4, 1.0, 0.3), 60.0 * scale, 40.0);
        for settings in settings {
            let settings = RenderSettings {
                size: unlit(96, 80).size,
                ..settings
            };
            let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
            let expected = renderer.render(&there, &camera, &settings).unwrap();
            assert!(expected.image.pixels.iter().any(|pixel| pixel[3] > 0.2));
            let found = reused.render(&placed, &camera, &settings).unwrap();
            assert!(bytes(&found) == bytes(&expected), "{scale} {settings:?}");
        }
    }
}

/// Clips of an item go with it; those of a scene stay.
#[test]
fn clips_of_an_item_go_with_it() {
    let place = place(1.5);
    let plane = Clip::plane(DVec3::new(0.0, 1.0, 2.0), DVec3::new(0.3, -0.2, 1.0)).unwrap();
    let bounds = splatvol::Bounds {
        min: DVec3::splat(-9.0),
        max: DVec3::new(2.0, 3.0, 4.0),
    };
    let corner = Clip::of_box(&bounds, Keep::Outside).unwrap();
    let item = Item::volume(noise(), look(None)).at(place);
    let own = Scene::from(Item {
        clips: vec![plane.clone(), corner.clone()],
        ..item.clone()
    });
    let of_scene = Scene::from(item)
        .with_clip(plane.transformed(&place))
        .with_clip(corner.transformed(&place));
    let camera = perspective(
        place.transform_point3(DVec3::ZERO),
        DVec3::new(0.4, 1.0, 0.3),
        90.0,
        40.0,
    );
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    let mut picture = |scene| renderer.render(scene, &camera, &unlit(64, 64)).unwrap();
    let [a, b] = [&own, &of_scene].map(&mut picture);
    assert!(bytes(&a) == bytes(&b));
    let uncut = picture(&Scene::from(Item::volume(noise(), look(None)).at(place)));
    assert!(Comparison::of(&a.image, &uncut.image).psnr < 30.0);
}

/// An item that moves among others is seen at each of its positions for a share of the time.
#[test]
fn items_move_on_their_own() {
    let sphere = || {
        let look = PointLook {
            color: [1.0, 0.0, 0.0],
            ..PointLook::default()
        };
        item(sphere(2000), look, 1.0)
    };
    let rest = item(sphere_of_green(), PointLook::default(), 1.0);
    let way = DVec3::new(0.0, 0.0, 4.0);
    let moving = Scene::of_items(vec![
        rest.clone(),
        Item {
            motion: Some(Motion::Linear(way)),
            ..sphere()
        },
    ])
    .unwrap();
    let camera = perspective(DVec3::ZERO, DVec3::Y, 20.0, 30.0);
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    let settings = checked(FlatSettings {
        motion_blur: MotionBlur::Subframes { count: 2 },
        ..unlit(64, 64).into()
    });
    let found = renderer.render(&moving, &camera, &settings).unwrap();
    let mut exposure = splatvol::Exposure::new(settings.size);
    for time in [-0.25, 0.25] {
        let at = sphere().at(DAffine3::from_translation(time * way));
        let scene = Scene::of_items(vec![rest.clone(), at]).unwrap();
        let frame = renderer.render(&scene, &camera, &unlit(64, 64)).unwrap();
        exposure.add(&frame).unwrap();
    }
    let mut expected = Frame::empty(settings.size);
    exposure.take(&mut expected).unwrap();
    assert!(bytes(&found) == bytes(&expected));
    // A scene that moves as a whole is seen by a camera that moves the other way.
    let together = moving.with_motion(&Motion::Linear(way));
    let whole = renderer.render(&together, &camera, &settings).unwrap();
    assert!(bytes(&whole) != bytes(&found));
}

/// A green copy of the points, beside the middle.
fn sphere_of_green() -> splatvol::Points {
    let points = sphere(2000);
    let mut attributes = points.attributes().clone();
    attributes.colors = vec![[0, 255, 0, 255]; points.len()];
    points.with_attributes(attributes).unwrap()
}

/// The edges of all kinds of items are sampled.
#[test]
fn coverage_is_of_every_kind() {
    let scene = Scene::from(item(sphere(2000), PointLook::default(), 1.0));
    let camera = perspective(DVec3::ZERO, DVec3::Y, 9.0, 30.0);
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    let settings = RenderSettings {
        coverage: splatvol::Coverage::ADAPTIVE,
        ..unlit(48, 48)
    };
    let plain = renderer.render(&scene, &camera, &unlit(48, 48)).unwrap();
    let sampled = renderer.render(&scene, &camera, &settings).unwrap();
    let count = renderer.statistics().sampled_pixels;
    let changed = plain
        .image
        .pixels
        .iter()
        .zip(&sampled.image.pixels)
        .filter(|(a, b)| a != b);
    assert!((50..1000).contains(&count) && changed.count() as u64 <= count);
    // Four samples per axis of a picture four times as large.
    let fine = renderer.render(&scene, &camera, &unlit(192, 192)).unwrap();
    let mean = |frame: &Frame| {
        let sum: f64 = frame.image.pixels.iter().map(|pixel| f64::from(pixel[3])).sum();
        sum / frame.image.pixels.len() as f64
    };
    assert!(
        (mean(&sampled) - mean(&fine)).abs() < 2e-3 * mean(&fine),
        "{} {}",
        mean(&sampled),
        mean(&fine)
    );
}
