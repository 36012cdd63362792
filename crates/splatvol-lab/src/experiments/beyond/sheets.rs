//! Deviation of composited footprints from the emission-absorption integral, depending on the thickness of
//! the sheets.
//!
//! A sheet holds the exact integral of extinction over its depth, but loses the order within it. So colours that change
//! within a sheet make an error of second order in its thickness. Whole footprints, one by one or added up on slices of
//! the grid, are as thick as the kernel, whatever the sheets.

use glam::DVec3;
use splatvol::{
    Camera, Classification, Compositing, FlatSettings, Image, RenderSettings, Renderer, Scene, SceneError,
    SheetContent,
};
use splatvol_reference::ReferenceSettings;

use super::scenes::{SMOOTH, colors, difference, noise_ball, orthographic, rms, shown};
use crate::{
    Axis, Curve, Expectation, Experiment, Finding, LabError, Outcome, Plate, Plot, Published, Table,
    Workbench,
};

const FIGURE: &str = "Sheet thickness";
/// Voxels, thickest first; each half of the one before.
const THICKNESSES: [f64; 4] = [2.0, 1.0, 0.5, 0.25];
/// The sheets as thick as a voxel, and the thinnest: the order of convergence is measured between them.
const VOXEL: usize = 1;
const THINNEST: usize = 3;
const GAIN: f32 = 8.0;

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "beyond-sheet-thickness",
    paper: "beyond",
    title: "Compositing: splats one by one against sheets of 2, 1, 1/2 and 1/4 voxel",
    figures: &[FIGURE],
    about: "huang2000 (section 2) says that sheets thinner than a voxel improve the accuracy, and that whole splats, one by \
            one, compute the integral incorrectly. Here all of them are compared with the integral itself, computed in f64 \
            along every pixel's ray by a program that shares nothing with the engines.\n\n\
            The scene is a ball of seeded noise, unlit, once half transparent and once nearly opaque, seen along no axis in \
            particular. Colours are splatted (pre-classified), so that all methods draw the same thing. Two more curves \
            splat data, which is classified on the sheets: as planes with integrals between them, ours, and as the mean of \
            each sheet, huang2000's. These are compared with the integral of the classified field. The kernel is a \
            Gaussian of sigma .9, cut at 4.5. Errors are root mean squares over all channels.",
    run,
};

/// Looks, by opacity per voxel.
const LOOKS: [(&str, f64); 2] = [("translucent", 0.2), ("opaque", 0.9)];

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let mut outcome = Outcome::default();
    let columns = ["look", "method", "sheets (voxels)", "error (rms)"];
    let mut table = Table::new("errors", FIGURE, "Distance from the integral", &columns);
    let side = bench.choose(40, 20);
    let base = colors(bench.choose(120, 40), SMOOTH)?;
    let camera = orthographic(DVec3::new(0.48, -0.75, 0.4), DVec3::Z, side as f64)?;
    let mut renderer = bench.renderer()?;
    for (index, (look, opacity)) in LOOKS.into_iter().enumerate() {
        bench.step(index, LOOKS.len(), &format!("{look}, the integral"));
        let scene = noise_ball(side, opacity)?;
        let mut judge = Judge {
            renderer: &mut renderer,
            scene: &scene,
            camera: &camera,
        };
        let truth = judge.integral(&base)?;
        bench.step(2 * index + 1, 2 * LOOKS.len(), &format!("{look}, sheets"));
        let found = judge.errors(&base, &truth)?;
        for (method, thickness, error) in found.rows() {
            table.row([look.into(), method.into(), thickness.into(), error.into()]);
        }
        findings(&mut outcome, look, &found);
        outcome.plots.push(plot(look, &found));
        outcome.plates.push(judge.plate(look, &base, &truth)?);
    }
    outcome.tables.push(table);
    Ok(outcome)
}

/// Errors by [`THICKNESSES`], and of whole footprints.
struct Errors {
    /// Classified splats on sheets.
    colors: Vec<f64>,
    /// Planes of data.
    planes: Vec<f64>,
    /// Means of data over sheets.
    sections: Vec<f64>,
    per_splat: f64,
    axis_sheets: f64,
}

impl Errors {
    fn sheets(&self) -> [(&'static str, &[f64]); 3] {
        [
            ("colours on sheets", &self.colors),
            ("data on planes, integrated between", &self.planes),
            ("data, mean of each sheet", &self.sections),
        ]
    }

    fn whole(&self) -> [(&'static str, f64); 2] {
        [
            ("splats one by one", self.per_splat),
            ("axis sheets", self.axis_sheets),
        ]
    }

    fn rows(&self) -> Vec<(&'static str, String, f64)> {
        let sheets = self.sheets();
        let by_thickness = sheets.iter().flat_map(|(name, errors)| {
            let rows = THICKNESSES.iter().zip(*errors);
            rows.map(move |(thickness, error)| (*name, thickness.to_string(), *error))
        });
        let whole = self.whole().map(|(name, error)| (name, "–".to_owned(), error));
        by_thickness.chain(whole).collect()
    }
}

/// The integral of classified splats, and of classified data.
struct Truth {
    colors: Image,
    data: Image,
}

/// Renders a scene and compares it with its integral.
struct Judge<'a> {
    renderer: &'a mut Renderer,
    scene: &'a Scene,
    camera: &'a Camera,
}

fn data(base: &RenderSettings) -> Result<RenderSettings, SceneError> {
    RenderSettings::try_from(FlatSettings {
        classification: Classification::Post,
        ..(*base).into()
    })
}

/// Whole footprints, composited like this.
fn whole(base: &RenderSettings, compositing: Compositing) -> Result<RenderSettings, SceneError> {
    RenderSettings::try_from(FlatSettings {
        compositing,
        ..(*base).into()
    })
}

fn of_thickness(base: &RenderSettings, sheet_thickness: f64) -> Result<RenderSettings, SceneError> {
    RenderSettings::try_from(FlatSettings {
        sheet_thickness,
        ..(*base).into()
    })
}

impl Judge<'_> {
    fn integral(&self, base: &RenderSettings) -> Result<Truth, LabError> {
        let options = ReferenceSettings::default();
        let integral = |settings: &RenderSettings| {
            splatvol_reference::render(self.scene, self.camera, settings, &options)
                .map(|frame| frame.image)
                .map_err(|error| LabError::Reference(error.to_string()))
        };
        Ok(Truth {
            colors: integral(base)?,
            data: integral(&data(base)?)?,
        })
    }

    fn image(&mut self, settings: &RenderSettings) -> Result<Image, LabError> {
        Ok(self.renderer.render(self.scene, self.camera, settings)?.image)
    }

    fn errors(&mut self, base: &RenderSettings, truth: &Truth) -> Result<Errors, LabError> {
        let sections = RenderSettings::try_from(FlatSettings {
            sheet: Some(SheetContent::Section),
            ..data(base)?.into()
        })?;
        Ok(Errors {
            colors: self.by_thickness(base, &truth.colors)?,
            planes: self.by_thickness(&data(base)?, &truth.data)?,
            sections: self.by_thickness(&sections, &truth.data)?,
            per_splat: rms(&self.image(&whole(base, Compositing::PerSplat)?)?, &truth.colors),
            axis_sheets: rms(
                &self.image(&whole(base, Compositing::AxisSheets)?)?,
                &truth.colors,
            ),
        })
    }

    fn by_thickness(&mut self, base: &RenderSettings, truth: &Image) -> Result<Vec<f64>, LabError> {
        let error = |sheet_thickness| {
            let settings = of_thickness(base, sheet_thickness)?;
            Ok(rms(&self.image(&settings)?, truth))
        };
        THICKNESSES.into_iter().map(error).collect()
    }

    fn plate(&mut self, look: &str, base: &RenderSettings, truth: &Truth) -> Result<Plate, LabError> {
        let caption = format!("The {look} ball, and {GAIN} times what is wrong with it (grey: nothing)");
        let mut plate = Plate::new(&format!("errors-{look}"), FIGURE, &caption);
        plate = plate.panel("the integral", shown(&truth.colors));
        for (label, settings) in [
            ("splats one by one", whole(base, Compositing::PerSplat)?),
            ("axis sheets", whole(base, Compositing::AxisSheets)?),
            ("sheets of 1 voxel", of_thickness(base, 1.0)?),
            ("sheets of 1/4 voxel", of_thickness(base, 0.25)?),
        ] {
            let image = self.image(&settings)?;
            plate = plate.panel(label, difference(&image, &truth.colors, GAIN));
        }
        Ok(plate)
    }
}

fn findings(outcome: &mut Outcome, look: &str, found: &Errors) {
    let order = (found.colors[VOXEL] / found.colors[THINNEST]).log2() / (THINNEST - VOXEL) as f64;
    outcome.find(
        Finding::new(
            FIGURE,
            &format!("{look}-order"),
            &format!("{look}: order of convergence of classified sheets, from 1 to 1/4 voxel"),
            order,
            Expectation::Between(1.7, 2.3),
        )
        .published(Published::Claim(
            "huang2000 section 2: sub-voxel sheets improve the accuracy".to_owned(),
        )),
    );
    outcome.find(
        Finding::new(
            FIGURE,
            &format!("{look}-per-splat"),
            &format!("{look}: error of splats one by one over that of sheets of a voxel"),
            found.per_splat / found.colors[VOXEL],
            Expectation::AtLeast(2.0),
        )
        .published(Published::Claim(
            "huang2000 section 2: incorrect volume integration".to_owned(),
        ))
        .detail(format!("{:.4} rms", found.per_splat)),
    );
    outcome.find(
        Finding::new(
            FIGURE,
            &format!("{look}-axis-sheets"),
            &format!("{look}: error of axis sheets over that of image sheets of a voxel"),
            found.axis_sheets / found.colors[VOXEL],
            Expectation::AtLeast(1.0),
        )
        .detail(format!("{:.4} rms", found.axis_sheets)),
    );
    outcome.find(Finding::new(
        FIGURE,
        &format!("{look}-planes"),
        &format!("{look}: data on planes half a voxel apart, error over that of the mean of each sheet"),
        found.planes[2] / found.sections[2],
        Expectation::AtMost(0.5),
    ));
}

fn plot(look: &str, found: &Errors) -> Plot {
    let plot = Plot::curves(
        &format!("convergence-{look}"),
        FIGURE,
        &format!("The {look} ball: distance from the integral"),
        Axis::logarithmic("thickness of the sheets (voxels)").range(0.2, 2.5),
        Axis::logarithmic("error (rms of all channels, of full light)"),
    );
    let plot = found.sheets().into_iter().fold(plot, |plot, (name, errors)| {
        let points = THICKNESSES
            .into_iter()
            .zip(errors.iter().copied())
            .map(<[f64; 2]>::from);
        plot.curve(Curve::new(name, points).dots())
    });
    let second = THICKNESSES.map(|thickness| [thickness, found.colors[VOXEL] * 0.5 * thickness * thickness]);
    let plot = plot.curve(Curve::new("second order", second).dashed());
    found.whole().into_iter().fold(plot, |plot, (name, error)| {
        let points = THICKNESSES.map(|thickness| [thickness, error]);
        let curve = Curve::new(name, points).dashed();
        // The two may coincide.
        plot.curve(if name == "axis sheets" {
            curve
        } else {
            curve.dots()
        })
    })
}
