//! `splatvol info`: what a volume is, and how it would be shown.

mod data;
mod kernel;

use std::fmt::Write;

use glam::DVec3;
use serde::Serialize;
use splatvol::{Grid, TransferFunction};
use splatvol_document::ChunkRules;
use splatvol_document::input::{self, Input};
use splatvol_document::upright::Up;

use crate::args::{InfoArgs, of_input};
use crate::failure::{During, Failure, Step};
use crate::output::Target;
use crate::terminal::Terminal;

pub(crate) fn run(args: &InfoArgs, terminal: &Terminal) -> Result<(), Failure> {
    let Some(name) = &args.input else {
        return kernel::run(args);
    };
    if let Some(text) = data::text(name, args, terminal)? {
        return Target::Stdout.write(text.as_bytes(), false);
    }
    let mut rules = args.read.rules();
    // A huge image is described by its metadata and a coarse level.
    rules.chunks = Some(ChunkRules {
        memory: splatvol_io::memory::granted() / 2,
        holes: false,
        whole_if_it_fits: false,
    });
    let mut input = input::load(&of_input(&args.read, name), terminal.reads(rules))?;
    let stored = input.volume.finest_grid().clone();
    let up = Up::of(&input);
    // The choice of a transfer function depends on the axes in which a volume is rendered.
    input.turn(up.axis)?;
    let report = Report::new(name, &input, (&stored, up), usize::from(args.bins));
    let text = if args.json {
        serde_json::to_string_pretty(&report).during(Step::Output)? + "\n"
    } else {
        report.text()
    };
    Target::Stdout.write(text.as_bytes(), false)
}

/// All that is known about a volume.
#[derive(Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
struct Report {
    kind: &'static str,
    input: String,
    format: String,
    stored_type: String,
    files: Vec<std::path::PathBuf>,
    dims: [usize; 3],
    sample_type: &'static str,
    memory_bytes: usize,
    slope: f64,
    intercept: f64,
    spacing: [f64; 3],
    unit: &'static str,
    origin: [f64; 3],
    /// World directions of the voxel axes.
    directions: [[f64; 3]; 3],
    orientation_code: String,
    orientation: String,
    up: Up,
    min: f64,
    max: f64,
    mean: f64,
    missing_samples: usize,
    /// Names of channels, number of times, dims of levels, series: if there are several to choose from.
    channels: Vec<String>,
    times: usize,
    levels: Vec<[usize; 3]>,
    series: Vec<String>,
    /// Samples along x, y, z of the level whose values are described, where that is not the finest.
    #[serde(skip_serializing_if = "Option::is_none")]
    values_of: Option<[usize; 3]>,
    histogram: Vec<u64>,
    transfer_function: TransferFunctionReport,
    warnings: Vec<String>,
}

/// Automatic choices, and their reasons.
#[derive(Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
struct TransferFunctionReport {
    reason: String,
    #[serde(flatten)]
    curves: TransferFunction,
}

impl Report {
    /// Of a volume and the grid that it was stored on.
    fn new(name: &str, input: &Input, (grid, up): (&Grid, Up), bins: usize) -> Self {
        let (volume, description) = (&input.volume, &input.description);
        let statistics = volume.statistics();
        let direction = grid.direction();
        let (automatic, choice) = TransferFunction::automatic(volume, None);
        let (curves, reason) = match input.sample.and_then(|s| s.default_transfer_function().ok()) {
            Some(own) => (own, "the sample brings its own".to_owned()),
            None => (automatic, choice.reason),
        };
        let (sample_type, bytes) = match volume.chunks() {
            Some(chunks) => (chunks.layout(0).element.name(), chunks.layout(0).element.size()),
            None => (volume.samples().type_name(), volume.samples().bytes_per_sample()),
        };
        Self {
            kind: "volume",
            input: name.to_owned(),
            format: description.format.clone(),
            stored_type: description.stored_type.clone(),
            files: description.files.clone(),
            dims: grid.dims(),
            sample_type,
            memory_bytes: grid.sample_count() * bytes,
            slope: volume.rescale().slope,
            intercept: volume.rescale().intercept,
            spacing: grid.spacing().to_array(),
            unit: volume.unit().symbol(),
            origin: grid.origin().to_array(),
            directions: [direction.x_axis, direction.y_axis, direction.z_axis].map(|axis| axis.to_array()),
            orientation_code: orientation_code(grid),
            orientation: description.orientation.clone(),
            up,
            min: statistics.min,
            max: statistics.max,
            mean: statistics.mean,
            missing_samples: statistics.non_finite,
            channels: description.channels.clone(),
            times: description.times,
            levels: description.levels.clone(),
            series: description.series.clone(),
            values_of: Some(volume.grid().dims()).filter(|dims| *dims != grid.dims()),
            histogram: volume.histogram(bins),
            transfer_function: TransferFunctionReport { reason, curves },
            warnings: description.warnings.clone(),
        }
    }

    fn text(&self) -> String {
        let mut text = String::new();
        let mut row = |label: &str, value: String| {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{label:<18} {value}");
        };
        let list = |values: &[f64]| values.iter().map(|v| tidy(*v)).collect::<Vec<_>>().join(", ");
        let samples: usize = self.dims.iter().product();
        row("input", self.input.clone());
        row("format", self.format.clone());
        row("dims", self.dims.map(|n| n.to_string()).join(" x "));
        row("stored type", self.stored_type.clone());
        row(
            "memory",
            format!("{} ({} per sample)", bytes(self.memory_bytes), self.sample_type),
        );
        if (self.slope, self.intercept) != (1.0, 0.0) {
            row(
                "rescale",
                format!("{} * stored + {}", tidy(self.slope), tidy(self.intercept)),
            );
        }
        row("spacing", format!("{} {}", list(&self.spacing), self.unit));
        let extent: Vec<f64> = self
            .spacing
            .iter()
            .zip(self.dims)
            .map(|(s, n)| s * n as f64)
            .collect();
        row("extent", format!("{} {}", list(&extent), self.unit));
        row("origin", list(&self.origin));
        let directions = self.directions.map(|axis| format!("({})", list(&axis)));
        row("directions", directions.join(" "));
        row(
            "orientation",
            format!("{} ({})", self.orientation_code, self.orientation),
        );
        row("up", format!("{} ({})", self.up.axis.name(), self.up.reason));
        if let Some(dims) = self.values_of {
            let level = dims.map(|n| n.to_string()).join(" x ");
            row("values", format!("of the level {level}: the finest was not read"));
        }
        row("range", format!("{} to {}", tidy(self.min), tidy(self.max)));
        row("mean", tidy(self.mean));
        let share = 100.0 * self.missing_samples as f64 / samples as f64;
        row(
            "missing samples",
            match self.missing_samples {
                0 => "none".to_owned(),
                count => format!("{count} ({share:.2} %)"),
            },
        );
        for channel in &self.channels {
            row("channel", channel.clone());
        }
        if self.times > 1 {
            row("times", self.times.to_string());
        }
        for (level, dims) in self.levels.iter().enumerate() {
            row(
                "level",
                format!("{level}: {}", dims.map(|n| n.to_string()).join(" x ")),
            );
        }
        for series in &self.series {
            row("series", series.clone());
        }
        row("transfer function", self.transfer_function.reason.clone());
        for warning in &self.warnings {
            row("warning", warning.clone());
        }
        text.push_str("histogram\n");
        text.push_str(&bars(&self.histogram, [self.min, self.max]));
        text
    }
}

/// Rows of text bars, as long as the logarithm of the counts: scans are mostly air.
fn bars(counts: &[u64], [low, high]: [f64; 2]) -> String {
    const WIDTH: f64 = 44.0;
    let height = |count: u64| (count as f64 + 1.0).ln();
    let most = counts
        .iter()
        .map(|&c| height(c))
        .fold(f64::MIN_POSITIVE, f64::max);
    let step = (high - low) / counts.len() as f64;
    let mut text = String::new();
    for (i, &count) in counts.iter().enumerate() {
        let length = (WIDTH * height(count) / most).round() as usize;
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:>14}  {:<44}  {count}",
            tidy(low + step * i as f64),
            "#".repeat(length)
        );
    }
    text
}

/// The directions of the voxel axes as letters: `RAS` means x to the right, y forward (anterior), z up
/// (superior).
fn orientation_code(grid: &Grid) -> String {
    let direction = grid.direction();
    [direction.x_axis, direction.y_axis, direction.z_axis]
        .into_iter()
        .map(letter)
        .collect()
}

fn letter(axis: DVec3) -> char {
    let size = axis.abs();
    let letters = if size.x >= size.y && size.x >= size.z {
        (axis.x, ['L', 'R'])
    } else if size.y >= size.z {
        (axis.y, ['P', 'A'])
    } else {
        (axis.z, ['I', 'S'])
    };
    letters.1[usize::from(letters.0 > 0.0)]
}

/// At most six significant digits, without trailing zeros.
pub(super) fn tidy(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        return "0".to_owned();
    }
    if !(1e-4..1e9).contains(&size) {
        return format!("{value:.5e}");
    }
    let decimals = (5 - size.log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

fn bytes(count: usize) -> String {
    let mut size = count as f64;
    for unit in ["B", "KiB", "MiB"] {
        if size < 1024.0 {
            return format!("{} {unit}", tidy((10.0 * size).round() / 10.0));
        }
        size /= 1024.0;
    }
    format!("{size:.2} GiB")
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat3;

    #[test]
    fn numbers_are_short_and_right() {
        for (value, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (-1024.0, "-1024"),
            (0.937_500_1, "0.9375"),
            (123_456_789.0, "123456789"),
            (1.0 / 3.0, "0.333333"),
            (2.5e-7, "2.50000e-7"),
        ] {
            assert_eq!(tidy(value), text);
        }
        assert_eq!(bytes(512), "512 B");
        assert_eq!(bytes(33_554_432), "32 MiB");
    }

    #[test]
    fn orientation_letters_follow_the_axes() {
        let grid = |columns: [DVec3; 3]| {
            let direction = DMat3::from_cols(columns[0], columns[1], columns[2]);
            Grid::new([2, 2, 2], DVec3::ZERO, DVec3::ONE, direction).unwrap()
        };
        assert_eq!(orientation_code(&grid([DVec3::X, DVec3::Y, DVec3::Z])), "RAS");
        assert_eq!(orientation_code(&grid([-DVec3::Y, DVec3::Z, DVec3::X])), "PSR");
    }

    #[test]
    fn bars_grow_with_the_counts() {
        let text = bars(&[1000, 0, 10], [0.0, 3.0]);
        let lengths: Vec<_> = text.lines().map(|line| line.matches('#').count()).collect();
        assert_eq!(lengths[0], 44);
        assert_eq!(lengths[1], 0);
        assert!(lengths[2] > 5 && lengths[2] < 44);
    }
}
