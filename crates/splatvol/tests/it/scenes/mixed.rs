//! Things inside each other.

use glam::{DAffine3, DVec3};
use splatvol::{
    Absorption, Alignment, Classification, Compositing, EngineConfig, Extraction, Filter, FlatSettings, Grid,
    Item, Kernel, Occlusion, PointLook, Rasterizer, Reconstruction, RenderSettings, Renderer, Scene,
    TransferFunction, check,
};
use splatvol_testing::fields::{Ball, Noise};
use splatvol_testing::{Comparison, sample};
use splatvol_testing::{checked, transfer::linear_extinction};

use super::support::{cloud, item, picture, pictured, sphere, unlit};
use crate::common::{orthographic, perspective};

/// Extinction of the fog's densest place, per world length.
const FOG: f64 = 0.8;

fn volume(content: (splatvol::Volume, TransferFunction)) -> Item {
    Item::volume(content.0, content.1)
}

/// A ball of fog of radius 1.2, `FOG (1 - (r / 1.2)^2)` dense, dark.
fn fog() -> Item {
    let grid = Grid::centred([32, 32, 32], DVec3::splat(2.6 / 32.0)).unwrap();
    let field = Ball {
        centre: DVec3::ZERO,
        radius: 1.2,
    };
    volume((
        sample(&field, &grid),
        linear_extinction([0.0, 1.0], FOG, [0.0; 3]),
    ))
}

/// Optical depth of the fog along a diameter, from `a` to `b` on it.
fn fog_between(a: f64, b: f64) -> f64 {
    let integral = |x: f64| FOG * (x - x.powi(3) / (3.0 * 1.44));
    integral(b.clamp(-1.2, 1.2)) - integral(a.clamp(-1.2, 1.2))
}

/// Red, green and blue spheres, half transparent, in a ball of fog: seen from all sides, the ray through the middle
/// meets them in their order.
#[test]
fn transparent_spheres_in_fog_are_seen_in_order_from_all_sides() {
    let spheres = [
        (1.0, [1.0, 0.0, 0.0]),
        (0.7, [0.0, 1.0, 0.0]),
        (0.4, [0.0, 0.0, 1.0]),
    ];
    let opacity = 0.5;
    let mut items = vec![fog()];
    for (radius, color) in spheres {
        let look = PointLook {
            color,
            opacity,
            ..PointLook::default()
        };
        items.push(item(sphere(3_000), look, radius));
    }
    // Front to back along a diameter: where the ray meets a surface, and which one.
    let mut expected = [0.0; 4];
    let (mut transmittance, mut last) = (1.0, -2.0);
    for (place, color) in [-1.0, -0.7, -0.4, 0.4, 0.7, 1.0]
        .into_iter()
        .zip([0, 1, 2, 2, 1, 0])
    {
        transmittance *= (-fog_between(last, place)).exp();
        expected[color] += transmittance * opacity;
        transmittance *= 1.0 - opacity;
        last = place;
    }
    transmittance *= (-fog_between(last, 2.0)).exp();
    expected[3] = 1.0 - transmittance;
    let scene = Scene::of_items(items).unwrap();
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    for x in -1..=1 {
        for y in -1..=1 {
            for z in -1..=1 {
                let direction = DVec3::new(f64::from(x), f64::from(y), f64::from(z));
                if direction == DVec3::ZERO {
                    continue;
                }
                let camera = perspective(DVec3::ZERO, direction, 9.0, 16.0);
                let frame = renderer.render(&scene, &camera, &unlit(31, 31)).unwrap();
                let found = frame.image.pixel(15, 15).map(f64::from);
                for c in 0..4 {
                    let error = found[c] - expected[c];
                    assert!(error.abs() < 0.015, "{direction}: {found:.3?} {expected:.3?}");
                }
            }
        }
    }
}

/// Splat by splat and in X-rays, where everything is one cloud, a volume beside others looks as it does alone: `splats`
/// against `classic`.
#[test]
fn a_volume_beside_others_is_the_volume() {
    let grid = Grid::centred([24, 20, 28], DVec3::new(1.0, 1.3, 0.8)).unwrap();
    let data = sample(&Noise::new(5, 20, DVec3::splat(0.6)), &grid);
    let look = linear_extinction([-1.0, 1.0], 0.2, [0.9, 0.5, 0.2]);
    let camera = perspective(DVec3::ZERO, DVec3::new(0.4, 1.0, 0.3), 60.0, 40.0);
    for (compositing, alignment) in [
        (Compositing::PerSplat, Alignment::Sheet),
        (Compositing::Xray, Alignment::Affine),
    ] {
        for filter in [
            Filter::Ewa { pixel_sigma: 0.55 },
            Filter::Matched { pixel_sigma: 2.0 },
        ] {
            let settings = checked(FlatSettings {
                compositing,
                classification: Classification::Pre,
                alignment,
                filter,
                ..RenderSettings {
                    size: unlit(96, 80).size,
                    ..RenderSettings::default()
                }
                .into()
            });
            let alone = picture(vec![volume((data.clone(), look.clone()))], &camera, &settings);
            let unseen = item(sphere(100), PointLook::default(), 1.0);
            let unseen = unseen.at(DAffine3::from_translation(DVec3::new(0.0, 0.0, 500.0)));
            let beside = vec![volume((data.clone(), look.clone())), unseen];
            let found = picture(beside, &camera, &settings);
            let figures = Comparison::of(&found.image, &alone.image);
            println!("{compositing:?} {filter:?}: {:.1} dB", figures.psnr);
            assert!(
                figures.psnr > 60.0,
                "{compositing:?} {filter:?}: {}",
                figures.psnr
            );
        }
    }
}

/// Twice as large and twice as far is the same picture.
#[test]
fn scaled_items_look_the_same_from_farther_away() {
    let pictures = [1.0, 2.5].map(|scale| {
        let mut fog = fog();
        fog.world_from_item = DAffine3::from_scale(DVec3::splat(scale));
        let look = PointLook {
            opacity: 0.6,
            ..PointLook::default()
        };
        let items = vec![fog, item(sphere(3000), look, 0.8 * scale)];
        let camera = perspective(DVec3::ZERO, DVec3::new(1.0, 0.2, 0.1), 7.0 * scale, 20.0);
        picture(items, &camera, &unlit(64, 64)).image
    });
    let figures = Comparison::of(&pictures[0], &pictures[1]);
    assert!(figures.psnr > 70.0, "{}", figures.psnr);
}

/// Each thing has the optical depth that it has alone, but for roundings of points seen from their edge; a volume beside nothing
/// that is seen, the bytes.
#[test]
fn x_rays_add_up() {
    let camera = perspective(DVec3::ZERO, DVec3::new(0.4, 1.0, 0.3), 6.0, 40.0);
    let xray = |filter| {
        checked(FlatSettings {
            compositing: Compositing::Xray,
            gaussians: splatvol::GaussianMode::Volumetric,
            filter,
            ..unlit(96, 80).into()
        })
    };
    let moved = |item: Item, x: f64| item.at(DAffine3::from_translation(DVec3::new(x, 0.2, 0.1)));
    for settings in [xray(Filter::None), xray(Filter::Ewa { pixel_sigma: 0.5 })] {
        let parts = [
            fog(),
            moved(fog(), 0.7),
            item(sphere(2000), PointLook::default(), 0.6),
            Item::gaussians(cloud(200, [0.02, 0.2], 7)),
        ];
        let alone = parts
            .each_ref()
            .map(|part| picture(vec![part.clone()], &camera, &settings));
        let together = picture(parts.to_vec(), &camera, &settings);
        let mut backwards = parts.to_vec();
        backwards.reverse();
        let backwards = picture(backwards, &camera, &settings);
        for (at, (&found, &other)) in together
            .optical_depth
            .iter()
            .zip(&backwards.optical_depth)
            .enumerate()
        {
            let sum: f32 = alone.iter().map(|frame| frame.optical_depth[at]).sum();
            for found in [found, other] {
                assert!((found - sum).abs() <= 1e-3 * sum + 1e-6, "{at}: {found} {sum}");
            }
            let emission = |frame: &splatvol::Frame| {
                let [r, _, _, alpha] = frame.image.pixels[at];
                if alpha > 0.0 {
                    r / alpha * frame.optical_depth[at]
                } else {
                    0.0
                }
            };
            let (found, sum) = (emission(&together), alone.iter().map(emission).sum::<f32>());
            assert!((found - sum).abs() <= 1e-3 * sum + 1e-5, "{at}: {found} {sum}");
        }
        let unseen = item(sphere(100), PointLook::default(), 1.0);
        let unseen = unseen.at(DAffine3::from_translation(DVec3::new(0.0, 0.0, 500.0)));
        let beside = picture(vec![unseen, fog()], &camera, &settings);
        assert!(beside.image.pixels == alone[0].image.pixels && beside.depth == alone[0].depth);
    }
}

/// Material so dense that no number holds its transmittance has its share of colours, too.
#[test]
fn x_rays_of_dense_things_add_up() {
    let colors = [[0.9, 0.2, 0.1], [0.1, 0.3, 0.9]];
    let densities = [8.0, 3.0];
    let ball = |at: usize| {
        let field = Ball {
            centre: DVec3::ZERO,
            radius: 12.0,
        };
        let grid = Grid::centred([32; 3], DVec3::ONE).unwrap();
        let look = linear_extinction([0.0, 1.0], densities[at], colors[at]);
        volume((sample(&field, &grid), look))
    };
    let camera = orthographic(DVec3::ZERO, DVec3::new(0.1, 0.5, 1.0), 32.0);
    let settings = checked(FlatSettings {
        compositing: Compositing::Xray,
        ..unlit(48, 48).into()
    });
    let frame = picture(vec![ball(0), ball(1)], &camera, &settings);
    let all: f64 = densities.iter().sum();
    let depth = f64::from(frame.optical_depth[24 * 48 + 24]);
    // Along a diameter of `1 - (r / 12)^2`.
    let expected = all * 12.0 * 4.0 / 3.0;
    assert!((depth / expected - 1.0).abs() < 0.02, "{depth} {expected}");
    // Elsewhere looks of this density are only nearly linear.
    let is_dense = |at: &usize| frame.optical_depth[*at] > 120.0;
    let dense: Vec<usize> = (0..48 * 48).filter(is_dense).collect();
    assert!(dense.len() > 200, "{}", dense.len());
    let alone = [0, 1].map(|at| picture(vec![ball(at)], &camera, &settings));
    for at in dense {
        for channel in 0..4 {
            let of = |own: usize| densities[own] * f64::from(alone[own].image.pixels[at][channel]);
            let mean = (of(0) + of(1)) / all;
            let found = f64::from(frame.image.pixels[at][channel]);
            assert!((found - mean).abs() < 1e-3, "{channel}: {found} {mean}");
        }
    }
}

#[test]
fn pictures_do_not_depend_on_threads() {
    let gaussians = Item::gaussians(cloud(300, [0.02, 0.3], 3));
    let items = vec![fog(), item(sphere(3000), PointLook::default(), 0.6), gaussians];
    let scene = Scene::of_items(items).unwrap();
    let camera = orthographic(DVec3::ZERO, DVec3::new(0.1, 0.5, 1.0), 3.0);
    for compositing in [Compositing::ImageSheets, Compositing::PerSplat, Compositing::Xray] {
        let settings = checked(FlatSettings {
            compositing,
            classification: Classification::Pre,
            ..unlit(150, 130).into()
        });
        let bits = |threads| {
            let frame = pictured(&scene, &camera, &settings, Some(threads));
            frame
                .image
                .pixels
                .iter()
                .map(|p| p.map(f32::to_bits))
                .collect::<Vec<_>>()
        };
        assert!(bits(1) == bits(3), "{compositing:?}");
    }
}

/// Features of a single volume are refused beside other items, by the name of the field; nothing else is rendered
/// instead.
#[test]
fn what_is_of_one_volume_is_refused() {
    let points = || item(sphere(100), PointLook::default(), 1.0);
    let scenes = [
        Scene::from(points()),
        Scene::of_items(vec![fog(), points()]).unwrap(),
    ];
    let camera = orthographic(DVec3::ZERO, DVec3::Z, 3.0);
    let base = checked(FlatSettings {
        classification: Classification::Pre,
        ..unlit(16, 16).into()
    });
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    let mut refused = |settings: RenderSettings, words: &str| {
        for scene in &scenes {
            let expected = check(scene, &camera, &settings).expect_err(words).to_string();
            let found = renderer.render(scene, &camera, &settings).unwrap_err();
            assert_eq!(found.to_string(), expected);
            assert!(expected.contains(words), "{words}: {expected}");
        }
    };
    let of = |compositing| {
        checked(FlatSettings {
            compositing,
            ..base.into()
        })
    };
    refused(of(Compositing::Mip), "maximum");
    refused(of(Compositing::AxisSheets), "one volume");
    refused(of(Compositing::PerSplatBackToFront), "per-splat");
    for compositing in [Compositing::ImageSheets, Compositing::PerSplat, Compositing::Xray] {
        let base = of(compositing);
        let filter = Filter::Swan;
        refused(
            checked(FlatSettings {
                filter,
                ..base.into()
            }),
            "ewa or matched",
        );
        let alignment = Alignment::Exact;
        refused(
            checked(FlatSettings {
                alignment,
                ..base.into()
            }),
            "alignment",
        );
        let occlusion = Occlusion::None;
        refused(
            checked(FlatSettings {
                occlusion,
                ..base.into()
            }),
            "occlusion",
        );
        let absorption = Absorption::Linear;
        refused(
            checked(FlatSettings {
                absorption,
                ..base.into()
            }),
            "absorption",
        );
        let rasterizer = Rasterizer::Ellipse1d;
        refused(
            checked(FlatSettings {
                rasterizer,
                ..base.into()
            }),
            "rasterizer",
        );
        let kernel = Kernel::CubicBspline;
        refused(
            checked(FlatSettings {
                kernel,
                ..base.into()
            }),
            "kernel",
        );
        let reconstruction = Reconstruction::Surface { flatness: 4.0 };
        refused(
            checked(FlatSettings {
                reconstruction,
                ..base.into()
            }),
            "reconstruction",
        );
        let extraction = Some(Extraction {
            density: Some([0.2, 0.8]),
            gradient: 0.0,
        });
        refused(
            checked(FlatSettings {
                extraction,
                ..base.into()
            }),
            "extraction",
        );
    }
}

/// Data are classified before their splats are composited one by one, but only on request.
#[test]
fn data_are_not_classified_first_unasked() {
    let points = item(sphere(100), PointLook::default(), 1.0);
    let camera = orthographic(DVec3::ZERO, DVec3::Z, 3.0);
    let whole = FlatSettings {
        compositing: Compositing::PerSplat,
        ..unlit(16, 16).into()
    };
    let error = RenderSettings::try_from(whole).unwrap_err().to_string();
    assert!(error.starts_with("classification: Post"), "{error}");
    let colors = checked(FlatSettings {
        classification: Classification::Pre,
        ..whole
    });
    let both = Scene::of_items(vec![fog(), points.clone()]).unwrap();
    check(&both, &camera, &colors).unwrap();
    check(&Scene::from(points), &camera, &colors).unwrap();
}

#[test]
fn volumes_are_refused_where_whole_splats_are_asked_for() {
    let items = vec![fog(), item(sphere(100), PointLook::default(), 1.0)];
    let scene = Scene::of_items(items).unwrap();
    let camera = orthographic(DVec3::ZERO, DVec3::Z, 3.0);
    let settings = RenderSettings {
        gaussians: splatvol::GaussianMode::Published,
        ..unlit(16, 16)
    };
    let error = Renderer::new(EngineConfig::default())
        .unwrap()
        .render(&scene, &camera, &settings)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("3dgs") && error.contains("a volume") && error.contains("volumetric"),
        "{error}"
    );
}
