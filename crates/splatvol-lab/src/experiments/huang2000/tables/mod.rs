//! Errors of footprint tables: section 5.1, Fig. 3 and 4.
//!
//! A table holds the footprint `q` at n places from the centre to the edge, evenly in the distance or in its square, in
//! levels of `q(0) / 255` or `q(0) / 65535`. A pixel takes the nearest entry. So it errs by at most half the difference
//! of two neighbours plus half a level.

mod findings;
mod show;

use splatvol::Kernel;
use splatvol::radial::{AnySection, FootprintTable, Precision, RadialKernel, Spacing, TableSettings};
use splatvol_testing::Random;

use crate::{Experiment, LabError, Outcome, Workbench};
use findings::{bound_findings, mean_findings, quantisation_findings};
use show::{numbers, plots};

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "huang2000-tables",
    paper: "huang2000",
    title: "Errors of footprint tables by their size and precision",
    figures: &["Fig. 3", "Fig. 4", "Section 5.1"],
    about: "The paper fills tables of a Gaussian of radius 2 in 128 sections, and looks for the largest difference of \
neighbouring entries: half of it bounds the error of point sampling. Half a level of 8 or 16 bits comes on top.

We do the same with the program's own tables, for 32 to 1024 entries. Errors are shares of the whole footprint's centre, and \
bounds are in 256ths of it, as in the paper. Besides the bounds we measure: the largest error over a fine sample of \
distances, and the mean error over pixels, which are even over the footprint's disc.

The paper does not tell the Gaussian's width. We take exp(-1.38 r²), which its authors gave for the kernel of radius 2 in \
1998. A wider Gaussian is flatter at the centre, where tables by squared distance err most.",
    run,
};

/// The papers' kernel of radius 2 (mueller1998 section 4.2).
pub(super) const KERNEL: Kernel = Kernel::Gaussian {
    sigma: 0.602,
    radius: 2.0,
};
const SIZES: [usize; 6] = [32, 64, 128, 256, 512, 1024];
const SPACINGS: [(&str, Spacing); 2] = [("squared", Spacing::Squared), ("linear", Spacing::Linear)];
/// The paper's levels in a footprint's centre.
const LEVELS: f64 = 256.0;
/// A sheet a voxel thick, in support radii.
const SHEET: f32 = 0.5;

fn table(
    kernel: Kernel,
    entries: usize,
    spacing: Spacing,
    precision: Precision,
) -> Result<FootprintTable, LabError> {
    let settings = TableSettings {
        entries,
        precision,
        spacing,
        sections: 128,
    };
    Ok(FootprintTable::new(kernel, settings)?)
}

/// Half the largest difference of neighbouring entries, a share of the whole footprint's centre, over all parts of the
/// kernel of a thickness (support radii; 2 for everything in front of a section).
fn sampling_bound(
    kernel: Kernel,
    (entries, spacing): (usize, Spacing),
    thickness: f32,
) -> Result<f64, LabError> {
    let table = table(kernel, entries, spacing, Precision::F32)?;
    let mut largest = 0.0_f64;
    for section in 1..=128_u8 {
        let depth = f32::from(section) / 64.0 - 1.0;
        if let AnySection::F32(part) = table.section(depth - thickness, depth) {
            let [front, back] = part.rows();
            let part: Vec<f64> = back.iter().zip(front).map(|(b, f)| f64::from(b - f)).collect();
            let differences = part.windows(2).map(|pair| (pair[1] - pair[0]).abs());
            largest = differences.fold(largest, f64::max);
        }
    }
    Ok(0.5 * largest)
}

/// Largest quantisation error of an entry, a share of the whole footprint's centre.
fn quantisation(entries: usize, precision: Precision) -> Result<f64, LabError> {
    let exact = table(KERNEL, entries, Spacing::Squared, Precision::F32)?;
    let coarse = table(KERNEL, entries, Spacing::Squared, precision)?;
    let peak = RadialKernel::new(KERNEL).line_integral(0.0);
    let last = (entries - 1) as f32;
    let mut largest = 0.0_f64;
    for section in 1..=128_u8 {
        let depth = f32::from(section) / 64.0 - 1.0;
        for entry in 0..entries {
            let at = entry as f32 / last;
            let value = |table: &FootprintTable| f64::from(table.between(at, -1.0, depth));
            largest = largest.max((value(&exact) - value(&coarse)).abs() / peak);
        }
    }
    Ok(largest)
}

/// A pixel of a footprint: squared distance in support radii, and the part of the kernel.
struct Pixel {
    rho2: f64,
    front: f64,
    back: f64,
}

/// Pixels spread evenly over the disc: of whole footprints, or of sheets that cut kernels anywhere, on the table's
/// sections.
fn pixels(count: usize, sheets: bool) -> Vec<Pixel> {
    let mut random = Random::new(2000);
    let pixel = |_| {
        let rho2 = random.unit();
        let front = (random.range(-80.0, 64.0)).floor() / 64.0;
        match sheets {
            true => Pixel {
                rho2,
                front: front.max(-1.0),
                back: (front + f64::from(SHEET)).min(1.0),
            },
            false => Pixel {
                rho2,
                front: -1.0,
                back: 1.0,
            },
        }
    };
    (0..count).map(pixel).collect()
}

/// Mean and largest error over pixels, in 256ths of the whole footprint's centre.
fn errors(table: &FootprintTable, pixels: &[Pixel]) -> [f64; 2] {
    let kernel = RadialKernel::new(KERNEL);
    let (support, scale) = (kernel.support(), LEVELS / kernel.line_integral(0.0));
    let error = |pixel: &Pixel| {
        let part = |depth: f64| kernel.partial_line_integral(pixel.rho2 * support * support, depth * support);
        let exact = part(pixel.back) - part(pixel.front);
        let found = table.between(pixel.rho2 as f32, pixel.front as f32, pixel.back as f32);
        scale * (f64::from(found) - exact).abs()
    };
    let all = pixels.iter().map(error);
    let (sum, largest) = all.fold((0.0, 0.0_f64), |(sum, most), e| (sum + e, most.max(e)));
    [sum / pixels.len() as f64, largest]
}

/// Mean error of a table that rounds down: entries to whole levels, and distances to the entry before.
fn mean_error_rounding_down(entries: usize, pixels: &[Pixel]) -> f64 {
    let kernel = RadialKernel::new(KERNEL);
    let (support2, peak) = (kernel.support().powi(2), kernel.line_integral(0.0));
    let share = |rho2: f64| kernel.line_integral(rho2 * support2) / peak;
    let error = |pixel: &Pixel| {
        let entry = (pixel.rho2 * entries as f64).floor() / entries as f64;
        (LEVELS * share(pixel.rho2) - (LEVELS * share(entry)).floor()).abs()
    };
    pixels.iter().map(error).sum::<f64>() / pixels.len() as f64
}

/// Largest difference between a place halfway between two entries and the entries beside it, by squared distance,
/// levels.
fn largest_halfway(entries: usize) -> f64 {
    let kernel = RadialKernel::new(KERNEL);
    let (support2, scale) = (kernel.support().powi(2), LEVELS / kernel.line_integral(0.0));
    let at = |position: f64| scale * kernel.line_integral(position / (entries - 1) as f64 * support2);
    let farthest = |entry: usize| {
        let [here, half, next] = [0.0, 0.5, 1.0].map(|more| at(entry as f64 + more));
        (here - half).abs().max((half - next).abs())
    };
    (0..entries - 1).map(farthest).fold(0.0, f64::max)
}

/// Errors of a table size.
struct Row {
    entries: usize,
    /// Sampling error by squared distance and by distance: half the largest difference of neighbours.
    sampling: [f64; 2],
    quantisation: [f64; 2],
    /// Largest measured error of 8 bits by spacing, levels.
    largest: [f64; 2],
    /// Mean error of 8 bits by spacing, levels.
    mean: [f64; 2],
}

impl Row {
    /// Bound of the total error in levels.
    fn bound(&self, spacing: usize, precision: usize) -> f64 {
        LEVELS * (self.sampling[spacing] + self.quantisation[precision])
    }
}

fn measure(entries: usize, pixels: &[Pixel]) -> Result<Row, LabError> {
    let mut row = Row {
        entries,
        sampling: [0.0; 2],
        quantisation: [
            quantisation(entries, Precision::U8)?,
            quantisation(entries, Precision::U16)?,
        ],
        largest: [0.0; 2],
        mean: [0.0; 2],
    };
    for (index, (_, spacing)) in SPACINGS.into_iter().enumerate() {
        row.sampling[index] = sampling_bound(KERNEL, (entries, spacing), 2.0)?;
        let table = table(KERNEL, entries, spacing, Precision::U8)?;
        [row.mean[index], row.largest[index]] = errors(&table, pixels);
    }
    Ok(row)
}

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let whole = pixels(bench.choose(200_000, 50_000), false);
    let mut rows = Vec::new();
    for (index, entries) in SIZES.into_iter().enumerate() {
        bench.step(index, SIZES.len(), &format!("{entries} entries"));
        rows.push(measure(entries, &whole)?);
    }
    let mut outcome = Outcome::default();
    quantisation_findings(&mut outcome, &rows);
    bound_findings(&mut outcome, &rows)?;
    mean_findings(&mut outcome, &rows, &whole)?;
    outcome.tables.push(numbers(&rows));
    outcome.plots = plots(&rows);
    Ok(outcome)
}
