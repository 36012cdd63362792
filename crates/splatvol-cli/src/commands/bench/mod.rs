//! `splatvol bench`: render fixed or given scenes again and again, time them, and check their pictures.
//!
//! [`scenes`] has the cases, [`looks`] their looks; [`measure`] runs and times them, [`checksum`] compares their
//! pictures with those recorded in `expected.json`, and [`report`] has the results. After an intended change of
//! pictures, record them again with
//! `cargo run --release -- bench --update-expected crates/splatvol-cli/src/commands/bench/expected.json`.

mod around;
mod checksum;
mod looks;
mod measure;
mod process;
mod report;
pub(crate) mod scenes;

use std::path::Path;
use std::sync::Arc;

use splatvol::{ImageSize, Item, Scene};
use splatvol_document::input::{self, Input};
use splatvol_document::keys::{CHARCOAL, CameraKeys};
use splatvol_document::look::{self, Look};
use splatvol_document::upright::Up;
use splatvol_document::{CameraPose, Surroundings, outline};

use self::around::around;
use self::checksum::{Check, Checksum, Expected};
use self::looks::Window;
use self::measure::{Course, Measured, Subject, measure, median};
use self::report::{CaseReport, Report, Table};
use self::scenes::{SceneChoice, Variant};
use crate::args::{BenchArgs, LookName, MethodArgs, ProjectionName, of_input};
use crate::failure::{During, Failure, Step};
use crate::output::{Target, check_distinct, encode_frame, picture_format};
use crate::terminal::Terminal;

pub(crate) fn run(args: &BenchArgs, terminal: &Terminal) -> Result<(), Failure> {
    let bench = Bench::new(args, terminal)?;
    let report = bench.run()?;
    if let Some(path) = &args.update_expected {
        return update(path, args, &report, terminal);
    }
    if let Some(json) = &args.json {
        let mut text = serde_json::to_string_pretty(&report).during(Step::Output)?;
        text.push('\n');
        Target::new(json).write(text.as_bytes(), args.write.overwrite)?;
    }
    let complaints = report.complaints();
    if complaints.is_empty() {
        return Ok(());
    }
    let message = format!("pictures are not as expected:\n  {}", complaints.join("\n  "));
    Err(anyhow::Error::msg(message)).during(Step::Render)
}

/// Records the pictures in the file that the program is built from.
fn update(path: &Path, args: &BenchArgs, report: &Report, terminal: &Terminal) -> Result<(), Failure> {
    let mut expected = Expected::recorded(args.expected.as_deref())?;
    let names = scenes::fixed_names();
    expected.retain(|case| names.iter().any(|name| name == case));
    for case in &report.cases {
        expected.record(&case.name, &case.picture);
    }
    expected.write(path)?;
    terminal.note(format!(
        "recorded {} pictures in {}",
        report.cases.len(),
        path.display()
    ));
    Ok(())
}

/// A run of the command.
struct Bench<'a> {
    args: &'a BenchArgs,
    terminal: &'a Terminal,
    course: Course,
    variants: Vec<Variant>,
    table: Table,
    /// `None` if nothing is expected of the pictures.
    expected: Option<Expected>,
}

impl<'a> Bench<'a> {
    /// Refuses early what would be refused after the work.
    fn new(args: &'a BenchArgs, terminal: &'a Terminal) -> Result<Self, Failure> {
        let keeps_pictures = args.keeps_fixed_pictures();
        if args.update_expected.is_some() && !keeps_pictures {
            return Err(Failure::usage(
                "--update-expected: other flags change the pictures of the fixed scenes",
            ));
        }
        let picture = args.picture.as_deref();
        picture.map(picture_format).transpose()?;
        let results = [("picture", picture), ("report", args.json.as_deref())];
        let results = results.map(|(name, path)| path.map(|path| (name, Target::new(path))));
        let results: Vec<_> = results
            .iter()
            .flatten()
            .map(|(name, target)| (*name, target))
            .collect();
        check_distinct(&results)?;
        for (_, target) in results {
            target.check(args.write.overwrite)?;
        }
        let recording = args.update_expected.is_some();
        Ok(Self {
            args,
            terminal,
            course: Course {
                frames: if recording { 1 } else { args.frames },
                warm_up: if recording { 0 } else { args.warm_up },
                orbit: args.orbit,
            },
            variants: scenes::variants(args),
            table: Table::new(&scenes::scenes(args)),
            expected: (keeps_pictures && !recording)
                .then(|| Expected::recorded(args.expected.as_deref()))
                .transpose()?,
        })
    }

    /// Runs all cases, and prints each when it is done.
    fn run(&self) -> Result<Report, Failure> {
        let mut cases = Vec::new();
        self.print(&self.table.head())?;
        for scene in scenes::scenes(self.args) {
            let keys = of_input(&self.args.read, &scene.reference);
            let mut input = input::load(&keys, self.terminal.reads(self.args.read.rules()))?;
            if let Some(axis) = Up::of(&input).said(&scene.reference, self.terminal) {
                input.turn(axis)?;
            }
            for variant in &self.variants {
                let subject = self.subject(&scene, &input, variant)?;
                let (case, measured) = self.case(&scene, variant, &subject)?;
                if cases.is_empty() {
                    self.write_picture(&measured)?;
                }
                self.print(&self.table.line(&case))?;
                cases.push(case);
            }
        }
        let mut threads: Vec<usize> = cases.iter().map(|case| case.threads).collect();
        threads.sort_unstable();
        threads.dedup();
        Ok(Report {
            version: env!("CARGO_PKG_VERSION"),
            simd: cases
                .first()
                .map_or_else(String::new, |case| case.statistics.simd.to_owned()),
            processors: scenes::processors(),
            threads,
            course: self.course,
            cases,
        })
    }

    fn subject(&self, scene: &SceneChoice, input: &Input, variant: &Variant) -> Result<Subject, Failure> {
        let args = self.args;
        let method = MethodArgs {
            classification: variant.classification,
            ..args.method.clone()
        };
        let settings = method.keys(None);
        let window = || Window::new(input, &args.look);
        let look = match variant.look {
            LookName::Opaque => Look::from(window().opaque().during(Step::Usage)?),
            LookName::Translucent => Look::from(window().translucent().during(Step::Usage)?),
            LookName::AsRender => {
                let keys = args.item_keys(&scene.reference);
                look::resolve(
                    &keys,
                    input,
                    settings.compositing(),
                    self.terminal.reads(self.args.read.rules()),
                )?
            }
        };
        let size = match args.size {
            Some(size) => size,
            None => ImageSize::new(scene.side, scene.side).during(Step::Usage)?,
        };
        let settings = settings.resolve(Some(size), look.wishes)?;
        let projection = variant.projection.unwrap_or(ProjectionName::Perspective);
        let around = around(input.volume.grid(), projection, size.aspect()).during(Step::Usage)?;
        let camera = CameraKeys::from(&args.camera).over(&CameraKeys::from(&CameraPose::from(&around)));
        let item = Item::volume(Arc::clone(&input.volume), look.transfer_function.clone());
        let outlines = || outline(&item, camera.fit.unwrap_or_default());
        let preferred = input.sample.and_then(|sample| sample.preferred_view());
        let surroundings = Surroundings::of_outline(outlines, size.aspect()).preferring(preferred);
        let camera = camera.resolve(&surroundings)?;
        Ok(Subject {
            scene: Scene::new(Arc::clone(&input.volume), look.transfer_function),
            camera,
            settings,
            threads: variant.threads,
        })
    }

    fn case(
        &self,
        scene: &SceneChoice,
        variant: &Variant,
        subject: &Subject,
    ) -> Result<(CaseReport, Measured), Failure> {
        let classification = subject.settings.method.classification();
        let projection = subject.camera.projection().into();
        let name = scenes::case_name(&scene.name, variant.look, classification, projection);
        process::reset_peak_memory();
        let measured = {
            let bar = self
                .terminal
                .progress(format!("{name}, {} threads", subject.threads));
            measure(subject, &self.course, &|share| bar.set(share))?
        };
        let peak_memory_bytes = process::peak_memory();
        let picture = Checksum::new(&measured.first.image);
        let check = match &self.expected {
            Some(expected) => expected.check(&name, &picture),
            None => Check::Unchecked,
        };
        let single = subject.scene.single_volume().during(Step::Render)?;
        let case = CaseReport {
            name,
            input: scene.reference.clone(),
            dims: single.volume.grid().dims(),
            look: variant.look,
            threads: subject.threads,
            settings: subject.settings,
            camera: CameraPose::from(&subject.camera),
            transfer_function: single.transfer_function.clone(),
            median_wall_ms: median(&measured.wall_ms),
            median_cpu_ms: measured.cpu_ms.as_deref().map(median),
            wall_ms: measured.wall_ms.clone(),
            cpu_ms: measured.cpu_ms.clone(),
            statistics: measured.statistics.clone(),
            peak_memory_bytes,
            picture,
            check,
        };
        Ok((case, measured))
    }

    fn write_picture(&self, measured: &Measured) -> Result<(), Failure> {
        let Some(path) = &self.args.picture else {
            return Ok(());
        };
        let bytes = encode_frame(&measured.first, picture_format(path)?, Some(CHARCOAL), &[])?;
        Target::File(path.clone()).write(&bytes, self.args.write.overwrite)
    }

    /// Prints a line of the table, unless the standard output is for the JSON.
    fn print(&self, line: &str) -> Result<(), Failure> {
        if self.args.json.as_deref() == Some(Path::new("-")) {
            return Ok(());
        }
        Target::Stdout.write(format!("{line}\n").as_bytes(), false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_fixed_cases_are_recorded_and_no_others() {
        let recorded = Expected::recorded(None)
            .map_err(|failure| format!("{failure:?}"))
            .unwrap();
        let mut fixed = scenes::fixed_names();
        fixed.sort();
        assert_eq!(recorded.names(), fixed);
    }
}
