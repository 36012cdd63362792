//! Figure 14: a column of pixels of the spinning landscape over time, and how it flickers.

use splatvol::{Camera, CameraPath, Filter, Image, ImageSize, MotionBlur, Renderer, Scene};

use super::scenes::{FOUR, above_terrain, enlarged, spinning, unsteadiness};
use super::spin::blurred;
use crate::experiments::ground::Ground;
use crate::measure::{luminance, mean};
use crate::{
    Axis, Curve, Expectation, Experiment, Finding, LabError, Outcome, Plate, Plot, Published, Table,
    Workbench,
};

pub(super) const TERRAIN: Experiment = Experiment {
    name: "mueller1998-space-time",
    paper: "mueller1998",
    title: "A column of the spinning landscape over time",
    figures: &["Fig. 14"],
    about: "The paper takes the column of pixels from the centre of the spinning landscape to the picture's upper edge from successive frames, and sets \
the columns side by side: rows of the result are what a pixel shows over time.\n\n\
We do the same with a whole turn in steps of 3 degrees, the shutter open all the time, and count the flicker of each row: the variance over \
time of what a frame differs by from the mean of the frames before and after it, times 2/3, which for noise is its variance. Luminance is \
linear. Beside the paper's four there are means of eight pictures while the shutter is open, plain and anti-aliased: what motion blur should come to. \
`--quick` takes fewer frames of a smaller landscape.",
    run: terrain,
};

pub(super) const VOLCANO: Experiment = Experiment {
    name: "mueller1998-space-time-volcano",
    paper: "mueller1998",
    title: "A column of the real landscape over time",
    figures: &["Fig. 14"],
    about: "The same as mueller1998-space-time with measured heights under a photograph from a satellite: the volcano of \
swan1997-volcano, from the same folder of data, without which the experiment is skipped.",
    run: volcano,
};

/// Turn from frame to frame, degrees.
const STEP: f64 = 3.0;

/// Number of pictures of the reference while the shutter is open.
const SUBFRAMES: u32 = 8;

/// Columns over time: `[frame][row]`, rows from the upper edge to the centre.
struct Slice {
    name: &'static str,
    pixels: Vec<Vec<[f32; 4]>>,
}

/// The paper's four variants, and the reference in motion: means of pictures, plain and anti-aliased.
fn variants() -> [(&'static str, Filter, MotionBlur); 6] {
    let [plain, filtered, blurred, both] = FOUR;
    let mean = MotionBlur::Subframes { count: SUBFRAMES };
    let means = [
        ("sub-frames", plain.1, mean),
        ("anti-aliased sub-frames", filtered.1, mean),
    ];
    [plain, filtered, blurred, both, means[0], means[1]]
}

fn terrain(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    measure(bench, Ground::Generated)
}

fn volcano(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    measure(bench, Ground::Volcano)
}

fn measure(bench: &Workbench<'_>, ground: Ground) -> Result<Outcome, LabError> {
    let mut outcome = Outcome::default();
    let slices = slices(bench, ground)?;
    show(&mut outcome, &slices, bench.choose(3, 8))?;
    let flicker: Vec<Vec<f64>> = slices.iter().map(flicker).collect();
    plot(&mut outcome, &slices, &flicker);
    claims(&mut outcome, &flicker);
    Ok(outcome)
}

/// The columns over time.
fn slices(bench: &Workbench<'_>, ground: Ground) -> Result<[Slice; 6], LabError> {
    let (side, depth) = bench.choose((512, 103), (128, 26));
    let (frames, height) = bench.choose((120, 120), (32, 32));
    let scene = ground.scene(bench, [side, side, depth])?;
    let camera = above_terrain(&scene, side as f64)?;
    let scene = spinning(scene, STEP)?;
    let mut renderer = bench.renderer()?;
    let mut slices = variants().map(|(name, _, _)| Slice {
        name,
        pixels: Vec::with_capacity(frames),
    });
    let path = CameraPath::turntable(camera, 360.0)?;
    for frame in 0..frames {
        bench.step(frame, frames, "frames");
        let camera = path.camera(frame as f64 * STEP / 360.0)?;
        for (slice, (_, filter, motion_blur)) in slices.iter_mut().zip(variants()) {
            let way = (filter, motion_blur);
            slice
                .pixels
                .push(column(&mut renderer, (&scene, &camera), height, way)?);
        }
    }
    Ok(slices)
}

/// The upper half of the picture's middle column, from a picture one pixel wide: the field of view is vertical, so
/// the width does not change it.
fn column(
    renderer: &mut Renderer,
    looking: (&Scene, &Camera),
    height: u32,
    way: (Filter, MotionBlur),
) -> Result<Vec<[f32; 4]>, LabError> {
    let image = blurred(renderer, looking, [1, height], way)?.image;
    let black = [0.0, 0.0, 0.0, 1.0];
    Ok(image.over(black).pixels[..height as usize / 2].to_vec())
}

/// Flicker of each row.
fn flicker(slice: &Slice) -> Vec<f64> {
    let values: Vec<Vec<f64>> = slice.pixels.iter().map(|column| lightness(column)).collect();
    let rows = values.first().map_or(0, Vec::len);
    let of = |row: usize| {
        let threes = values.windows(3);
        let each: Vec<f64> = threes
            .map(|three| unsteadiness([0, 1, 2].map(|time| three[time][row])))
            .collect();
        mean(&each)
    };
    (0..rows).map(of).collect()
}

fn lightness(column: &[[f32; 4]]) -> Vec<f64> {
    let size = ImageSize::new(1, column.len() as u32);
    let image = size.and_then(|size| Image::from_pixels(size, column.to_vec()));
    image.map_or_else(|_| Vec::new(), |image| luminance(&image))
}

fn show(outcome: &mut Outcome, slices: &[Slice; 6], block: usize) -> Result<(), LabError> {
    let caption = "from left to right: time; from top to bottom: from the picture's upper edge to its centre";
    let mut plate = Plate::new("slices", "Fig. 14", caption);
    for slice in slices {
        let rows = slice.pixels.first().map_or(0, Vec::len);
        let pixels = (0..rows).flat_map(|row| slice.pixels.iter().map(move |column| column[row]));
        let size = ImageSize::new(slice.pixels.len() as u32, rows as u32)?;
        let image = Image::from_pixels(size, pixels.collect())?;
        plate = plate.panel(slice.name, enlarged(&image, block)?);
    }
    outcome.plates.push(plate);
    Ok(())
}

fn plot(outcome: &mut Outcome, slices: &[Slice; 6], flicker: &[Vec<f64>]) {
    let rows = flicker[0].len();
    let mut plot = Plot::curves(
        "flicker",
        "Fig. 14",
        "how each row flickers",
        Axis::new("distance from the centre (pixels)"),
        Axis::logarithmic("temporal variance of luminance"),
    );
    let columns: Vec<&str> = ["distance from the centre (pixels)"]
        .into_iter()
        .chain(slices.iter().map(|slice| slice.name))
        .collect();
    let caption = "temporal variance of luminance per row";
    let mut table = Table::new("flicker", "Fig. 14", caption, &columns).hidden();
    let distance = |row: usize| (rows - row) as f64 - 0.5;
    for (slice, flicker) in slices.iter().zip(flicker) {
        let points = (0..rows).rev().map(|row| [distance(row), flicker[row].max(1e-9)]);
        let curve = Curve::new(slice.name, points);
        plot = plot.curve(if slice.name.contains("anti") {
            curve.dashed()
        } else {
            curve
        });
    }
    for row in (0..rows).rev() {
        let mut cells = vec![distance(row).into()];
        cells.extend(flicker.iter().map(|one| one[row].into()));
        table.row(cells);
    }
    outcome.plots.push(plot);
    outcome.tables.push(table);
}

/// Mean flicker of a slice in some rows, share of the plain one's.
fn share(flicker: &[Vec<f64>], index: usize, rows: &std::ops::Range<usize>) -> f64 {
    mean(&flicker[index][rows.clone()]) / mean(&flicker[0][rows.clone()])
}

fn claims(outcome: &mut Outcome, flicker: &[Vec<f64>]) {
    let rows = flicker[0].len();
    let part = rows / 3;
    let [all, edge, centre] = [0..rows, 0..part, rows - part..rows];
    let claim = |words: &str| Published::Claim(words.to_owned());
    outcome.find(
        Finding::new(
            "Fig. 14 (b)",
            "anti-aliased",
            "flicker of the anti-aliased frames, share of the plain ones'",
            share(flicker, 1, &all),
            Expectation::AtMost(0.5),
        )
        .published(claim("smooth variations of color, absence of flickering")),
    );
    outcome.find(
        Finding::new(
            "Fig. 14 (c)",
            "motion-blurred-centre",
            "flicker of the motion-blurred frames in the third of the rows nearest the centre, share of the plain ones'",
            share(flicker, 2, &centre),
            Expectation::AtLeast(0.25),
        )
        .published(claim("the same random pixel colors: considerable flickering in the center")),
    );
    let towards_edge = |index: usize| share(flicker, index, &edge) / share(flicker, index, &centre);
    outcome.find(
        Finding::new(
            "Fig. 14 (c)",
            "motion-blurred-edge",
            "that share in the third of the rows nearest the edge, over that near the centre",
            towards_edge(2),
            Expectation::AtMost(0.8),
        )
        .published(claim("less pronounced toward the top"))
        .explained_by(
            "capsules do not blur as motion does: means of pictures while the shutter is open keep the claim",
            towards_edge(4),
            Expectation::AtMost(0.8),
        ),
    );
    outcome.find(
        Finding::new(
            "Fig. 14 (d)",
            "both",
            "flicker of the frames with both, share of the plain ones'",
            share(flicker, 3, &all),
            Expectation::AtMost(0.25),
        )
        .published(claim("both artifacts are greatly reduced"))
        .explained_by(
            "what is seen moves, and even means of anti-aliased pictures while the shutter is open flicker by at least four fifths of that",
            share(flicker, 5, &all) / share(flicker, 3, &all),
            Expectation::AtLeast(0.8),
        ),
    );
    let others = &flicker[..3];
    let least = |way: usize| {
        let is_least = |row: &usize| others.iter().all(|one| flicker[way][*row] <= one[*row]);
        (0..rows).filter(is_least).count() as f64 / rows as f64
    };
    outcome.find(
        Finding::new(
            "Fig. 14 (d)",
            "both-least",
            "share of the rows in which, of the four, the frames with both flicker least",
            least(3),
            Expectation::AtLeast(0.9),
        )
        .explained_by(
            "capsules do not blur as motion does: anti-aliased means of pictures while the shutter is open flicker least of all \
             in this share of the rows",
            least(5),
            Expectation::AtLeast(0.9),
        ),
    );
}
