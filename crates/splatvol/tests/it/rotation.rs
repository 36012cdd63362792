//! No popping: half-degree steps through 45 degrees, where sheets along the volume's axes would switch.
//!
//! Pictures have 48 x 48 pixels; the reference integrates every third of every third row, all of them in a long test.

use crate::common::settings;
use glam::DVec3;
use splatvol::{
    Camera, ColorPoint, EngineConfig, Grid, OpacityPoint, Projection, Renderer, Scene, TransferFunction,
};
use splatvol_recorded::long;
use splatvol_reference::{ReferenceSettings, render_pixels};
use splatvol_testing::fields::Noise;
use splatvol_testing::sample;

const PIXELS: u32 = 48;

/// Colours of some pixels.
type Colors = Vec<[f64; 4]>;

/// Largest and root-mean-square change of a channel from one frame to the next.
fn change(a: &Colors, b: &Colors) -> [f64; 2] {
    let differences = a.iter().zip(b).flat_map(|(p, q)| (0..4).map(|c| p[c] - q[c]));
    let (largest, squares) = differences.fold((0.0f64, 0.0), |(largest, squares), d| {
        (largest.max(d.abs()), squares + d * d)
    });
    [largest, (squares / (4.0 * a.len() as f64)).sqrt()]
}

#[test]
fn frames_change_no_more_than_the_reference_does() {
    let grid = Grid::centred([24, 24, 24], DVec3::ONE).unwrap();
    let opacities = vec![
        OpacityPoint::new(0.35, 0.0),
        OpacityPoint::new(0.6, 0.2),
        OpacityPoint::new(0.8, 0.9),
    ];
    let colors = vec![
        ColorPoint::new(0.3, [0.2, 0.5, 0.9]),
        ColorPoint::new(0.8, [1.0, 0.8, 0.5]),
    ];
    let tf = TransferFunction::new(colors, opacities, None).unwrap();
    let scene = Scene::new(sample(&Noise::new(45, 40, DVec3::splat(1.4)), &grid), tf);
    let settings = settings(PIXELS);
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    let stride = if long() { 1 } else { 3 };
    let along = || (stride / 2..PIXELS).step_by(stride as usize);
    let pixels: Vec<(u32, u32)> = along().flat_map(|y| along().map(move |x| (x, y))).collect();
    for projection in [
        Projection::Orthographic { height: 36.0 },
        Projection::Perspective { fov_degrees: 30.0 },
    ] {
        let (mut engine, mut reference): (Vec<Colors>, Vec<Colors>) = (Vec::new(), Vec::new());
        for step in 0..=16 {
            let angle = (41.0 + 0.5 * f64::from(step)).to_radians();
            let position = DVec3::new(70.0 * angle.cos(), 70.0 * angle.sin(), 15.0);
            let camera = Camera::new(position, DVec3::ZERO, DVec3::Z, projection).unwrap();
            let options = ReferenceSettings {
                tolerance: 1e-5,
                ..ReferenceSettings::default()
            };
            let image = renderer.render(&scene, &camera, &settings).unwrap().image;
            let color = |&(x, y): &(u32, u32)| image.pixel(x as usize, y as usize).map(f64::from);
            engine.push(pixels.iter().map(color).collect());
            let exact = render_pixels(&scene, &camera, &settings, &options, &pixels).unwrap();
            reference.push(exact.iter().map(|pixel| pixel.rgba).collect());
        }
        let most = |frames: &[Colors]| {
            let changes = frames.windows(2).map(|pair| change(&pair[0], &pair[1]));
            changes.fold([0.0f64; 2], |most, c| [most[0].max(c[0]), most[1].max(c[1])])
        };
        let (found, exact) = (most(&engine), most(&reference));
        println!("{projection:?}: largest and rms change {found:.4?}, reference {exact:.4?}");
        assert!(
            found[0] <= 2.0 * exact[0] && found[1] <= 1.1 * exact[1],
            "{found:?} {exact:?}"
        );
    }
}
