//! Seeded clouds, and the published algorithm in f64, pixel by pixel, from its equations (Kerbl et al. 2023,
//! Zwicker et al. 2002). Shares no code with the engine.

mod depths;
mod kernels;
mod published;
mod robust;
mod shares;

use fearless_simd::{Level, dispatch};
use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};
use splatvol_core::engine::{Control, Task};
use splatvol_core::splats::Splat;
use splatvol_scene::transfer_function::srgb_from_linear;
use splatvol_scene::{Camera, Frame, GaussianAttributes, Gaussians, ImageSize, Projection};

use super::{BlendMode, Cloud, CloudSettings, LowPass, Near, SplatEngine};
use crate::config::SimdLevel;
use crate::instructions::{InstructionSet, Part, Work};
use crate::pool::Pool;
use crate::run::{Pass, Run};

/// An engine with threads of its own.
struct Renderer {
    pool: Pool,
    level: Level,
    engine: SplatEngine,
}

impl Renderer {
    /// `None` where the processor lacks the instructions.
    fn new(threads: usize, simd: Option<SimdLevel>) -> Option<Self> {
        Some(Self {
            pool: Pool::new(Some(threads)).expect("threads"),
            level: simd.map_or(Some(Level::new()), SimdLevel::level)?,
            engine: SplatEngine::default(),
        })
    }

    fn render(&mut self, clouds: &[&Gaussians], camera: &Camera, settings: &CloudSettings) -> Frame {
        let mut frame = Frame::empty(settings.size);
        self.render_into(clouds, camera, settings, &mut frame);
        frame
    }

    fn render_into(
        &mut self,
        clouds: &[&Gaussians],
        camera: &Camera,
        settings: &CloudSettings,
        frame: &mut Frame,
    ) {
        let own = |cloud| Cloud::Gaussians(cloud, DAffine3::IDENTITY);
        let clouds: Vec<Cloud<'_>> = clouds.iter().copied().map(own).collect();
        self.render_clouds(&clouds, camera, settings, frame);
    }

    fn render_clouds(
        &mut self,
        clouds: &[Cloud<'_>],
        camera: &Camera,
        settings: &CloudSettings,
        frame: &mut Frame,
    ) {
        self.render_with(clouds, (camera, settings), &Control::default(), frame);
    }

    fn render_with(
        &mut self,
        clouds: &[Cloud<'_>],
        view: (&Camera, &CloudSettings),
        control: &Control<'_>,
        frame: &mut Frame,
    ) {
        let run = Run {
            pool: &self.pool,
            instructions: InstructionSet {
                level: self.level,
                run,
            },
            tile_edge: None,
            task: Task::new(control, &|_| {}),
            block: None,
            pass: Pass::WHOLE,
        };
        self.engine.render(run, clouds, view, frame);
    }
}

/// The loops of this engine, for every instruction set.
fn run(level: Level, work: Work<'_, '_>) {
    match work.0 {
        Part::Splats(splats) => dispatch!(level, simd => splats.run(simd)),
        Part::Sheets(_) => unreachable!("this engine has no sheets"),
    }
}

fn settings(width: u32, height: u32) -> CloudSettings {
    CloudSettings::published(ImageSize::new(width, height).expect("a valid size"))
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

    fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.signed(), self.signed(), self.signed())
    }
}

/// `count` Gaussians in the cube -1..1, of standard deviations spread over `scales` logarithmically.
fn attributes(seed: u64, count: usize, degree: u32, scales: [f64; 2]) -> GaussianAttributes {
    let mut random = Random(seed);
    let mut made = GaussianAttributes::default();
    for _ in 0..count {
        made.means.push(random.vector().as_vec3().to_array());
        let scale = [(); 3].map(|()| random.between(scales[0].ln(), scales[1].ln()).exp() as f32);
        made.scales.push(scale);
        made.rotations
            .push([(); 4].map(|()| random.signed() as f32 + 1e-3));
        made.opacities.push(random.unit() as f32);
        for k in 0..(degree + 1).pow(2) {
            let size = if k == 0 { 1.6 } else { 0.4 };
            made.harmonics.push((size * random.vector()).as_vec3().to_array());
        }
    }
    made
}

fn cloud(seed: u64, count: usize, degree: u32, scales: [f64; 2]) -> Gaussians {
    Gaussians::new(
        attributes(seed, count, degree, scales),
        degree,
        DAffine3::IDENTITY,
    )
    .expect("valid")
}

fn perspective(position: DVec3, fov_degrees: f64) -> Camera {
    let up = DVec3::new(0.1, 0.05, 1.0);
    Camera::new(
        position,
        DVec3::new(0.05, 0.1, -0.1),
        up,
        Projection::Perspective { fov_degrees },
    )
    .expect("valid")
}

/// Premultiplied display colour, opacity, and mean depth of a pixel.
#[derive(Clone, Copy)]
struct Pixel {
    color: DVec3,
    through: f64,
    depth_sum: f64,
    ended: bool,
}

struct Projected {
    depth: f64,
    centre: DVec2,
    inverse: [f64; 3],
    opacity: f64,
    color: DVec3,
    tiles: [i64; 4],
}

struct Published {
    size: ImageSize,
    low_pass: f64,
    near: f64,
}

/// A covariance on the screen.
struct Ellipse {
    depth: f64,
    centre: DVec2,
    inverse: [f64; 3],
    /// Determinants without the low-pass and with it.
    determinants: [f64; 2],
    /// Pixels per world length, and slopes of the rays.
    scale: f64,
    slopes: DVec2,
    tiles: [i64; 4],
}

impl Published {
    fn of(settings: &CloudSettings) -> Self {
        let (LowPass::Added(low_pass), Near::OfGaussians(near)) = (settings.low_pass, settings.near) else {
            panic!("not as published: {settings:?}");
        };
        Self {
            size: settings.size,
            low_pass: f64::from(low_pass),
            near,
        }
    }

    fn render(&self, clouds: &[&Gaussians], camera: &Camera) -> Vec<Pixel> {
        self.render_with(clouds, &[], camera)
    }

    /// With kernels of other things behind Gaussians of the same depth.
    fn render_with(&self, clouds: &[&Gaussians], kernels: &[Splat], camera: &Camera) -> Vec<Pixel> {
        let mut splats: Vec<Projected> = Vec::new();
        for cloud in clouds {
            splats.extend((0..cloud.len()).filter_map(|i| self.project(cloud, i, camera)));
        }
        let unit = |cloud: &&Gaussians| cloud.world_from_local().matrix3.determinant().abs().cbrt();
        let near = clouds.iter().map(unit).reduce(f64::min).unwrap_or(0.0) * self.near;
        splats.extend(
            kernels
                .iter()
                .filter_map(|kernel| self.project_kernel(kernel, near, camera)),
        );
        splats.sort_by(|a, b| a.depth.total_cmp(&b.depth));
        let empty = Pixel {
            color: DVec3::ZERO,
            through: 1.0,
            depth_sum: 0.0,
            ended: false,
        };
        let (width, height) = (i64::from(self.size.width()), i64::from(self.size.height()));
        let mut pixels = vec![empty; self.size.pixel_count()];
        for splat in &splats {
            let [x0, x1, y0, y1] = splat.tiles.map(|tile| tile * 16);
            for y in y0..y1.min(height) {
                for x in x0..x1.min(width) {
                    splat.add(
                        DVec2::new(x as f64, y as f64),
                        &mut pixels[(y * width + x) as usize],
                    );
                }
            }
        }
        pixels
    }

    /// A covariance around `t`, both in camera space.
    fn ellipse(&self, t: DVec3, sigma: DMat3, near: f64, camera: &Camera) -> Option<Ellipse> {
        let (width, height) = (f64::from(self.size.width()), f64::from(self.size.height()));
        let (jacobian, screen, scale, slopes) = match camera.projection() {
            Projection::Perspective { fov_degrees } => {
                if t.z <= near {
                    return None;
                }
                let tan_y = (0.5 * fov_degrees.to_radians()).tan();
                let tan_x = tan_y * width / height;
                let focal = height / (2.0 * tan_y);
                let slope = DVec2::new(
                    (t.x / t.z).clamp(-1.3 * tan_x, 1.3 * tan_x),
                    (t.y / t.z).clamp(-1.3 * tan_y, 1.3 * tan_y),
                );
                let rows = [
                    DVec3::new(focal / t.z, 0.0, -focal * slope.x / t.z),
                    DVec3::new(0.0, focal / t.z, -focal * slope.y / t.z),
                ];
                (rows, focal * t.truncate() / t.z, focal / t.z, slope)
            }
            Projection::Orthographic { height: extent } => {
                if t.z <= 0.0 {
                    return None;
                }
                let m = height / extent;
                ([DVec3::X * m, DVec3::Y * m], m * t.truncate(), m, DVec2::ZERO)
            }
        };
        let v = |p: usize, q: usize| jacobian[p].dot(sigma * jacobian[q]);
        let (xx, xy, yy) = (v(0, 0), v(0, 1), v(1, 1));
        let before = xx * yy - xy * xy;
        let (xx, yy) = (xx + self.low_pass, yy + self.low_pass);
        let det = xx * yy - xy * xy;
        let middle = 0.5 * (xx + yy);
        let radius = (3.0 * (middle + (middle * middle - det).max(0.1).sqrt()).sqrt()).ceil();
        // Pixels are numbered by their centres.
        let centre = screen + 0.5 * DVec2::new(width, height) - 0.5;
        let tile = |place: f64, pixels: f64| ((place / 16.0) as i64).clamp(0, (pixels / 16.0).ceil() as i64);
        let tiles = [
            tile(centre.x - radius, width),
            tile(centre.x + radius + 15.0, width),
            tile(centre.y - radius, height),
            tile(centre.y + radius + 15.0, height),
        ];
        Some(Ellipse {
            depth: t.z,
            centre,
            inverse: [yy / det, -xy / det, xx / det],
            determinants: [before, det],
            scale,
            slopes,
            tiles,
        })
    }

    fn project(&self, cloud: &Gaussians, i: usize, camera: &Camera) -> Option<Projected> {
        let a = cloud.attributes();
        let world_from_local = cloud.world_from_local();
        let mean = DVec3::from(a.means[i].map(f64::from));
        let view = camera.camera_from_world();
        let t = view.transform_point3(world_from_local.transform_point3(mean));
        let w = view.matrix3 * world_from_local.matrix3;
        let [x, y, z, r] = a.rotations[i].map(f64::from);
        let rotation = DMat3::from_quat(DQuat::from_xyzw(x, y, z, r).normalize());
        let scale = DMat3::from_diagonal(DVec3::from(a.scales[i].map(f64::from)));
        let sigma = rotation * scale * scale * rotation.transpose();
        let near = self.near * w.determinant().abs().cbrt();
        let ellipse = self.ellipse(t, w * sigma * w.transpose(), near, camera)?;
        let [before, det] = ellipse.determinants;
        let ratio = if cloud.antialiased() {
            (before / det).max(0.000_025).sqrt()
        } else {
            1.0
        };
        let count = (cloud.degree() as usize + 1).pow(2);
        let direction = match camera.projection() {
            Projection::Perspective { .. } => {
                mean - world_from_local.inverse().transform_point3(camera.position())
            }
            Projection::Orthographic { .. } => world_from_local
                .inverse()
                .transform_vector3(camera.target() - camera.position()),
        };
        Some(Projected {
            depth: ellipse.depth,
            centre: ellipse.centre,
            inverse: ellipse.inverse,
            opacity: f64::from(a.opacities[i]) * ratio,
            color: color(&a.harmonics[i * count..(i + 1) * count], direction.normalize()),
            tiles: ellipse.tiles,
        })
    }

    /// A kernel that holds a mass, unlit: what a ray through its middle meets.
    fn project_kernel(&self, kernel: &Splat, near: f64, camera: &Camera) -> Option<Projected> {
        let view = camera.camera_from_world();
        let t = view.transform_point3(kernel.centre);
        let sigma = view.matrix3 * kernel.covariance * view.matrix3.transpose();
        let ellipse = self.ellipse(t, sigma, near, camera)?;
        let [mass, emission @ ..] = kernel.payload.map(f64::from);
        let path = (1.0 + ellipse.slopes.length_squared()).sqrt();
        let mass_on_screen = mass * ellipse.scale.powi(2) * path;
        let depth = mass_on_screen / (std::f64::consts::TAU * ellipse.determinants[1].sqrt());
        Some(Projected {
            depth: ellipse.depth,
            centre: ellipse.centre,
            inverse: ellipse.inverse,
            opacity: -(-depth).exp_m1(),
            color: DVec3::from(emission.map(|e| srgb_from_linear(e / mass))),
            tiles: ellipse.tiles,
        })
    }
}

impl Projected {
    fn add(&self, pixel_centre: DVec2, pixel: &mut Pixel) {
        let d = self.centre - pixel_centre;
        let [a, b, c] = self.inverse;
        let power = -0.5 * (a * d.x * d.x + 2.0 * b * d.x * d.y + c * d.y * d.y);
        let alpha = (self.opacity * power.exp()).min(0.99);
        if pixel.ended || alpha < 1.0 / 255.0 {
            return;
        }
        let next = pixel.through * (1.0 - alpha);
        if next < 0.0001 {
            pixel.ended = true;
            return;
        }
        pixel.color += pixel.through * alpha * self.color;
        pixel.depth_sum += pixel.through * alpha * self.depth;
        pixel.through = next;
    }
}

/// Harmonics from associated Legendre functions, `N_lm P_l^|m|(cos theta)` times `sqrt(2) cos(m phi)` or
/// `sqrt(2) sin(|m| phi)`, with the Condon-Shortley phase: nothing but the definition.
fn harmonic(l: i32, m: i32, d: DVec3) -> f64 {
    let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
    let k = m.abs();
    let (cos, sin) = (d.z, (1.0 - d.z * d.z).max(0.0).sqrt());
    let mut previous = (0..k).map(|i| -f64::from(2 * i + 1) * sin).product::<f64>();
    let mut legendre = previous;
    let mut before = 0.0;
    for n in k + 1..=l {
        let (n, k) = (f64::from(n), f64::from(k));
        legendre = ((2.0 * n - 1.0) * cos * previous - (n + k - 1.0) * before) / (n - k);
        before = previous;
        previous = legendre;
    }
    let norm =
        (f64::from(2 * l + 1) / (4.0 * std::f64::consts::PI) * factorial(l - k) / factorial(l + k)).sqrt();
    let phi = d.y.atan2(d.x);
    match m {
        0 => norm * legendre,
        1.. => std::f64::consts::SQRT_2 * norm * legendre * (f64::from(m) * phi).cos(),
        _ => std::f64::consts::SQRT_2 * norm * legendre * (f64::from(k) * phi).sin(),
    }
}

fn color(harmonics: &[[f32; 3]], direction: DVec3) -> DVec3 {
    let orders = (0..4).flat_map(|l| (-l..=l).map(move |m| (l, m)));
    let sum = harmonics
        .iter()
        .zip(orders)
        .fold(DVec3::splat(0.5), |sum, (c, (l, m))| {
            sum + harmonic(l, m, direction) * DVec3::from(c.map(f64::from))
        });
    sum.max(DVec3::ZERO)
}
