//! Time from a stop to the return, 1024 x 1024, for every engine: ten stops, spread over the rendering time of a
//! picture.
//!
//! ```text
//! cargo bench -p splatvol --bench cancel [-- NAME]
//! ```
//!
//! A line has the time of the whole picture, and the median and the largest of the ten. *First* pictures have to
//! prepare what later ones of the same scene reuse.
#![allow(clippy::unwrap_used, reason = "a bench")]

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use glam::{DAffine3, DVec3};
use splatvol::{
    Alignment, Camera, Classification, Compositing, Control, EngineConfig, FlatSettings, Frame,
    GaussianAttributes, GaussianMode, Gaussians, ImageSize, Item, Occlusion, PointAttributes, PointLook,
    Points, Projection, RenderSettings, Renderer, Scene, SceneError, View,
};
use splatvol_samples::{Sample, SampleSize};
use splatvol_testing::{Random, checked};

const STOPS: u32 = 10;
const SIDE: u32 = 1024;

struct Case {
    name: &'static str,
    scene: Scene,
    settings: RenderSettings,
}

fn head(side: usize) -> Item {
    let volume = Sample::Head.generate(Some(SampleSize::Longest(side))).unwrap();
    Item::volume(volume, Sample::Head.default_transfer_function().unwrap())
}

/// Surfels on a sphere about as large as the head.
fn sphere(count: usize) -> Item {
    let mut random = Random::new(3);
    let positions: Vec<[f32; 3]> = (0..count)
        .map(|_| random.direction().as_vec3().to_array())
        .collect();
    let spacing = (4.0 * std::f64::consts::PI / count as f64).sqrt() as f32;
    let attributes = PointAttributes {
        normals: positions.clone(),
        radii: vec![spacing; count],
        ..PointAttributes::default()
    };
    let points = Points::new(positions, attributes, DAffine3::IDENTITY).unwrap();
    Item::points(points, PointLook::default()).at(DAffine3::from_scale(DVec3::splat(110.0)))
}

/// Gaussians of all shapes in a cube.
fn gaussians(count: usize) -> Item {
    let mut random = Random::new(7);
    let mut made = GaussianAttributes::default();
    for _ in 0..count {
        let mean = random.point(DVec3::splat(-1.0), DVec3::ONE);
        made.means.push(mean.as_vec3().to_array());
        made.scales
            .push([(); 3].map(|()| random.range(0.001, 0.01) as f32));
        let [x, y, z] = random.direction().as_vec3().to_array();
        made.rotations.push([x, y, z, random.range(-1.0, 1.0) as f32]);
        made.opacities.push(random.range(0.05, 0.9) as f32);
        made.harmonics.push([random.range(-1.7, 1.7) as f32; 3]);
    }
    Item::gaussians(Gaussians::new(made, 0, DAffine3::IDENTITY).unwrap())
}

fn cases() -> Vec<Case> {
    let sized = |settings| RenderSettings {
        size: ImageSize::new(SIDE, SIDE).unwrap(),
        ..settings
    };
    let default = sized(RenderSettings::default());
    let of = |compositing| {
        checked(FlatSettings {
            compositing,
            classification: Classification::Pre,
            ..default.into()
        })
    };
    let case = |name, items: Vec<Item>, settings| Case {
        name,
        scene: Scene::of_items(items).unwrap(),
        settings,
    };
    let volumetric = RenderSettings {
        gaussians: GaussianMode::Volumetric,
        ..default
    };
    let exact = checked(FlatSettings {
        alignment: Alignment::Exact,
        ..of(Compositing::PerSplat).into()
    });
    let table = checked(FlatSettings {
        occlusion: Occlusion::Sat,
        ..of(Compositing::PerSplat).into()
    });
    let sections = checked(FlatSettings {
        alignment: Alignment::Affine,
        ..of(Compositing::ImageSheets).into()
    });
    let along_axis = checked(FlatSettings {
        alignment: Alignment::Affine,
        ..of(Compositing::Xray).into()
    });
    vec![
        case("sheets", vec![head(256)], default),
        case(
            "sheets, pre-classified",
            vec![head(256)],
            of(Compositing::ImageSheets),
        ),
        case("sheets, X-ray", vec![head(256)], of(Compositing::Xray)),
        case("sheets, MIP", vec![head(256)], of(Compositing::Mip)),
        case("sheets, points", vec![sphere(300_000)], default),
        case("sheets, layers", vec![head(128), sphere(100_000)], default),
        case("sheets, volumetric", vec![gaussians(200_000)], volumetric),
        case("splats, 3dgs", vec![gaussians(1_370_000)], default),
        case(
            "splats, light",
            vec![head(128), sphere(300_000)],
            of(Compositing::PerSplat),
        ),
        case(
            "splats, X-ray",
            vec![head(128), sphere(300_000)],
            of(Compositing::Xray),
        ),
        case("classic, per splat", vec![head(128)], of(Compositing::PerSplat)),
        case("classic, exact", vec![head(128)], exact),
        case(
            "classic, axis sheets",
            vec![head(128)],
            of(Compositing::AxisSheets),
        ),
        case("classic, sections", vec![head(128)], sections),
        case("classic, X-ray", vec![head(128)], along_axis),
        case("classic, occlusion table", vec![head(128)], table),
        case("best", vec![head(128)], sized(RenderSettings::best())),
    ]
}

fn renderer() -> Renderer {
    let config = EngineConfig {
        threads: Some(2),
        ..EngineConfig::default()
    };
    Renderer::new(config).unwrap()
}

impl Case {
    fn camera(&self) -> Camera {
        let projection = Projection::Perspective { fov_degrees: 30.0 };
        Camera::framing(&self.scene.bounds().unwrap(), View::Iso, projection, 1.0).unwrap()
    }

    fn render(
        &self,
        renderer: &mut Renderer,
        frame: &mut Frame,
        control: &Control<'_>,
    ) -> Result<(), SceneError> {
        renderer.render_with(&self.scene, &self.camera(), &self.settings, frame, control)
    }

    /// Rendering time of a picture that is not stopped.
    fn time(&self, renderer: &mut Renderer, frame: &mut Frame) -> Duration {
        let start = Instant::now();
        self.render(renderer, frame, &Control::default()).unwrap();
        start.elapsed()
    }

    /// Time from a stop after this time to the return; `None` if the picture was finished by then.
    fn stopped(&self, renderer: &mut Renderer, frame: &mut Frame, after: Duration) -> Option<Duration> {
        let stop = AtomicBool::new(false);
        let control = Control {
            stop: Some(&stop),
            ..Control::default()
        };
        std::thread::scope(|threads| {
            let stopper = threads.spawn(|| {
                std::thread::sleep(after);
                stop.store(true, Ordering::Relaxed);
                Instant::now()
            });
            let result = self.render(renderer, frame, &control);
            let returned = Instant::now();
            let stopped = stopper.join().unwrap();
            result.is_err().then(|| returned - stopped)
        })
    }

    fn measure(&self, first: bool) {
        let mut kept = renderer();
        let mut frame = Frame::empty(self.settings.size);
        if !first {
            self.time(&mut kept, &mut frame);
        }
        let whole = self.time(&mut kept, &mut frame);
        let mut times: Vec<Duration> = (0..STOPS)
            .filter_map(|k| {
                if first {
                    kept = renderer();
                }
                let after = whole.mul_f64((f64::from(k) + 0.5) / f64::from(STOPS));
                self.stopped(&mut kept, &mut frame, after)
            })
            .collect();
        times.sort();
        let ms = |time: Option<&Duration>| time.map_or(f64::NAN, |time| 1e3 * time.as_secs_f64());
        println!(
            "{:<28} {:<6} {:>9.1} ms   middle {:>6.1} ms   largest {:>6.1} ms   of {}",
            self.name,
            if first { "first" } else { "next" },
            1e3 * whole.as_secs_f64(),
            ms(times.get(times.len() / 2)),
            ms(times.last()),
            times.len()
        );
    }
}

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    for case in cases() {
        if wanted.is_empty() || wanted.iter().any(|name| case.name.contains(name.as_str())) {
            case.measure(false);
            case.measure(true);
        }
    }
}
