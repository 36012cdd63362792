//! Layers: volumes keep their own classification, kernel and light beside other things.

use glam::{DAffine3, DVec3};
use splatvol::{
    EngineConfig, Frame, Grid, Item, PointLook, RenderSettings, Renderer, Scene, TransferFunction, Volume,
};
use splatvol_testing::fields::Noise;
use splatvol_testing::transfer::linear_extinction;
use splatvol_testing::{Comparison, sample};

use super::support::{item, picture, sphere, unlit};
use crate::common::perspective;

fn noise(seed: u64) -> Volume {
    let grid = Grid::centred([24, 20, 28], DVec3::new(1.0, 1.3, 0.8)).unwrap();
    sample(&Noise::new(seed, 20, DVec3::splat(0.6)), &grid)
}

fn look(opacity: f64) -> TransferFunction {
    linear_extinction([-1.0, 1.0], opacity, [0.9, 0.5, 0.2])
}

fn lit(side: u32) -> RenderSettings {
    RenderSettings {
        lighting: RenderSettings::default().lighting,
        ..unlit(side, side)
    }
}

fn moved(item: Item, by: DVec3) -> Item {
    Item {
        world_from_item: DAffine3::from_translation(by) * item.world_from_item,
        ..item
    }
}

/// Pixels that differ, and of these how many lie left of a column.
fn differing(a: &Frame, b: &Frame, column: u32) -> [usize; 2] {
    let size = a.image.size();
    let bits = |frame: &Frame, x: u32, y: u32| frame.image.pixel(x as usize, y as usize).map(f32::to_bits);
    let mut counts = [0; 2];
    for y in 0..size.height() {
        for x in 0..size.width() {
            if bits(a, x, y) != bits(b, x, y) {
                counts[0] += 1;
                counts[1] += usize::from(x < column);
            }
        }
    }
    counts
}

/// Where points do not reach, a volume among them has the same bytes as the volume alone, far and near.
#[test]
fn points_beside_a_volume_change_only_their_own_pixels() {
    let volume = Item::volume(noise(5), look(0.2));
    let points = moved(
        item(sphere(2000), PointLook::default(), 3.0),
        DVec3::new(40.0, 0.0, 0.0),
    );
    for distance in [120.0, 190.0, 400.0] {
        let camera = perspective(DVec3::new(15.0, 0.0, 0.0), DVec3::Y, distance, 30.0);
        let settings = lit(96);
        let alone = picture(vec![volume.clone()], &camera, &settings);
        let both = picture(vec![volume.clone(), points.clone()], &camera, &settings);
        let right_of_the_volume = camera.screen_from_camera(settings.size).project(
            camera
                .camera_from_world()
                .transform_point3(DVec3::new(24.0, 0.0, 0.0)),
        );
        let column = right_of_the_volume.x as u32;
        let flipped = camera.camera_from_world().transform_vector3(DVec3::X).x < 0.0;
        let [differ, left] = differing(&alone, &both, column);
        let wrong = if flipped { differ - left } else { left };
        assert!(differ > 5, "{distance}: the points are seen");
        assert!(
            wrong == 0,
            "{distance}: {wrong} of {differ} pixels of the volume changed"
        );
    }
}

/// Two volumes in one place, each half as dense, are one volume.
#[test]
fn two_halves_of_a_medium_are_the_medium() {
    let camera = perspective(DVec3::ZERO, DVec3::new(0.3, 1.0, -0.2), 90.0, 30.0);
    let settings = unlit(64, 64);
    let whole = picture(vec![Item::volume(noise(5), look(0.2))], &camera, &settings);
    let half = || Item::volume(noise(5), look(0.1));
    let halves = picture(vec![half(), half()], &camera, &settings);
    let figures = Comparison::of(&halves.image, &whole.image);
    assert!(figures.psnr > 50.0, "{}", figures.psnr);
}

/// Volumes of different spacing, which alone have sheets of their own, look in one picture as each does
/// alone.
#[test]
fn volumes_of_different_spacing_stand_side_by_side() {
    let fine = Item::volume(noise(5), look(0.2));
    let coarse = Item {
        world_from_item: DAffine3::from_translation(DVec3::new(60.0, 0.0, 0.0))
            * DAffine3::from_scale(DVec3::splat(1.7)),
        ..Item::volume(noise(6), look(0.2))
    };
    let camera = perspective(DVec3::new(30.0, 0.0, 0.0), DVec3::Y, 250.0, 30.0);
    let settings = lit(128);
    let both = picture(vec![fine.clone(), coarse.clone()], &camera, &settings);
    for (name, alone) in [("fine", fine), ("coarse", coarse)] {
        let alone = picture(vec![alone], &camera, &settings);
        let mut expected = both.image.clone();
        for (pixel, own) in expected.pixels.iter_mut().zip(&alone.image.pixels) {
            if own[3] > 0.0 {
                *pixel = *own;
            }
        }
        let figures = Comparison::of(&both.image, &expected);
        assert!(figures.psnr > 40.0, "{name}: {}", figures.psnr);
    }
}

/// Layers do not depend on threads and tiles.
#[test]
fn layers_are_the_same_bytes_on_any_threads_and_tiles() {
    let scene = Scene::of_items(vec![
        Item::volume(noise(5), look(0.2)),
        item(
            sphere(3000),
            PointLook {
                opacity: 0.4,
                ..PointLook::default()
            },
            12.0,
        ),
        moved(Item::volume(noise(8), look(0.1)), DVec3::new(9.0, 4.0, 6.0)),
    ])
    .unwrap();
    let camera = perspective(DVec3::ZERO, DVec3::new(1.0, -2.0, 0.5), 90.0, 30.0);
    let bits = |config: EngineConfig| -> Vec<[u32; 4]> {
        let mut renderer = Renderer::new(config).unwrap();
        let frame = renderer.render(&scene, &camera, &lit(150)).unwrap();
        frame.image.pixels.iter().map(|p| p.map(f32::to_bits)).collect()
    };
    let one = bits(EngineConfig {
        threads: Some(1),
        ..EngineConfig::default()
    });
    for (threads, tile_edge) in [(7, None), (2, Some(32)), (3, Some(48))] {
        let config = EngineConfig {
            threads: Some(threads),
            tile_edge,
            ..EngineConfig::default()
        };
        assert!(bits(config) == one, "{threads} threads, tiles {tile_edge:?}");
    }
}
