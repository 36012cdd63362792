//! State that a renderer keeps between frames does not affect them.

use splatvol::{Camera, ImageSize, Lighting, Projection, RenderSettings, Scene};
use splatvol_samples::Sample;

use super::modes::{modes, shown};
use super::support::{bits, fast, framing, generated, noise, opaque, render, rendered, renderer};
use crate::common::PROJECTIONS;

/// A frame's scene, camera and settings.
type Shot<'a> = (&'a str, Scene, Camera, RenderSettings);

/// Renders A, B, A, B, A on one renderer; each must equal the frame of a fresh one.
fn demand_no_memory(a: &Shot<'_>, b: &Shot<'_>) {
    let fresh = [a, b].map(|(_, scene, camera, settings)| bits(&render(scene, camera, settings)));
    assert!(fresh[0] != fresh[1], "{} and {} look alike", a.0, b.0);
    let mut kept = renderer();
    for turn in 0..5 {
        let (name, scene, camera, settings) = [a, b][turn % 2];
        let (frame, _) = rendered(&mut kept, scene, camera, settings);
        assert!(
            bits(&frame) == fresh[turn % 2],
            "{name} in turn {turn}, alternating {} and {}",
            a.0,
            b.0
        );
    }
}

fn first() -> Shot<'static> {
    let scene = generated(Sample::Shells, 48);
    let camera = framing(&scene, PROJECTIONS[0], 1.0, 1.0);
    ("first", scene, camera, fast(144, 144))
}

#[test]
fn transfer_functions_take_turns() {
    let (name, scene, camera, settings) = first();
    let other = ("opaque", opaque(&scene), camera, settings);
    demand_no_memory(&(name, scene, camera, settings), &other);
}

#[test]
fn lights_take_turns() {
    let a = first();
    let (_, scene, camera, settings) = a.clone();
    let aside = Lighting {
        direction: [0.6, -0.5, -1.0],
        ..Lighting::default()
    };
    for (name, lighting) in [("aside", Some(aside)), ("unlit", None)] {
        let settings = RenderSettings { lighting, ..settings };
        demand_no_memory(&a, &(name, scene.clone(), camera, settings));
    }
}

#[test]
fn modes_take_turns() {
    let a = first();
    let (_, scene, camera, settings) = a.clone();
    let modes = modes(settings);
    for (name, settings) in modes {
        demand_no_memory(&a, &(name, scene.clone(), camera, settings));
    }
    // Coarse rasters, and levels of detail.
    let close = framing(&scene, PROJECTIONS[1], 1.0, 6.0);
    let far = framing(&scene, PROJECTIONS[0], 1.0, 0.3);
    for pair in modes.windows(2) {
        let [(name, settings), (other, others)] = [pair[0], pair[1]];
        demand_no_memory(
            &(name, scene.clone(), close, settings),
            &(other, scene.clone(), far, others),
        );
    }
}

#[test]
fn transfer_functions_take_turns_in_all_modes() {
    let (name, scene, camera, settings) = first();
    for (mode, settings) in modes(settings) {
        let other = (mode, opaque(&scene), camera, settings);
        let scene = shown(mode, &scene).into_owned();
        demand_no_memory(&(name, scene, camera, settings), &other);
    }
}

#[test]
fn cameras_take_turns() {
    let a = first();
    let (_, scene, _, settings) = a.clone();
    // Close: a coarse raster. Far: two levels blended. Farther: another level alone.
    for (name, projection, zoom) in [
        ("orthographic", PROJECTIONS[1], 1.0),
        ("close", PROJECTIONS[1], 6.0),
        ("far", PROJECTIONS[0], 0.3),
        ("farther", PROJECTIONS[1], 0.2),
        ("narrow", Projection::Perspective { fov_degrees: 12.0 }, 1.3),
    ] {
        let camera = framing(&scene, projection, 1.0, zoom);
        demand_no_memory(&a, &(name, scene.clone(), camera, settings));
    }
}

#[test]
fn sizes_take_turns() {
    let a = first();
    let (_, scene, camera, settings) = a.clone();
    for (name, width, height) in [("small", 48, 40), ("wide", 220, 100), ("tall", 60, 300)] {
        let size = ImageSize::new(width, height).unwrap();
        let settings = RenderSettings { size, ..settings };
        demand_no_memory(&a, &(name, scene.clone(), camera, settings));
    }
}

#[test]
fn volumes_take_turns() {
    let scene = noise();
    let camera = framing(&scene, PROJECTIONS[1], 1.0, 1.0);
    demand_no_memory(&first(), &("noise", scene, camera, fast(120, 90)));
}

#[test]
fn the_other_method_in_between_does_not_show() {
    let (_, scene, camera, settings) = first();
    let best = RenderSettings {
        size: settings.size,
        ..RenderSettings::best()
    };
    let expected = bits(&render(&scene, &camera, &settings));
    let mut kept = renderer();
    for turn in 0..2 {
        let (frame, _) = rendered(&mut kept, &scene, &camera, &settings);
        assert!(bits(&frame) == expected, "turn {turn}");
        kept.render(&scene, &camera, &best).unwrap();
    }
}
