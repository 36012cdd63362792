//! Figure 11 and eq. 11: whether a splat that is cut in half and drawn apart keeps its energy.

use glam::DVec3;
use splatvol::{
    Alignment, Camera, Compositing, Filter, FlatSettings, Kernel, Motion, MotionBlur, Projection,
    RenderSettings, Renderer, Scene,
};
use splatvol_core::radial::RadialKernel;
use splatvol_samples::Sample;

use super::alignment::{RADIUS, sigma};
use super::scenes::{scene, settings};
use crate::{
    Axis, Curve, Expectation, Experiment, Finding, LabError, Outcome, Plot, Published, Table, Workbench,
};

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "mueller1998-capsule",
    paper: "mueller1998",
    title: "The energy of a motion-blurred splat",
    figures: &["Fig. 11"],
    about: "The paper cuts a footprint of radius s in half, draws the halves apart by the length l of the motion, \
and fills the rectangle between them with the footprint's profile. It dims the result by how much its area grows \
(eq. 11): A1 / (A1 + 2 l s), so that its energy remains constant.\n\n\
The energy of such a capsule is E + l L, where E is the footprint's integral over the plane and L that over a line through its middle; we \
integrate both in 64 bits for the paper's two kernels and for a footprint of constant height. Then we measure the same on X-rays of a ball that \
moves across the picture, by capsules and by our closed form (`--motion-blur exact`).",
    run,
};

/// A footprint: its height at a distance from the centre, share of the radius.
struct Profile {
    key: &'static str,
    name: &'static str,
    height: Box<dyn Fn(f64) -> f64>,
}

impl Profile {
    fn of(key: &'static str, name: &'static str, kernel: Kernel) -> Self {
        let kernel = RadialKernel::new(kernel);
        let support = kernel.support();
        Self {
            key,
            name,
            height: Box::new(move |share| kernel.line_integral((share * support).powi(2))),
        }
    }

    /// Energy of the capsule of eq. 11 whose ways are `l` radii long, share of the still footprint's.
    fn energy(&self, l: f64) -> f64 {
        const STEPS: usize = 4000;
        let at = |i: usize| (i as f64 + 0.5) / STEPS as f64;
        let disc: f64 = (0..STEPS)
            .map(|i| std::f64::consts::TAU * at(i) * (self.height)(at(i)) / STEPS as f64)
            .sum();
        let line: f64 = (0..STEPS)
            .map(|i| 2.0 * (self.height)(at(i)) / STEPS as f64)
            .sum();
        let area = std::f64::consts::PI;
        (disc + l * line) / disc * area / (area + 2.0 * l)
    }
}

fn kernels() -> [(&'static str, &'static str, Kernel); 2] {
    let gaussian = Kernel::Gaussian {
        sigma: sigma(),
        radius: RADIUS,
    };
    [
        ("crawfis-max", "Crawfis-Max", Kernel::CrawfisMax),
        ("gaussian", "Gaussian of Fig. 9", gaussian),
    ]
}

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let mut outcome = Outcome::default();
    let flat = Profile {
        key: "flat",
        name: "constant height",
        height: Box::new(|_| 1.0),
    };
    let mut profiles: Vec<Profile> = kernels()
        .map(|(key, name, kernel)| Profile::of(key, name, kernel))
        .into();
    profiles.push(flat);
    let ways = [0.5, 1.0, 2.0, 4.0, 8.0];
    let mut measured = Vec::new();
    for (step, (_, _, kernel)) in kernels().into_iter().enumerate() {
        bench.step(step, 2, "X-rays of a moving ball");
        measured.push(energies(bench, kernel, &ways)?);
    }
    outcome.plots.push(plot(&profiles, &measured, &ways));
    outcome.tables.push(table(&profiles, &measured, &ways));
    claims(&mut outcome, &profiles, &measured, &ways);
    Ok(outcome)
}

/// Energies of X-rays of a ball that moves by this many radii of its splats, by capsules and in closed form, share of
/// the still one's.
fn energies(bench: &Workbench<'_>, kernel: Kernel, ways: &[f64]) -> Result<Vec<[f64; 2]>, LabError> {
    let mut renderer = bench.renderer()?;
    let still = scene(Sample::Ball, [18; 3])?;
    let centre = still.bounds()?.centre();
    let projection = Projection::Orthographic { height: 48.0 };
    let camera = Camera::new(centre - 100.0 * DVec3::Y, centre, DVec3::Z, projection)?;
    let settings = |motion_blur| -> Result<RenderSettings, LabError> {
        Ok(RenderSettings::try_from(FlatSettings {
            compositing: Compositing::Xray,
            alignment: Alignment::Affine,
            kernel,
            motion_blur,
            ..settings([192, 192], Filter::None)?.into()
        })?)
    };
    let radius = RadialKernel::new(kernel).support();
    let mut energy = |scene: &Scene, motion_blur| -> Result<f64, LabError> {
        let frame = render(&mut renderer, scene, &camera, &settings(motion_blur)?)?;
        Ok(frame.iter().map(|&tau| f64::from(tau)).sum())
    };
    let whole = energy(&still, MotionBlur::None)?;
    let moving = |way: f64| {
        let motion = Motion::Linear(way * radius * DVec3::new(0.8, 0.0, 0.6));
        still.clone().with_motion(&motion)
    };
    let mut shares = Vec::new();
    for &way in ways {
        let scene = moving(way);
        shares.push([
            energy(&scene, MotionBlur::Capsule)? / whole,
            energy(&scene, MotionBlur::Exact)? / whole,
        ]);
    }
    Ok(shares)
}

fn render(
    renderer: &mut Renderer,
    scene: &Scene,
    camera: &Camera,
    settings: &RenderSettings,
) -> Result<Vec<f32>, LabError> {
    Ok(renderer.render(scene, camera, settings)?.optical_depth)
}

fn plot(profiles: &[Profile], measured: &[Vec<[f64; 2]>], ways: &[f64]) -> Plot {
    let mut plot = Plot::curves(
        "energy",
        "Fig. 11",
        "energy of a motion-blurred splat",
        Axis::new("length of the motion (splat radii)"),
        Axis::new("energy (share of the still splat's)"),
    );
    for profile in profiles {
        let points = (0..=80)
            .map(|i| f64::from(i) * 0.1)
            .map(|l| [l, profile.energy(l)]);
        plot = plot.curve(Curve::new(&format!("capsule, {}", profile.name), points).dashed());
    }
    let points = |method: usize| {
        ways.iter()
            .zip(&measured[0])
            .map(move |(&way, shares)| [way, shares[method]])
    };
    plot.curve(Curve::new("X-ray, capsules, Crawfis-Max", points(0)).dots())
        .curve(Curve::new("X-ray, closed form, Crawfis-Max", points(1)).dots())
}

fn table(profiles: &[Profile], measured: &[Vec<[f64; 2]>], ways: &[f64]) -> Table {
    let columns = [
        "kernel",
        "length (radii)",
        "capsule, computed",
        "capsule, X-ray",
        "closed form, X-ray",
    ];
    let caption = "energy of a motion-blurred splat, share of the still one's";
    let mut table = Table::new("energy", "Fig. 11", caption, &columns);
    for (profile, measured) in profiles.iter().zip(measured) {
        for (&way, [capsule, exact]) in ways.iter().zip(measured) {
            table.row([
                profile.name.into(),
                way.into(),
                profile.energy(way).into(),
                (*capsule).into(),
                (*exact).into(),
            ]);
        }
    }
    table
}

fn claims(outcome: &mut Outcome, profiles: &[Profile], measured: &[Vec<[f64; 2]>], ways: &[f64]) {
    const WAY: f64 = 4.0;
    let constant = Expectation::Near {
        value: 1.0,
        within: 0.05,
    };
    let flat = profiles.last().map_or(f64::NAN, |flat| flat.energy(WAY));
    for (profile, measured) in profiles.iter().zip(measured) {
        let computed = profile.energy(WAY);
        outcome.find(
            Finding::new(
                "Fig. 11",
                &format!("energy-{}", profile.key),
                &format!("energy of a capsule drawn apart by two diameters, {}, share of the still splat's", profile.name),
                computed,
                constant,
            )
            .published(Published::Claim("remains constant".to_owned()))
            .explained_by(
                "eq. 11 counts area, which is right for a footprint of constant height, and the rectangle has more than its share of the bright middle",
                flat,
                Expectation::Near {
                    value: 1.0,
                    within: 1e-3,
                },
            ),
        );
        let largest = |of: &dyn Fn(f64, [f64; 2]) -> f64| {
            let each = ways
                .iter()
                .zip(measured)
                .map(|(&way, &shares)| of(way, shares).abs());
            each.fold(0.0, f64::max)
        };
        outcome.find(Finding::new(
            "Fig. 11",
            &format!("engine-{}", profile.key),
            &format!(
                "largest difference between X-rays of capsules and the computed energy, {}",
                profile.name
            ),
            largest(&|way, [capsule, _]| capsule / profile.energy(way) - 1.0),
            Expectation::AtMost(0.01),
        ));
        outcome.find(Finding::new(
            "Fig. 11",
            &format!("exact-{}", profile.key),
            &format!(
                "largest change of the energy by the closed form, {}",
                profile.name
            ),
            largest(&|_, [_, exact]| exact - 1.0),
            Expectation::AtMost(0.005),
        ));
    }
}
