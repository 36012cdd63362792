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
mod shown;

use std::path::Path;

use splatvol_document::{CameraPose, Picture};

use self::checksum::{Check, Checksum, Expected};
use self::measure::{Course, Measured, Subject, measure, median};
use self::report::{CaseReport, Report, Table, counts};
use self::scenes::{SceneChoice, Variant};
use self::shown::Shown;
use crate::args::BenchArgs;
use crate::commands::outputs::encode_with_bits;
use crate::failure::{During, Failure, Step};
use crate::output::{Target, check_distinct, picture_format};
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
        let picture = args.first_frame.as_deref();
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
                slide: args.slide,
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
            let shown = Shown::read(&scene, self.args, self.terminal)?;
            for variant in &self.variants {
                let picture = shown.picture(variant)?;
                let (case, measured) = self.case(&scene, (&picture, variant))?;
                if cases.is_empty() {
                    self.write_picture(&picture, &measured)?;
                }
                self.print(&self.table.line(&case))?;
                if !case.statistics.passes.is_empty() {
                    self.print(&report::passes(&case.statistics))?;
                }
                if self.args.counts {
                    self.print(&counts(&case.statistics))?;
                }
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

    fn case(
        &self,
        scene: &SceneChoice,
        (shown, variant): (&Picture, &Variant),
    ) -> Result<(CaseReport, Measured), Failure> {
        let classification = shown.settings.method.classification();
        let projection = shown.camera.projection().into();
        let name = scenes::case_name(&scene.name, variant.look, classification, projection);
        let subject = Subject {
            scene: shown.scene.clone(),
            cameras: match &shown.sub_frames[..] {
                [] => vec![shown.camera],
                several => several.to_vec(),
            },
            settings: shown.settings,
            threads: variant.threads,
            engine: self.args.engine.into(),
        };
        process::reset_peak_memory();
        let measured = {
            let bar = self
                .terminal
                .progress(format!("{name}, {} threads", subject.threads));
            measure(&subject, &self.course, &|share| bar.set(share))?
        };
        let peak_memory_bytes = process::peak_memory();
        let picture = Checksum::new(&measured.first.image);
        let check = match &self.expected {
            Some(expected) => expected.check(&name, &picture),
            None => Check::Unchecked,
        };
        let single = shown.scene.single_volume().ok();
        let case = CaseReport {
            name,
            input: scene.input.clone().unwrap_or_else(|| scene.name.clone()),
            dims: single.as_ref().map(|single| single.volume.grid().dims()),
            look: variant.look,
            threads: subject.threads,
            settings: subject.settings,
            camera: CameraPose::from(&shown.camera),
            transfer_function: single.map(|single| single.transfer_function.clone()),
            document: shown.document.clone(),
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

    fn write_picture(&self, shown: &Picture, measured: &Measured) -> Result<(), Failure> {
        let Some(path) = &self.args.first_frame else {
            return Ok(());
        };
        let format = (picture_format(path)?, shown.bits());
        let bytes = encode_with_bits(&measured.first, format, shown.background(), &[])?;
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
