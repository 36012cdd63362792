//! Points, meshes and volumetric Gaussians on the GPU's planes, alone and among volumes, against the CPU engine's.

use splatvol::glam::{DAffine3, DVec3};
use splatvol::samples::{Sample, SampleSize};
use splatvol::{
    Association, Camera, Classification, Clip, Compositing, Filter, FlatSettings, GaussianAttributes,
    GaussianMode, Gaussians, Isosurface, Item, Mesh, MeshField, Motion, MotionBlur, PointAttributes,
    PointLook, Points, Projection, RenderSettings, Renderer, Scene, Topology,
};
use splatvol_gpu::GpuConfig;
use splatvol_testing::random::Random;
use splatvol_testing::{Comparison, Tolerance, assert_images, checked};

use super::common::{both, camera, gpu, gpu_of, sized};

const PERSPECTIVE: Projection = Projection::Perspective { fov_degrees: 30.0 };
const PARALLEL: Projection = Projection::Orthographic { height: 1.0 };

/// Even points on the unit sphere (Fibonacci's spiral), coloured by place. `are_bare`: without radii and normals.
fn sphere(count: usize, are_bare: bool) -> Item {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let positions: Vec<[f32; 3]> = (0..count)
        .map(|i| {
            let z = 1.0 - 2.0 * (i as f64 + 0.5) / count as f64;
            let (sin, cos) = (golden * i as f64).sin_cos();
            let radius = (1.0 - z * z).sqrt();
            [radius * cos, radius * sin, z].map(|x| x as f32)
        })
        .collect();
    let area = 4.0 * std::f64::consts::PI / count as f64;
    let shade = |x: f32| (127.0 + 127.0 * x) as u8;
    let attributes = PointAttributes {
        colors: positions
            .iter()
            .map(|p| [shade(p[0]), shade(p[1]), shade(p[2]), 255])
            .collect(),
        normals: if are_bare { Vec::new() } else { positions.clone() },
        radii: if are_bare {
            Vec::new()
        } else {
            vec![area.sqrt() as f32; count]
        },
    };
    let points = Points::new(positions, attributes, DAffine3::IDENTITY).unwrap();
    Item::points(points, PointLook::default())
}

/// Gaussians of all shapes in a cube, with harmonics.
fn gaussians(seed: u64, count: usize) -> Item {
    let mut random = Random::new(seed);
    let mut made = GaussianAttributes::default();
    let mut signed = || 2.0 * random.unit() as f32 - 1.0;
    for _ in 0..count {
        made.means.push([(); 3].map(|()| signed()));
        made.scales.push([(); 3].map(|()| 0.03 * (1.5 * signed()).exp()));
        made.rotations.push([(); 4].map(|()| signed() + 1e-3));
        made.opacities.push(0.5 + 0.45 * signed());
        for k in 0..4 {
            let size = if k == 0 { 1.6 } else { 0.4 };
            made.harmonics.push([(); 3].map(|()| size * signed()));
        }
    }
    Item::gaussians(Gaussians::new(made, 1, DAffine3::IDENTITY).unwrap())
}

/// A curved field on a mesh whose points lie closer in the middle.
fn mesh() -> Item {
    let dims = [17, 15, 19];
    let count: usize = dims.iter().product();
    let points: Vec<DVec3> = (0..count)
        .map(|i| {
            let at = [i % dims[0], i / dims[0] % dims[1], i / dims[0] / dims[1]];
            DVec3::from_array(std::array::from_fn(|a| {
                let t = 2.0 * at[a] as f64 / (dims[a] - 1) as f64 - 1.0;
                t * (0.75 + 0.25 * t * t)
            }))
        })
        .collect();
    let value = |p: &DVec3| (1.2 - p.length() + 0.2 * (4.0 * p.x).sin() * p.y) as f32;
    let field = MeshField {
        name: "value".to_owned(),
        association: Association::Point,
        values: points.iter().map(value).collect(),
    };
    let positions = points.iter().map(|p| p.as_vec3().to_array()).collect();
    let topology = Topology::Structured(vec![dims]);
    let mesh = Mesh::new(positions, topology, Vec::new(), field, DAffine3::IDENTITY).unwrap();
    let look = splatvol_testing::transfer::linear_extinction([0.5, 1.1], 9.0, [0.9, 0.5, 0.2]);
    Item::mesh(mesh, look)
}

/// The head, as wide as the other things.
fn head() -> Item {
    let volume = Sample::Head.generate(Some(SampleSize::Dims([32; 3]))).unwrap();
    let look = Sample::Head.default_transfer_function().unwrap();
    let scene = Scene::new(volume, look);
    let bounds = scene.bounds().unwrap();
    let scale = 1.6 / (bounds.max[0] - bounds.min[0]);
    let at = DAffine3::from_scale(DVec3::splat(scale)) * DAffine3::from_translation(-bounds.centre());
    scene.items.into_iter().next().unwrap().at(at)
}

fn scene(items: impl IntoIterator<Item = Item>) -> Scene {
    Scene::of_items(items.into_iter().collect()).unwrap()
}

/// A camera in the middle of things.
fn within() -> Camera {
    let eye = DVec3::new(0.2, 0.1, 0.05);
    let projection = Projection::Perspective { fov_degrees: 80.0 };
    Camera::new(eye, eye + DVec3::new(0.4, 1.0, 0.2), DVec3::Z, projection).unwrap()
}

fn volumetric(settings: RenderSettings) -> RenderSettings {
    RenderSettings {
        gaussians: GaussianMode::Volumetric,
        ..settings
    }
}

/// Law 3: at least so many decibels, and the share of pixels of which no channel differs by more than a level of eight bits.
fn compare(
    (gpu, cpu): (&mut Renderer, &mut Renderer),
    (scene, camera, settings): (&Scene, &Camera, &RenderSettings),
    what: &str,
    (decibels, share): (f64, f64),
) {
    let own = gpu.render(scene, camera, settings).unwrap();
    let wanted = cpu.render(scene, camera, settings).unwrap();
    let seen = wanted.image.pixels.iter().filter(|pixel| pixel[3] > 0.1).count();
    assert!(20 * seen > wanted.image.pixels.len(), "{what}: {seen} pixels");
    let near = |(p, q): (&[f32; 4], &[f32; 4])| (0..4).all(|c| (p[c] - q[c]).abs() <= 1.0 / 255.0);
    let both = own.image.pixels.iter().zip(&wanted.image.pixels);
    let found = both.filter(|&both| near(both)).count() as f64 / own.image.pixels.len() as f64;
    let figures = Comparison::of(&own.image, &wanted.image);
    println!("{what}: {:.1} dB, {:.1} %", figures.psnr, 100.0 * found);
    assert_images(what, &own.image, &wanted.image, Tolerance::psnr(decibels));
    assert!(found >= share, "{what}: {found:.4}");
    let mut depths: Vec<f64> = (0..own.depth.len())
        .filter(|&at| {
            [&own, &wanted]
                .iter()
                .all(|frame| frame.image.pixels[at][3] > 0.5)
        })
        .map(|at| f64::from((own.depth[at] - wanted.depth[at]).abs() / wanted.depth[at]))
        .collect();
    depths.sort_by(f64::total_cmp);
    let median = depths.get(depths.len() / 2).copied().unwrap_or(0.0);
    assert!(median < 1e-3, "{what}: {median:e}");
}

#[test]
fn points_are_the_cpu_s() {
    let Some((mut gpu, mut cpu)) = both() else {
        return;
    };
    let lit = sized(RenderSettings::balanced(), 64);
    let unlit = RenderSettings {
        lighting: None,
        ..lit
    };
    let sharp = checked(FlatSettings {
        filter: Filter::None,
        ..lit.into()
    });
    let wide = checked(FlatSettings {
        filter: Filter::Ewa { pixel_sigma: 0.6 },
        ..lit.into()
    });
    let surfels = scene([sphere(3000, false)]);
    let bare = scene([sphere(3000, true)]);
    let mut clipped = surfels.clone();
    clipped
        .clips
        .push(Clip::plane(DVec3::ZERO, [0.31, 1.0, 0.113]).unwrap());
    for (name, scene, settings) in [
        ("lit", &surfels, lit),
        ("unlit", &surfels, unlit),
        ("sharp", &surfels, sharp),
        ("wide", &surfels, wide),
        ("bare", &bare, lit),
        ("clipped", &clipped, lit),
        ("fast", &surfels, sized(RenderSettings::fast(), 64)),
        ("best", &surfels, sized(RenderSettings::best(), 64)),
    ] {
        for projection in [PERSPECTIVE, PARALLEL] {
            let camera = camera(scene, projection);
            let what = format!("gpu-points-{name}");
            compare(
                (&mut gpu, &mut cpu),
                (scene, &camera, &settings),
                &what,
                (62.0, 0.99),
            );
        }
    }
}

#[test]
fn volumetric_gaussians_are_the_cpu_s() {
    let Some((mut gpu, mut cpu)) = both() else {
        return;
    };
    let scene = scene([gaussians(3, 400)]);
    for (name, preset) in [("fast", RenderSettings::fast()), ("best", RenderSettings::best())] {
        for projection in [PERSPECTIVE, PARALLEL] {
            let camera = camera(&scene, projection);
            let settings = volumetric(sized(preset, 64));
            let what = format!("gpu-volumetric-{name}");
            compare(
                (&mut gpu, &mut cpu),
                (&scene, &camera, &settings),
                &what,
                (78.0, 0.999),
            );
        }
    }
    // From within.
    let settings = volumetric(sized(RenderSettings::fast(), 64));
    let what = "gpu-volumetric-within";
    compare(
        (&mut gpu, &mut cpu),
        (&scene, &within(), &settings),
        what,
        (72.0, 0.999),
    );
}

#[test]
fn meshes_are_the_cpu_s() {
    let Some((mut gpu, mut cpu)) = both() else {
        return;
    };
    let plain = scene([mesh()]);
    let mut clipped = plain.clone();
    clipped
        .clips
        .push(Clip::plane(DVec3::ZERO, [0.31, 1.0, 0.113]).unwrap());
    let mut surfaces = plain.clone();
    if let splatvol::Content::Mesh { isosurfaces, .. } = &mut surfaces.items[0].content {
        isosurfaces.push(Isosurface {
            value: 0.7,
            opacity: 0.8,
            rgb: [0.2, 0.7, 0.9],
        });
    }
    let lit = sized(RenderSettings::balanced(), 64);
    let unlit = RenderSettings {
        lighting: None,
        ..lit
    };
    let pre = checked(FlatSettings {
        classification: Classification::Pre,
        ..lit.into()
    });
    for (name, scene, settings) in [
        ("lit", &plain, lit),
        ("unlit", &plain, unlit),
        ("pre", &plain, pre),
        ("clipped", &clipped, lit),
        ("surface", &surfaces, lit),
        ("fast", &plain, sized(RenderSettings::fast(), 64)),
    ] {
        for projection in [PERSPECTIVE, PARALLEL] {
            let camera = camera(scene, projection);
            let what = format!("gpu-mesh-{name}");
            compare(
                (&mut gpu, &mut cpu),
                (scene, &camera, &settings),
                &what,
                (82.0, 0.999),
            );
        }
    }
}

/// Everything together, in both orders.
#[test]
fn mixtures_are_the_cpu_s() {
    let Some((mut gpu, mut cpu)) = both() else {
        return;
    };
    let moved = |item: Item, by: [f64; 3]| item.at(DAffine3::from_translation(DVec3::from_array(by)));
    let all = || {
        [
            head(),
            moved(sphere(2000, false), [0.6, 0.2, 0.3]),
            moved(gaussians(5, 150), [-0.4, 0.5, 0.0]),
            moved(mesh(), [0.2, -0.9, 0.4]),
        ]
    };
    let fast = volumetric(sized(RenderSettings::fast(), 64));
    let pre = checked(FlatSettings {
        classification: Classification::Pre,
        ..fast.into()
    });
    let mut backwards: Vec<Item> = all().into();
    backwards.reverse();
    // The engines cut kernels of volumes in different ways.
    for (name, scene, settings, decibels, share) in [
        ("all", scene(all()), fast, 54.0, 0.97),
        ("backwards", scene(backwards), fast, 54.0, 0.97),
        ("pre", scene(all()), pre, 57.0, 0.96),
        ("two", scene([head(), sphere(2000, false)]), fast, 65.0, 0.99),
    ] {
        let camera = camera(&scene, PERSPECTIVE);
        let what = format!("gpu-mixture-{name}");
        compare(
            (&mut gpu, &mut cpu),
            (&scene, &camera, &settings),
            &what,
            (decibels, share),
        );
    }
}

/// These settings with another compositing.
fn shown(settings: RenderSettings, compositing: Compositing) -> RenderSettings {
    checked(FlatSettings {
        compositing,
        ..settings.into()
    })
}

#[test]
fn x_rays_are_the_cpu_s() {
    let Some((mut gpu, mut cpu)) = both() else {
        return;
    };
    let xray = |preset| volumetric(shown(sized(preset, 64), Compositing::Xray));
    let (fast, best) = (xray(RenderSettings::fast()), xray(RenderSettings::best()));
    let filtered = |filter| {
        checked(FlatSettings {
            filter,
            ..fast.into()
        })
    };
    let wide = filtered(Filter::Ewa { pixel_sigma: 0.6 });
    let matched = filtered(Filter::Matched { pixel_sigma: 0.8 });
    let points = || sphere(3000, false);
    // The same footprints, but for roundings; of volumes the GPU adds up planes.
    let same = (120.0, 1.0);
    for (name, scene, settings, limits) in [
        ("points", scene([points()]), fast, same),
        ("points-best", scene([points()]), best, same),
        ("points-wide", scene([points()]), wide, same),
        ("gaussians", scene([gaussians(3, 400)]), fast, same),
        ("gaussians-wide", scene([gaussians(3, 400)]), wide, same),
        ("gaussians-matched", scene([gaussians(3, 400)]), matched, same),
        ("mesh", scene([mesh()]), fast, same),
        ("mesh-wide", scene([mesh()]), wide, same),
        (
            "together",
            scene([mesh(), points(), gaussians(5, 150)]),
            wide,
            same,
        ),
        ("volume", scene([head(), points()]), wide, (54.0, 0.95)),
        ("volume-best", scene([head(), points()]), best, (54.0, 0.95)),
        ("volume-mesh", scene([head(), mesh()]), fast, (50.0, 0.9)),
        // Here the head fades between two levels, of which the CPU adds a mean.
        (
            "volume-gaussians",
            scene([head(), gaussians(3, 400)]),
            fast,
            (44.0, 0.92),
        ),
    ] {
        for projection in [PERSPECTIVE, PARALLEL] {
            let camera = camera(&scene, projection);
            let what = format!("gpu-xray-{name}");
            compare((&mut gpu, &mut cpu), (&scene, &camera, &settings), &what, limits);
        }
    }
    // Dense material has depths whose transmittance is no number.
    let dense = scene([head(), mesh()]);
    let camera = camera(&dense, PERSPECTIVE);
    let middle = |renderer: &mut Renderer| {
        let frame = renderer.render(&dense, &camera, &best).unwrap();
        frame.optical_depth[32 * 64 + 30]
    };
    let [own, wanted] = [middle(&mut gpu), middle(&mut cpu)];
    println!("gpu-xray-dense: {own} {wanted}");
    assert!(
        wanted > 100.0 && (own / wanted - 1.0).abs() < 0.01,
        "{own} {wanted}"
    );
    // From within, some kernels lie behind the eye.
    let both = scene([gaussians(3, 400), points()]);
    let what = "gpu-xray-within";
    compare((&mut gpu, &mut cpu), (&both, &within(), &fast), what, same);
}

#[test]
fn values_of_meshes_are_the_cpu_s() {
    let Some((mut gpu, mut cpu)) = both() else {
        return;
    };
    let mut scene = scene([mesh()]);
    if let splatvol::Content::Mesh {
        transfer_function, ..
    } = &mut scene.items[0].content
    {
        // Minima are small.
        *transfer_function = splatvol_testing::transfer::linear_extinction([-0.8, 1.3], 9.0, [0.9, 0.5, 0.2]);
    }
    let fast = sized(RenderSettings::fast(), 64);
    for (compositing, settings) in [
        (Compositing::Mip, fast),
        (Compositing::MinimumIntensity, fast),
        (Compositing::Mean, fast),
        (Compositing::Mean, sized(RenderSettings::balanced(), 64)),
    ] {
        let settings = shown(settings, compositing);
        for projection in [PERSPECTIVE, PARALLEL] {
            let camera = camera(&scene, projection);
            let what = format!("gpu-mesh-{compositing:?}");
            let limits = (80.0, 0.999);
            compare((&mut gpu, &mut cpu), (&scene, &camera, &settings), &what, limits);
        }
    }
}

/// What rays keep does not depend on what was drawn before either, nor on the parts of a picture.
#[test]
fn kept_values_are_repeated_to_the_bit() {
    let Some(mut gpu) = gpu() else { return };
    let divided = GpuConfig {
        samples_per_dispatch: Some(1),
        ..GpuConfig::default()
    };
    let mut divided = gpu_of(&divided).unwrap();
    let fast = volumetric(sized(RenderSettings::fast(), 32));
    let everything = scene([head(), sphere(2000, false), gaussians(5, 150), mesh()]);
    let alone = scene([mesh()]);
    let of = |compositing| shown(fast, compositing);
    let pictures = [
        (&everything, of(Compositing::Xray)),
        (&alone, of(Compositing::Mip)),
        (&alone, of(Compositing::Mean)),
        (&alone, of(Compositing::Xray)),
        (&alone, fast),
    ];
    let camera = camera(&everything, PERSPECTIVE);
    let all =
        |gpu: &mut Renderer| pictures.map(|(scene, settings)| gpu.render(scene, &camera, &settings).unwrap());
    let first = all(&mut gpu);
    for again in [all(&mut gpu), all(&mut divided)] {
        for (at, (own, other)) in first.iter().zip(&again).enumerate() {
            assert!(
                own.image.pixels == other.image.pixels && own.depth == other.depth,
                "{at}"
            );
        }
    }
}

/// Nothing depends on what was drawn before, nor on the bands and intervals of a picture.
#[test]
fn pictures_are_repeated_to_the_bit() {
    let Some(mut gpu) = gpu() else { return };
    let everything = scene([head(), sphere(2000, false), gaussians(5, 150), mesh()]);
    let camera = camera(&everything, PERSPECTIVE);
    let settings = volumetric(sized(RenderSettings::fast(), 48));
    let first = gpu.render(&everything, &camera, &settings).unwrap();
    let bytes = gpu.statistics().memory;
    // Where a device has no timestamps there are no passes.
    let passes = &gpu.statistics().passes;
    let names = ["cull", "open", "make_planes", "march", "mixture"];
    let is_timed = |name: &&str| passes.iter().any(|own| own.pass == *name && own.seconds > 0.0);
    assert!(passes.is_empty() || names.iter().all(is_timed), "{passes:?}");
    assert!(bytes.device > 0 && bytes.clouds > 0, "{bytes:?}");
    // Colours of Gaussians, look of the mesh, and what there is.
    let mut edited = everything.clone();
    if let splatvol::Content::Mesh {
        transfer_function, ..
    } = &mut edited.items[3].content
    {
        *transfer_function = splatvol_testing::transfer::constant_extinction(0.5, [0.2; 3]);
    }
    let mut other = self::camera(&everything, PARALLEL);
    let between = gpu.render(&edited, &other, &settings).unwrap();
    assert_ne!(first.image.pixels, between.image.pixels);
    gpu.render(&scene([sphere(100, false)]), &camera, &sized(settings, 20))
        .unwrap();
    let again = gpu.render(&everything, &camera, &settings).unwrap();
    assert!(first.image.pixels == again.image.pixels && first.depth == again.depth);
    other = camera;
    let divided = GpuConfig {
        samples_per_dispatch: Some(1),
        ..GpuConfig::default()
    };
    let mut divided = gpu_of(&divided).unwrap();
    let parts = divided.render(&everything, &other, &settings).unwrap();
    assert!(first.image.pixels == parts.image.pixels && first.depth == parts.depth);
}

/// The facade's sub-frames are of scenes at rest.
#[test]
fn motion_is_the_cpu_s() {
    let Some((mut gpu, mut cpu)) = both() else {
        return;
    };
    let motion = Motion::Linear(DVec3::new(0.3, 0.1, 0.0));
    let scene = scene([head(), sphere(1000, false)]).with_motion(&motion);
    let camera = camera(&scene, PERSPECTIVE);
    let settings = RenderSettings {
        motion_blur: MotionBlur::Subframes { count: 3 },
        ..sized(RenderSettings::fast(), 48)
    };
    compare(
        (&mut gpu, &mut cpu),
        (&scene, &camera, &settings),
        "gpu-motion",
        (70.0, 0.99),
    );
}

#[test]
fn what_is_not_drawn_is_refused_by_name() {
    let Some(mut gpu) = gpu() else { return };
    let fast = sized(RenderSettings::fast(), 16);
    let of = |compositing, classification| {
        checked(FlatSettings {
            compositing,
            classification,
            ..fast.into()
        })
    };
    let (pre, post) = (Classification::Pre, Classification::Post);
    let best = sized(RenderSettings::best(), 16);
    let points = scene([sphere(100, false)]);
    let meshes = scene([mesh()]);
    let two = scene([mesh(), head()]);
    for (scene, settings, word) in [
        (&points, of(Compositing::Mip, post), "maxima"),
        (&two, of(Compositing::Mip, post), "maxima"),
        (&points, of(Compositing::PerSplat, pre), "sheets"),
        (&meshes, best, "gradient"),
    ] {
        let camera = camera(scene, PERSPECTIVE);
        let error = gpu.render(scene, &camera, &settings).unwrap_err().to_string();
        assert!(error.contains(word), "{word}: {error}");
    }
    let plane = Clip::plane(DVec3::ZERO, [1.0, 0.0, 0.0]).unwrap();
    let camera = camera(&points, PERSPECTIVE);
    let mut clipped = scene([head(), sphere(100, false)]);
    clipped.clips.push(plane.clone());
    let error = gpu
        .render(&clipped, &camera, &of(Compositing::Xray, pre))
        .unwrap_err()
        .to_string();
    assert!(error.contains("a clip in X-rays"), "{error}");
    let mut clipped = points.clone();
    clipped.items[0].clips.push(plane);
    let error = gpu.render(&clipped, &camera, &fast).unwrap_err().to_string();
    assert!(error.contains("clip"), "{error}");
    let mut moving = points.clone().with_motion(&Motion::Linear(DVec3::X));
    moving.items.push(head());
    let capsule = RenderSettings {
        motion_blur: MotionBlur::Capsule,
        ..fast
    };
    assert!(gpu.render(&moving, &camera, &capsule).is_err());
}
