//! Levels of detail: from a voxel per pixel to eight, steps are bounded, and small pictures cost little.

use splatvol::{
    Camera, Classification, Frame, Grid, ImageSize, Item, Label, LengthUnit, OpacityPoint, Projection,
    RenderSettings, RenderStatistics, Rescale, Samples, Scene, Shows, TransferFunction, Volume,
};
use splatvol_samples::Sample;

use super::support::{fast, generated, name_of, opaque, rendered, renderer};
use crate::common::PROJECTIONS;

const PIXELS: u32 = 192;
const STEPS_PER_OCTAVE: i32 = 8;

/// A camera that sees the middle of the volume with this many voxels to a pixel.
fn minified(scene: &Scene, projection: Projection, voxels_per_pixel: f64) -> Camera {
    let grid = scene.single_volume().unwrap().volume.grid();
    let height = f64::from(PIXELS) * grid.mean_spacing() * voxels_per_pixel;
    let target = grid.bounds().centre();
    let towards = glam::DVec3::new(-0.62, 0.70, 0.36).normalize();
    let (distance, projection) = match projection {
        Projection::Orthographic { .. } => (500.0, Projection::Orthographic { height }),
        Projection::Perspective { fov_degrees } => {
            (0.5 * height / (0.5 * fov_degrees).to_radians().tan(), projection)
        }
    };
    Camera::new(target + distance * towards, target, glam::DVec3::Z, projection).unwrap()
}

/// Sums of a frame's channels, as areas in voxels.
fn areas(frame: &Frame, voxels_per_pixel: f64) -> [f64; 4] {
    let sum = |c: usize| frame.image.pixels.iter().map(|p| f64::from(p[c])).sum::<f64>();
    std::array::from_fn(|c| sum(c) * voxels_per_pixel * voxels_per_pixel)
}

/// Areas of a picture, and what it took.
type Seen = ([f64; 4], RenderStatistics);

/// Pictures of the same view in a pixel per six voxels and in a pixel per voxel, which is of the finest level: their areas, and
/// what they took.
fn far_and_near(scene: &Scene, projection: Projection, settings: &RenderSettings) -> [Seen; 2] {
    let camera = minified(scene, projection, 6.0);
    let mut renderer = renderer();
    [(PIXELS, 6.0), (6 * PIXELS, 1.0)].map(|(pixels, voxels_per_pixel)| {
        let settings = settings.with_size(ImageSize::new(pixels, pixels).unwrap());
        let (frame, statistics) = rendered(&mut renderer, scene, &camera, &settings);
        (areas(&frame, voxels_per_pixel), statistics)
    })
}

/// Checks that a picture of the third level has the areas of one of the finest, for a hundredth of the voxels.
fn check_alike(name: &str, (level, exact): (&Seen, &Seen), tolerance: f64) {
    assert_eq!((exact.1.level, level.1.level), (0, 3), "{name}");
    assert!(
        100 * level.1.voxels < exact.1.voxels,
        "{name}: {}",
        level.1.voxels
    );
    for c in 0..4 {
        let ratio = level.0[c] / exact.0[c];
        assert!((ratio - 1.0).abs() < tolerance, "{name}, channel {c}: {ratio}");
    }
}

/// Levels of classified voxels are means of classes: what is thinner than a level's voxels keeps its optical depth, and
/// so its light where that is small.
#[test]
fn classified_voxels_keep_their_optical_depth_at_any_level() {
    // Shells of thin fog.
    let shells = generated(Sample::Shells, 96);
    let single = shells.single_volume().unwrap();
    let look = single.transfer_function;
    let thin = |point: &OpacityPoint| OpacityPoint {
        opacity: 0.01 * point.opacity,
        ..*point
    };
    let opacities = look.opacities().iter().map(thin).collect();
    let thin = TransferFunction::new(look.colors().to_vec(), opacities, look.unit_distance).unwrap();
    let scene = Scene::from(Item::volume(single.volume.clone(), thin));
    for shows in [Shows::Xray, Shows::Material(Classification::Pre)] {
        let settings = RenderSettings {
            lighting: None,
            ..fast(PIXELS, PIXELS).with_shows(shows)
        };
        for projection in PROJECTIONS {
            let [level, exact] = far_and_near(&scene, projection, &settings);
            let name = format!("{shows:?} {}", name_of(projection));
            println!("{name}: {:?} {:?}", exact.0, level.0);
            check_alike(&name, (&level, &exact), 0.01);
        }
    }
}

/// A ball of labels in eight parts, with a core.
fn ball_of_labels() -> Volume {
    let edge = 80;
    let label = |i: usize| {
        let place = [i % edge, i / edge % edge, i / (edge * edge)];
        let [x, y, z] = place.map(|at| at as f64 - 39.5);
        let part = u8::from(x > 3.0) + 2 * u8::from(y > x) + 4 * u8::from(z > 5.0);
        match (x * x + y * y + z * z).sqrt() {
            distance if distance < 12.0 => 9,
            distance if distance < 36.0 => 1 + part,
            _ => 0,
        }
    };
    let samples: Vec<u8> = (0..edge * edge * edge).map(label).collect();
    let grid = Grid::centred([edge; 3], glam::DVec3::ONE).unwrap();
    let unit = LengthUnit::Millimetre;
    Volume::new(grid, Samples::U8(samples.into()), Rescale::default(), unit).unwrap()
}

/// Levels of labels are lit as their finest voxels are: where there is a surface, by its own share. The labels are thin, so that
/// what a ray loses is in proportion to what it meets.
#[test]
fn labels_have_levels_with_the_light_of_the_finest() {
    let labels: Vec<Label> = (0..10)
        .map(|name: u8| Label {
            value: f64::from(name),
            rgb: [0.9 - 0.08 * f64::from(name), 0.1 * f64::from(name), 0.5],
            opacity: match name {
                0 => 0.0,
                9 => 0.002,
                _ => 0.0005,
            },
        })
        .collect();
    let look = TransferFunction::of_labels(&labels, Some(1.0)).unwrap();
    let scene = Scene::from(Item::labels(ball_of_labels(), look));
    for projection in PROJECTIONS {
        let lit = fast(PIXELS, PIXELS);
        let unlit = RenderSettings {
            lighting: None,
            ..lit
        };
        let name = name_of(projection);
        let mut darker = [1.0; 2];
        for (settings, tolerance) in [(lit, 0.02), (unlit, 0.01)] {
            let [level, exact] = far_and_near(&scene, projection, &settings);
            println!("{name}: {:?} {:?}", exact.0, level.0);
            check_alike(name, (&level, &exact), tolerance);
            darker = [level.0[0] / darker[0], exact.0[0] / darker[1]];
        }
        // What light takes away is there, too: curved surfaces within a voxel have one mean gradient.
        let taken = darker.map(|unlit_over_lit| unlit_over_lit - 1.0);
        println!("{name}: light takes {taken:?}");
        assert!(
            taken[1] > 0.04 && (0.7..1.1).contains(&(taken[0] / taken[1])),
            "{name}: {taken:?}"
        );
    }
}

struct Shot {
    level: usize,
    /// Two levels were rendered: their tiles are counted together.
    blended: bool,
    voxels: u64,
    areas: [f64; 4],
}

fn sweep(scene: &Scene, projection: Projection) -> Vec<Shot> {
    let mut renderer = renderer();
    (0..=3 * STEPS_PER_OCTAVE)
        .map(|step| {
            let voxels_per_pixel = (f64::from(step) / f64::from(STEPS_PER_OCTAVE)).exp2();
            let camera = minified(scene, projection, voxels_per_pixel);
            let (frame, statistics) = rendered(&mut renderer, scene, &camera, &fast(PIXELS, PIXELS));
            Shot {
                level: statistics.level,
                blended: statistics.tiles > PIXELS.div_ceil(128).pow(2) as usize,
                voxels: statistics.voxels,
                areas: areas(&frame, voxels_per_pixel),
            }
        })
        .collect()
}

/// Limits are a tenth above the measured values. Between levels the picture changes several times faster than within
/// them: sheets thinner than a voxel's mean, like those of the shells, fade and at last vanish.
#[test]
fn a_sweep_through_the_levels_changes_by_bounded_steps_at_ever_less_cost() {
    let shells = generated(Sample::Shells, 96);
    let head = generated(Sample::Head, 96);
    for (look, scene, [within_limit, across_limit]) in [
        ("opaque shells", opaque(&shells), [3.8, 5.0]),
        ("translucent shells", shells, [0.08, 1.0]),
        ("head", head, [0.053, 0.14]),
    ] {
        for projection in PROJECTIONS {
            let shots = sweep(&scene, projection);
            let name = format!("{look} {}", name_of(projection));
            for (i, shot) in shots.iter().enumerate() {
                println!(
                    "{name} 2^({i}/8): level {}, {:6} voxels, areas {:.0?}",
                    shot.level, shot.voxels, shot.areas
                );
            }
            let (within, across) = jumps(&shots);
            println!(
                "{name}: largest step within a level {within:.3}, across levels {across:.3} (natural logarithm)"
            );
            assert!(within < within_limit, "{name}: {within:.3}");
            assert!(across < across_limit, "{name}: {across:.3}");
            let [first, last] = [&shots[0], &shots[shots.len() - 1]].map(|shot| shot.voxels);
            assert!(4 * last <= first, "{name}: {first} voxels at 1:1, {last} at 8:1");
        }
    }
}

/// Largest steps of the logarithm of a channel's area, within levels and where one is blended into the next. Less than
/// a hundredth of the area at 1:1 counts as that hundredth: shells vanish in the end.
fn jumps(shots: &[Shot]) -> (f64, f64) {
    let (mut within, mut across) = (0.0f64, 0.0f64);
    let least = shots[0].areas.map(|area| 0.01 * area);
    for pair in shots.windows(2) {
        let step = |c: usize| {
            (pair[1].areas[c].max(least[c]) / pair[0].areas[c].max(least[c]))
                .ln()
                .abs()
        };
        let most = (0..4).map(step).fold(0.0, f64::max);
        let blended = pair[0].level != pair[1].level || pair.iter().any(|shot| shot.blended);
        if blended {
            across = across.max(most);
        } else {
            within = within.max(most);
        }
    }
    (within, across)
}
