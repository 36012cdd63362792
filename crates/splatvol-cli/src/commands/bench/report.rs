//! Report of the measurements: a table for people, JSON for programs.

use serde::Serialize;
use splatvol::{RenderSettings, RenderStatistics, StageSeconds, TransferFunction};
use splatvol_document::{CameraPose, Document};

use super::checksum::{Check, Checksum};
use super::measure::Course;
use super::scenes::SceneChoice;
use crate::args::LookName;

/// All measurements of a run.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    /// Version of splatvol.
    pub(super) version: &'static str,
    /// SIMD level that the engine chose.
    pub(super) simd: String,
    /// Logical processors.
    pub(super) processors: usize,
    /// Numbers of threads that cases were run with.
    pub(super) threads: Vec<usize>,
    /// How the camera moved.
    #[serde(flatten)]
    pub(super) course: Course,
    /// In the order in which they ran.
    pub(super) cases: Vec<CaseReport>,
}

/// One case: everything that makes its picture, and what it took.
#[derive(Debug, Serialize)]
pub(super) struct CaseReport {
    /// Scene, look, classification and projection.
    pub(super) name: String,
    /// The file or the earlier picture, as `splatvol render` takes it.
    pub(super) input: String,
    /// Samples along x, y, z of a volume that is shown alone.
    pub(super) dims: Option<[usize; 3]>,
    pub(super) look: LookName,
    pub(super) threads: usize,
    pub(super) settings: RenderSettings,
    /// Of the first measured frame.
    pub(super) camera: CameraPose,
    /// Of a volume that is shown alone.
    pub(super) transfer_function: Option<TransferFunction>,
    /// All that the picture is made of, as a scene file has it.
    pub(super) document: Document,
    pub(super) median_wall_ms: f64,
    pub(super) median_cpu_ms: Option<f64>,
    /// Wall clock per frame.
    pub(super) wall_ms: Vec<f64>,
    /// Processor time per frame, user and system, all threads.
    pub(super) cpu_ms: Option<Vec<f64>>,
    /// Of the median frame, by wall clock.
    pub(super) statistics: RenderStatistics,
    /// Largest resident size of the process during the case.
    pub(super) peak_memory_bytes: Option<u64>,
    /// Of the first measured frame.
    pub(super) picture: Checksum,
    #[serde(flatten)]
    pub(super) check: Check,
}

impl Report {
    /// Errors of the pictures.
    pub(super) fn complaints(&self) -> Vec<String> {
        let unexpected = self.cases.iter().filter_map(CaseReport::complaint);
        // Cases with the same name differ only in their threads.
        let variable = self.cases.iter().filter_map(|case| {
            let first = self.cases.iter().find(|other| other.name == case.name)?;
            (first.picture.sha256 != case.picture.sha256).then(|| {
                let [few, many] = [first.threads, case.threads];
                format!("{}: {few} and {many} threads make different pictures", case.name)
            })
        });
        unexpected.chain(variable).collect()
    }
}

impl CaseReport {
    fn complaint(&self) -> Option<String> {
        match self.check {
            Check::Differs { difference, cell } => Some(format!(
                "{}, {} threads: a cell's mean differs by {difference:.4} (column {}, row {} of 8)",
                self.name, self.threads, cell[0], cell[1]
            )),
            Check::Unrecorded => Some(format!("{}: nothing is recorded", self.name)),
            Check::Agrees { .. } | Check::Unchecked => None,
        }
    }
}

/// The table, whose lines can be printed as soon as their case is done.
pub(super) struct Table {
    name_width: usize,
}

impl Table {
    /// A table of cases of these scenes.
    pub(super) fn new(scenes: &[SceneChoice]) -> Self {
        const LONGEST: &str = "/translucent/post/orthographic";
        let widths = scenes.iter().map(|scene| scene.name.chars().count());
        Self {
            name_width: widths.max().unwrap_or(0) + LONGEST.len(),
        }
    }

    /// The line above the cases.
    pub(super) fn head(&self) -> String {
        let stages = stage_shares(&StageSeconds::default(), 1).map(|(stage, _)| format!("{stage:>8}"));
        format!(
            "{:<width$} threads   wall ms  [min..max]           cpu ms{}  picture",
            "case",
            stages.join(""),
            width = self.name_width
        )
    }

    /// The line of a case.
    pub(super) fn line(&self, case: &CaseReport) -> String {
        let [least, most] = [f64::min, f64::max].map(|pick| case.wall_ms.iter().copied().reduce(pick));
        let range = format!("[{:.1}..{:.1}]", least.unwrap_or(0.0), most.unwrap_or(0.0));
        let cpu = case
            .median_cpu_ms
            .map_or("-".to_owned(), |cpu| format!("{cpu:.1}"));
        let shares = stage_shares(&case.statistics.seconds, case.threads);
        let shares = shares.map(|(_, share)| format!("{:>6.1} %", 100.0 * share));
        let picture = match case.check {
            Check::Agrees { .. } => "as recorded",
            Check::Differs { .. } => "DIFFERS",
            Check::Unrecorded => "not recorded",
            Check::Unchecked => &case.picture.sha256[..12],
        };
        format!(
            "{:<width$} {:>7} {:>9.1}  {range:<18} {cpu:>8}{}  {picture}",
            case.name,
            case.threads,
            case.median_wall_ms,
            shares.join(""),
            width = self.name_width
        )
    }
}

/// Stages in the table, with their shares of the threads' time in a frame; `rest` is waiting and what is not timed.
fn stage_shares(seconds: &StageSeconds, threads: usize) -> [(&'static str, f64); 5] {
    // Their seconds are sums over threads.
    let [splat, shade] = [seconds.splat, seconds.shade].map(|sum| sum / threads.max(1) as f64);
    let prepare = seconds.prefilter + seconds.classify;
    let rest = (seconds.total - prepare - seconds.bin - splat - shade).max(0.0);
    let share = |part: f64| part / seconds.total.max(f64::MIN_POSITIVE);
    [
        ("prepare", share(prepare)),
        ("bin", share(seconds.bin)),
        ("splat", share(splat)),
        ("shade", share(shade)),
        ("rest", share(rest)),
    ]
}

/// What a frame's passes took on the device, below the line of its case.
pub(super) fn passes(statistics: &RenderStatistics) -> String {
    let passes = statistics.passes.iter();
    let each: Vec<String> = passes
        .map(|own| format!("{} {:.3}", own.pass, 1e3 * own.seconds))
        .collect();
    format!("  on the device, ms: {}", each.join(", "))
}

/// Lines of what a frame counts, below that of its case.
pub(super) fn counts(statistics: &RenderStatistics) -> String {
    let per = |part: u64, whole: u64| part as f64 / whole.max(1) as f64;
    let RenderStatistics {
        bricks,
        searched_bricks,
        solved_bricks,
        active_bricks,
        opened_bricks,
        voxels,
        activated_vectors,
        splatted_vectors,
        shaded_vectors,
        shaded_pixels,
        ..
    } = *statistics;
    format!(
        "  reused: the search of {} bricks of {bricks}, coefficients of {} of {active_bricks} visible\n  \
         bricks {opened_bricks} opened of {active_bricks} visible\n  \
         voxels {voxels} splatted, {:.2} of the lanes of {activated_vectors} vectors; {splatted_vectors} vectors added to, \
         {:.1} per voxel\n  \
         pixels {shaded_pixels} hold material, {:.2} of the lanes of {shaded_vectors} vectors shaded",
        bricks.saturating_sub(searched_bricks),
        active_bricks.saturating_sub(solved_bricks),
        per(voxels, 16 * activated_vectors),
        per(splatted_vectors, voxels),
        per(shaded_pixels, 16 * shaded_vectors),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_shares_of_lanes() {
        let statistics = RenderStatistics {
            bricks: 9,
            searched_bricks: 2,
            solved_bricks: 1,
            active_bricks: 3,
            opened_bricks: 4,
            voxels: 800,
            activated_vectors: 100,
            splatted_vectors: 7200,
            shaded_vectors: 10,
            shaded_pixels: 40,
            ..RenderStatistics::default()
        };
        let expected = "  reused: the search of 7 bricks of 9, coefficients of 2 of 3 visible
  bricks 4 opened of 3 visible
  voxels 800 splatted, 0.50 of the lanes of 100 vectors; 7200 vectors added to, 9.0 per voxel
  pixels 40 hold material, 0.25 of the lanes of 10 vectors shaded";
        assert_eq!(counts(&statistics), expected);
        assert!(counts(&RenderStatistics::default()).ends_with("0.00 of the lanes of 0 vectors shaded"));
    }

    #[test]
    fn passes_are_listed_with_milliseconds() {
        let pass = |name: &str, seconds| splatvol::PassSeconds {
            pass: name.to_owned(),
            seconds,
        };
        let statistics = RenderStatistics {
            passes: vec![pass("cull", 1e-5), pass("march", 0.0123)],
            ..RenderStatistics::default()
        };
        assert_eq!(
            passes(&statistics),
            "  on the device, ms: cull 0.010, march 12.300"
        );
    }

    #[test]
    fn shares_add_up_to_the_frame() {
        let seconds = StageSeconds {
            prefilter: 0.5,
            classify: 0.25,
            bin: 0.25,
            splat: 4.0,
            shade: 2.0,
            total: 5.0,
            ..StageSeconds::default()
        };
        let shares = stage_shares(&seconds, 2).map(|(_, share)| share);
        assert_eq!(shares, [0.15, 0.05, 0.4, 0.2, 0.2]);
    }
}
