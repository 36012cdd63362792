//! Popping: change of the picture from one frame to the next while the camera turns through 45 degrees about an axis of
//! the grid. If the method has no influence, the change is equally large between all frames. A jump is a change larger
//! than its neighbours.

use glam::DVec3;
use splatvol::{Compositing, FlatSettings, Image, RenderSettings, Renderer, Scene};
use splatvol_core::radial::RadialKernel;

use super::scenes::{SMOOTH, colors, difference, noise_ball, orthographic, rms, shown};
use crate::{
    Axis, Curve, Expectation, Experiment, Finding, LabError, Mark, Outcome, Plate, Plot, Published, Table,
    Workbench,
};

const FIGURE: &str = "Popping";
/// Degrees from one frame to the next; 45 degrees lie between two frames.
const STEP: f64 = 0.1;
/// Changes on either side of the jump that serve as the baseline.
const NEIGHBOURS: usize = 10;
/// Gain of the difference pictures.
const GAIN: f32 = 15.0;

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "beyond-popping",
    paper: "beyond",
    title: "Popping: what jumps when the camera passes 45 degrees",
    figures: &[FIGURE],
    about: "huang2000 (section 2) says of axis-aligned sheets that the picture pops where the sheets' orientation changes, \
            and of splats composited one by one that they pop too. Neither is measured there. Here the camera turns about \
            an axis of the grid in steps of a tenth of a degree through 45 degrees, where another axis faces it. The change from each frame \
            to the next (root mean square of all channels) is set beside the median of its neighbours: 1 is steady.\n\n\
            The scene is a ball of seeded noise, classified and unlit, once half transparent and once nearly opaque. All \
            methods draw the same splats with the same Gaussian (sigma .9, cut at 4.5), without a filter.",
    run,
};

/// A way to composite, its name, and the condition on its jump.
const METHODS: [(&str, &str, Compositing); 3] = [
    ("axis-sheets", "axis sheets", Compositing::AxisSheets),
    ("per-splat", "splats one by one", Compositing::PerSplat),
    (
        "image-sheets",
        "image sheets, half a voxel",
        Compositing::ImageSheets,
    ),
];

/// Looks, by opacity per voxel.
const LOOKS: [(&str, f64); 2] = [("translucent", 0.2), ("opaque", 0.9)];

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let mut renderer = bench.renderer()?;
    let pixels = bench.choose(160, 64);
    let side = bench.choose(48, 24);
    let mut outcome = Outcome::default();
    let columns = [
        "look",
        "method",
        "angle (degrees)",
        "change (% of full light, rms)",
    ];
    let mut table = Table::new("changes", FIGURE, "Change from one frame to the next", &columns).hidden();
    for (index, (look, opacity)) in LOOKS.into_iter().enumerate() {
        let scene = noise_ball(side, opacity)?;
        let mut plate = Plate::new(
            &format!("jump-{look}"),
            FIGURE,
            &format!(
                "The {look} ball just before 45 degrees, and {GAIN} times what the step across it changes"
            ),
        );
        let mut curves = Vec::new();
        for (step, (key, name, compositing)) in METHODS.into_iter().enumerate() {
            bench.step(
                index * METHODS.len() + step,
                LOOKS.len() * METHODS.len(),
                &format!("{look}, {name}"),
            );
            let settings = RenderSettings::try_from(FlatSettings {
                compositing,
                ..colors(pixels, SMOOTH)?.into()
            })?;
            let turn = Turn::render(&mut renderer, &scene, &settings, bench.choose(30, 12))?;
            if compositing == Compositing::AxisSheets {
                plate = plate.panel("before", shown(&turn.around[0]));
            }
            plate = plate.panel(name, difference(&turn.around[1], &turn.around[0], GAIN));
            for [angle, change] in &turn.changes {
                table.row([look.into(), name.into(), (*angle).into(), (*change).into()]);
            }
            outcome.find(jump([look, key, name], opacity, &turn));
            curves.push(Curve::new(name, turn.changes));
        }
        outcome.plates.push(plate);
        outcome.plots.push(plot(look, curves));
    }
    outcome.tables.push(table);
    Ok(outcome)
}

/// Changes of the picture over a turn of the camera.
struct Turn {
    /// Angle between two frames, degrees, and their difference, % of full light.
    changes: Vec<[f64; 2]>,
    /// The frames before and after 45 degrees.
    around: [Image; 2],
}

impl Turn {
    /// `half` frames on either side of 45 degrees, the nearest half a step off.
    fn render(
        renderer: &mut Renderer,
        scene: &Scene,
        settings: &RenderSettings,
        half: i32,
    ) -> Result<Self, LabError> {
        let height = scene.single_volume()?.volume.grid().dims()[0] as f64;
        let mut changes = Vec::new();
        let mut last: Option<Image> = None;
        let mut around = None;
        for index in -half..half {
            let angle = 45.0 + (f64::from(index) + 0.5) * STEP;
            let (sin, cos) = angle.to_radians().sin_cos();
            let camera = orthographic(DVec3::new(cos, sin, 0.2), DVec3::Z, height)?;
            let image = renderer.render(scene, &camera, settings)?.image;
            if let Some(last) = last.take() {
                changes.push([angle - 0.5 * STEP, 100.0 * rms(&image, &last)]);
                if index == 0 {
                    around = Some([last, image.clone()]);
                }
            }
            last = Some(image);
        }
        let around = around.ok_or_else(|| LabError::Measurement("no frames around 45 degrees".to_owned()))?;
        Ok(Self { changes, around })
    }

    /// The change across 45 degrees over the median of its neighbours.
    fn jump(&self) -> f64 {
        let middle = self.changes.len() / 2;
        let near = middle.saturating_sub(NEIGHBOURS)..(middle + NEIGHBOURS + 1).min(self.changes.len());
        let mut others: Vec<f64> = near
            .filter(|&index| index != middle)
            .map(|index| self.changes[index][1])
            .collect();
        others.sort_by(f64::total_cmp);
        self.changes[middle][1] / others[others.len() / 2]
    }
}

fn jump([look, key, name]: [&str; 3], opacity: f64, turn: &Turn) -> Finding {
    // A change twice as large as all others is seen; one within a quarter of them is not.
    let (published, expected) = match key {
        "axis-sheets" => (
            "a more substantial popping artifact when the orientation of the sheets changes",
            Expectation::AtLeast(2.0),
        ),
        "per-splat" => ("popping artifacts", Expectation::AtLeast(2.0)),
        _ => ("overcomes this drawback", Expectation::Between(0.75, 1.25)),
    };
    let quantity = format!("{look}, {name}: change across 45 degrees over the median of its neighbours");
    let finding = Finding::new(FIGURE, &format!("{look}-{key}"), &quantity, turn.jump(), expected)
        .published(Published::Claim(format!("huang2000 section 2: {published}")));
    match key {
        "per-splat" => finding.explained_by(
            "the order of two splats matters by the product of their opacities, of full light, which here is below a \
             hundredth",
            largest_opacity(opacity).powi(2),
            Expectation::AtMost(0.01),
        ),
        _ => finding,
    }
}

/// Opacity of a splat of this opacity per voxel, at its centre: `1 - (1 - opacity)^q(0)`, q its footprint.
fn largest_opacity(opacity: f64) -> f64 {
    1.0 - (1.0 - opacity).powf(RadialKernel::new(SMOOTH).line_integral(0.0))
}

fn plot(look: &str, curves: Vec<Curve>) -> Plot {
    let plot = Plot::curves(
        &format!("turn-{look}"),
        FIGURE,
        &format!("The {look} ball: change from one frame to the next"),
        Axis::new("angle of the camera (degrees)"),
        Axis::logarithmic("change (% of full light, rms)"),
    )
    .mark(Mark::Vertical {
        at: 45.0,
        label: "another axis faces the camera".to_owned(),
    });
    curves.into_iter().fold(plot, Plot::curve)
}

#[cfg(test)]
mod tests {
    use super::*;
    use splatvol::ImageSize;

    #[test]
    fn a_jump_is_relative_to_its_neighbours() {
        let blank = || Image::filled(ImageSize::new(1, 1).unwrap(), [0.0; 4]);
        let change = |index: usize| {
            if index == 20 {
                6.0
            } else {
                2.0 + 0.01 * index as f64
            }
        };
        let turn = Turn {
            changes: (0..41).map(|index| [index as f64, change(index)]).collect(),
            around: [blank(), blank()],
        };
        assert!((turn.jump() - 6.0 / 2.2).abs() < 0.03, "{}", turn.jump());
    }
}
