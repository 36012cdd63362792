//! One picture of every kind of scene, classification, compositing and paper's method.

use glam::{DAffine3, DVec3, Vec3};
use splatvol::mesh::{Association, MeshField, Topology};
use splatvol::{
    BumpMap, Camera, Classification, Clip, Compositing, Coverage, FlatSettings, Frame, GaussianAttributes,
    GaussianMode, Gaussians, Gradient, Grid, Image, ImageSize, Isosurface, Item, Mesh, Motion, MotionBlur,
    PointAttributes, PointLook, Points, Projection, RenderSettings, Renderer, Rescale, Samples, Scene,
    SolidTexture, Stuff, TransferFunction, View, Volume,
};
use splatvol_samples::{Sample, SampleSize};
use splatvol_testing::{Random, checked};

/// One picture.
pub(crate) struct Case {
    pub(crate) name: String,
    scene: Scene,
    camera: Camera,
    settings: RenderSettings,
}

impl Case {
    /// The picture, by this engine.
    pub(crate) fn frame(&self, renderer: &mut Renderer) -> Frame {
        let frame = renderer.render(&self.scene, &self.camera, &self.settings);
        frame.unwrap_or_else(|error| panic!("{}: {error}", self.name))
    }
}

const PERSPECTIVE: Projection = Projection::Perspective { fov_degrees: 25.0 };
const PARALLEL: Projection = Projection::Orthographic { height: 1.0 };

/// Not multiples of any tile's edge.
fn sized(settings: RenderSettings) -> RenderSettings {
    RenderSettings {
        size: ImageSize::new(152, 104).unwrap(),
        ..settings
    }
}

fn head() -> Volume {
    Sample::Head.generate(Some(SampleSize::Longest(40))).unwrap()
}

fn look() -> TransferFunction {
    Sample::Head.default_transfer_function().unwrap()
}

/// The volume with a hole in it, and one of its corners missing.
fn holed(volume: &Volume) -> Volume {
    let count = volume.grid().sample_count();
    let [low, high] = volume.value_range();
    let mut random = Random::new(5);
    let mut samples: Vec<f32> = (0..count).map(|_| random.range(low, high) as f32).collect();
    samples[count / 2 + 17] = f32::NAN;
    let [nx, ny, _] = volume.grid().dims();
    for (i, sample) in samples.iter_mut().enumerate() {
        if i % nx + i / nx % ny + i / (nx * ny) > (nx + ny) / 2 + 20 {
            *sample = f32::INFINITY;
        }
    }
    Volume::new(
        volume.grid().clone(),
        Samples::F32(samples.into()),
        Rescale::default(),
        Default::default(),
    )
    .unwrap()
}

/// Every way to composite and to classify, by the settings of a preset.
fn modes(preset: &str, base: RenderSettings) -> Vec<(String, RenderSettings)> {
    let named = |name: &str, settings| (format!("{preset} {name}"), settings);
    let composited = |compositing| {
        checked(FlatSettings {
            compositing,
            ..base.into()
        })
    };
    vec![
        named("post", base),
        named(
            "unlit",
            RenderSettings {
                lighting: None,
                ..base
            },
        ),
        named(
            "pre",
            checked(FlatSettings {
                classification: Classification::Pre,
                ..base.into()
            }),
        ),
        named("xray", composited(Compositing::Xray)),
        named("mip", composited(Compositing::Mip)),
        named("minip", composited(Compositing::MinimumIntensity)),
        named("mean", composited(Compositing::Mean)),
    ]
}

/// The papers' methods, and the methods that they consist of.
fn methods() -> Vec<(String, RenderSettings)> {
    let papers = [
        ("swan1997", RenderSettings::swan1997()),
        ("mueller1998", RenderSettings::mueller1998()),
        ("fastsplats2000", RenderSettings::fastsplats2000()),
        ("ewa2001", RenderSettings::ewa2001()),
    ];
    let compositings = [
        Compositing::PerSplat,
        Compositing::PerSplatBackToFront,
        Compositing::AxisSheets,
    ]
    .map(|compositing| {
        let settings = checked(FlatSettings {
            compositing,
            classification: Classification::Pre,
            prefilter: false,
            ..FlatSettings::default()
        });
        (format!("{compositing:?}"), settings)
    });
    let mut methods: Vec<_> = papers.map(|(name, s)| (name.to_owned(), s)).into();
    methods.extend(compositings);
    methods
}

/// Scenes of one volume.
fn of_one() -> Vec<Case> {
    let scene = Scene::new(head(), look());
    let bounds = scene.bounds().unwrap();
    let camera = Camera::framing(&bounds, View::Iso, PERSPECTIVE, 1.47).unwrap();
    let case = |name: String, scene: &Scene, settings| Case {
        name,
        scene: scene.clone(),
        camera,
        settings: sized(settings),
    };
    let mut cases = Vec::new();
    let mut settings = modes("default", RenderSettings::default());
    settings.extend(modes("best", RenderSettings::best()));
    settings.extend(methods());
    for (name, settings) in settings {
        cases.push(case(name, &scene, settings));
    }
    let parallel = Case {
        camera: Camera::framing(&bounds, View::Front, PARALLEL, 1.47).unwrap(),
        ..case("parallel".to_owned(), &scene, RenderSettings::fast())
    };
    // Inside the head: footprints differ in size too much for one raster.
    let eye = Camera::new(bounds.centre(), bounds.centre() + DVec3::Y, DVec3::Z, PERSPECTIVE).unwrap();
    let inside = Case {
        camera: eye,
        ..case("inside".to_owned(), &scene, RenderSettings::default())
    };
    let default = RenderSettings::default();
    let covered = RenderSettings {
        coverage: Coverage::ADAPTIVE,
        ..default
    };
    let open = checked(FlatSettings {
        motion_blur: MotionBlur::Subframes { count: 3 },
        ..default.into()
    });
    let image = Image::filled(ImageSize::new(8, 4).unwrap(), [0.3, 0.7, 0.1, 1.0]);
    let operated = scene
        .clone()
        .with_operator(SolidTexture::new(Stuff::Marble, &bounds, 4.0).unwrap())
        .with_operator(BumpMap::new(&image, &bounds, 0.5).unwrap())
        .with_clip(Clip::plane(bounds.centre(), DVec3::new(1.0, 0.3, 0.2)).unwrap());
    let volume = scene.single_volume().unwrap().volume;
    let [low, high] = volume.value_range();
    let surface = Isosurface {
        value: low + 0.4 * (high - low),
        rgb: [0.9, 0.6, 0.3],
        opacity: 0.6,
    };
    let spinning = scene.clone().with_motion(&Motion::Spin {
        axis: DVec3::Z,
        centre: bounds.centre(),
        angle: 0.3,
    });
    let of_holes = Scene::new(holed(volume), look());
    let plain = checked(FlatSettings {
        prefilter: false,
        ..default.into()
    });
    let composited = |compositing, base: RenderSettings| {
        checked(FlatSettings {
            compositing,
            ..base.into()
        })
    };
    let mip = composited(Compositing::Mip, default);
    let mean = composited(Compositing::Mean, RenderSettings::best());
    let xray = composited(Compositing::Xray, default);
    let clip = Clip::plane(bounds.centre(), DVec3::new(1.0, 0.3, 0.2)).unwrap();
    cases.extend([
        parallel,
        inside,
        case("holed".to_owned(), &of_holes, default),
        case("holed best".to_owned(), &of_holes, RenderSettings::best()),
        case("holed plain".to_owned(), &of_holes, plain),
        case("holed mip".to_owned(), &of_holes, mip),
        case("holed best mean".to_owned(), &of_holes, mean),
        case("holed xray".to_owned(), &of_holes, xray),
        case(
            "holed operators".to_owned(),
            &of_holes.clone().with_clip(clip),
            plain,
        ),
        Case {
            camera: eye,
            ..case("inside holes".to_owned(), &of_holes, default)
        },
        Case {
            camera: eye,
            ..case("inside holes best".to_owned(), &of_holes, RenderSettings::best())
        },
        case("coverage".to_owned(), &scene, covered),
        case("motion".to_owned(), &spinning, open),
        case("operators".to_owned(), &operated, default),
        case(
            "isosurface".to_owned(),
            &Scene::of_isosurfaces(volume.clone(), &[surface]).unwrap(),
            default,
        ),
    ]);
    cases
}

fn surfels(count: usize) -> Item {
    let mut random = Random::new(9);
    let normals: Vec<[f32; 3]> = (0..count)
        .map(|_| random.direction().as_vec3().to_array())
        .collect();
    let positions = normals
        .iter()
        .map(|n| (0.7 * Vec3::from_array(*n)).to_array())
        .collect();
    let attributes = PointAttributes {
        radii: vec![0.12; count],
        normals,
        ..PointAttributes::default()
    };
    let points = Points::new(positions, attributes, DAffine3::IDENTITY).unwrap();
    Item::points(points, PointLook::default())
}

fn gaussians(count: usize) -> Item {
    let mut random = Random::new(3);
    let mut attributes = GaussianAttributes::default();
    for _ in 0..count {
        let mean = random.point(DVec3::splat(-1.0), DVec3::ONE);
        attributes.means.push(mean.as_vec3().to_array());
        attributes
            .scales
            .push(std::array::from_fn(|_| random.range(0.02, 0.3) as f32));
        let axis = random.direction().as_vec3();
        let turn = random.range(-1.0, 1.0) as f32;
        attributes.rotations.push([axis.x, axis.y, axis.z, turn]);
        attributes.opacities.push(random.range(0.2, 0.95) as f32);
        attributes
            .harmonics
            .push(std::array::from_fn(|_| random.range(-1.7, 1.7) as f32));
    }
    Item::gaussians(Gaussians::new(attributes, 0, DAffine3::IDENTITY).unwrap())
}

/// Noise on a grid whose planes come closer towards the middle.
fn mesh() -> Item {
    let side = 14;
    let along = |i: usize| {
        let t = 2.0 * i as f64 / (side - 1) as f64 - 1.0;
        t * (0.75 + 0.25 * t * t)
    };
    let positions = (0..side * side * side)
        .map(|i| {
            let place = [i % side, i / side % side, i / (side * side)].map(along);
            DVec3::from_array(place).as_vec3().to_array()
        })
        .collect();
    let mut random = Random::new(21);
    let values = MeshField {
        name: "value".to_owned(),
        association: Association::Point,
        values: (0..side * side * side)
            .map(|_| random.range(0.0, 1.0) as f32)
            .collect(),
    };
    let topology = Topology::Structured(vec![[side; 3]]);
    let mesh = Mesh::new(positions, topology, Vec::new(), values, DAffine3::IDENTITY).unwrap();
    Item::mesh(mesh, noise_look())
}

fn noise_look() -> TransferFunction {
    splatvol_testing::transfer::linear_extinction([0.0, 1.0], 2.0, [0.9, 0.5, 0.2])
}

fn fog() -> Item {
    let grid = Grid::centred([20; 3], DVec3::splat(0.12)).unwrap();
    let mut random = Random::new(2);
    let samples = (0..8000).map(|_| random.range(0.0, 1.0) as f32).collect();
    let volume = Volume::new(
        grid,
        Samples::F32(samples),
        Rescale::default(),
        Default::default(),
    )
    .unwrap();
    Item::volume(volume, noise_look())
}

/// Scenes of other things, and of several.
fn of_several() -> Vec<Case> {
    let camera = |fov_degrees| {
        let projection = Projection::Perspective { fov_degrees };
        Camera::new(DVec3::new(3.0, 6.0, 2.0), DVec3::ZERO, DVec3::Z, projection).unwrap()
    };
    let case = |name: &str, items: Vec<Item>, settings| Case {
        name: name.to_owned(),
        scene: Scene::of_items(items).unwrap(),
        camera: camera(24.0),
        settings: sized(settings),
    };
    let default = RenderSettings::default();
    let unlit = RenderSettings {
        lighting: None,
        ..default
    };
    let volumetric = RenderSettings {
        gaussians: GaussianMode::Volumetric,
        ..unlit
    };
    let everything = || vec![fog(), mesh(), surfels(300), gaussians(100)];
    let xray = checked(FlatSettings {
        compositing: Compositing::Xray,
        ..unlit.into()
    });
    let per_splat = checked(FlatSettings {
        compositing: Compositing::PerSplat,
        classification: Classification::Pre,
        gradient: Gradient::Differences,
        ..default.into()
    });
    vec![
        case("surfels", vec![surfels(900)], default),
        case("mesh", vec![mesh()], default),
        case(
            "mesh mip",
            vec![mesh()],
            checked(FlatSettings {
                compositing: Compositing::Mip,
                ..default.into()
            }),
        ),
        case("3dgs", vec![gaussians(400)], default),
        case("volumetric gaussians", vec![gaussians(400)], volumetric),
        case("surfels one by one", vec![surfels(900)], per_splat),
        case("points among 3dgs", vec![gaussians(400), surfels(300)], default),
        case("everything one by one", everything(), per_splat),
        case("x-ray of everything", everything(), xray),
        case("volume and points", vec![fog(), surfels(300)], default),
        case("everything", everything(), unlit),
    ]
}

/// All of them.
pub(crate) fn cases() -> Vec<Case> {
    let mut cases = of_one();
    cases.extend(of_several());
    cases
}
