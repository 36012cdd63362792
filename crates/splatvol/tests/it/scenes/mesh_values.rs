//! Fields of meshes: one value of each ray, and post-classified pictures against the f64 integral of the same kernels.

use glam::{DMat3, DVec3};
use splatvol::{
    Camera, Clip, Compositing, Filter, FlatSettings, Frame, Gradient, Grid, Item, Mesh, RenderSettings,
    Scene, TransferFunction, check,
};
use splatvol_reference::ellipsoids::{Sample, field_picture};
use splatvol_testing::fields::{Ball, Field};
use splatvol_testing::{Comparison, Random, sample};
use splatvol_testing::{checked, transfer::linear_extinction};

use super::meshes::{graded, structured};
use super::support::{picture, unlit};
use crate::common::{orthographic, perspective, world_ray};

/// The ball, or its complement (a bowl).
struct Dented {
    ball: Ball,
    is_bowl: bool,
}

impl Field for Dented {
    fn value(&self, world: DVec3) -> f64 {
        match self.is_bowl {
            true => 1.0 - 0.8 * self.ball.value(world),
            false => 0.1 + 0.8 * self.ball.value(world),
        }
    }

    fn gradient(&self, world: DVec3) -> DVec3 {
        self.ball.gradient(world) * if self.is_bowl { -0.8 } else { 0.8 }
    }
}

const BALL: Ball = Ball {
    centre: DVec3::new(0.1, -0.05, 0.0),
    radius: 0.7,
};
/// Extinction of value one per world length.
const EXTINCTION: f64 = 2.0;

fn graded_mesh(field: &impl Field) -> Mesh {
    let dims = [61, 59, 63];
    structured(field, dims, |i| {
        DVec3::from_array(std::array::from_fn(|a| graded(i[a], dims[a])))
    })
}

fn of_values(compositing: Compositing) -> RenderSettings {
    checked(FlatSettings {
        compositing,
        ..unlit(72, 72).into()
    })
}

/// The value that a pixel's opacity stands for.
fn shown(frame: &Frame, pixel: usize) -> f64 {
    -f64::from(1.0 - frame.image.pixels[pixel][3]).ln() / EXTINCTION
}

/// Largest, smallest and mean values of rays through a graded mesh: those of a regular volume, and those of the field
/// itself.
#[test]
fn rays_through_meshes_keep_the_values_of_the_field() {
    let look = linear_extinction([0.0, 1.0], EXTINCTION, [0.9, 0.5, 0.2]);
    let cases = [
        (Compositing::Mip, false),
        (Compositing::MinimumIntensity, true),
        (Compositing::Mean, false),
    ];
    for (compositing, is_bowl) in cases {
        let field = Dented { ball: BALL, is_bowl };
        let mesh = Item::mesh(graded_mesh(&field), look.clone());
        let grid = Grid::centred([81; 3], DVec3::splat(2.0 / 80.0)).unwrap();
        let volume = Item::volume(sample(&field, &grid), look.clone());
        let settings = of_values(compositing);

        // Rays along an axis are two long.
        let camera = orthographic(DVec3::ZERO, DVec3::Y, 1.5);
        let found = picture(vec![mesh.clone()], &camera, &settings);
        let width = settings.size.width() as usize;
        let mut worst = (0.0f64, 0.0);
        for pixel in 0..found.image.pixels.len() {
            let (origin, direction) = world_ray(&camera, &settings, pixel % width, pixel / width);
            let along = direction.normalize();
            let to = BALL.centre - origin;
            let offset = (to - along * to.dot(along)).length();
            let nearest = BALL.value(BALL.centre + DVec3::X * offset);
            let expected = match compositing {
                Compositing::Mean => 0.1 + 0.8 * BALL.line_integral(offset) / 2.0,
                _ if is_bowl => 1.0 - 0.8 * nearest,
                _ => 0.1 + 0.8 * nearest,
            };
            let error = (shown(&found, pixel) - expected).abs();
            if error > worst.0 {
                worst = (error, offset);
            }
        }

        let camera = perspective(DVec3::ZERO, DVec3::new(0.4, 1.0, 0.3), 6.0, 16.0);
        let found = picture(vec![mesh], &camera, &settings);
        let regular = picture(vec![volume], &camera, &settings);
        let figures = Comparison::of(&found.image, &regular.image);
        println!(
            "{compositing:?}: {worst:.4?} from the field, {:.1} dB from a volume",
            figures.psnr
        );
        // Worst at the edge of the ball, where the field bends within a cell.
        assert!(worst.0 < 0.02, "{compositing:?}: {worst:?}");
        assert!(figures.psnr > 45.0, "{compositing:?}: {}", figures.psnr);
        let middle = found.depth.len() / 2 + width / 2;
        let [own, other] = [&found, &regular].map(|frame| frame.depth[middle]);
        assert!((own - other).abs() < 0.05, "{compositing:?}: {own} {other}");
    }
}

/// Settings that planes of mesh values cannot show are refused by name.
#[test]
fn what_values_of_meshes_cannot_have_is_refused() {
    let look = linear_extinction([0.0, 1.0], EXTINCTION, [0.9, 0.5, 0.2]);
    let scene = Scene::of_items(vec![Item::mesh(graded_mesh(&BALL), look)]).unwrap();
    let camera = perspective(DVec3::ZERO, DVec3::Y, 6.0, 25.0);
    let why =
        |scene: &Scene, settings: &RenderSettings| check(scene, &camera, settings).unwrap_err().to_string();
    for compositing in [Compositing::ImageSheets, Compositing::Mip] {
        let analytic = checked(FlatSettings {
            gradient: Gradient::Analytic,
            ..of_values(compositing).into()
        });
        let why = why(&scene, &analytic);
        assert!(why.contains("gradient") && why.contains("meshes"), "{why}");
    }
    let cut = scene
        .clone()
        .with_clip(Clip::plane(DVec3::ZERO, DVec3::X).unwrap());
    let why = why(&cut, &of_values(Compositing::Mean));
    assert!(why.contains("a clip"), "{why}");
}

/// A seeded field on a curved mesh, post-classified: the integral of `v = S / W` and `min(W, 1)`, ray by ray in f64.
#[test]
fn meshes_agree_with_the_integral_of_their_kernels() {
    let mut random = Random::new(17);
    let mut unit = || random.unit();
    let waves: Vec<[DVec3; 2]> = (0..4)
        .map(|_| [(); 2].map(|()| DVec3::new(unit(), unit(), unit()) * 5.0 - 2.5))
        .collect();
    let place = |i: DVec3| {
        let p = i / 6.5 - 1.0;
        DVec3::new(
            p.x + 0.2 * p.y * p.z,
            p.y + 0.15 * p.x * p.x,
            p.z - 0.2 * p.x * p.y,
        )
    };
    let mesh = structured(&Waves(waves), [14; 3], place);
    for (name, look, least) in [
        (
            "material",
            linear_extinction([0.0, 1.0], 3.0, [0.9, 0.5, 0.2]),
            65.0,
        ),
        (
            "band",
            TransferFunction::isosurface(0.5, 0.3, [0.3, 0.6, 0.9]).unwrap(),
            47.0,
        ),
    ] {
        let look =
            TransferFunction::new(look.colors().to_vec(), look.opacities().to_vec(), Some(1.0)).unwrap();
        let settings = checked(FlatSettings {
            filter: Filter::None,
            sheet_thickness: 0.125,
            termination: 1e-4,
            ..unlit(40, 40).into()
        });
        for camera in [
            perspective(DVec3::ZERO, DVec3::new(1.0, -2.0, 0.5), 6.0, 26.0),
            orthographic(DVec3::ZERO, DVec3::new(-1.0, 0.3, 2.0), 2.6),
        ] {
            let found = picture(vec![Item::mesh(mesh.clone(), look.clone())], &camera, &settings).image;
            let expected = integrated(&mesh, &look, &camera, &settings);
            let figures = Comparison::of(&found, &expected);
            println!("{name}: {:.1} dB", figures.psnr);
            assert!(figures.psnr > least, "{name}: {}", figures.psnr);
        }
    }
}

/// A sum of waves, from 0 to 1.
struct Waves(Vec<[DVec3; 2]>);

impl Field for Waves {
    fn value(&self, world: DVec3) -> f64 {
        let waves = self.0.iter().map(|[k, phase]| (k.dot(world) + phase.x).sin());
        0.5 + 0.5 * waves.sum::<f64>() / self.0.len() as f64
    }

    fn gradient(&self, world: DVec3) -> DVec3 {
        let waves = self
            .0
            .iter()
            .map(|[k, phase]| *k * (k.dot(world) + phase.x).cos());
        waves.sum::<DVec3>() * (0.5 / self.0.len() as f64)
    }
}

fn integrated(
    mesh: &Mesh,
    look: &TransferFunction,
    camera: &Camera,
    settings: &RenderSettings,
) -> splatvol::Image {
    let sigma = settings.method.kernel().gaussian().unwrap().0;
    let kernels = splatvol_core::irregular::kernels(mesh, sigma);
    let coefficients = kernels.coefficients();
    let samples: Vec<Sample> = (0..kernels.len())
        .map(|i| {
            let [xx, xy, xz, yy, yz, zz] = kernels.covariances[i].map(f64::from);
            Sample {
                centre: DVec3::from_array(kernels.positions[i].map(f64::from)),
                covariance: DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]),
                mass: f64::from(kernels.masses[i]),
                coefficient: f64::from(coefficients[i]),
            }
        })
        .collect();
    field_picture(&samples, (look, 1.0), camera, settings.size)
}
