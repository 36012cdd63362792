//! `splatvol info --kernel`: what a reconstruction kernel does to the data.

use std::fmt::Write;

use serde::Serialize;
use splatvol::radial::{KernelAnalysis, RESPONSE_FREQUENCIES, RadialKernel, analyse};
use splatvol::{Kernel, RenderSettings};
use splatvol_document::keys::SettingKeys;
use splatvol_document::settings::kernel;

use super::tidy;
use crate::args::InfoArgs;
use crate::failure::{During, Failure, Step};
use crate::output::Target;

pub(super) fn run(args: &InfoArgs) -> Result<(), Failure> {
    let kernel = kernel::resolve(
        &SettingKeys::from(&args.kernel),
        RenderSettings::default().method.kernel(),
    )?;
    kernel.validate().during(Step::Usage)?;
    let report = Report::new(kernel, usize::from(args.bins));
    let text = if args.json {
        serde_json::to_string_pretty(&report).during(Step::Output)? + "\n"
    } else {
        report.text(kernel)
    };
    Target::Stdout.write(text.as_bytes(), false)
}

/// A kernel's properties. Lengths are voxels, frequencies cycles per voxel.
#[derive(Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
struct Report {
    kernel: Kernel,
    support: f64,
    sigma: f64,
    mean: f64,
    /// Peak to peak, as a share of the mean.
    ripple: f64,
    lattice_sum_range: [f64; 2],
    cut_off_mass: f64,
    edge_step: f64,
    peak: f64,
    footprint_peak: f64,
    largest_alias: f64,
    response: Vec<Response>,
    profile: Vec<Sample>,
}

#[derive(Debug, Serialize)]
struct Response {
    frequency: f64,
    value: f64,
}

/// The kernel and its footprint at one distance.
#[derive(Debug, Serialize)]
struct Sample {
    distance: f64,
    value: f64,
    footprint: f64,
}

impl Report {
    fn new(kernel: Kernel, rows: usize) -> Self {
        let radial = RadialKernel::new(kernel);
        let analysis = analyse(&radial);
        let KernelAnalysis {
            support,
            sigma,
            mean,
            range,
            response,
            alias,
            peak,
            footprint_peak,
            edge,
            cut_off_mass,
        } = analysis;
        let sample = |i: usize| {
            let distance = support * i as f64 / rows as f64;
            Sample {
                distance,
                value: radial.value(distance),
                footprint: radial.line_integral(distance * distance),
            }
        };
        Self {
            kernel,
            support,
            sigma,
            mean,
            ripple: analysis.ripple(),
            lattice_sum_range: range,
            cut_off_mass,
            edge_step: edge,
            peak,
            footprint_peak,
            largest_alias: alias,
            response: RESPONSE_FREQUENCIES
                .into_iter()
                .zip(response)
                .map(|(frequency, value)| Response { frequency, value })
                .collect(),
            profile: (0..rows).map(sample).collect(),
        }
    }

    fn text(&self, kernel: Kernel) -> String {
        let mut text = String::new();
        let mut row = |label: &str, value: String| {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{label:<18} {value}");
        };
        row("kernel", described(kernel));
        row("support", format!("{} voxels", tidy(self.support)));
        row("sigma", format!("{} voxels along an axis", tidy(self.sigma)));
        row("mean", format!("{:.6}", self.mean));
        let [least, most] = self.lattice_sum_range;
        row(
            "ripple",
            format!("{:.3} % ({least:.5} to {most:.5})", 100.0 * self.ripple),
        );
        row(
            "cut off",
            format!(
                "{:.3} % of the mass, a step of {:.3} % of the peak",
                100.0 * self.cut_off_mass,
                100.0 * self.edge_step.abs()
            ),
        );
        row(
            "peak",
            format!(
                "{} per cubic voxel; footprint {} per square voxel",
                tidy(self.peak),
                tidy(self.footprint_peak)
            ),
        );
        row(
            "largest alias",
            format!("{:.5} of a constant", self.largest_alias),
        );
        text.push_str("frequency response, cycles per voxel\n");
        for Response { frequency, value } in &self.response {
            let _ = writeln!(text, "{frequency:>14.2}  {}  {value:.5}", bar(*value));
        }
        text.push_str("profile, voxels\n");
        for Sample { distance, value, .. } in &self.profile {
            let _ = writeln!(
                text,
                "{:>14}  {}  {:.5}",
                tidy(*distance),
                bar(value / self.peak),
                value / self.peak
            );
        }
        text
    }
}

fn described(kernel: Kernel) -> String {
    let name = kernel.name();
    match kernel {
        Kernel::Gaussian { sigma, radius } => {
            format!("{name} (sigma {}, radius {})", tidy(sigma), tidy(radius))
        }
        Kernel::CrawfisMax | Kernel::CubicBspline => name.to_owned(),
        Kernel::KaiserBessel { radius, alpha } => {
            format!("{name} (radius {}, alpha {})", tidy(radius), tidy(alpha))
        }
    }
}

/// A share as a row of at most 44 signs; empty if it is negative.
fn bar(share: f64) -> String {
    let length = (44.0 * share.clamp(0.0, 1.0)).round() as usize;
    format!("{:<44}", "#".repeat(length))
}
