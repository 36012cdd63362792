//! Figures 5 and 6: a tunnel and a landscape, plain and anti-aliased.

use splatvol::{Coverage, Filter, Frame, Image, RenderSettings, Renderer};

use super::depths::{difference, line, nearer, rms, smooth};
use super::footprints::alignments;
use super::scenes::{averaged, made_faint, settings, unsteadiness};
use super::views::{View, forward, terrain_view, tunnel_view, z_k};
use crate::experiments::ground::Ground;
use crate::measure::{luminance, psnr};
use crate::{
    Axis, Expectation, Experiment, Finding, LabError, Outcome, Plate, Plot, PlotKind, Published, Table,
    Workbench,
};

pub(super) const TUNNEL: Experiment = Experiment {
    name: "mueller1998-tunnel",
    paper: "mueller1998",
    title: "A checkered tunnel, plain and anti-aliased",
    figures: &["Fig. 5", "Section 4.2"],
    about: "The paper looks through a hollow tube of 160x160x300 voxels whose squares are red or white; a black line marks z_k, beyond which \
there is more than a voxel per pixel. Size of the squares, position and angle of the camera are not given. Ours are \
10 voxels long, 32 of them around, seen from the tube's mouth with a field of view of 90 degrees in 240x240 pixels. \
So z_k is 120 voxels away, and 2.5 voxels fall on a pixel at the far end.\n\n\
Splats are composited one by one, from the Crawfis-Max kernel, as in the paper. `swan-alpha` lowers opacities as its text has it, `swan` lowers \
extinctions; `ewa` is zwicker2001's filter, and `coverage` takes 16 samples of pixels that differ from their neighbours.\n\n\
The low-passed difference is the RMS difference in luminance from the mean of many samples per pixel, both low-passed by a Gaussian of one \
pixel, so that blur counts little; over the pixels beyond z_k. It counts the false detail that aliasing leaves, but whatever else is wrong, too, and \
so can exceed the plain picture's where aliased energy falls, as in `swan1997-terrain`: opaque splats that are filtered cover more and, on \
ground, stand higher, most of all EWA's. The table says by how much of a pixel the mean must be shifted up to differ least, and what difference is left. \
The same things made faint show what the filter does where splats only add up.\n\n\
Flicker is what aliasing \
does in motion: as in `mueller1998-space-time`, the variance of what a frame differs by from the mean of those before and after it, while the camera \
moves forward by a hundredth of the longest side per frame.",
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
measures are those of the tunnel.",
    run: terrain,
};

pub(super) const VOLCANO: Experiment = Experiment {
    name: "mueller1998-volcano",
    paper: "mueller1998",
    title: "A real landscape, plain and anti-aliased",
    figures: &["Fig. 6"],
    about: "The same as mueller1998-terrain with measured heights under a photograph from a satellite: the volcano of swan1997-volcano, \
from the same folder of data, without which the experiment is skipped.",
    run: volcano,
};

const FILTERS: [(&str, &str, Filter); 4] = [
    ("plain", "plain", Filter::None),
    ("swan-alpha", "anti-aliased, opacity falls", Filter::SwanAlpha),
    ("swan", "anti-aliased, extinction falls", Filter::Swan),
    ("ewa", "EWA", Filter::Ewa { pixel_sigma: 0.55 }),
];

/// A view's pictures: the right one, and one per method with its differences.
struct Compared {
    right: Image,
    /// The right picture, low-passed, and shifted up by this many pixels.
    shifted: Vec<(f64, Vec<f64>)>,
    beyond: Vec<bool>,
    methods: Vec<Method>,
}

/// Rendering of a view by one method, and its errors.
struct Method {
    key: &'static str,
    words: &'static str,
    frame: Frame,
    /// RMS difference from the right picture beyond `z_k`, both low-passed.
    difference: f64,
    /// Upward shift of the right picture, in pixels, that minimises the difference, and that difference.
    shifted: [f64; 2],
    /// Temporal variance beyond `z_k` while the camera moves forward.
    flicker: f64,
}

impl Compared {
    fn of(renderer: &mut Renderer, view: &View) -> Result<Self, LabError> {
        let fine = settings(view.size.map(|side| side * view.samples), Filter::None)?;
        let fine = renderer.render(&view.scene, &view.camera, &fine)?.image;
        let right = averaged(&fine, view.samples as usize, 0)?;
        let shifted = shifted(&fine, view.samples as isize)?;
        let plain = settings(view.size, Filter::None)?;
        let z_k = z_k(view, &plain)?;
        let depths = renderer.render(&view.scene, &view.camera, &plain)?.depth;
        let beyond: Vec<bool> = depths
            .iter()
            .map(|&z| z.is_finite() && f64::from(z) > z_k)
            .collect();
        let mut compared = Self {
            right,
            shifted,
            beyond,
            methods: Vec::new(),
        };
        for (key, words, filter) in FILTERS {
            compared.add(renderer, view, [key, words], &settings(view.size, filter)?)?;
        }
        let covered = RenderSettings {
            coverage: Coverage::ADAPTIVE,
            ..plain
        };
        compared.add(
            renderer,
            view,
            ["coverage", "16 samples where pixels differ"],
            &covered,
        )?;
        Ok(compared)
    }

    fn add(
        &mut self,
        renderer: &mut Renderer,
        view: &View,
        [key, words]: [&'static str; 2],
        settings: &RenderSettings,
    ) -> Result<(), LabError> {
        let frame = renderer.render(&view.scene, &view.camera, settings)?;
        let mut beside = |steps: f64| -> Result<Vec<f64>, LabError> {
            let frame = renderer.render(&view.scene, &forward(view, steps)?, settings)?;
            Ok(luminance(&frame.image))
        };
        let three = [beside(-1.0)?, luminance(&frame.image), beside(1.0)?];
        let here = self.beyond.iter().enumerate().filter(|(_, beyond)| **beyond);
        let each: Vec<f64> = here
            .map(|(index, _)| unsteadiness([0, 1, 2].map(|time| three[time][index])))
            .collect();
        let light = smooth(&frame.image);
        let each_shift = self.shifted.iter();
        let differing = each_shift.map(|(up, right)| [*up, rms(&light, right, &self.beyond)]);
        self.methods.push(Method {
            key,
            words,
            difference: difference(&frame.image, &self.right, &self.beyond),
            shifted: differing
                .min_by(|a, b| a[1].total_cmp(&b[1]))
                .unwrap_or([0.0, f64::NAN]),
            flicker: each.iter().sum::<f64>() / each.len().max(1) as f64,
            frame,
        });
        Ok(())
    }

    fn method(&self, key: &str) -> Option<&Method> {
        self.methods.iter().find(|one| one.key == key)
    }

    /// A measure of a method, share of the plain picture's.
    fn share(&self, key: &str, measure: impl Fn(&Method) -> f64) -> f64 {
        let of = |key| self.method(key).map_or(f64::NAN, &measure);
        of(key) / of("plain")
    }

    /// The share of a method's difference that remains when the right picture is shifted up.
    fn left(&self, key: &str) -> f64 {
        self.method(key)
            .map_or(f64::NAN, |one| one.shifted[1] / one.difference)
    }

    /// Mean luminance beyond `z_k`, share of the right one.
    fn brightness(&self, method: &Method) -> f64 {
        let sum = |image: &Image| -> f64 {
            let values = luminance(image).into_iter().zip(&self.beyond);
            values
                .filter(|(_, beyond)| **beyond)
                .map(|(value, _)| value)
                .sum()
        };
        sum(&method.frame.image) / sum(&self.right)
    }
}

/// The mean of the samples of each pixel, low-passed, for shifts up to two pixels up and down.
fn shifted(fine: &Image, n: isize) -> Result<Vec<(f64, Vec<f64>)>, LabError> {
    (-2 * n..=2 * n)
        .map(|down| Ok((down as f64 / n as f64, smooth(&averaged(fine, n as usize, down)?))))
        .collect()
}

fn tunnel(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let view = tunnel_view(bench)?;
    let (mut outcome, mut renderer) = compare(bench, &view)?;
    alignments(
        &mut outcome,
        &mut renderer,
        (&view.scene, &view.camera),
        view.size,
    )?;
    Ok(outcome)
}

fn terrain(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    Ok(compare(bench, &terrain_view(bench, Ground::Generated)?)?.0)
}

fn volcano(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    Ok(compare(bench, &terrain_view(bench, Ground::Volcano)?)?.0)
}

/// A view as it is, and made faint.
fn compare(bench: &Workbench<'_>, view: &View) -> Result<(Outcome, Renderer), LabError> {
    let mut renderer = bench.renderer()?;
    let mut outcome = Outcome::default();
    bench.step(0, 3, "plain and filtered");
    let compared = Compared::of(&mut renderer, view)?;
    bench.step(1, 3, "made faint");
    let scene = made_faint(&view.scene, 300.0)?;
    let faint = Compared::of(&mut renderer, &View { scene, ..*view })?;
    bench.step(2, 3, "findings");
    show(&mut outcome, view, &compared)?;
    claims(&mut outcome, view.figure, &compared, &faint);
    Ok((outcome, renderer))
}

fn show(outcome: &mut Outcome, view: &View, compared: &Compared) -> Result<(), LabError> {
    let black = [0.0, 0.0, 0.0, 1.0];
    let lined = settings(view.size, Filter::None)?;
    let caption = "plain, with the line at z_k; anti-aliased; the mean of many samples per pixel";
    let mut plate = Plate::new("pictures", view.figure, caption);
    let columns = [
        "method",
        "low-passed difference beyond z_k",
        "stands up by (pixels)",
        "low-passed difference left there",
        "flicker beyond z_k",
        "brightness beyond z_k",
        "PSNR (dB)",
    ];
    let mut table = Table::new(
        "methods",
        view.figure,
        "against the mean of many samples per pixel",
        &columns,
    );
    for method in &compared.methods {
        let mut image = method.frame.image.over(black);
        if method.key == "plain" {
            line(&mut image, &method.frame.depth, z_k(view, &lined)?);
        }
        plate = plate.panel(method.words, image);
        table.row([
            method.words.into(),
            method.difference.into(),
            method.shifted[0].into(),
            method.shifted[1].into(),
            method.flicker.into(),
            compared.brightness(method).into(),
            psnr(&method.frame.image, &compared.right).into(),
        ]);
    }
    outcome
        .plates
        .push(plate.panel("many samples per pixel", compared.right.over(black)));
    outcome.tables.push(table);
    let group = |method: &Method| {
        let shares = [
            compared.share(method.key, |one| one.difference),
            compared.share(method.key, |one| one.flicker),
        ];
        (method.key.to_owned(), shares.to_vec())
    };
    let bars = PlotKind::Bars {
        bars: vec!["low-passed difference".to_owned(), "flicker".to_owned()],
        groups: compared.methods.iter().map(group).collect(),
    };
    let axes = [Axis::new("method"), Axis::new("share of the plain picture's")];
    let caption = "low-passed difference from the mean of many samples, and flicker, beyond z_k";
    outcome
        .plots
        .push(Plot::new("aliasing", view.figure, caption, axes, bars));
    Ok(())
}

fn claims(outcome: &mut Outcome, figure: &str, compared: &Compared, faint: &Compared) {
    let smooth = || Published::Claim("strong aliasing effects are smoothed out".to_owned());
    for (key, words) in [("swan-alpha", "as the paper has it"), ("swan", "by extinction")] {
        outcome.find(
            Finding::new(
                figure,
                &format!("{key}-false-detail"),
                &format!("low-passed difference beyond z_k, anti-aliased {words}, share of the plain picture's"),
                compared.share(key, |one| one.difference),
                Expectation::AtMost(0.5),
            )
            .published(smooth())
            .explained_by(
                "what is seen is opaque, and a low-passed extinction is no low-passed picture; made faint, the share is less",
                faint.share(key, |one| one.difference),
                Expectation::AtMost(0.5),
            )
            .explained_by(
                "a part of it is that opaque splats reach over what lies behind them, which on ground is higher up: against the mean \
                 of samples shifted up by the best whole number of samples, this share of the difference is left",
                compared.left(key),
                Expectation::AtMost(0.9),
            ),
        );
    }
    let flicker = |key: &str| compared.share(key, |one| one.flicker);
    outcome.find(
        Finding::new(
            figure,
            "swan-alpha-flicker",
            "flicker beyond z_k while the camera moves, anti-aliased as the paper has it, share of the plain pictures'",
            flicker("swan-alpha"),
            Expectation::AtMost(0.5),
        )
        .published(smooth())
        .explained_by(
            "what is seen moves, and rightly flickers: of what the plain pictures flicker beyond means of 16 samples per pixel, less than half is left",
            (flicker("swan-alpha") - flicker("coverage")) / (1.0 - flicker("coverage")),
            Expectation::AtMost(0.5),
        ),
    );
    outcome.find(Finding::new(
        figure,
        "coverage-false-detail",
        "low-passed difference beyond z_k with 16 samples where pixels differ, share of the plain picture's",
        compared.share("coverage", |one| one.difference),
        Expectation::AtMost(0.25),
    ));
    if let (Some(plain), Some(filtered)) = (compared.method("plain"), compared.method("swan-alpha")) {
        let near = nearer(&plain.frame, &compared.beyond);
        outcome.find(
            Finding::new(
                figure,
                "nearer",
                "RMS difference of the anti-aliased from the plain picture nearer than z_k",
                difference(&filtered.frame.image, &plain.frame.image, &near),
                Expectation::AtMost(0.01),
            )
            .published(Published::Claim(
                "previous to z_k, splats are drawn the same size".to_owned(),
            )),
        );
    }
}
