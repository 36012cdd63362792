//! Flat settings and the methods that they describe.

use splatvol::{
    Absorption, Alignment, Classification, Compositing, Coverage, Extraction, Filter, FlatSettings, Kernel,
    KernelEdge, Method, MotionBlur, Occlusion, PixelFilter, Rasterizer, Reconstruction, RenderSettings,
    SheetContent, SheetKernel, SheetPrecision, SheetSettings, SheetValues, Shows, SplatCompositing,
    SplatSettings, Stretch, TableLayout,
};
use splatvol_testing::Random;

/// Checks them as a picture would be checked.
fn validated(flat: FlatSettings) -> Result<RenderSettings, String> {
    let settings = RenderSettings::try_from(flat).map_err(|error| error.to_string())?;
    settings.validate().map_err(|error| error.to_string())?;
    Ok(settings)
}

fn pick<T: Copy>(random: &mut Random, from: &[T]) -> T {
    from[((random.unit() * from.len() as f64) as usize).min(from.len() - 1)]
}

fn sheets(random: &mut Random) -> SheetSettings {
    let pixel_sigma = random.unit();
    let shows = [
        Shows::Material(Classification::Pre),
        Shows::Material(Classification::Post),
        Shows::Xray,
        Shows::Mip,
        Shows::MinimumIntensity,
        Shows::Mean,
    ];
    let filters = [
        PixelFilter::None,
        PixelFilter::Ewa { pixel_sigma },
        PixelFilter::Matched { pixel_sigma },
    ];
    SheetSettings {
        shows: pick(random, &shows),
        thickness: 0.25 + random.unit(),
        kernel: SheetKernel {
            sigma: 0.5 + 0.5 * random.unit(),
            radius: 2.0 + random.unit(),
        },
        filter: pick(random, &filters),
        prefilter: random.unit() < 0.5,
        ..pick(
            random,
            &[
                SheetSettings::best(),
                SheetSettings::fast(),
                SheetSettings::draft(),
            ],
        )
    }
}

fn splats(random: &mut Random) -> SplatSettings {
    let compositing = [
        SplatCompositing::FrontToBack,
        SplatCompositing::BackToFront,
        SplatCompositing::AxisSheets,
        SplatCompositing::ImageSheets(Classification::Pre),
        SplatCompositing::ImageSheets(Classification::Post),
        SplatCompositing::Xray,
    ];
    let extraction = Extraction {
        density: Some([0.0, random.unit()]),
        gradient: random.unit(),
    };
    let ewa = Filter::Ewa { pixel_sigma: 0.7 };
    let filters = [Filter::None, ewa, Filter::Swan, Filter::SwanAlpha];
    let alignments = [
        Alignment::Sheet,
        Alignment::Affine,
        Alignment::Exact,
        Alignment::AUTO,
    ];
    let rasterizers = [
        Rasterizer::Auto,
        Rasterizer::Square1d,
        Rasterizer::Rlut { subpixels: 7 },
    ];
    let surface = Reconstruction::Surface { flatness: 4.0 };
    SplatSettings {
        compositing: pick(random, &compositing),
        sheet_thickness: 0.25 + random.unit(),
        absorption: pick(random, &[Absorption::Exp, Absorption::Linear]),
        filter: pick(random, &filters),
        alignment: pick(random, &alignments),
        stretch: pick(random, &[Stretch::Box, Stretch::Trapezoid]),
        rasterizer: pick(random, &rasterizers),
        occlusion: pick(random, &[Occlusion::Auto, Occlusion::None, Occlusion::Sat]),
        extraction: pick(random, &[None, Some(extraction)]),
        reconstruction: pick(random, &[Reconstruction::Volume, surface]),
        kernel: pick(
            random,
            &[Kernel::default(), Kernel::CrawfisMax, Kernel::KAISER_BESSEL],
        ),
        sheet_precision: rarely(random, SheetPrecision::U8),
        sheet_values: rarely(random, SheetValues::Sum),
        kernel_edge: rarely(random, KernelEdge::Raw),
        ..SplatSettings::default()
    }
}

/// A value one time in six, otherwise the default: what goes with few others.
fn rarely<T: Copy + Default>(random: &mut Random, value: T) -> T {
    let usual = T::default();
    pick(random, &[value, usual, usual, usual, usual, usual])
}

/// Every method survives a round trip through a file or flags, also plain splats, which differ from sheets only in the
/// name of their sections.
#[test]
fn settings_survive_being_flat() {
    let mut random = Random::new(13);
    let mut valid = [0; 2];
    let plain = |compositing| {
        Method::Splats(SplatSettings {
            compositing,
            ..SplatSettings::default()
        })
    };
    let mut found = vec![
        plain(SplatCompositing::ImageSheets(Classification::Pre)),
        plain(SplatCompositing::ImageSheets(Classification::Post)),
        plain(SplatCompositing::Xray),
    ];
    for _ in 0..5000 {
        found.push(sheets(&mut random).into());
        found.push(splats(&mut random).into());
    }
    let moving = [
        MotionBlur::None,
        MotionBlur::Capsule,
        MotionBlur::Subframes { count: 3 },
    ];
    for method in found {
        let settings = RenderSettings {
            method,
            motion_blur: pick(&mut random, &moving),
            ..RenderSettings::best()
        };
        if settings.validate().is_err() {
            continue;
        }
        valid[usize::from(method.splats().is_some())] += 1;
        let flat = FlatSettings::from(settings);
        assert_eq!(validated(flat), Ok(settings), "{flat:?}");
        let text = serde_json::to_string(&settings).expect("it can be written");
        let read: RenderSettings = serde_json::from_str(&text).expect("it can be read");
        assert_eq!(read, settings, "{text}");
    }
    assert!(valid.iter().all(|&count| count > 500), "{valid:?}");
}

#[test]
fn presets_are_valid_and_survive_being_flat() {
    for settings in [
        RenderSettings::best(),
        RenderSettings::balanced(),
        RenderSettings::fast(),
        RenderSettings::draft(),
        RenderSettings::fastsplats2000(),
        RenderSettings::swan1997(),
        RenderSettings::mueller1998(),
        RenderSettings::ewa2001(),
    ] {
        assert_eq!(validated(settings.into()), Ok(settings));
    }
}

/// Footprints that are drawn one by one for their motion alone are sheets again when nothing moves.
#[test]
fn what_motion_alone_splats_goes_back_to_sheets() {
    let moving = validated(FlatSettings {
        classification: Classification::Pre,
        motion_blur: MotionBlur::Exact,
        ..FlatSettings::default()
    })
    .expect("colours can move");
    assert!(moving.method.splats().is_some());
    let still = validated(FlatSettings {
        motion_blur: MotionBlur::None,
        ..moving.into()
    });
    assert!(still.expect("they can stand").method.sheets().is_some());
}

#[test]
fn other_kernels_are_not_prefiltered() {
    for compositing in [Compositing::ImageSheets, Compositing::Mip, Compositing::Mean] {
        let text = validated(FlatSettings {
            kernel: Kernel::CrawfisMax,
            compositing,
            prefilter: true,
            ..FlatSettings::default()
        })
        .expect_err("refused");
        assert!(text.starts_with("kernel: \"crawfis-max\""), "{text}");
    }
}

#[test]
fn footprints_of_any_kernel_are_splatted_but_planes_have_none() {
    let colors = FlatSettings {
        kernel: Kernel::CubicBspline,
        classification: Classification::Pre,
        ..FlatSettings::default()
    };
    let sections = FlatSettings {
        classification: Classification::Post,
        sheet: Some(SheetContent::Section),
        prefilter: false,
        ..colors
    };
    assert!(validated(colors).is_ok());
    assert!(validated(sections).is_ok());
    let planes = FlatSettings {
        sheet: None,
        ..sections
    };
    let text = validated(planes).expect_err("refused");
    assert!(text.contains("sections of sheets"), "{text}");
}

fn refused(flat: FlatSettings, start: &str) {
    let text = validated(flat).expect_err(start);
    assert!(text.starts_with(start), "{text}");
}

#[test]
fn rasterizers_tables_and_ranges_outside_their_domain_are_refused() {
    let base = FlatSettings::from(RenderSettings::fastsplats2000());
    let table = |entries, sections| FlatSettings {
        table: TableLayout {
            entries,
            sections,
            ..base.table
        },
        ..base
    };
    let raster = |rasterizer| FlatSettings { rasterizer, ..base };
    let range = |density, gradient| FlatSettings {
        extraction: Some(Extraction { density, gradient }),
        ..base
    };
    let surface = FlatSettings {
        reconstruction: Reconstruction::Surface { flatness: 4.0 },
        ..base
    };
    refused(table(31, 128), "table entries: 31");
    refused(table(1025, 128), "table entries: 1025");
    refused(table(128, 0), "table sections: 0");
    refused(raster(Rasterizer::Rlut { subpixels: 129 }), "subpixels: 129");
    refused(raster(Rasterizer::Blit2d { subpixels: 0 }), "subpixels: 0");
    refused(range(Some([2.0, 1.0]), 0.0), "extraction density: [2.0, 1.0]");
    refused(range(None, f64::NAN), "extraction gradient: NaN");
    refused(surface, "rasterizer: \"square-1d\"");
}

#[test]
fn what_no_method_has_is_refused_by_key() {
    let post = FlatSettings::default();
    let pre = FlatSettings {
        classification: Classification::Pre,
        ..post
    };
    let with = |base: FlatSettings, change: fn(&mut FlatSettings)| {
        let mut flat = base;
        change(&mut flat);
        flat
    };
    refused(
        with(post, |s| s.rasterizer = Rasterizer::Ellipse1d),
        "sheet: None",
    );
    refused(
        with(post, |s| s.compositing = Compositing::PerSplat),
        "classification: Post",
    );
    refused(
        with(pre, |s| s.sheet = Some(SheetContent::Sample)),
        "sheet: Sample",
    );
    refused(
        with(post, |s| {
            (s.compositing, s.occlusion) = (Compositing::Mip, Occlusion::Sat);
        }),
        "compositing: Mip",
    );
    refused(
        with(pre, |s| {
            (s.compositing, s.occlusion) = (Compositing::PerSplatBackToFront, Occlusion::Sat);
        }),
        "occlusion: Sat",
    );
    refused(
        with(post, |s| s.stretch = Stretch::Trapezoid),
        "stretch: Trapezoid",
    );
    refused(
        with(pre, |s| {
            (s.sheet_precision, s.absorption) = (SheetPrecision::U8, Absorption::Exp);
        }),
        "sheet precision: U8",
    );
    refused(
        with(pre, |s| {
            (s.sheet_precision, s.compositing) = (SheetPrecision::U16, Compositing::PerSplat);
        }),
        "sheet precision: U16",
    );
    refused(
        with(pre, |s| {
            (s.kernel_edge, s.kernel) = (KernelEdge::Raw, Kernel::CrawfisMax);
        }),
        "kernel edge: Raw",
    );
    refused(
        with(post, |s| {
            s.sheet = Some(SheetContent::Section);
            s.extraction = Some(Extraction::default());
        }),
        "sheet values: Mean",
    );
    refused(
        with(post, |s| s.motion_blur = MotionBlur::Capsule),
        "motion blur: Capsule",
    );
    refused(with(pre, |s| s.filter = Filter::SwanAlpha), "filter: SwanAlpha");
    refused(
        with(post, |s| {
            s.reconstruction = Reconstruction::Surface { flatness: 4.0 };
        }),
        "reconstruction: Surface",
    );
    refused(
        with(post, |s| {
            (s.compositing, s.coverage) = (Compositing::Mean, Coverage::ADAPTIVE);
        }),
        "coverage: Adaptive",
    );
    let moving = RenderSettings {
        motion_blur: MotionBlur::Capsule,
        ..RenderSettings::default()
    };
    let text = moving.validate().expect_err("sheets do not move").to_string();
    assert!(text.starts_with("motion blur: Capsule"), "{text}");
}

#[test]
fn a_level_bias_of_an_octave_takes_half_of_the_resolution_and_analytic_gradients_refuse_it() {
    let volume = splatvol_samples::Sample::Ball
        .generate(Some(splatvol_samples::SampleSize::Longest(64)))
        .expect("the sample exists");
    let look = splatvol::TransferFunction::gray_ramp(volume.value_range(), 0.2).expect("a range");
    let scene = splatvol::Scene::new(volume, look);
    let projection = splatvol::Projection::Orthographic { height: 64.0 };
    let bounds = scene.bounds().expect("an item");
    let camera =
        splatvol::Camera::framing(&bounds, splatvol::View::Front, projection, 1.0).expect("a camera");
    let size = splatvol::ImageSize::new(64, 64).expect("a size");
    let mut renderer = splatvol::Renderer::new(splatvol::EngineConfig::default()).expect("threads");
    let mut render = |settings: RenderSettings| {
        let frame = renderer
            .render(&scene, &camera, &settings.with_size(size))
            .expect("valid");
        let light: f32 = frame.image.pixels.iter().map(|pixel| pixel[3]).sum();
        (renderer.statistics().level, renderer.statistics().voxels, light)
    };
    let (fast, draft) = (render(RenderSettings::fast()), render(RenderSettings::draft()));
    assert_eq!(draft.0, fast.0 + 1);
    assert!(draft.1 * 4 < fast.1, "{} of {} voxels", draft.1, fast.1);
    assert!((draft.2 / fast.2 - 1.0).abs() < 0.05, "{} {}", draft.2, fast.2);
    for (gradient, level_bias) in [
        (splatvol::Gradient::Analytic, 1.0),
        (splatvol::Gradient::Differences, 9.0),
    ] {
        let refused = validated(FlatSettings {
            gradient,
            level_bias,
            ..FlatSettings::default()
        });
        assert!(refused.is_err_and(|error| error.contains("level bias")));
    }
}
