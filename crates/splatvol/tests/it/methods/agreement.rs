//! The footprint engine against the other engine, which agrees with the reference (docs/numerics.md).

use splatvol::{
    Alignment, Classification, Compositing, Filter, FlatSettings, Occlusion, Projection, RenderSettings,
    Scene, SheetContent,
};
use splatvol_recorded::long;
use splatvol_samples::{Sample, SampleSize};
use splatvol_testing::{Comparison, checked};

use crate::common::{self, PROJECTIONS};
use crate::fast::support::{bits, framing, generated, name_of, noise, translucent};

/// Sheets of classified colours.
fn colors(pixels: u32) -> RenderSettings {
    checked(FlatSettings {
        classification: Classification::Pre,
        ..common::settings(pixels).into()
    })
}

fn scenes() -> Vec<(&'static str, Scene)> {
    let ball = Sample::Ball.generate(Some(SampleSize::Longest(32))).unwrap();
    vec![
        ("head", generated(Sample::Head, 48)),
        ("ball", Scene::new(ball, translucent())),
        ("noise", noise()),
    ]
}

/// Decibels between two ways to render a scene.
fn psnr(scene: &Scene, projection: Projection, [a, b]: [&RenderSettings; 2]) -> f64 {
    let camera = framing(scene, projection, 1.0, 1.0);
    let render = |settings| common::render(scene, &camera, settings);
    Comparison::of(&render(a).image, &render(b).image).psnr
}

#[test]
fn sections_agree_with_the_sheets() {
    let mut failed = Vec::new();
    for (name, scene) in scenes() {
        for projection in PROJECTIONS {
            let slices = colors(128);
            for (alignment, floor) in [(Alignment::Exact, 50.0), (Alignment::Affine, 45.0)] {
                let footprints = checked(FlatSettings {
                    alignment,
                    ..slices.into()
                });
                let found = psnr(&scene, projection, [&footprints, &slices]);
                println!("{name} {} {alignment:?}: {found:.1} dB", name_of(projection));
                if found < floor {
                    failed.push(format!("{name} {projection:?} {alignment:?}: {found:.1}"));
                }
            }
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn whole_footprints_show_nearly_the_same_picture() {
    for (name, scene) in scenes() {
        for projection in PROJECTIONS {
            let sheets = colors(128);
            for compositing in [Compositing::PerSplat, Compositing::AxisSheets] {
                let whole = checked(FlatSettings {
                    compositing,
                    ..sheets.into()
                });
                let found = psnr(&scene, projection, [&whole, &sheets]);
                println!("{name} {} {compositing:?}: {found:.1} dB", name_of(projection));
                assert!(found > 20.0, "{name} {compositing:?}: {found:.1}");
            }
            let front = checked(FlatSettings {
                compositing: Compositing::PerSplat,
                termination: 0.0,
                ..sheets.into()
            });
            let back = checked(FlatSettings {
                compositing: Compositing::PerSplatBackToFront,
                ..front.into()
            });
            let found = psnr(&scene, projection, [&front, &back]);
            assert!(found > 120.0, "{name}: {found}");
        }
    }
}

#[test]
fn an_x_ray_is_the_same_by_whole_footprints() {
    for (name, scene) in scenes() {
        for projection in PROJECTIONS {
            let slabs = checked(FlatSettings {
                compositing: Compositing::Xray,
                ..colors(128).into()
            });
            let whole = checked(FlatSettings {
                alignment: Alignment::Exact,
                ..slabs.into()
            });
            let found = psnr(&scene, projection, [&whole, &slabs]);
            println!("{name} {}: {found:.1} dB", name_of(projection));
            assert!(found > 55.0, "{name}: {found}");
        }
    }
}

#[test]
fn sheets_of_data_show_nearly_what_planes_show() {
    for (name, scene) in scenes() {
        for projection in PROJECTIONS {
            let planes = checked(FlatSettings {
                prefilter: false,
                ..common::settings(128).into()
            });
            let sections = checked(FlatSettings {
                sheet: Some(SheetContent::Section),
                ..planes.into()
            });
            let found = psnr(&scene, projection, [&sections, &planes]);
            println!("{name} {}: {found:.1} dB", name_of(projection));
            assert!(found > 20.0, "{name}: {found}");
        }
    }
}

#[test]
fn pictures_do_not_depend_on_threads_or_tiles() {
    let scene = noise();
    let camera = framing(&scene, PROJECTIONS[0], 1.0, 1.4);
    for settings in every_way(96) {
        let frame = |threads| {
            let config = splatvol::EngineConfig {
                threads: Some(threads),
                ..splatvol::EngineConfig::default()
            };
            splatvol::Renderer::new(config)
                .unwrap()
                .render(&scene, &camera, &settings)
                .unwrap()
        };
        assert!(bits(&frame(1)) == bits(&frame(3)), "{settings:?}");
    }
}

/// At `termination` 0 occluders let no light through at all, so culling the material behind them changes no byte; the
/// summed-area table makes the picture one tile. Voxels are as many pixels wide at both sizes.
#[test]
fn what_is_hidden_changes_no_byte() {
    let (edge, pixels) = if long() { (64, 96) } else { (32, 48) };
    let scene = crate::fast::support::opaque(&generated(Sample::Head, edge));
    let camera = framing(&scene, PROJECTIONS[0], 1.0, 1.0);
    for settings in every_way(pixels) {
        if matches!(
            settings.method.compositing(),
            Compositing::PerSplatBackToFront | Compositing::Xray
        ) {
            continue;
        }
        let frame = |occlusion, termination| {
            let settings = checked(FlatSettings {
                occlusion,
                termination,
                absorption: splatvol::Absorption::Linear,
                ..settings.into()
            });
            common::render(&scene, &camera, &settings)
        };
        let everything = frame(Occlusion::None, 0.0);
        for occlusion in [Occlusion::Auto, Occlusion::Sat] {
            assert!(
                bits(&frame(occlusion, 0.0)) == bits(&everything),
                "{occlusion:?} {settings:?}"
            );
            let eps = 1.0 / 64.0;
            let figures = Comparison::of(&frame(occlusion, eps).image, &everything.image);
            assert!(figures.max_error <= eps, "{occlusion:?}: {}", figures.max_error);
        }
    }
}

fn every_way(pixels: u32) -> Vec<RenderSettings> {
    let base = checked(FlatSettings {
        alignment: Alignment::Affine,
        filter: Filter::default(),
        ..colors(pixels).into()
    });
    let of = |compositing| {
        checked(FlatSettings {
            compositing,
            ..base.into()
        })
    };
    vec![
        base,
        of(Compositing::PerSplat),
        of(Compositing::PerSplatBackToFront),
        of(Compositing::AxisSheets),
        of(Compositing::Xray),
        checked(FlatSettings {
            classification: Classification::Post,
            sheet: Some(SheetContent::Section),
            ..base.into()
        }),
        checked(FlatSettings {
            kernel: splatvol::Kernel::CubicBspline,
            ..base.into()
        }),
        checked(FlatSettings {
            rasterizer: splatvol::Rasterizer::Ellipse1d,
            alignment: Alignment::Grid,
            ..base.into()
        }),
    ]
}
