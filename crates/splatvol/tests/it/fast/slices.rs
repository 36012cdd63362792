//! Thick slices: voxels four and seven times as long as wide, seen at angles at which each is a long tilted ellipsoid whose
//! footprints on neighbouring sheets lie beside each other.

use glam::DVec3;
use splatvol::{Camera, Filter, FlatSettings, Grid, Projection, RenderSettings, Scene};
use splatvol_testing::fields::Noise;
use splatvol_testing::{Comparison, checked, sample};

use super::agreement::pictures_from;
use super::support::{fast, translucent};

const PIXELS: u32 = 256;

/// Noise that slices of this thickness resolve.
pub(crate) fn slices(thickness: f64) -> Scene {
    let noise = Noise::new(11, 40, DVec3::new(1.2, 1.2, 1.2 / thickness));
    let count = (48.0 / thickness) as usize;
    let grid = Grid::centred([48, 48, count], DVec3::new(1.0, 1.0, thickness)).unwrap();
    Scene::new(sample(&noise, &grid), translucent())
}

/// A camera that looks at the scene's middle, at an angle from the slices' normal, degrees.
pub(crate) fn tilted(scene: &Scene, angle: f64, is_perspective: bool) -> Camera {
    let bounds = scene.bounds().unwrap();
    let target = bounds.centre();
    let (sin, cos) = angle.to_radians().sin_cos();
    let direction = DVec3::new(0.8 * sin, 0.6 * sin, cos);
    let projection = match is_perspective {
        true => Projection::Perspective { fov_degrees: 30.0 },
        false => Projection::Orthographic { height: 60.0 },
    };
    Camera::new(
        target + direction * 130.0,
        target,
        DVec3::new(0.0, 1.0, 0.01),
        projection,
    )
    .unwrap()
}

fn settings() -> RenderSettings {
    checked(FlatSettings {
        filter: Filter::None,
        ..fast(PIXELS, PIXELS).into()
    })
}

/// Angles from the slices' normal, degrees, and PSNR in dB, one below the least that is measured of both thicknesses and
/// projections.
const DEMANDS: [(f64, f64); 5] = [
    (0.0, 28.2),
    (10.0, 29.7),
    (30.0, 32.3),
    (55.0, 33.3),
    (80.0, 31.2),
];

#[test]
fn pictures_of_thick_slices_agree_with_the_reference() {
    for thickness in [4.0, 7.0] {
        let scene = slices(thickness);
        for (angle, demanded) in DEMANDS {
            for is_perspective in [true, false] {
                let camera = tilted(&scene, angle, is_perspective);
                let (found, expected) = pictures_from(&scene, &camera, &settings());
                let psnr = Comparison::of(&found, &expected).psnr;
                let name = format!("1:{thickness} at {angle} degrees, perspective: {is_perspective}");
                println!("{name}: {psnr:.1} dB");
                assert!(psnr > demanded, "{name}: {psnr:.2} dB, demanded {demanded}");
            }
        }
    }
}
