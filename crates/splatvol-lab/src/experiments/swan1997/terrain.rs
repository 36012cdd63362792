//! Fig. 7 (c) and (d): terrain that recedes into the distance.

use glam::DVec3;
use splatvol::{Camera, ImageSize, Projection, Scene};

use super::comparison::compare;
use super::verdicts::{Claims, report};
use super::view::{METHODS, View};
use super::window::Window;
use crate::experiments::ground::{Columns, Ground};
use crate::{Expectation, Experiment, Finding, LabError, Outcome, Published, Workbench};

pub(super) const GENERATED: Experiment = Experiment {
    name: "swan1997-terrain",
    paper: "swan1997",
    title: "Terrain that recedes into the distance",
    figures: &["Fig. 7"],
    about: "The paper shows terrain of 512 x 512 x 103 voxels, 386 thousand of them splats, in 270 x 175 pixels: every column \
has the colour of its pixel in a satellite photograph, and extra splats fill the holes where neighbours differ in height. A \
black line marks the distance k; the half above it, with about 90 % of the data, aliases, and flickers when animated.\n\n\
The data are not published. Ours are the built-in sample of that size, height and photograph drawn from noise, reduced to the \
paper's splats: the top of each column, and what is below it down to the height of the lowest of its eight neighbours. \
The camera is chosen as the paper describes its view: it looks down by 20 degrees, with a view cone of 30 degrees to \
either side. The mean height is seen at k in the middle of the picture, and the near edge of the data lies below the \
picture's lower edge.\n\n\
Filters, aliased energy and flicker as in swan1997-checker; the camera flies forward by a quarter of a voxel per frame.",
    run: generated,
};

pub(super) const VOLCANO: Experiment = Experiment {
    name: "swan1997-volcano",
    paper: "swan1997",
    title: "Real terrain that recedes into the distance",
    figures: &["Fig. 7"],
    about: "The same as swan1997-terrain with measured heights and a photograph from a satellite, as the paper had: a volcano and \
its surroundings, 256 x 256 heights under 2048 x 2048 pixels (`Data/elevation/dem.csv` and `dem.jpg` of Kitware's vtk-js, \
BSD-3-Clause). Heights are interpolated to 512 x 512 columns and stretched to 103 layers, as their unit is not stated; the \
photograph is reduced to the columns and to 255 colours.\n\n\
The two files are not part of the program: they are read from `terrain` in the folder that `--data` names, and without them \
the experiment is skipped. Its splats are more than the paper's, as the relief is rougher, and their number is no finding.",
    run: volcano,
};

const CLAIMS: Claims = Claims {
    figures: ["Fig. 7 (c)", "Fig. 7 (d)"],
    plain: "strong aliasing in the upper half",
    least: 0.1,
    smoothed: "smoothed out",
    animated: Some("prominent flickering and strobing; free of it"),
};

/// Lays the ground out as the paper has it, and looks over it.
fn view(bench: &Workbench<'_>, ground: Ground) -> Result<View, LabError> {
    let scene = ground.scene(bench, [512, 512, 103])?;
    let ground = scene.single_volume()?;
    let grid = ground.volume.grid();
    let columns = Columns::of(ground.volume)?;
    let bounds = grid.bounds();
    let level = bounds.min.z + columns.mean_top() + 0.5;
    let scene = Scene::new(columns.volume(grid, 0)?, ground.transfer_function.clone());
    let size = ImageSize::new(270, 175)?;
    let projection = Projection::Perspective { fov_degrees: 60.0 };
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    let looking = DVec3::new(0.0, cos, -sin);
    let at = |position: DVec3| Camera::new(position, position + looking, DVec3::Z, projection);
    let k = at(DVec3::ZERO)?.screen_from_camera(size).scale;
    // The middle of the picture meets the mean height at k; the lower edge meets the highest point just inside the near
    // edge.
    let above = k * sin;
    let lower = (above + columns.mean_top() - columns.highest_near() as f64) / 50_f64.to_radians().tan();
    let camera = at(DVec3::new(0.0, bounds.min.y + 2.0 - lower, level + above))?;
    Ok(View {
        scene,
        camera,
        size,
        lighting: None,
    })
}

/// Counts of splats, and of those in the picture and beyond k in it.
fn counts(view: &View) -> Result<[f64; 3], LabError> {
    let volume = view.scene.single_volume()?.volume;
    let [nx, ny, _] = volume.grid().dims();
    let screen = view.camera.screen_from_camera(view.size);
    let camera_from_voxel = view.camera.camera_from_world() * volume.grid().world_from_voxel();
    let [width, height] = <[u32; 2]>::from(view.size).map(f64::from);
    let k = view.k()?;
    let mut counts = [0.0; 3];
    for index in (0..volume.grid().sample_count()).filter(|&index| volume.value(index) > 0.0) {
        counts[0] += 1.0;
        let voxel = [index % nx, index / nx % ny, index / (nx * ny)].map(|i| i as f64);
        let point = camera_from_voxel.transform_point3(DVec3::from_array(voxel));
        if point.z <= 0.0 {
            continue;
        }
        let pixel = screen.project(point);
        if (0.0..width).contains(&pixel.x) && (0.0..height).contains(&pixel.y) {
            counts[1] += 1.0;
            counts[2] += f64::from(u8::from(point.z >= k));
        }
    }
    Ok(counts)
}

fn generated(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    measure(bench, Ground::Generated)
}

fn volcano(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    measure(bench, Ground::Volcano)
}

fn measure(bench: &Workbench<'_>, ground: Ground) -> Result<Outcome, LabError> {
    let view = view(bench, ground)?;
    let plain = view.frame(&mut bench.renderer()?, METHODS[0].filter)?;
    let k = view.k()?;
    let window = Window::at_depths(&plain, |depth| depth >= k)?.inside(1);
    let mut outcome = Outcome::default();
    sizes(&mut outcome, &view, ground)?;
    let comparison = compare(bench, &view, &window, 0.25 * DVec3::Y)?;
    report(&mut outcome, &comparison, &view, &CLAIMS)?;
    Ok(outcome)
}

/// Number of splats and their positions.
fn sizes(outcome: &mut Outcome, view: &View, ground: Ground) -> Result<(), LabError> {
    let [splats, seen, beyond] = counts(view)?;
    if ground == Ground::Generated {
        let published = Expectation::relative(386_000.0, 0.1);
        outcome.find(
            Finding::new("Fig. 7 (c)", "splats", "splats", splats, published)
                .published(Published::Number(386_000.0)),
        );
    }
    outcome.find(
        Finding::new(
            "Fig. 7 (c)",
            "beyond-k",
            "share of the splats in the picture that lie beyond k",
            beyond / seen,
            Expectation::Near {
                value: 0.9,
                within: 0.05,
            },
        )
        .detail(format!("{splats} splats, {seen} of them in the picture"))
        .published(Published::Number(0.9)),
    );
    Ok(())
}
