//! Time of a frame of 1024 x 1024 pixels: one figure, three by three of it (1.37 million), and these with a point
//! beside them; and of shares of a frame of 512 x 512, as workers without common memory draw them.
//!
//! ```text
//! cargo bench -p splatvol --bench gaussians
//! ```
//!
//! The figure is made up: 152,746 Gaussians on an upright cylinder, flat on it, with the quantiles of scales and
//! opacities that a captured person has (`biker.spz` of `playcanvas`). An item is a Gaussian.

use std::fmt;

use divan::Bencher;
use divan::counter::ItemsCount;
use glam::{DAffine3, DQuat, DVec3};
use splatvol::{Control, EngineConfig, Frame, Renderer, Share, SimdLevel};
use splatvol_scene::{
    Camera, GaussianAttributes, Gaussians, ImageSize, Item, PointAttributes, PointLook, Points, Projection,
    RenderSettings, Scene, View,
};

const SPLATS: usize = 152_746;

fn main() {
    divan::main();
}

/// PCG (O'Neill 2014).
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let word = (((self.0 >> 18) ^ self.0) >> 27) as u32;
        f64::from(word.rotate_right((self.0 >> 59) as u32)) / f64::from(u32::MAX)
    }

    /// Normal to within a percent or so: the sum of twelve (Irwin-Hall).
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.unit()).sum::<f64>() - 6.0
    }
}

fn figure(place: DVec3) -> Gaussians {
    let mut random = Random(42);
    let mut made = GaussianAttributes::default();
    for _ in 0..SPLATS {
        let angle = std::f64::consts::TAU * random.unit();
        let outwards = DVec3::new(angle.cos(), angle.sin(), 0.0);
        let mean = (0.3 + 0.01 * random.normal()) * outwards + 3.2 * random.unit() * DVec3::Z;
        made.means.push(mean.as_vec3().to_array());
        let medians_and_spreads = [(0.0132, 0.65), (0.0029, 1.0), (0.0006, 0.9)];
        made.scales.push(
            medians_and_spreads.map(|(median, spread)| (median * (spread * random.normal()).exp()) as f32),
        );
        let normal =
            (outwards + 0.3 * DVec3::new(random.normal(), random.normal(), random.normal())).normalize();
        let spin = DQuat::from_rotation_z(std::f64::consts::TAU * random.unit());
        let rotation = DQuat::from_rotation_arc(DVec3::Z, normal) * spin;
        made.rotations.push(rotation.as_quat().to_array());
        made.opacities
            .push((1.0 / (1.0 + (1.6 - 1.7 * random.normal()).exp())) as f32);
        made.harmonics
            .push([(); 3].map(|()| (random.unit() - 0.5) as f32));
    }
    Gaussians::new(made, 0, DAffine3::from_translation(place)).expect("a valid cloud")
}

/// One point in front of them.
fn point() -> Item {
    let attributes = PointAttributes {
        radii: vec![0.1],
        ..PointAttributes::default()
    };
    let point = Points::new(vec![[0.5, 0.5, 3.0]], attributes, DAffine3::IDENTITY);
    Item::points(point.expect("a valid point"), PointLook::default())
}

#[derive(Clone, Copy)]
struct Case {
    figures: usize,
    /// Adds a point beside them.
    point: bool,
    threads: usize,
    simd: Option<SimdLevel>,
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let simd = self.simd.map_or("best".to_owned(), |simd| format!("{simd:?}"));
        let beside = if self.point { " and a point" } else { "" };
        write!(
            f,
            "{} figures{beside}, {} threads, {simd}",
            self.figures, self.threads
        )
    }
}

fn cases() -> Vec<Case> {
    let case = |figures, threads, simd| Case {
        figures,
        point: false,
        threads,
        simd,
    };
    let with_point = |case| Case { point: true, ..case };
    let levels = SimdLevel::ALL.into_iter().filter(|level| level.is_available());
    let mut cases = vec![
        case(1, 1, None),
        case(1, 2, None),
        case(9, 1, None),
        case(9, 2, None),
        with_point(case(9, 1, None)),
        with_point(case(9, 2, None)),
    ];
    cases.extend(levels.map(|level| case(1, 1, Some(level))));
    cases
}

#[divan::bench(args = cases())]
fn frame(bencher: Bencher<'_, '_>, case: Case) {
    let places = (0..case.figures).map(|i| 1.4 * DVec3::new((i % 3) as f64, (i / 3) as f64, 0.0));
    let figures = places.map(|place| Item::gaussians(figure(place)));
    let point = case.point.then(point);
    let scene = Scene::of_items(figures.chain(point).collect()).expect("valid items");
    let size = ImageSize::new(1024, 1024).expect("a valid size");
    let projection = Projection::Perspective { fov_degrees: 40.0 };
    let bounds = scene.bounds().expect("a box of figures");
    let camera = Camera::framing(&bounds, View::Iso, projection, size.aspect()).expect("a valid camera");
    let mut renderer = Renderer::new(EngineConfig {
        threads: Some(case.threads),
        simd: case.simd,
        ..EngineConfig::default()
    })
    .expect("threads");
    let settings = RenderSettings {
        size,
        ..RenderSettings::default()
    };
    bencher
        .counter(ItemsCount::new(case.figures * SPLATS))
        .bench_local(|| renderer.render(&scene, &camera, &settings));
}

/// One of several shares of a frame, in blocks of `edge` pixels.
#[derive(Clone, Copy)]
struct Part {
    shares: usize,
    edge: usize,
    simd: SimdLevel,
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { shares, edge, simd } = self;
        write!(f, "1/{shares} in blocks of {edge}, {simd:?}")
    }
}

fn parts() -> impl Iterator<Item = Part> {
    let levels = SimdLevel::ALL.into_iter().filter(|level| level.is_available());
    levels.flat_map(|simd| [(1, 64), (2, 64), (2, 128)].map(|(shares, edge)| Part { shares, edge, simd }))
}

#[divan::bench(args = parts())]
fn share(bencher: Bencher<'_, '_>, part: Part) {
    let scene = Scene::of_items(vec![Item::gaussians(figure(DVec3::ZERO))]).expect("a valid item");
    let size = ImageSize::new(512, 512).expect("a valid size");
    let projection = Projection::Perspective { fov_degrees: 40.0 };
    let bounds = scene.bounds().expect("a box of the figure");
    let camera = Camera::framing(&bounds, View::Iso, projection, size.aspect()).expect("a valid camera");
    let mut renderer = Renderer::new(EngineConfig {
        threads: Some(1),
        simd: Some(part.simd),
        ..EngineConfig::default()
    })
    .expect("threads");
    let settings = RenderSettings {
        size,
        ..RenderSettings::default()
    };
    let control = Control {
        share: Some(Share::new(0, part.shares, part.edge).expect("a share")),
        ..Control::default()
    };
    let mut frame = Frame::empty(size);
    bencher
        .counter(ItemsCount::new(SPLATS))
        .bench_local(|| renderer.render_with(&scene, &camera, &settings, &mut frame, &control));
}
