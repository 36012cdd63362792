//! Clips, isosurfaces and operators against the CPU engine's.

use std::sync::Arc;

use splatvol::samples::Sample;
use splatvol::{
    Appearance, Bounds, BumpMap, Clip, EnvironmentMap, GradientOpacity, GradientOpacityPoint, Image,
    ImageSize, Isosurface, Item, Keep, PixelOperator, Region, RenderSettings, Scene, SheetSample,
    SolidTexture, Stuff, TransferFunction2d,
};

use super::common::{PROJECTIONS, both, camera, compare, gpu, scene, sized};

/// A slice out of the volume, a box out of the rest, a cut that belongs to the item, and isosurfaces.
#[test]
fn cuts_and_isosurfaces_are_the_cpu_s() {
    let Some((mut gpu, mut cpu)) = both() else { return };
    let whole = scene(Sample::Head, 32);
    let bounds = whole.bounds().unwrap();
    let middle = bounds.min.lerp(bounds.max, 0.5);
    let corner = Bounds {
        min: middle,
        max: bounds.max,
    };
    let behind = Clip::plane(middle, [0.3, 1.0, 0.1]).unwrap();
    let boxed = Clip::of_box(&corner, Keep::Outside).unwrap();
    let mut cut = whole.clone();
    cut.clips = vec![behind.clone(), boxed.clone()];
    let mut own = whole.clone();
    own.items[0].clips.push(boxed);
    let volume = Arc::clone(whole.single_volume().unwrap().volume);
    let range = volume.value_range();
    let surface = |share: f64, rgb, opacity| Isosurface {
        value: range[0] + share * (range[1] - range[0]),
        rgb,
        opacity,
    };
    let levels = [
        surface(0.3, [0.9, 0.7, 0.6], 0.4),
        surface(0.6, [1.0, 1.0, 0.9], 1.0),
    ];
    let mut surfaces = Scene::from(Item::isosurfaces(volume, &levels).unwrap());
    surfaces.clips.push(behind);
    for (name, scene) in [("cut", &cut), ("own", &own), ("surfaces", &surfaces)] {
        for projection in PROJECTIONS {
            let camera = camera(&whole, projection);
            let settings = sized(RenderSettings::balanced(), 64);
            let what = format!("gpu-{name}");
            let shot = (scene, &camera, &settings);
            compare((&mut gpu, &mut cpu), shot, &what, (43.0, 0.9, 2e-3));
        }
    }
}

/// A smooth picture of two periods across.
fn picture() -> Image {
    let size = ImageSize::new(24, 12).unwrap();
    let pixel = |i: usize| {
        let [x, y] = [i % 24, i / 24].map(|k| 0.26 * k as f32);
        [
            0.5 + 0.5 * (2.0 * x).sin(),
            0.5 + 0.4 * y.cos(),
            0.3 * x % 1.0,
            0.6,
        ]
    };
    Image::from_pixels(size, (0..24 * 12).map(pixel).collect()).unwrap()
}

/// All operators, in lists that a scene may have.
fn lists(scene: &Scene) -> Vec<(&'static str, Vec<Arc<dyn PixelOperator>>)> {
    let bounds: Bounds = scene.bounds().unwrap();
    let volume = scene.single_volume().unwrap().volume;
    let [low, high] = volume.value_range();
    let steepest = 0.4 * (high - low) / volume.grid().mean_spacing();
    let of_value = |share: f64| low + share * (high - low);
    let curve = [(0.05, 0.1), (0.3, 1.0), (0.5, 0.4)].map(|(share, factor)| GradientOpacityPoint {
        gradient: share * steepest,
        factor,
    });
    let region = |value: [f64; 2], rgb, opacity| Region {
        value: value.map(of_value),
        gradient: [0.0, steepest],
        rgb,
        opacity,
        softness: 0.6,
    };
    let regions = [
        region([0.1, 0.5], [0.9, 0.6, 0.3], 0.2),
        region([0.4, 1.0], [0.3, 0.6, 0.9], 0.5),
    ];
    let two_d = TransferFunction2d::new(&regions, 1.0).unwrap();
    let painted = TransferFunction2d::from_image(&picture(), [low, high], [0.0, steepest], 2.0).unwrap();
    let marble = SolidTexture::new(Stuff::Marble, &bounds, 0.3).unwrap();
    let wood = SolidTexture::new(Stuff::Wood, &bounds, 0.3).unwrap();
    let bumps = BumpMap::new(&picture(), &bounds, 0.02).unwrap();
    let mirror = EnvironmentMap::new(&picture(), 0.7).unwrap();
    vec![
        (
            "gradient-opacity",
            vec![Arc::new(GradientOpacity::new(&curve).unwrap())],
        ),
        ("regions", vec![Arc::new(two_d)]),
        ("painted", vec![Arc::new(painted)]),
        ("marble", vec![Arc::new(marble)]),
        ("wood", vec![Arc::new(wood)]),
        ("bumps-and-mirror", vec![Arc::new(bumps), Arc::new(mirror)]),
    ]
}

#[test]
fn operators_are_the_cpu_s() {
    let Some((mut gpu, mut cpu)) = both() else { return };
    let plain = scene(Sample::Ball, 32);
    let settings = sized(RenderSettings::balanced(), 64);
    for (name, operators) in lists(&plain) {
        let mut scene = plain.clone();
        scene.items[0].operators = operators;
        for projection in PROJECTIONS {
            let camera = camera(&plain, projection);
            let what = format!("gpu-{name}");
            compare(
                (&mut gpu, &mut cpu),
                (&scene, &camera, &settings),
                &what,
                (45.0, 0.9, 2e-3),
            );
        }
    }
}

/// An operator that nobody wrote in WGSL.
#[derive(Debug)]
struct OfRust;

impl PixelOperator for OfRust {
    fn apply(&self, _: &SheetSample, appearance: &mut Appearance) {
        appearance.extinction *= 0.5;
    }
}

#[test]
fn an_operator_without_wgsl_is_refused_by_name() {
    let Some(mut gpu) = gpu() else { return };
    let mut scene = scene(Sample::Ball, 16);
    let camera = camera(&scene, PROJECTIONS[0]);
    scene.items[0].operators.push(Arc::new(OfRust));
    let error = gpu
        .render(&scene, &camera, &sized(RenderSettings::fast(), 16))
        .unwrap_err();
    assert!(error.to_string().contains("an operator without WGSL"), "{error}");
}
