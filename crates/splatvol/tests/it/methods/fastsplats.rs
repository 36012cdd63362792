//! FastSplats: rasterisers with tables, other kernels, the range of interest, and occlusion.

use glam::{DMat3, DVec3};
use splatvol::{
    Absorption, Alignment, Classification, Compositing, Control, EngineConfig, Extraction, Filter,
    FlatSettings, Frame, Grid, ImageSize, Kernel, Occlusion, Partial, Projection, Rasterizer, RenderSettings,
    Renderer, Samples, Scene, SheetContent, SheetPrecision, TableLayout, TablePrecision, Volume,
};
use splatvol_samples::Sample;
use splatvol_testing::{Comparison, checked};

use crate::common::{self, PROJECTIONS};
use crate::fast::support::{bits, framing, generated, noise, opaque, translucent};

const ALL: [Rasterizer; 6] = [
    Rasterizer::Linear1d,
    Rasterizer::Square1d,
    Rasterizer::Ellipse1d,
    Rasterizer::Rlut { subpixels: 100 },
    Rasterizer::Blit2d { subpixels: 4 },
    Rasterizer::Hybrid {
        subpixels: 8,
        radius: 3,
    },
];

/// The preset, into tables that leave next to no error.
fn fine(pixels: u32) -> RenderSettings {
    checked(FlatSettings {
        size: ImageSize::new(pixels, pixels).unwrap(),
        table: TableLayout {
            entries: 1024,
            precision: TablePrecision::F32,
            sections: 128,
        },
        ..RenderSettings::fastsplats2000().into()
    })
}

fn psnr(a: &Frame, b: &Frame) -> f64 {
    Comparison::of(&a.image, &b.image).psnr
}

#[test]
fn pictures_from_tables_are_those_without() {
    let scene = generated(Sample::Head, 48);
    for projection in PROJECTIONS {
        let camera = framing(&scene, projection, 1.0, 1.0);
        let post = checked(FlatSettings {
            classification: Classification::Post,
            ..fine(128).into()
        });
        let whole = checked(FlatSettings {
            compositing: Compositing::AxisSheets,
            sheet: None,
            ..fine(128).into()
        });
        for (name, base) in [("pre", fine(128)), ("post", post), ("whole", whole)] {
            let auto = checked(FlatSettings {
                rasterizer: Rasterizer::Auto,
                ..base.into()
            });
            let evaluated = common::render(&scene, &camera, &auto);
            for rasterizer in ALL {
                let found = psnr(
                    &common::render(
                        &scene,
                        &camera,
                        &checked(FlatSettings {
                            rasterizer,
                            ..base.into()
                        }),
                    ),
                    &evaluated,
                );
                println!("{name} {rasterizer:?}: {found:.1} dB");
                let floor = match rasterizer {
                    Rasterizer::Blit2d { .. } | Rasterizer::Hybrid { .. } => 25.0,
                    _ => 38.0,
                };
                assert!(found > floor, "{name} {rasterizer:?} {projection:?}: {found}");
            }
        }
    }
}

#[test]
fn every_rasterizer_is_the_same_for_any_number_of_threads() {
    let scene = generated(Sample::Head, 32);
    let camera = framing(&scene, PROJECTIONS[0], 1.0, 1.4);
    for rasterizer in ALL {
        let settings = checked(FlatSettings {
            rasterizer,
            occlusion: Occlusion::Auto,
            ..fine(150).into()
        });
        let frame = |threads| {
            let config = EngineConfig {
                threads: Some(threads),
                ..EngineConfig::default()
            };
            let mut renderer = Renderer::new(config).unwrap();
            renderer.render(&scene, &camera, &settings).unwrap()
        };
        let first = frame(1);
        assert!(bits(&first) == bits(&frame(3)), "{rasterizer:?}");
        // The summed-area table makes the picture one tile: footprints do not depend on where tiles end.
        let one_tile = checked(FlatSettings {
            occlusion: Occlusion::Sat,
            termination: 0.0,
            ..settings.into()
        });
        let many = checked(FlatSettings {
            occlusion: Occlusion::None,
            ..one_tile.into()
        });
        let [one, many] = [one_tile, many].map(|settings| common::render(&scene, &camera, &settings));
        assert!(bits(&one) == bits(&many), "{rasterizer:?}");
    }
}

#[test]
fn footprints_that_are_no_circles_are_refused_with_what_to_use() {
    let refusal = |scene: &Scene, projection, settings: RenderSettings| {
        let camera = framing(scene, projection, 1.0, 1.0);
        let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
        renderer
            .render(scene, &camera, &settings)
            .map(|_| ())
            .map_err(|e| e.to_string())
    };
    let (oblong, cubes) = (noise(), generated(Sample::Head, 16));
    for projection in PROJECTIONS {
        for rasterizer in ALL {
            let settings = checked(FlatSettings {
                rasterizer,
                ..fine(32).into()
            });
            let any = matches!(rasterizer, Rasterizer::Linear1d | Rasterizer::Ellipse1d);
            assert_eq!(refusal(&cubes, projection, settings), Ok(()));
            match refusal(&oblong, projection, settings) {
                Ok(()) => assert!(any, "{rasterizer:?}"),
                Err(text) => assert!(
                    !any && text.contains("ellipse-1d") && text.contains("voxels are not cubes"),
                    "{text}"
                ),
            }
            let affine = checked(FlatSettings {
                alignment: Alignment::Affine,
                ..settings.into()
            });
            let perspective = matches!(projection, Projection::Perspective { .. });
            assert_eq!(refusal(&cubes, projection, affine).is_ok(), any || !perspective);
            let exact = checked(FlatSettings {
                alignment: Alignment::Exact,
                ..settings.into()
            });
            assert_eq!(refusal(&cubes, projection, exact).is_ok(), !perspective);
        }
    }
}

/// A block of ones: 40 voxels deep along the ray.
fn block() -> Scene {
    let grid = Grid::new([30, 30, 40], DVec3::ZERO, DVec3::ONE, DMat3::IDENTITY).unwrap();
    // One voxel elsewhere keeps the range of values open.
    let mut values = vec![1.0_f32; 30 * 30 * 40];
    values[0] = 0.0;
    Scene::new(
        Volume::new(
            grid,
            Samples::F32(values.into()),
            splatvol::Rescale::default(),
            splatvol::LengthUnit::default(),
        )
        .unwrap(),
        translucent(),
    )
}

/// The kernels' ripple is 1.1 % at most, and a line through all of the block averages it.
#[test]
fn an_x_ray_through_a_constant_field_is_right_for_each_kernel() {
    let scene = block();
    let camera = common::orthographic(DVec3::new(14.6, 14.8, 20.0), DVec3::Z, 6.0);
    let kernels = [
        Kernel::default(),
        Kernel::Gaussian {
            sigma: 0.602,
            radius: 2.0,
        },
        Kernel::CrawfisMax,
        Kernel::CubicBspline,
        Kernel::KAISER_BESSEL,
    ];
    let depth = |kernel, rasterizer| {
        let settings = checked(FlatSettings {
            compositing: Compositing::Xray,
            occlusion: Occlusion::Auto,
            absorption: Absorption::Exp,
            sheet: None,
            kernel,
            rasterizer,
            ..fine(48).into()
        });
        let frame = common::render(&scene, &camera, &settings);
        let sum: f64 = frame.optical_depth.iter().copied().map(f64::from).sum();
        let (least, most) = frame
            .optical_depth
            .iter()
            .fold((f32::MAX, f32::MIN), |(a, b), &t| (a.min(t), b.max(t)));
        (sum / frame.optical_depth.len() as f64, f64::from(most - least))
    };
    // Opacity 0.6 per unit distance, 40 voxels.
    let exact = 40.0 * -(1.0 - 0.6_f64).ln();
    for kernel in kernels {
        for rasterizer in [Rasterizer::Auto, Rasterizer::Linear1d, Rasterizer::Square1d] {
            let (mean, range) = depth(kernel, rasterizer);
            println!(
                "{} {rasterizer:?}: {:.4}, range {:.4} of the exact depth",
                kernel.name(),
                mean / exact,
                range / exact
            );
            assert!(
                (mean / exact - 1.0).abs() < 4e-3,
                "{kernel:?} {rasterizer:?}: {mean} {exact}"
            );
            assert!(range / exact < 0.025, "{kernel:?} {rasterizer:?}: {range}");
        }
    }
}

#[test]
fn only_the_range_of_interest_has_splats() {
    let scene = generated(Sample::Head, 32);
    let camera = framing(&scene, PROJECTIONS[1], 1.0, 1.0);
    let [low, high] = scene.single_volume().unwrap().volume.value_range();
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    let mut drawn = |extraction| {
        let settings = checked(FlatSettings {
            extraction,
            compositing: Compositing::PerSplatBackToFront,
            occlusion: Occlusion::None,
            sheet: None,
            filter: Filter::None,
            ..fine(64).into()
        });
        let frame = renderer.render(&scene, &camera, &settings).unwrap();
        (frame, renderer.statistics().voxels)
    };
    let range = |density, gradient| Some(Extraction { density, gradient });
    let (all, count) = drawn(None);
    let (same, same_count) = drawn(range(Some([low, high]), 0.0));
    assert!(bits(&all) == bits(&same) && count == same_count && count > 0);
    let middle = 0.5 * (low + high);
    let below = drawn(range(Some([low, middle]), 0.0)).1;
    let above = drawn(range(Some([middle + 1e-6 * (high - low), high]), 0.0)).1;
    println!("{count} splats: {below} below the middle, {above} above");
    // A splat in two tiles counts twice, in all three alike.
    assert!(
        below + above == count && below > 0 && above > 0,
        "{below} {above} {count}"
    );
    let [gentle, steep, none] = [0.02, 0.2, 900.0].map(|gradient| drawn(range(None, gradient)).1);
    println!("gradient 0.02: {gentle}, 0.2: {steep}");
    assert!(
        count > gentle && gentle > steep && steep > 0 && none == 0,
        "{gentle} {steep} {none}"
    );
}

/// huang2000 section 1: voxels outside the range of interest are culled, and post-classified sheets take them as zeros. The
/// nerve is drawn as with all of its voxels, but for what dim voxels around it add to the kernels at its surface: the fewer of
/// them are culled, the less is missing. As means of what is left, it would cover 71 % more pixels.
#[test]
fn culled_voxels_are_zeros_on_sheets_of_values() {
    let scene = generated(Sample::Nerve, 64);
    let camera = framing(&scene, PROJECTIONS[1], 1.0, 1.0);
    let single = scene.single_volume().unwrap();
    let [low, high] = single.volume.value_range();
    let covered = |extraction| {
        let settings = checked(FlatSettings {
            classification: Classification::Post,
            rasterizer: Rasterizer::Ellipse1d,
            extraction,
            ..fine(160).into()
        });
        let frame = common::render(&scene, &camera, &settings);
        let alpha = frame.image.pixels.iter().map(|pixel| pixel[3]);
        alpha.filter(|&alpha| alpha > 0.5 / 255.0).count() as f64
    };
    let all = covered(None);
    assert!(all > 1000.0, "{all}");
    for (from, most) in [(0.1, 0.05), (0.03, 0.02)] {
        let missing = 1.0
            - covered(Some(Extraction {
                density: Some([low + from * (high - low), high]),
                gradient: 0.0,
            })) / all;
        println!("voxels from {from} of the range on: {missing:.3} of {all} covered pixels missing");
        assert!((0.0..most).contains(&missing), "{from}: {missing}");
    }
}

/// huang2000 section 5.1: buffers of 8 bits for colours and 16 for values, into a picture of 8 bits.
#[test]
fn sheets_of_few_bits_make_pictures_of_eight() {
    let scene = opaque(&generated(Sample::Head, 32));
    let camera = framing(&scene, PROJECTIONS[1], 1.0, 1.0);
    for (classification, sheet_precision, least) in [
        (Classification::Pre, SheetPrecision::U8, 20.0),
        (Classification::Pre, SheetPrecision::U16, 22.0),
        (Classification::Post, SheetPrecision::U16, 28.0),
        (Classification::Post, SheetPrecision::U8, 12.0),
    ] {
        let single = checked(FlatSettings {
            classification,
            ..fine(96).into()
        });
        let few = checked(FlatSettings {
            sheet_precision,
            ..single.into()
        });
        let [exact, rounded] = [single, few].map(|settings| common::render(&scene, &camera, &settings));
        for channel in rounded.image.pixels.as_flattened() {
            let level = 255.0 * channel;
            assert!(
                (level - level.round()).abs() < 1e-3,
                "{classification:?}: {level}"
            );
        }
        let found = psnr(&rounded, &exact);
        println!("{classification:?} {sheet_precision:?}: {found:.1} dB");
        assert!(
            (least..70.0).contains(&found),
            "{classification:?} {sheet_precision:?}: {found}"
        );
    }
}

/// swan1997 section 3.1: partial images, front to back and back to front. The last is the picture, opacity only grows on the way,
/// and pictures that nobody looks at are the same.
#[test]
fn pictures_between_sheets_lead_to_the_picture() {
    let scene = generated(Sample::Head, 32);
    let camera = framing(&scene, PROJECTIONS[0], 1.0, 1.0);
    for (compositing, classification) in [
        (Compositing::ImageSheets, Classification::Pre),
        (Compositing::ImageSheets, Classification::Post),
        (Compositing::AxisSheets, Classification::Pre),
        (Compositing::PerSplat, Classification::Pre),
        (Compositing::PerSplatBackToFront, Classification::Pre),
    ] {
        let settings = checked(FlatSettings {
            compositing,
            classification,
            sheet: (classification == Classification::Post).then_some(SheetContent::Section),
            // Several tiles, each at its own pace.
            occlusion: Occlusion::Auto,
            termination: 0.0,
            ..fine(150).into()
        });
        let seen = std::sync::Mutex::new(Vec::<(usize, Vec<[f32; 4]>)>::new());
        let look = |sheets: usize, pixels: &[[f32; 4]]| seen.lock().unwrap().push((sheets, pixels.to_vec()));
        let control = Control {
            partial: Some(Partial {
                every: 5,
                picture: &look,
            }),
            ..Control::default()
        };
        let mut frame = Frame::empty(settings.size);
        let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
        renderer
            .render_with(&scene, &camera, &settings, &mut frame, &control)
            .unwrap();
        let sheets = renderer.statistics().sheets;
        let plain = common::render(&scene, &camera, &settings);
        assert!(bits(&plain) == bits(&frame), "{compositing:?}");
        let seen = seen.into_inner().unwrap();
        println!(
            "{compositing:?} {classification:?}: {} pictures of {sheets} sheets",
            seen.len()
        );
        assert_eq!(seen.len(), sheets.div_ceil(5));
        assert!(seen.len() > 2 && seen.last().unwrap() == &(sheets, frame.image.pixels.clone()));
        let covered = |pixels: &[[f32; 4]]| pixels.iter().map(|pixel| f64::from(pixel[3])).sum::<f64>();
        let growth: Vec<f64> = seen.iter().map(|(_, pixels)| covered(pixels)).collect();
        assert!(
            growth.is_sorted() && growth[0] < 0.5 * growth[growth.len() - 1],
            "{growth:?}"
        );
    }
    let look = |_: usize, _: &[[f32; 4]]| {};
    let control = Control {
        partial: Some(Partial {
            every: 5,
            picture: &look,
        }),
        ..Control::default()
    };
    let sheets = common::settings(32);
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    let mut frame = Frame::empty(sheets.size);
    let refused = renderer.render_with(&scene, &camera, &sheets, &mut frame, &control);
    let text = refused.unwrap_err().to_string();
    assert!(
        text.starts_with("partial: 5") && text.contains("fastsplats2000"),
        "{text}"
    );
}

/// huang2000 section 4.1 replaces the convolution by the table: both hide nothing that would be seen.
#[test]
fn the_box_hides_splats_and_changes_nothing() {
    let scene = opaque(&generated(Sample::Head, 48));
    for projection in PROJECTIONS {
        let camera = framing(&scene, projection, 1.0, 1.0);
        let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
        let mut render = |occlusion| {
            let settings = checked(FlatSettings {
                occlusion,
                ..fine(128).into()
            });
            let frame = renderer.render(&scene, &camera, &settings).unwrap();
            (frame, renderer.statistics().hidden_voxels)
        };
        let (by_table, most) = render(Occlusion::Sat);
        let (by_box, some) = render(Occlusion::Box);
        println!("{projection:?}: hidden by the table {most}, by the box {some}");
        assert!(bits(&by_table) == bits(&by_box));
        assert!(some > 0 && some <= most, "{some} {most}");
    }
}

/// huang2000 section 4.1: on opaque data the table hides most splats.
#[test]
fn the_summed_area_table_hides_most_of_an_opaque_head() {
    let scene = opaque(&generated(Sample::Head, 96));
    let camera = framing(&scene, PROJECTIONS[0], 1.0, 1.0);
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    let mut render = |occlusion| {
        let settings = checked(FlatSettings {
            occlusion,
            ..fine(192).into()
        });
        let frame = renderer.render(&scene, &camera, &settings).unwrap();
        (frame, renderer.statistics().clone())
    };
    let (everything, all) = render(Occlusion::None);
    let (picture, figures) = render(Occlusion::Sat);
    println!(
        "hidden: {:.3} of {} splats, {} bricks; drawn {}",
        figures.hidden_share,
        figures.voxels + figures.hidden_voxels,
        figures.hidden_bricks,
        figures.voxels
    );
    assert_eq!((all.hidden_share, all.hidden_voxels), (0.0, 0));
    assert!(figures.hidden_share > 0.3 && figures.voxels < all.voxels);
    assert!(Comparison::of(&picture.image, &everything.image).max_error <= 1.0 / 256.0);
}

#[test]
fn sheets_take_sections_of_other_kernels() {
    let scene = generated(Sample::Head, 32);
    let camera = framing(&scene, PROJECTIONS[1], 1.0, 1.0);
    for kernel in [Kernel::CrawfisMax, Kernel::CubicBspline, Kernel::KAISER_BESSEL] {
        let interpolated = checked(FlatSettings {
            kernel,
            rasterizer: Rasterizer::Auto,
            ..fine(96).into()
        });
        let looked_up = checked(FlatSettings {
            kernel,
            rasterizer: Rasterizer::Linear1d,
            ..fine(96).into()
        });
        let data = checked(FlatSettings {
            classification: Classification::Post,
            sheet: Some(SheetContent::Section),
            ..interpolated.into()
        });
        let [a, b, _] =
            [interpolated, looked_up, data].map(|settings| common::render(&scene, &camera, &settings));
        let found = psnr(&a, &b);
        println!("{}: {found:.1} dB", kernel.name());
        assert!(found > 40.0, "{kernel:?}: {found}");
    }
}
