//! Planes stand still: hiding material by a transfer function or a clip moves nothing behind it.

use glam::DVec3;
use splatvol::{
    Classification, Clip, ColorPoint, Compositing, FlatSettings, Frame, Grid, OpacityPoint, RenderSettings,
    Scene, TransferFunction, Volume,
};
use splatvol_testing::{Field, checked, sample};

use super::support::{fast, framing, render};
use crate::common::PROJECTIONS;

/// A multiple neither of a brick nor of a sheet.
const FRONT: DVec3 = DVec3::new(-13.0, 14.3, 9.0);
const BACK: DVec3 = DVec3::new(9.0, -11.1, -9.0);

/// A ball of values above the middle near the camera, and one of values below it behind: `exp(-(d / radius)^4)`.
struct Balls;

const BALLS: [(DVec3, f64, f64); 2] = [(FRONT, 6.0, 0.5), (BACK, 9.0, -0.5)];

impl Field for Balls {
    fn value(&self, world: DVec3) -> f64 {
        let ball = |(centre, radius, height): (DVec3, f64, f64)| {
            let square = (world - centre).length_squared() / (radius * radius);
            height * (-square * square).exp()
        };
        0.5 + BALLS.map(ball).iter().sum::<f64>()
    }

    fn gradient(&self, world: DVec3) -> DVec3 {
        let ball = |(centre, radius, height): (DVec3, f64, f64)| {
            let square = (world - centre).length_squared() / (radius * radius);
            (world - centre) * (-4.0 * height * square * (-square * square).exp() / (radius * radius))
        };
        BALLS.map(ball).into_iter().sum()
    }
}

fn balls() -> Volume {
    sample(&Balls, &Grid::centred([48; 3], DVec3::ONE).unwrap())
}

/// The look of small values, of large ones, or both.
fn look(small: bool, large: bool) -> TransferFunction {
    let opacity = |shown: bool| if shown { 0.2 } else { 0.0 };
    let opacities = [
        (0.0, opacity(small)),
        (0.3, 0.0),
        (0.7, 0.0),
        (1.0, opacity(large)),
    ];
    let colors = vec![
        ColorPoint::new(0.0, [0.9, 0.5, 0.2]),
        ColorPoint::new(1.0, [0.2, 0.4, 0.8]),
    ];
    let opacities = opacities.map(|(value, opacity)| OpacityPoint::new(value, opacity));
    TransferFunction::new(colors, opacities.to_vec(), None).unwrap()
}

fn variants() -> [(&'static str, RenderSettings); 4] {
    let base = fast(150, 130);
    let with = |compositing, classification| {
        checked(FlatSettings {
            compositing,
            classification,
            ..base.into()
        })
    };
    [
        ("fast", base),
        (
            "balanced",
            RenderSettings {
                size: base.size,
                ..RenderSettings::balanced()
            },
        ),
        (
            "pre-classified",
            with(Compositing::ImageSheets, Classification::Pre),
        ),
        ("x-ray", with(Compositing::Xray, Classification::Post)),
    ]
}

/// Numbers of a pixel, to the bit.
fn pixel(frame: &Frame, index: usize) -> [u32; 6] {
    let [r, g, b, a] = frame.image.pixels[index];
    [r, g, b, a, frame.depth[index], frame.optical_depth[index]].map(f32::to_bits)
}

/// Checks that pixels empty in one frame, with empty neighbours, are equal in the two others; returns the number of
/// them that show anything.
fn same_where_empty(empty: &Frame, [a, b]: [&Frame; 2], name: &str) -> usize {
    let [width, height] = <[u32; 2]>::from(empty.image.size()).map(|side| side as usize);
    // X-rays take second differences.
    let is_empty = |x: usize, y: usize| {
        (y - 1..=y + 1).all(|y| (x - 1..=x + 1).all(|x| empty.image.pixel(x, y) == [0.0; 4]))
    };
    let inner = (1..height - 1).flat_map(|y| (1..width - 1).map(move |x| (x, y)));
    let mut seen = 0;
    for (x, y) in inner.filter(|&(x, y)| is_empty(x, y)) {
        let index = y * width + x;
        assert_eq!(pixel(a, index), pixel(b, index), "{name}: pixel {x}, {y}");
        seen += usize::from(a.image.pixels[index][3] > 0.0);
    }
    seen
}

#[test]
fn hiding_what_is_in_front_moves_nothing_behind() {
    let volume = std::sync::Arc::new(balls());
    let scene = |small, large| Scene::new(volume.clone(), look(small, large));
    for projection in PROJECTIONS {
        for (name, settings) in variants() {
            let camera = framing(&scene(true, true), projection, 1.15, 1.0);
            let [both, back, front] = [(true, true), (true, false), (false, true)]
                .map(|(small, large)| render(&scene(small, large), &camera, &settings));
            let name = format!("{name}, {projection:?}");
            let seen = same_where_empty(&front, [&both, &back], &name);
            let hidden = front.image.pixels.iter().filter(|pixel| pixel[3] > 0.0).count();
            assert!(seen > 150 && hidden > 150, "{name}: {seen} and {hidden} pixels");
        }
    }
}

#[test]
fn cutting_what_is_in_front_away_moves_nothing_behind() {
    let scene = Scene::new(balls(), look(true, true));
    for projection in PROJECTIONS {
        let camera = framing(&scene, projection, 1.15, 1.0);
        let away = camera.target() - camera.position();
        let cut = |place: DVec3| {
            let keep_behind = Clip::plane(place, away).unwrap();
            scene.clone().with_clip(keep_behind)
        };
        for (name, settings) in &variants()[..3] {
            let [whole, behind] = [FRONT - 30.0 * away.normalize(), DVec3::ZERO]
                .map(|place| render(&cut(place), &camera, settings));
            let front = render(
                &Scene::new(scene.single_volume().unwrap().volume.clone(), look(false, true)),
                &camera,
                settings,
            );
            let seen = same_where_empty(&front, [&whole, &behind], &format!("{name}, {projection:?}"));
            assert!(seen > 150, "{name}: {seen} pixels");
        }
    }
}
