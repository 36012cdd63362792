//! Rendering times of pre-classified splatting: Table 1, with the pictures of Fig. 2 and 7.

mod findings;
mod show;

use splatvol::{Camera, FlatSettings, Occlusion, Rasterizer, Scene, View};

use super::data;
use super::lookups::Lookups;
use super::method::{FASTSPLATS, RLUT, Subject, fastsplats, picture_size, rounds, seconds};
use crate::measure::Rounds;
use crate::{Experiment, LabError, Outcome, Workbench};
use findings::{across_findings, lookup_finding, time_findings};
use show::{alone, bars, numbers, pictures};

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "huang2000-preshaded",
    paper: "huang2000",
    title: "Pre-classified rendering times of the four FastSplats, with and without occlusion",
    figures: &["Table 1", "Fig. 1 (plate)", "Fig. 2", "Fig. 7", "Section 7"],
    about: "The paper renders three volumes at 512 x 512 with four rasterisers on a 300 MHz R12000: a Gaussian of radius 2, 128 \
sections, tables of 128 entries of 8 bits, sheets a voxel apart, hidden bricks and voxels left out. Its data are not public.

We render generated look-alikes of the same sizes, with the program's preset of that name, by one thread. *Brain*: the upper 145 of 256 \
slices of the sample head, 256 x 256 x 145 cubes, opaque. *Nerve*: the sample nerve, 512 x 512 x 76 voxels of 1:1:5, opaque, seen along \
z. *Tomato*: the sample tomato, 256 x 256 x 256, at a fifth of its opacity. Seconds are medians of interleaved rounds, the volume being \
classified before.

Voxels of 1:1:5 leave ellipses: the square FastSplat is that of section 3.1.3 there. The program's 2D FastSplat draws footprints of \
cubes only. So the nerve is rendered a second time with its samples as cubes, by all four.

Seconds of a machine of today say nothing about the paper's. Orders and ratios do. What differs between methods is how they find a pixel's \
entry. That is timed alone too, by loops that do nothing else: it makes up little of a frame, the rest being the same for all.",
    run,
};

/// A volume of the table.
struct Case {
    name: &'static str,
    scene: Scene,
    camera: Camera,
    methods: Vec<(&'static str, Rasterizer)>,
    /// Published seconds: 2D, linear, square, RLUT.
    published: [f64; 4],
    rows: Vec<Row>,
}

/// Cost of a method.
struct Row {
    method: &'static str,
    seconds: f64,
    /// Without occlusion.
    open: f64,
    /// Share of `seconds` in which footprints become pixels.
    splat: f64,
    splats: u64,
    slices: u64,
    /// Slices without occlusion.
    open_slices: u64,
    /// Pixels of the sections' boxes.
    pixels: f64,
    hidden_share: f64,
}

impl Case {
    fn row(&self, method: &str) -> Option<&Row> {
        self.rows.iter().find(|row| row.method == method)
    }

    fn published(&self, method: &str) -> f64 {
        let index = FASTSPLATS.iter().position(|one| one.0 == method);
        index.map_or(f64::NAN, |index| self.published[index])
    }

    /// Measured and published seconds of a method over those of another; none where a method is missing.
    fn ratio(&self, method: &str, to: &str) -> Option<[f64; 2]> {
        let measured = self.row(method)?.seconds / self.row(to)?.seconds;
        Some([measured, self.published(method) / self.published(to)])
    }
}

fn cases(bench: &Workbench<'_>) -> Result<Vec<Case>, LabError> {
    let case = |name, scene: Scene, view, published| -> Result<Case, LabError> {
        let camera = data::orthographic(&scene, view)?;
        Ok(Case {
            name,
            camera,
            methods: FASTSPLATS.to_vec(),
            published,
            rows: Vec::new(),
            scene,
        })
    };
    let nerve_seconds = [6.02, 10.06, 6.36, 7.52];
    let nerve = data::nerve(bench)?;
    let cubes = data::nerve_of_cubes(&nerve)?;
    let oblong = Case {
        methods: vec![
            ("linear", Rasterizer::Linear1d),
            ("square", Rasterizer::Ellipse1d),
            ("RLUT", RLUT),
        ],
        ..case("nerve", nerve, View::Top, nerve_seconds)?
    };
    Ok(vec![
        case("brain", data::brain(bench)?, View::Iso, [3.51, 7.11, 4.33, 4.41])?,
        oblong,
        case("nerve-cubes", cubes, View::Top, nerve_seconds)?,
        case(
            "tomato",
            data::tomato(bench)?,
            View::Iso,
            [16.66, 60.00, 25.23, 27.00],
        )?,
    ])
}

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    bench.step(0, 10, "volumes");
    let mut cases = cases(bench)?;
    let count = 2 * cases.len() + 1;
    for (index, case) in cases.iter_mut().enumerate() {
        bench.step(2 * index + 1, count + 1, case.name);
        measure(bench, case)?;
    }
    bench.step(count, count + 1, "pictures");
    let mut outcome = Outcome::default();
    let lookups = Lookups::measure();
    for case in &cases {
        time_findings(&mut outcome, case, &lookups);
    }
    lookup_finding(&mut outcome, &lookups);
    across_findings(&mut outcome, &cases);
    pictures(bench, &mut outcome, &cases)?;
    outcome.tables = vec![numbers(&cases), alone(&lookups)];
    outcome.plots = bars(&cases);
    Ok(outcome)
}

fn measure(bench: &Workbench<'_>, case: &mut Case) -> Result<(), LabError> {
    let size = picture_size(bench)?;
    let pixels_per_unit = case.camera.screen_from_camera(size).scale_at(1.0);
    // A kernel of radius 2 voxels; the nerve's voxels are as wide as cubes where it is seen along z.
    let section = (4.0 * pixels_per_unit).powi(2);
    let subjects = |occlusion| -> Result<Vec<Subject<'_>>, LabError> {
        let settings = |rasterizer| FlatSettings {
            occlusion,
            ..fastsplats(size, rasterizer)
        };
        case.methods
            .iter()
            .map(|&(_, rasterizer)| Subject::new(&case.scene, &case.camera, settings(rasterizer)))
            .collect()
    };
    let mut hiding = subjects(Occlusion::Sat)?;
    let hidden = seconds(&mut hiding, rounds(bench))?;
    let mut showing = subjects(Occlusion::None)?;
    let open = seconds(&mut showing, Rounds::exactly(1))?;
    let rows: Vec<Row> = case
        .methods
        .iter()
        .enumerate()
        .map(|(index, &(method, _))| {
            let statistics = hiding[index].statistics();
            Row {
                method,
                seconds: hidden[index],
                open: open[index],
                splat: statistics.seconds.splat / statistics.seconds.total,
                splats: statistics.voxels + statistics.hidden_voxels,
                slices: statistics.slices,
                open_slices: showing[index].statistics().slices,
                pixels: statistics.slices as f64 * section,
                hidden_share: statistics.hidden_share,
            }
        })
        .collect();
    case.rows = rows;
    Ok(())
}
