//! Figures 5 and 6: a tunnel and a landscape, plain and anti-aliased.

use glam::DVec3;
use splatvol::{Camera, Coverage, Filter, Frame, Image, Projection, RenderSettings, Renderer, Scene};
use splatvol_samples::Sample;

use super::footprints::alignments;
use super::scenes::{averaged, scene, settings};
use crate::measure::{luminance, psnr};
use crate::{Axis, Expectation, Experiment, Finding, LabError, Outcome, Plate, Plot, PlotKind, Published, Table, Workbench};

pub(super) const TUNNEL: Experiment = Experiment {
    name: "mueller1998-tunnel",
    paper: "mueller1998",
    title: "A checkered tunnel, plain and anti-aliased",
    figures: &["Fig. 5", "Section 4.2"],
    about: "The paper looks through a hollow tube of 160x160x300 voxels whose squares are red or white; a black line marks z_k, beyond which \
there is more than a voxel per pixel. Size of the squares, position and angle of the camera are not given: ours are 10 voxels long, 32 of them \
around, seen from the tube's mouth with a field of view of 90 degrees in 240x240 pixels, so that z_k is 120 voxels away and 2.5 voxels fall on a \
pixel at the far end.\n\n\
Splats are composited one by one, from the Crawfis-Max kernel, as in the paper. `swan-alpha` lowers opacities as its text has it, `swan` lowers \
extinctions; `ewa` is zwicker2001's filter, and `coverage` takes 16 samples of pixels that differ from their neighbours.\n\n\
False detail is what aliasing leaves where the picture still resolves something: the RMS difference in luminance from the mean of many samples \
per pixel, both low-passed by a Gaussian of one pixel, so that mere blur does not count; over the pixels beyond z_k. On such opaque material a \
low-passed extinction is no low-passed picture; the same tunnel made faint shows what the filter does where it can.",
    run: tunnel,
};

pub(super) const TERRAIN: Experiment = Experiment {
    name: "mueller1998-terrain",
    paper: "mueller1998",
    title: "A landscape, plain and anti-aliased",
    figures: &["Fig. 6"],
    about: "The paper shows a landscape of 512x512x103 voxels, each column of splats in the colour of a satellite photograph, in perspective: \
the plain picture aliases strongly in its upper half, the anti-aliased one does not.\n\n\
Heights and photograph are not public; ours are drawn from noise with fields, woods, towns and rocks (`sample:terrain`). The camera stands low \
before the landscape's edge, so that voxels are larger than pixels in front and several fall on a pixel behind. Methods and \
measure are those of the tunnel.",
    run: terrain,
};

/// Something to look at.
struct View {
    figure: &'static str,
    scene: Scene,
    camera: Camera,
    size: [u32; 2],
    /// Samples per pixel along each axis of what counts as right.
    samples: u32,
}

const FILTERS: [(&str, &str, Filter); 4] = [
    ("plain", "plain", Filter::None),
    ("swan-alpha", "anti-aliased, opacity falls", Filter::SwanAlpha),
    ("swan", "anti-aliased, extinction falls", Filter::Swan),
    ("ewa", "EWA", Filter::Ewa { pixel_sigma: 0.55 }),
];

/// A view's pictures: the right one, and one per method with its false detail.
struct Compared {
    right: Image,
    beyond: Vec<bool>,
    methods: Vec<(&'static str, &'static str, Frame, f64)>,
}

impl Compared {
    fn of(renderer: &mut Renderer, view: &View) -> Result<Self, LabError> {
        let fine = settings(view.size.map(|side| side * view.samples), Filter::None)?;
        let fine = renderer.render(&view.scene, &view.camera, &fine)?.image;
        let right = averaged(&fine, view.samples as usize)?;
        let mut methods = Vec::new();
        for (key, words, filter) in FILTERS {
            let frame = renderer.render(&view.scene, &view.camera, &settings(view.size, filter)?)?;
            methods.push((key, words, frame, 0.0));
        }
        let covered = RenderSettings {
            coverage: Coverage::ADAPTIVE,
            ..settings(view.size, Filter::None)?
        };
        let frame = renderer.render(&view.scene, &view.camera, &covered)?;
        methods.push(("coverage", "16 samples where pixels differ", frame, 0.0));
        let z_k = z_k(view, &covered);
        let depths = &methods[0].2.depth;
        let beyond: Vec<bool> = depths.iter().map(|&z| z.is_finite() && f64::from(z) > z_k).collect();
        for (_, _, frame, false_detail) in &mut methods {
            *false_detail = difference(&frame.image, &right, &beyond);
        }
        Ok(Self { right, beyond, methods })
    }

    /// False detail of a method, share of the plain picture's.
    fn ratio(&self, key: &str) -> f64 {
        let of = |key: &str| {
            let method = self.methods.iter().find(|one| one.0 == key);
            method.map_or(f64::NAN, |one| one.3)
        };
        of(key) / of("plain")
    }

    fn frame(&self, key: &str) -> Option<&Frame> {
        self.methods.iter().find(|one| one.0 == key).map(|one| &one.2)
    }

    /// Mean luminance beyond `z_k`, share of the right one.
    fn brightness(&self, key: &str) -> f64 {
        let sum = |image: &Image| -> f64 {
            let values = luminance(image).into_iter().zip(&self.beyond);
            values.filter(|(_, beyond)| **beyond).map(|(value, _)| value).sum()
        };
        self.frame(key).map_or(f64::NAN, |frame| sum(&frame.image) / sum(&self.right))
    }
}

/// Where pixels are as far apart as voxels (eq. 3).
fn z_k(view: &View, settings: &RenderSettings) -> f64 {
    let screen = view.camera.screen_from_camera(settings.size);
    screen.scale * view.scene.volume.grid().mean_spacing()
}

/// RMS difference of two pictures, both low-passed by a pixel, where a mask says.
fn difference(one: &Image, other: &Image, mask: &[bool]) -> f64 {
    let width = one.size().width() as usize;
    let [a, b] = [one, other].map(|image| low_passed(&luminance(image), width));
    let squares = a.iter().zip(&b).zip(mask).filter(|(_, here)| **here);
    let (sum, count) = squares.fold((0.0, 0.0), |(sum, count), ((a, b), _)| (sum + (a - b).powi(2), count + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}

/// Convolved with a Gaussian of one pixel; the border repeats.
fn low_passed(values: &[f64], width: usize) -> Vec<f64> {
    const REACH: isize = 4;
    let height = values.len() / width;
    let weights: Vec<f64> = (-REACH..=REACH).map(|i| (-0.5 * (i * i) as f64).exp()).collect();
    let total: f64 = weights.iter().sum();
    let along = |values: &[f64], [dx, dy]: [isize; 2]| -> Vec<f64> {
        let at = |index: usize| {
            let (x, y) = ((index % width) as isize, (index / width) as isize);
            let taps = (-REACH..=REACH).zip(&weights).map(|(i, weight)| {
                let x = (x + i * dx).clamp(0, width as isize - 1) as usize;
                let y = (y + i * dy).clamp(0, height as isize - 1) as usize;
                weight * values[y * width + x]
            });
            taps.sum::<f64>() / total
        };
        (0..values.len()).map(at).collect()
    };
    along(&along(values, [1, 0]), [0, 1])
}

fn tunnel_view(bench: &Workbench<'_>) -> Result<View, LabError> {
    let (dims, side) = bench.choose(([160, 160, 300], 240), ([80, 80, 150], 120));
    let scene = scene(Sample::Tunnel, dims)?;
    let bounds = scene.volume.grid().bounds();
    let centre = bounds.centre();
    let mouth = DVec3::new(centre.x, centre.y, bounds.min.z);
    let projection = Projection::Perspective { fov_degrees: 90.0 };
    Ok(View {
        figure: "Fig. 5",
        scene,
        camera: Camera::new(mouth, centre, DVec3::Y, projection)?,
        size: [side, side],
        samples: bench.choose(6, 4),
    })
}

fn terrain_view(bench: &Workbench<'_>) -> Result<View, LabError> {
    let (dims, size) = bench.choose(([512, 512, 103], [320, 200]), ([160, 160, 32], [100, 62]));
    let scene = scene(Sample::Terrain, dims)?;
    let bounds = scene.volume.grid().bounds();
    let side = dims[0] as f64;
    let target = bounds.centre() - DVec3::Z * 0.1 * side;
    let position = target + side * DVec3::new(0.0, -0.62, 0.3);
    let projection = Projection::Perspective { fov_degrees: 40.0 };
    Ok(View {
        figure: "Fig. 6",
        scene,
        camera: Camera::new(position, target, DVec3::Z, projection)?,
        size,
        samples: bench.choose(6, 4),
    })
}

fn tunnel(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let mut renderer = bench.renderer()?;
    let view = tunnel_view(bench)?;
    let mut outcome = Outcome::default();
    bench.step(0, 4, "the tunnel, plain and filtered");
    let compared = Compared::of(&mut renderer, &view)?;
    bench.step(2, 4, "the tunnel made faint");
    let mut faint = tunnel_view(bench)?;
    faint.scene.transfer_function.unit_distance = Some(300.0 * view.scene.unit_distance());
    let faint = Compared::of(&mut renderer, &faint)?;
    show(&mut outcome, &view, &compared)?;
    claims(&mut outcome, &view, &compared, Some(&faint));
    bench.step(3, 4, "alignments");
    alignments(&mut outcome, &mut renderer, (&view.scene, &view.camera), view.size)?;
    Ok(outcome)
}

fn terrain(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let mut renderer = bench.renderer()?;
    let view = terrain_view(bench)?;
    let mut outcome = Outcome::default();
    bench.step(0, 1, "the landscape, plain and filtered");
    let compared = Compared::of(&mut renderer, &view)?;
    show(&mut outcome, &view, &compared)?;
    claims(&mut outcome, &view, &compared, None);
    Ok(outcome)
}

fn show(outcome: &mut Outcome, view: &View, compared: &Compared) -> Result<(), LabError> {
    let black = [0.0, 0.0, 0.0, 1.0];
    let lined = settings(view.size, Filter::None)?;
    let caption = "plain, with the line at z_k; anti-aliased; the mean of many samples per pixel";
    let mut plate = Plate::new("pictures", view.figure, caption);
    for (key, words, frame, _) in &compared.methods {
        let mut image = frame.image.over(black);
        if *key == "plain" {
            line(&mut image, &frame.depth, z_k(view, &lined));
        }
        plate = plate.panel(words, image);
    }
    outcome.plates.push(plate.panel("many samples per pixel", compared.right.over(black)));
    let columns = ["method", "false detail beyond z_k", "share of plain", "brightness beyond z_k", "PSNR (dB)"];
    let mut table = Table::new("methods", view.figure, "against the mean of many samples per pixel", &columns);
    for (key, words, frame, false_detail) in &compared.methods {
        table.row([
            (*words).into(),
            (*false_detail).into(),
            compared.ratio(key).into(),
            compared.brightness(key).into(),
            psnr(&frame.image, &compared.right).into(),
        ]);
    }
    outcome.tables.push(table);
    let groups = compared.methods.iter().map(|(key, _, _, value)| ((*key).to_owned(), vec![*value]));
    let bars = PlotKind::Bars {
        bars: vec!["false detail".to_owned()],
        groups: groups.collect(),
    };
    let axes = [Axis::new("method"), Axis::new("RMS luminance error, low-passed")];
    outcome.plots.push(Plot::new("false-detail", view.figure, "false detail beyond z_k", axes, bars));
    Ok(())
}

/// Blackens the pixels where the depth passes `z_k`.
fn line(image: &mut Image, depth: &[f32], z_k: f64) {
    let width = image.size().width() as usize;
    let beyond = |index: usize| depth.get(index).is_some_and(|&z| f64::from(z) > z_k);
    for index in 0..depth.len() {
        let right = (index + 1) % width != 0 && beyond(index) != beyond(index + 1);
        let below = index + width < depth.len() && beyond(index) != beyond(index + width);
        if right || below {
            image.pixels[index] = [0.0, 0.0, 0.0, 1.0];
        }
    }
}

fn claims(outcome: &mut Outcome, view: &View, compared: &Compared, faint: Option<&Compared>) {
    let figure = view.figure;
    let share = |key: &str, words: &str| {
        let mut finding = Finding::new(
            figure,
            &format!("{key}-false-detail"),
            &format!("false detail beyond z_k, {words}, share of the plain picture's"),
            compared.ratio(key),
            Expectation::AtMost(0.5),
        )
        .published(Published::Claim("strong aliasing effects are smoothed out".to_owned()))
        .explained_by(
            "splats whose opacity falls let too much or too little through: the brightness beyond z_k is off by more than a tenth",
            (compared.brightness(key) - 1.0).abs(),
            Expectation::AtLeast(0.1),
        );
        if let Some(faint) = faint {
            finding = finding.explained_by(
                "the tube is opaque, and a low-passed extinction is no low-passed picture; made faint, the share is small",
                faint.ratio(key),
                Expectation::AtMost(0.5),
            );
        }
        finding
    };
    outcome.find(share("swan-alpha", "anti-aliased as the paper has it"));
    outcome.find(share("swan", "anti-aliased by extinction"));
    outcome.find(Finding::new(
        figure,
        "coverage-false-detail",
        "false detail beyond z_k with 16 samples where pixels differ, share of the plain picture's",
        compared.ratio("coverage"),
        Expectation::AtMost(0.25),
    ));
    if let (Some(plain), Some(filtered)) = (compared.frame("plain"), compared.frame("swan-alpha")) {
        let near: Vec<bool> = nearer(plain, &compared.beyond);
        outcome.find(
            Finding::new(
                figure,
                "nearer",
                "RMS difference of the anti-aliased from the plain picture nearer than z_k",
                difference(&filtered.image, &plain.image, &near),
                Expectation::AtMost(0.01),
            )
            .published(Published::Claim("previous to z_k, splats are drawn the same size".to_owned())),
        );
    }
}

/// Pixels nearer than `z_k`, and farther than the low-pass reaches from what is not.
fn nearer(frame: &Frame, beyond: &[bool]) -> Vec<bool> {
    const REACH: usize = 6;
    let width = frame.image.size().width() as usize;
    let height = beyond.len() / width;
    let near = |index: usize| frame.depth[index].is_finite() && !beyond[index];
    (0..beyond.len())
        .map(|index| {
            let (x, y) = (index % width, index / width);
            let rows = y.saturating_sub(REACH)..(y + REACH + 1).min(height);
            rows.into_iter().all(|y| {
                let columns = x.saturating_sub(REACH)..(x + REACH + 1).min(width);
                columns.into_iter().all(|x| near(y * width + x))
            })
        })
        .collect()
}
