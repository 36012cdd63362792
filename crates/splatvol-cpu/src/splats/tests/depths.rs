//! Optical depths, front to back and added up, against f64 from the equations.

use fearless_simd::Level;
use glam::{DMat2, DMat3, DVec2, DVec3};
use splatvol_core::splats::{Gather, Gathered, SplatCloud};
use splatvol_scene::{Camera, Frame, Projection};

use super::kernels::kernels;
use super::robust::bits;
use super::{CloudSettings, Renderer, cloud, perspective, settings};
use crate::config::SimdLevel;
use crate::splats::{BlendMode, Cloud, LowPass, Near};

const CUT: f64 = 3.2;
const TERMINATION: f32 = 1e-4;

/// Kernels of masses, then Gaussians of depths, without colours of their own: these come from their places.
fn gathered() -> SplatCloud {
    let splats = kernels(71, 600);
    let gaussians = cloud(73, 300, 0, [0.01, 0.2]);
    let mut gather = Gather::around(DVec3::new(0.1, 0.0, -0.2), 0.1);
    gather.add_splats(splats.len(), |index| splats[index]);
    gather.add_gaussians(&gaussians, &glam::DAffine3::IDENTITY, |index| {
        [0.2, 0.9, index as f32 / 300.0]
    });
    let Gathered { cloud, .. } = gather.finish();
    assert!(cloud.peaks_from == 600);
    cloud
}

fn shown(size: [u32; 2], low_pass: LowPass, blend_mode: BlendMode) -> CloudSettings {
    CloudSettings {
        low_pass,
        near: Near::World(0.05),
        blend_mode,
        ..settings(size[0], size[1])
    }
}

fn render(cloud: &SplatCloud, camera: &Camera, settings: &CloudSettings) -> Frame {
    let mut frame = Frame::empty(settings.size);
    Renderer::new(2, None)
        .expect("the best instructions")
        .render_clouds(&[Cloud::Kernels(cloud)], camera, settings, &mut frame);
    frame
}

/// A kernel on the screen.
struct Footprint {
    depth: f64,
    centre: DVec2,
    inverse: DMat2,
    /// Optical depth in the middle, of a profile that is not cut.
    peak: f64,
    mass: bool,
    color: DVec3,
}

fn project(cloud: &SplatCloud, index: usize, camera: &Camera, settings: &CloudSettings) -> Option<Footprint> {
    let camera_from_local = camera.camera_from_world() * cloud.world_from_local;
    let u = camera_from_local.transform_point3(DVec3::from(cloud.positions[index].map(f64::from)));
    let screen = camera.screen_from_camera(settings.size);
    if screen.perspective && u.z <= 0.05 {
        return None;
    }
    let [xx, xy, xz, yy, yz, zz] = cloud.covariances[index].map(f64::from);
    let linear = camera_from_local.matrix3;
    let own = DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]);
    let covariance = linear * own * linear.transpose();
    let scale = if screen.perspective {
        screen.scale / u.z
    } else {
        screen.scale
    };
    let limit = |pixels: u32| 1.3 * 0.5 * f64::from(pixels) / screen.scale;
    let widest = DVec2::new(limit(settings.size.width()), limit(settings.size.height()));
    let slope = if screen.perspective {
        (u.truncate() / u.z).clamp(-widest, widest)
    } else {
        DVec2::ZERO
    };
    let rows = [DVec3::new(1.0, 0.0, -slope.x), DVec3::new(0.0, 1.0, -slope.y)].map(|row| row * scale);
    let v = |a: usize, b: usize| rows[a].dot(covariance * rows[b]);
    let sharp = DMat2::from_cols_array(&[v(0, 0), v(0, 1), v(0, 1), v(1, 1)]);
    let middle = 0.5 * (v(0, 0) + v(1, 1));
    let least = middle - (0.25 * (v(0, 0) - v(1, 1)).powi(2) + v(0, 1).powi(2)).sqrt();
    let added = match settings.low_pass {
        LowPass::Added(variance) => f64::from(variance),
        LowPass::Lacking(variance) => (f64::from(variance) - least).max(0.0),
    };
    let wide = sharp + DMat2::from_diagonal(DVec2::splat(added));
    let [carried, emission @ ..] = cloud.payloads[index].map(f64::from);
    let mass = index < cloud.peaks_from;
    let peak = if mass {
        let path = (1.0 + slope.length_squared()).sqrt();
        carried * scale * scale * path / (std::f64::consts::TAU * wide.determinant().sqrt())
    } else {
        carried * (sharp.determinant().max(0.0) / wide.determinant()).sqrt()
    };
    Some(Footprint {
        depth: u.z,
        centre: u.truncate() * scale + screen.centre,
        inverse: wide.inverse(),
        peak,
        mass,
        color: DVec3::from(emission.map(|e| e / carried)),
    })
}

impl Footprint {
    /// Optical depth at a pixel's centre.
    fn depth_at(&self, pixel: DVec2) -> f64 {
        let d = pixel - self.centre;
        let half = 0.5 * d.dot(self.inverse * d);
        let edge = (-0.5 * CUT * CUT).exp();
        let above = ((-half).exp() - edge).max(0.0);
        // A cut profile keeps its mass, or its peak.
        let norm = if self.mass {
            1.0 - edge - edge * 0.5 * CUT * CUT
        } else {
            1.0 - edge
        };
        self.peak * above / norm
    }
}

/// Colour and alpha of all pixels.
fn expected(cloud: &SplatCloud, camera: &Camera, settings: &CloudSettings) -> Vec<[f64; 4]> {
    let mut footprints: Vec<Footprint> = (0..cloud.len())
        .filter_map(|index| project(cloud, index, camera, settings))
        .collect();
    footprints.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    let width = settings.size.width() as usize;
    (0..settings.size.pixel_count())
        .map(|i| {
            let pixel = DVec2::new((i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
            let (mut through, mut total, mut color) = (1.0, 0.0, DVec3::ZERO);
            for footprint in &footprints {
                let depth = footprint.depth_at(pixel);
                if let BlendMode::Integral { .. } = settings.blend_mode {
                    color += depth * footprint.color;
                    total += depth;
                } else if through > f64::from(TERMINATION) {
                    let next = through * (-depth).exp();
                    color += (through - next) * footprint.color;
                    through = next;
                }
            }
            if let BlendMode::Integral { .. } = settings.blend_mode {
                through = (-total).exp();
                color *= (1.0 - through) / total.max(1e-300);
            }
            [color.x, color.y, color.z, 1.0 - through]
        })
        .collect()
}

fn cameras() -> [(&'static str, Camera); 3] {
    let orthographic = Projection::Orthographic { height: 2.4 };
    [
        ("wide", perspective(DVec3::new(1.6, 1.1, 0.7), 100.0)),
        ("far", perspective(DVec3::new(5.0, -3.0, 2.0), 25.0)),
        (
            "parallel",
            Camera::new(DVec3::new(3.0, 2.0, 1.0), DVec3::ZERO, DVec3::Z, orthographic).unwrap(),
        ),
    ]
}

const BLEND_MODES: [BlendMode; 2] = [
    BlendMode::Light {
        cut: CUT,
        termination: TERMINATION,
    },
    BlendMode::Integral { cut: CUT },
];

#[test]
fn depths_are_composited_and_added_up_as_the_equations_have_it() {
    let cloud = gathered();
    for (name, camera) in &cameras() {
        for low_pass in [LowPass::Added(0.3), LowPass::Lacking(0.6)] {
            for blend_mode in BLEND_MODES {
                let settings = shown([83, 60], low_pass, blend_mode);
                let frame = render(&cloud, camera, &settings);
                let expected = expected(&cloud, camera, &settings);
                let mut squared = 0.0;
                for (found, expected) in frame.image.pixels.iter().zip(&expected) {
                    squared += (0..4)
                        .map(|c| (f64::from(found[c]) - expected[c]).powi(2))
                        .sum::<f64>();
                }
                let psnr = -10.0 * (squared / (4.0 * expected.len() as f64)).log10();
                println!("{name} {low_pass:?} {blend_mode:?}: {psnr:.1} dB");
                assert!(psnr > 70.0, "{name} {low_pass:?} {blend_mode:?}: {psnr:.1} dB");
            }
        }
    }
}

/// Ten thousand faint splats, none of which would change a pixel of eight bits, are as thick together as one.
#[test]
fn faint_splats_add_up() {
    let one = super::kernels::gathered(&[super::kernels::ball(0.2, 1.0)]);
    let many: Vec<_> = (0..10_000).map(|_| super::kernels::ball(0.2, 1e-4)).collect();
    let many = super::kernels::gathered(&many);
    let (_, camera) = &cameras()[2];
    for blend_mode in BLEND_MODES {
        let settings = shown([60, 60], LowPass::Added(0.3), blend_mode);
        let [one, many] = [&one, &many].map(|cloud| render(cloud, camera, &settings));
        let pairs = one.image.pixels.iter().zip(&many.image.pixels);
        let worst = pairs.map(|(a, b)| (a[3] - b[3]).abs()).fold(0.0, f32::max);
        println!("{blend_mode:?}: {worst:.1e}");
        assert!(worst < 5e-4, "{blend_mode:?}: {worst}");
        assert!(one.image.pixel(30, 30)[3] > 0.5);
    }
}

#[test]
fn bytes_do_not_depend_on_threads_or_instructions() {
    let cloud = gathered();
    let (_, camera) = &cameras()[0];
    for blend_mode in BLEND_MODES {
        let settings = shown([233, 122], LowPass::Lacking(0.3), blend_mode);
        let of = |threads, simd| {
            let mut frame = Frame::empty(settings.size);
            let mut renderer = Renderer::new(threads, simd)?;
            renderer.render_clouds(&[Cloud::Kernels(&cloud)], camera, &settings, &mut frame);
            Some(bits(&frame))
        };
        let expected = of(1, None).expect("the processor's best instructions");
        assert!(of(7, None).as_ref() == Some(&expected), "{:?}", Level::new());
        for simd in SimdLevel::ALL {
            let same = of(2, Some(simd)).is_none_or(|found| found == expected);
            assert!(same, "{blend_mode:?} {simd:?}");
        }
    }
}
