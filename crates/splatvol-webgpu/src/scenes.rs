//! Scenes of all kinds: generated, small, the same everywhere.

use std::error::Error;

use splatvol::glam::{DAffine3, DVec3};
use splatvol::samples::{Sample, SampleSize};
use splatvol::{
    Camera, Classification, Compositing, Coverage, FlatSettings, GaussianAttributes, GaussianMode, Gaussians,
    ImageSize, Item, PointAttributes, PointLook, Points, Projection, RenderSettings, Scene, View,
};

use crate::laws::Law;

/// A scene, how it is rendered, and what is asked of its picture.
#[derive(Debug, Clone)]
pub(crate) struct Case {
    pub name: &'static str,
    pub scene: Scene,
    pub camera: Camera,
    pub settings: RenderSettings,
    pub law: Law,
}

/// Pixels along an edge of the pictures.
const EDGE: u32 = 96;
/// Seed of everything random.
const SEED: u64 = 1;

/// All scenes.
///
/// # Errors
/// None: they are all valid.
pub(crate) fn cases() -> Result<Vec<Case>, Box<dyn Error>> {
    let head = || volume(Sample::Head);
    let shells = || volume(Sample::Shells);
    let fast = RenderSettings::fast();
    let flat = |compositing, classification| {
        RenderSettings::try_from(FlatSettings {
            compositing,
            classification,
            ..fast.into()
        })
    };
    let volumetric = RenderSettings {
        gaussians: GaussianMode::Volumetric,
        ..fast
    };
    let published = RenderSettings {
        gaussians: GaussianMode::Published,
        ..fast
    };
    let mip = flat(Compositing::Mip, Classification::Post)?;
    let xray = flat(Compositing::Xray, Classification::Post)?;
    let pre = flat(Compositing::ImageSheets, Classification::Pre)?;
    let integrals = RenderSettings {
        gaussians: GaussianMode::Volumetric,
        ..xray
    };
    let clouds = [points(2000)?, gaussians(150, 0.03)?];
    let mixture = [head()?, points(2000)?, gaussians(150, 0.03)?];
    [
        (
            "head, default",
            vec![head()?],
            RenderSettings::default(),
            Law::VOLUMES,
        ),
        ("head, fast", vec![head()?], fast, Law::VOLUMES),
        ("shells, fast", vec![shells()?], fast, Law::VOLUMES),
        ("head, best", vec![head()?], RenderSettings::best(), Law::BEST),
        ("head, classified first", vec![head()?], pre, Law::VOLUMES),
        ("head, largest values", vec![head()?], mip, Law::VOLUMES),
        ("head, X-ray", vec![head()?], xray, Law::VOLUMES),
        ("points", vec![points(2000)?], fast, Law::OTHERS),
        ("Gaussians", vec![gaussians(3000, 0.02)?], published, Law::OTHERS),
        (
            "head, points and Gaussians",
            mixture.into(),
            volumetric,
            Law::OTHERS,
        ),
        (
            "points and Gaussians, X-ray",
            clouds.into(),
            integrals,
            Law::OTHERS,
        ),
    ]
    .into_iter()
    .map(|(name, items, settings, law)| {
        let scene = Scene::of_items(items)?;
        let projection = Projection::Perspective { fov_degrees: 30.0 };
        Ok(Case {
            name,
            camera: Camera::framing(&scene.bounds()?, View::Iso, projection, 1.0)?,
            scene,
            settings: RenderSettings {
                coverage: Coverage::Off,
                ..settings.with_size(ImageSize::new(EDGE, EDGE)?)
            },
            law,
        })
    })
    .collect()
}

/// A generated volume, as wide as the other things.
fn volume(sample: Sample) -> Result<Item, Box<dyn Error>> {
    let volume = sample.generate(Some(SampleSize::Dims([40; 3])))?;
    let scene = Scene::new(volume, sample.default_transfer_function()?);
    let bounds = scene.bounds()?;
    let scale = DVec3::splat(1.6 / (bounds.max[0] - bounds.min[0]));
    let to_middle = DAffine3::from_translation(-bounds.centre());
    let at = DAffine3::from_scale(scale) * to_middle;
    let item = scene.items.into_iter().next();
    Ok(item.ok_or("a scene of a volume is empty")?.at(at))
}

/// Even points on a sphere (Fibonacci's spiral), coloured by place.
fn points(count: usize) -> Result<Item, Box<dyn Error>> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let normals: Vec<[f32; 3]> = (0..count)
        .map(|i| {
            let z = 1.0 - 2.0 * (i as f64 + 0.5) / count as f64;
            let (sin, cos) = (golden * i as f64).sin_cos();
            let radius = (1.0 - z * z).sqrt();
            [radius * cos, radius * sin, z].map(|x| x as f32)
        })
        .collect();
    let shade = |x: f32| (127.0 + 127.0 * x) as u8;
    let area = 4.0 * std::f64::consts::PI / count as f64;
    let attributes = PointAttributes {
        colors: normals
            .iter()
            .map(|&[x, y, z]| [shade(x), shade(y), shade(z), 255])
            .collect(),
        normals: normals.clone(),
        radii: vec![area.sqrt() as f32; count],
    };
    let points = Points::new(normals, attributes, DAffine3::IDENTITY)?;
    let beside = DAffine3::from_translation(DVec3::new(0.6, 0.2, 0.3));
    Ok(Item::points(points, PointLook::default()).at(beside))
}

/// Gaussians of all shapes in a cube, with harmonics; `size`: of their axes, about.
fn gaussians(count: usize, size: f32) -> Result<Item, Box<dyn Error>> {
    let mut state = SEED;
    // Knuth's generator (MMIX), from -1 to 1.
    let mut signed = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1 << 23) as f32 - 1.0
    };
    let mut made = GaussianAttributes::default();
    for _ in 0..count {
        made.means.push([(); 3].map(|()| signed()));
        made.scales.push([(); 3].map(|()| size * (1.5 * signed()).exp()));
        made.rotations.push([(); 4].map(|()| signed() + 1e-3));
        made.opacities.push(0.5 + 0.45 * signed());
        for k in 0..4 {
            let size = if k == 0 { 1.6 } else { 0.4 };
            made.harmonics.push([(); 3].map(|()| size * signed()));
        }
    }
    Ok(Item::gaussians(Gaussians::new(made, 1, DAffine3::IDENTITY)?))
}
