//! Seconds per frame, beside those of the paper's machine, a Pentium III of 866 MHz. They carry no verdict: twenty
//! years of processors lie between the two.

use splatvol::{Camera, RenderSettings, Scene};

use crate::measure::{Rounds, Timed, median_seconds};
use crate::{LabError, Workbench};

/// Head of the column of the paper's seconds, which it gives as *approximately*.
pub(super) const PUBLISHED: &str = "published, a PIII of 866 MHz (s)";
/// Head of the column of ours.
pub(super) const MEASURED: &str = "measured, one thread (s)";

/// Median seconds per frame of each, by one thread, as the paper's machine had; each by an engine of its own.
pub(super) fn seconds_per_frame(
    bench: &Workbench<'_>,
    frames: &[(&Scene, &Camera, RenderSettings)],
) -> Result<Vec<f64>, LabError> {
    let one = Workbench {
        threads: Some(1),
        ..*bench
    };
    let timed = frames.iter().map(|&(scene, camera, settings)| {
        let mut renderer = one.renderer()?;
        let render = move || Ok(renderer.render(scene, camera, &settings).map(drop)?);
        Ok(Box::new(render) as Timed<'_>)
    });
    let mut timed = timed.collect::<Result<Vec<_>, LabError>>()?;
    let rounds = Rounds {
        least: bench.choose(3, 1),
        seconds: bench.choose(3.0, 0.0),
    };
    median_seconds(&mut timed, rounds)
}
