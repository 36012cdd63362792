//! Figures 12 and 13: a nerve cell and a landscape that spin, anti-aliased, motion-blurred, both.

use glam::DVec3;
use splatvol::{
    Camera, Filter, FlatSettings, Frame, Image, MotionBlur, Projection, RenderSettings, Renderer, Scene, View,
};
use splatvol_samples::Sample;

use super::scenes::{FOUR, above_terrain, made_faint, scene, settings, spinning};
use crate::experiments::ground::Ground;
use crate::measure::{luminance, psnr};
use crate::{
    Axis, Curve, Expectation, Experiment, Finding, LabError, Outcome, Plate, Plot, PlotKind, Published,
    Table, Workbench,
};

pub(super) const NERVE: Experiment = Experiment {
    name: "mueller1998-nerve",
    paper: "mueller1998",
    title: "A nerve cell that spins, anti-aliased and motion-blurred",
    figures: &["Fig. 12"],
    about: "The paper spins a nerve cell of 512x512x76 voxels rapidly and shows it plain, anti-aliased, with motion-blurred splats, and with both.\n\n\
The cell is not public; ours branches out of seeded random walks, in voxels of 1:1:5 (`sample:nerve`). It turns by 12 degrees about the axis of \
view while the shutter is open. Splats are composited one by one, from the Crawfis-Max kernel; blurred ones are the paper's capsules (Fig. 11, \
eq. 11). The table adds our closed form, and takes the mean of many pictures as right. How fast the paper's cell spins is not given; the plot \
has other speeds.\n\n\
Motion-blurred pictures come out too bright. Eq. 11 dims each capsule's opacity, but many capsules lie behind each other, so that what covers a pixel \
for a tenth of the time still hides most of what is behind; the closed form spreads extinctions and hides even more. Visibility over time is right in \
sub-frames only. The table has the \
brightness of the same cell made faint, too, where splats only add up: \
by what capsules are too bright even then, eq. 11 is to blame (`mueller1998-capsule`).",

    run: nerve,
};

pub(super) const TERRAIN: Experiment = Experiment {
    name: "mueller1998-spinning-terrain",
    paper: "mueller1998",
    title: "A landscape that spins, anti-aliased and motion-blurred",
    figures: &["Fig. 13"],
    about: "The paper spins the landscape of its Fig. 6 about its centre, seen so that all voxels are smaller than pixels, and shows a frame \
plain, anti-aliased, with motion-blurred splats, and with both.\n\n\
Ours is generated (`sample:terrain`, 512x512x103) and turns by 3 degrees while the shutter is open. What the four do over time is \
`mueller1998-space-time`.",
    run: terrain,
};

pub(super) const VOLCANO: Experiment = Experiment {
    name: "mueller1998-spinning-volcano",
    paper: "mueller1998",
    title: "A real landscape that spins, anti-aliased and motion-blurred",
    figures: &["Fig. 13"],
    about: "The same as mueller1998-spinning-terrain with measured heights under a photograph from a satellite: the volcano of \
swan1997-volcano, from the same folder of data, without which the experiment is skipped.",
    run: volcano,
};

fn nerve(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let (dims, size) = bench.choose(([512, 512, 76], [240, 240]), ([128, 128, 19], [60, 60]));
    let scene = scene(Sample::Nerve, dims)?;
    let bounds = scene.bounds()?;
    let projection = Projection::Perspective { fov_degrees: 30.0 };
    let camera = Camera::framing(&bounds, View::Top, projection, 1.0)?;
    let pictures = Pictures::of(bench, &spinning(scene.clone(), 12.0)?, &camera, size)?;
    let faint = Pictures::of(
        bench,
        &spinning(made_faint(&scene, 1000.0)?, 12.0)?,
        &camera,
        size,
    )?;
    let mut outcome = Outcome::default();
    pictures.show(&mut outcome, "Fig. 12", Some(&faint));
    brightness(&mut outcome, &pictures, &faint);
    let [plain, filtered, blurred, both] = &pictures.four;
    let still = rms(plain, filtered);
    let speeds = speeds(bench, (&scene, &camera), size, still)?;
    let fastest = speeds.last().map_or(f64::NAN, |one| one[1]);
    outcome.plots.push(
        Plot::curves(
            "speeds",
            "Fig. 12",
            "what anti-aliasing changes in motion, share of what it changes at rest",
            Axis::new("turn while the shutter is open (degrees)"),
            Axis::new("RMS difference, share of that at rest").range(0.0, 1.0),
        )
        .curve(Curve::new("capsules", speeds).dots()),
    );
    outcome.find(
        Finding::new(
            "Fig. 12",
            "blur-dominates",
            "RMS difference between motion-blurred and both, share of that between plain and anti-aliased",
            rms(blurred, both) / still,
            Expectation::AtMost(0.5),
        )
        .published(Published::Claim(
            "the motion blur dominates, and there is not much of a visible difference".to_owned(),
        ))
        .explained_by(
            "the paper's speed is not given: at four times ours, motion blur dominates",
            fastest,
            Expectation::AtMost(0.5),
        ),
    );
    Ok(outcome)
}

/// Brightness of motion-blurred pictures, and evidence that opacity causes it.
fn brightness(outcome: &mut Outcome, pictures: &Pictures, faint: &Pictures) {
    let same = Expectation::relative(1.0, 0.05);
    let of = |pictures: &Pictures| pictures.brightness(&pictures.exact);
    outcome.find(
        Finding::new(
            "Fig. 12",
            "exact-brightness",
            "brightness of both by the closed form, share of that of the mean of many pictures",
            of(pictures),
            same,
        )
        .explained_by(
            "extinction spread over time hides more than what is opaque for a part of the time; of the same cell made faint, \
             whose splats only add up, this share is kept",
            of(faint),
            same,
        ),
    );
}

/// Turns in degrees, and the difference between motion-blurred and both as a share of that at rest.
fn speeds(
    bench: &Workbench<'_>,
    (scene, camera): (&Scene, &Camera),
    size: [u32; 2],
    still: f64,
) -> Result<Vec<[f64; 2]>, LabError> {
    let mut renderer = bench.renderer()?;
    let mut share = |degrees: f64| -> Result<[f64; 2], LabError> {
        let scene = spinning(scene.clone(), degrees)?;
        let mut picture = |filter| {
            blurred(
                &mut renderer,
                (&scene, camera),
                size,
                (filter, MotionBlur::Capsule),
            )
        };
        let [plain, filtered] = [picture(Filter::None)?.image, picture(Filter::SwanAlpha)?.image];
        Ok([degrees, rms(&plain, &filtered) / still])
    };
    [3.0, 6.0, 12.0, 24.0, 48.0].into_iter().map(&mut share).collect()
}

fn terrain(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    landscape(bench, Ground::Generated)
}

fn volcano(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    landscape(bench, Ground::Volcano)
}

fn landscape(bench: &Workbench<'_>, ground: Ground) -> Result<Outcome, LabError> {
    let (side, depth, size) = bench.choose((512, 103, [200, 160]), (128, 26, [50, 40]));
    let scene = ground.scene(bench, [side, side, depth])?;
    let camera = above_terrain(&scene, side as f64)?;
    let nearest = nearest_voxels_per_pixel(&scene, &camera, size)?;
    let pictures = Pictures::of(bench, &spinning(scene, 3.0)?, &camera, size)?;
    let mut outcome = Outcome::default();
    pictures.show(&mut outcome, "Fig. 13", None);
    outcome.find(
        Finding::new(
            "Fig. 13",
            "voxels-per-pixel",
            "voxels per pixel at the nearest corner of what the picture may show",
            nearest,
            Expectation::AtLeast(1.0),
        )
        .published(Published::Claim(
            "all of the voxels map to subpixel sizes".to_owned(),
        )),
    );
    let [plain, filtered, blurred, both] = &pictures.four;
    let detail = [plain, filtered, blurred, both].map(roughness);
    outcome.find(
        Finding::order(
            "Fig. 13",
            "roughness",
            "mean difference of pixels side by side",
            &["both", "anti-aliased", "plain"],
            &[
                ("both", detail[3]),
                ("anti-aliased", detail[1]),
                ("plain", detail[0]),
            ],
            0.0,
        )
        .published(Published::Claim("both < anti-aliased < plain, by eye".to_owned())),
    );
    Ok(outcome)
}

/// Voxels per pixel where the lower edge of the picture's middle sees the volume's top.
fn nearest_voxels_per_pixel(scene: &Scene, camera: &Camera, size: [u32; 2]) -> Result<f64, LabError> {
    let size = settings(size, Filter::None)?.size;
    let screen = camera.screen_from_camera(size);
    let (_, ray) = screen.ray(glam::DVec2::new(screen.centre.x, f64::from(size.height())));
    let down = camera.camera_from_world().matrix3.transpose() * ray;
    let top = scene.bounds()?.max.z;
    // The depth at which the ray is at that height.
    let depth = (top - camera.position().z) / down.dot(DVec3::Z);
    Ok(1.0 / (screen.scale_at(depth) * scene.single_volume()?.volume.grid().mean_spacing()))
}

/// The paper's four pictures, and those that ours are compared with.
struct Pictures {
    four: [Image; 4],
    /// Anti-aliased and blurred by the closed form.
    exact: Image,
    /// The mean of anti-aliased pictures.
    mean: Image,
}

impl Pictures {
    fn of(bench: &Workbench<'_>, scene: &Scene, camera: &Camera, size: [u32; 2]) -> Result<Self, LabError> {
        let mut renderer = bench.renderer()?;
        let count = bench.choose(24, 8);
        let mut step = 0;
        let mut picture = |filter: Filter, motion_blur: MotionBlur| -> Result<Image, LabError> {
            bench.step(step, 6, "pictures");
            step += 1;
            Ok(blurred(&mut renderer, (scene, camera), size, (filter, motion_blur))?.image)
        };
        let mut four = Vec::with_capacity(4);
        for (_, filter, motion_blur) in FOUR {
            four.push(picture(filter, motion_blur)?);
        }
        let exact = picture(Filter::SwanAlpha, MotionBlur::Exact)?;
        let mean = picture(Filter::SwanAlpha, MotionBlur::Subframes { count })?;
        let four =
            <[Image; 4]>::try_from(four).map_err(|_| LabError::Measurement("four pictures".to_owned()))?;
        Ok(Self { four, exact, mean })
    }

    /// The paper's four pictures, then the one by the closed form.
    fn picture(&self, index: usize) -> &Image {
        self.four.get(index).unwrap_or(&self.exact)
    }

    /// Sum of luminance, share of the mean picture's.
    fn brightness(&self, image: &Image) -> f64 {
        let sum = |image: &Image| luminance(image).iter().sum::<f64>();
        sum(image) / sum(&self.mean)
    }

    /// All pictures, with their brightness; `faint` are those of the same scene made faint.
    fn show(&self, outcome: &mut Outcome, figure: &str, faint: Option<&Self>) {
        let black = [0.0, 0.0, 0.0, 1.0];
        let mut plate = Plate::new(
            "pictures",
            figure,
            "as the paper has them: plain, anti-aliased, motion-blurred, both",
        );
        let mut columns = vec!["picture", "PSNR (dB)", "brightness, share of the mean's"];
        columns.extend(faint.map(|_| "that of the same made faint"));
        let caption = "against the mean of many anti-aliased pictures while the shutter is open";
        let mut table = Table::new("pictures", figure, caption, &columns);
        let names = FOUR.map(|(name, _, _)| name);
        for (index, name) in names.into_iter().chain(["both, closed form"]).enumerate() {
            let image = self.picture(index);
            let mut cells = vec![
                name.into(),
                psnr(image, &self.mean).into(),
                self.brightness(image).into(),
            ];
            cells.extend(faint.map(|faint| faint.brightness(faint.picture(index)).into()));
            table.row(cells);
            plate = plate.panel(name, image.over(black));
        }
        outcome
            .plates
            .push(plate.panel("mean of many pictures", self.mean.over(black)));
        let groups = names.into_iter().zip(&self.four);
        let groups = groups.map(|(name, image)| (name.to_owned(), vec![roughness(image)]));
        let bars = PlotKind::Bars {
            bars: vec!["roughness".to_owned()],
            groups: groups.collect(),
        };
        let axes = [
            Axis::new("picture"),
            Axis::new("mean difference of pixels side by side"),
        ];
        outcome.plots.push(Plot::new(
            "roughness",
            figure,
            "how much pixels side by side differ",
            axes,
            bars,
        ));
        outcome.tables.push(table);
    }
}

/// A picture of a scene in motion.
pub(super) fn blurred(
    renderer: &mut Renderer,
    (scene, camera): (&Scene, &Camera),
    size: [u32; 2],
    (filter, motion_blur): (Filter, MotionBlur),
) -> Result<Frame, LabError> {
    let settings = RenderSettings::try_from(FlatSettings {
        motion_blur,
        ..settings(size, filter)?.into()
    })?;
    Ok(renderer.render(scene, camera, &settings)?)
}

fn rms(one: &Image, other: &Image) -> f64 {
    let [a, b] = [one, other].map(luminance);
    let squares: f64 = a.iter().zip(&b).map(|(a, b)| (a - b).powi(2)).sum();
    (squares / a.len() as f64).sqrt()
}

/// Mean absolute difference in luminance of pixels side by side.
fn roughness(image: &Image) -> f64 {
    let values = luminance(image);
    let rows = values.chunks(image.size().width() as usize);
    let differences = rows.flat_map(|row| row.windows(2).map(|pair| (pair[0] - pair[1]).abs()));
    let (sum, count) = differences.fold((0.0, 0.0), |(sum, count), one| (sum + one, count + 1.0));
    sum / f64::max(count, 1.0)
}
