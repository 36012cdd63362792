//! Label maps: values are names, which nothing may mix.

use glam::{DAffine3, DVec3};
use splatvol::{
    Camera, Classification, ColorPoint, Compositing, FlatSettings, Frame, Grid, ImageSize, Item, LengthUnit,
    OpacityPoint, RenderSettings, Rescale, Samples, Scene, TransferFunction, View, Volume, check,
};
use splatvol_testing::checked;

use super::support;
use crate::common::PROJECTIONS;

const N: usize = 28;

/// A ball of two kinds, one half of each, in nothing.
fn ball(names: [u8; 2]) -> Volume {
    let grid = Grid::centred([N; 3], DVec3::ONE).unwrap();
    let middle = (N as f64 - 1.0) / 2.0;
    let name = |i: usize| {
        let at = DVec3::new((i % N) as f64, (i / N % N) as f64, (i / (N * N)) as f64) - middle;
        match at.length() < 10.0 {
            true => names[usize::from(at.x + at.y > 1.0)],
            false => 0,
        }
    };
    let samples: Vec<u8> = (0..N * N * N).map(name).collect();
    Volume::new(
        grid,
        Samples::U8(samples.into()),
        Rescale::default(),
        LengthUnit::Unknown,
    )
    .unwrap()
}

/// Colours of names, each with a width of its own around it: red, green and blue for 1, 2, 3 in this order.
fn look(colors: [[f64; 3]; 3]) -> TransferFunction {
    let mut points = Vec::new();
    for (name, color) in (1..).zip(colors) {
        let name = f64::from(name);
        points.extend([-0.5, 0.49].map(|from| ColorPoint::new(name + from, color)));
    }
    let opacities = [(0.0, 0.0), (0.49, 0.0), (0.5, 0.9), (3.0, 0.9)];
    let opacities = opacities.map(|(value, opacity)| OpacityPoint::new(value, opacity));
    TransferFunction::new(points, opacities.to_vec(), None).unwrap()
}

const RED: [f64; 3] = [1.0, 0.0, 0.0];
const GREEN: [f64; 3] = [0.0, 1.0, 0.0];
const BLUE: [f64; 3] = [0.0, 0.0, 1.0];

fn camera() -> Camera {
    let bounds = Grid::centred([N; 3], DVec3::ONE).unwrap().bounds();
    Camera::framing(&bounds, View::Iso, PROJECTIONS[0], 1.2).unwrap()
}

fn picture(items: Vec<Item>, settings: &RenderSettings) -> Frame {
    support::picture(items, &camera(), settings)
}

fn small(settings: RenderSettings) -> RenderSettings {
    RenderSettings {
        size: ImageSize::new(72, 60).unwrap(),
        ..settings
    }
}

/// Largest green of any pixel.
fn green(frame: &Frame) -> f32 {
    frame
        .image
        .pixels
        .iter()
        .map(|pixel| pixel[1])
        .fold(0.0, f32::max)
}

fn largest_difference(a: &Frame, b: &Frame) -> f32 {
    let pixels = a.image.pixels.iter().zip(&b.image.pixels);
    pixels
        .flat_map(|(a, b)| (0..4).map(|c| (a[c] - b[c]).abs()))
        .fold(0.0, f32::max)
}

/// Renaming the kinds changes no pixel; it would if they were lit by differences of names.
#[test]
fn names_are_names() {
    for settings in [small(RenderSettings::default()), small(RenderSettings::best())] {
        let item = |names, colors| Item::labels(ball(names), look(colors));
        let one = picture(vec![item([1, 3], [RED, GREEN, BLUE])], &settings);
        let other = picture(vec![item([3, 1], [BLUE, GREEN, RED])], &settings);
        let difference = largest_difference(&one, &other);
        assert!(difference < 2e-5, "{difference}");
        assert!(one.image.pixels.iter().any(|pixel| pixel[3] > 0.9));
        let pre = checked(FlatSettings {
            classification: Classification::Pre,
            ..settings.into()
        });
        let values = |names, colors| Item::volume(ball(names), look(colors));
        let one = picture(vec![values([1, 3], [RED, GREEN, BLUE])], &pre);
        let other = picture(vec![values([3, 1], [BLUE, GREEN, RED])], &pre);
        assert!(largest_difference(&one, &other) > 0.05);
    }
}

/// Between 1 and 3 there is no 2, alone or beside data that are post-classified, which keep their own way.
#[test]
fn nothing_lies_between_two_names() {
    // Highlights are white.
    let settings = RenderSettings {
        lighting: None,
        ..small(RenderSettings::default())
    };
    let labels = || Item::labels(ball([1, 3]), look([RED, GREEN, BLUE]));
    let values = || Item::volume(ball([1, 3]), look([RED, GREEN, BLUE]));
    let alone = picture(vec![labels()], &settings);
    assert!(green(&alone) < 1e-6, "{}", green(&alone));
    assert!(green(&picture(vec![values()], &settings)) > 0.2);
    // Far behind the ball, and out of the picture.
    let away = |item: Item, x: f64| item.at(DAffine3::from_translation(DVec3::new(x, 0.0, 0.0)));
    let both = picture(vec![labels(), away(values(), 500.0)], &settings);
    assert_eq!(both.image.pixels, alone.image.pixels);
    let both = picture(vec![labels(), away(values(), 9.0)], &settings);
    assert!(green(&both) > 0.2);
}

#[test]
fn what_names_have_not_is_refused() {
    let settings = checked(FlatSettings {
        compositing: Compositing::Mip,
        ..small(RenderSettings::default()).into()
    });
    let scene = Scene::from(Item::labels(ball([1, 3]), look([RED, GREEN, BLUE])));
    let error = check(&scene, &camera(), &settings).unwrap_err().to_string();
    assert!(
        error.starts_with("a label map cannot be rendered: maxima"),
        "{error}"
    );
}
