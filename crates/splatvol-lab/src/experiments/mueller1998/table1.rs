//! Table 1: the engine's footprints against the five rows, and the effect of its misprints.

use glam::{DAffine3, DMat3, DVec2};
use splatvol::{Alignment, Filter, ImageSize, ScreenFromCamera, Stretch};
use splatvol_core::splats::{
    CameraView, Chunk, Footprint, GaussianProfile, KernelShape, Projection, SplatCloud,
};
use splatvol_testing::Random;

use super::alignment::{Kernel, Row, Setting, sigma};
use crate::{
    Axis, Curve, Expectation, Experiment, Finding, LabError, Outcome, Plot, Published, Table, Workbench,
};

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "mueller1998-table1",
    paper: "mueller1998",
    title: "The five rows of Table 1 as code",
    figures: &["Table 1"],
    about: "Table 1 takes a kernel at (y_v, z_v) into perspective space in five ways. With s(z) = min(1, z_k / z), dy = y_p z / z_k - y_v, \
dz = z - z_v and r = sqrt(y_v^2 + z_v^2) the corrected rows are\n\n\
1. trapezoid: s(z) h(s(z) dy, dz)\n\
2. box: s(z_v) h(s(z_v) dy, dz)\n\
3. ideal ray-perpendicular: s(z_v) h(s(z_v) (dy z_v - dz y_v) / r, (dz z_v + dy y_v) / r)\n\
4. practical ray-perpendicular: s(z_v) h(s(z_v) r (z_v y_p - y_v z_k) / (z_v z_k + y_p y_v), dz)\n\
5. grid-aligned: s(z_v) h(s(z_v) (y_p z_v / z_k - y_v), dz)\n\n\
Row 3 is printed as h(s(z_v) (-dz x_v^2 + dy y_v^2) / r, (dz y_v^2 + dy x_v^2) / r) with r = sqrt(x_v^2 + y_v^2): outside dy it says (x_v, y_v) \
for (y_v, z_v), and it squares both in its sums. To read only x_v as z_v is not enough, which we measure too. Row 4 is printed with a minus in the \
denominator, and with the same r. Rows 1 to 3 are \
integrated along the ray, in arc length, rows 4 and 5 along parallel lines.\n\n\
We compare the integrals of these rows, in 64 bits, with the footprints that the engine makes with `--alignment` and `--stretch` and the `swan` \
filter, for voxels at random in the paper's volume. The kernel is not cut at 2 here but where nothing is left of it, as the engine rounds the \
edge off. Each footprint counts relative to its own peak.",
    run,
};

const WAYS: [(Row, Alignment, Stretch, &str, &str); 5] = [
    (
        Row::Trapezoid,
        Alignment::Exact,
        Stretch::Trapezoid,
        "trapezoid",
        "row 1, --alignment exact --stretch trapezoid",
    ),
    (
        Row::Box,
        Alignment::Exact,
        Stretch::Box,
        "box",
        "row 2, --alignment exact --stretch box",
    ),
    (
        Row::RayIdeal,
        Alignment::RayIdeal,
        Stretch::Box,
        "ray-ideal",
        "row 3, --alignment ray-ideal",
    ),
    (
        Row::Ray,
        Alignment::Ray,
        Stretch::Box,
        "ray",
        "row 4, --alignment ray",
    ),
    (
        Row::Grid,
        Alignment::Grid,
        Stretch::Box,
        "grid",
        "row 5, --alignment grid",
    ),
];

/// Cut-off of the engine's kernel and of ours here, standard deviations.
const CUT: f64 = 5.0;

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let setting = Setting::new(512.0);
    let voxels = bench.choose(400, 60);
    let mut outcome = Outcome::default();
    let columns = ["row", "engine", "largest difference (levels)"];
    let mut table = Table::new(
        "rows",
        "Table 1",
        "the engine's footprints against the rows",
        &columns,
    );
    for (step, way) in WAYS.into_iter().enumerate() {
        bench.step(step, WAYS.len(), way.4);
        let worst = difference(&setting, way, voxels)?;
        table.row([(step + 1).into(), way.4.into(), worst.into()]);
        outcome.find(
            Finding::new(
                "Table 1",
                way.3,
                &format!(
                    "largest difference between the engine's footprint and the row ({})",
                    way.4
                ),
                worst,
                Expectation::AtMost(0.25),
            )
            .unit("levels"),
        );
    }
    outcome.tables.push(table);
    printed(&mut outcome, &setting);
    outcome.plots.push(plot(&setting));
    Ok(outcome)
}

/// A splat in camera space, as the engine holds it.
fn cloud(kernel: &Kernel) -> SplatCloud {
    let position = [0.0, kernel.y as f32, kernel.z as f32];
    let reach = sigma() as f32;
    SplatCloud {
        world_from_local: DAffine3::IDENTITY,
        positions: vec![position],
        payloads: vec![[1.0; 4]],
        gradients: Vec::new(),
        shape: KernelShape::Sphere { sigma: sigma() },
        covariances: Vec::new(),
        peaks_from: usize::MAX,
        mass: DMat3::IDENTITY.determinant(),
        spacing: 1.0,
        chunks: Chunk::of(&[position], 0, reach).into_iter().collect(),
    }
}

/// The paper's picture, larger so that voxels before `z_k` are in it.
fn view(setting: &Setting) -> Result<CameraView, LabError> {
    let side = 4.0 * setting.side;
    Ok(CameraView {
        camera_from_world: DAffine3::IDENTITY,
        screen: ScreenFromCamera {
            perspective: true,
            scale: setting.z_k,
            centre: DVec2::splat(0.5 * side),
        },
        size: ImageSize::new(side as u32, side as u32)?,
        near: 1e-3,
    })
}

/// Largest difference of the engine's footprints from a row, levels.
fn difference(
    setting: &Setting,
    (row, alignment, stretch, name, _): (Row, Alignment, Stretch, &str, &str),
    voxels: usize,
) -> Result<f64, LabError> {
    let profile = GaussianProfile::new(CUT);
    let view = view(setting)?;
    let mut random = Random::new(1998);
    let [near, far] = setting.depths();
    let mut worst = 0.0f64;
    for _ in 0..voxels {
        let [y, behind] = [random.range(0.0, setting.edge()), random.range(near, far)];
        let mut kernel = setting.kernel(y, behind);
        kernel.radius = CUT * sigma();
        let cloud = cloud(&kernel);
        // Where the splat lies in 32 bits.
        let [_, y, z] = cloud.positions[0].map(f64::from);
        kernel = Kernel { y, z, ..kernel };
        let projection =
            Projection::new(&cloud, &view, (Filter::Swan, alignment), &profile).with_stretch(stretch);
        let footprint = projection
            .project(0)
            .ok_or_else(|| LabError::Measurement(format!("{name}: no footprint at {y}, {z}")))?;
        worst = worst.max(apart(&footprint, &profile, &kernel, (row, &view)));
    }
    Ok(worst)
}

fn apart(
    footprint: &Footprint,
    profile: &GaussianProfile,
    kernel: &Kernel,
    (row, view): (Row, &CameraView),
) -> f64 {
    let pixel = |y_p: f64| [view.screen.centre.x as f32, (view.screen.centre.y + y_p) as f32];
    let engine = |y_p: f64| f64::from(footprint.integral(profile, None, pixel(y_p)));
    let ours = |y_p: f64| kernel.integral(row, y_p - f64::from(rounding(view, y_p)));
    let middle = kernel.centre();
    let scale = ours(middle) / engine(middle);
    let rays: Vec<f64> = kernel.rays(25).collect();
    let peak = rays.iter().map(|&y_p| ours(y_p)).fold(0.0, f64::max);
    let error = |&y_p: &f64| (scale * engine(y_p) - ours(y_p)).abs();
    256.0 * rays.iter().map(error).fold(0.0, f64::max) / peak
}

/// Rounding error of a pixel's position in 32 bits.
fn rounding(view: &CameraView, y_p: f64) -> f32 {
    let exact = view.screen.centre.y + y_p;
    (exact - f64::from(exact as f32)) as f32
}

/// A misprint: the row with it alone, and the corrected row.
struct Misprint {
    key: &'static str,
    rows: [Row; 2],
    words: &'static str,
    /// Why the row differs.
    wrong: &'static str,
    /// The voxel, and the error in levels below which the row stays there according to the paper.
    kernel: Kernel,
    place: &'static str,
    bound: f64,
}

/// Effect of each misprint alone, where the paper gives a bound that reveals it: at `z_k` kernels are round, and
/// misprinted letters that only rotate them do no harm.
fn printed(outcome: &mut Outcome, setting: &Setting) {
    const RAYS: usize = 401;
    let [_, far] = setting.depths();
    let [at_z_k, behind] = [0.0, far].map(|behind| setting.kernel(setting.edge(), behind));
    let misprints = [
        Misprint {
            key: "printed-row-3",
            rows: [Row::SquaredRayIdeal, Row::RayIdeal],
            words: "row 3 with its squares, and (y_v, z_v) for (x_v, y_v)",
            wrong: "the squares are misprinted: without them, the row keeps the bound",
            kernel: at_z_k,
            place: "at the volume's edge at z_k",
            bound: 2.0,
        },
        Misprint {
            key: "printed-row-3-letters",
            rows: [Row::SwappedRayIdeal, Row::RayIdeal],
            words: "row 3 without its squares, and z_v for x_v alone",
            wrong: "both letters are misprinted: with (y_v, z_v) for (x_v, y_v), the row keeps the bound",
            kernel: behind,
            place: "at the edge of the far face",
            bound: 8.0,
        },
        Misprint {
            key: "printed-row-4",
            rows: [Row::PrintedRay, Row::Ray],
            words: "row 4 with its minus, and (y_v, z_v) for (x_v, y_v) under the root",
            wrong: "the minus is misprinted: with a plus, the row keeps the bound",
            kernel: at_z_k,
            place: "at the volume's edge at z_k",
            bound: 2.0,
        },
    ];
    for one in misprints {
        let [printed, corrected] = one.rows.map(|row| one.kernel.errors(row, RAYS).levels());
        let kept = Expectation::AtMost(one.bound);
        outcome.find(
            Finding::new(
                "Table 1",
                one.key,
                &format!("error of {}, {}", one.words, one.place),
                printed,
                kept,
            )
            .unit("levels")
            .published(Published::Claim(format!("less than {}", one.bound)))
            .explained_by(one.wrong, corrected, kept),
        );
    }
}

fn plot(setting: &Setting) -> Plot {
    let kernel = setting.kernel(setting.edge(), 70.0);
    let curve = |row: Row, name: &str| {
        let point = |y_p: f64| [y_p - kernel.centre(), kernel.integral(row, y_p)];
        Curve::new(name, kernel.rays(121).map(point))
    };
    Plot::curves(
        "footprints",
        "Table 1",
        "footprints at the volume's edge at z_k + 70",
        Axis::new("y_p from the centre's ray (pixels)"),
        Axis::new("integral (kernel heights times voxels)"),
    )
    .curve(curve(Row::Trapezoid, "1, trapezoid"))
    .curve(curve(Row::Box, "2, box").dashed())
    .curve(curve(Row::RayIdeal, "3, ideal ray"))
    .curve(curve(Row::Ray, "4, ray").dashed())
    .curve(curve(Row::Grid, "5, grid"))
}
