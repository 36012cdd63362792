//! Drafts: which settings and which raster a picture has while something moves.
//!
//! A draft has the look, the light and the clips of the picture, the quality of the preset `draft`, and a raster that is coarser by
//! a step of 1, sqrt 2, 2, 2 sqrt 2 or 4, so that it is expected to take no longer than [`BUDGET_SECONDS`].

use splatvol::{Camera, Compositing, Coverage, FlatSettings, ImageSize, RenderSettings, Scene};

/// Time of a draft.
const BUDGET_SECONDS: f64 = 0.035;
/// Pixels per point of the raster, along each side.
const STEPS: [f64; 5] = [
    1.0,
    std::f64::consts::SQRT_2,
    2.0,
    2.0 * std::f64::consts::SQRT_2,
    4.0,
];
/// Share of a new measurement in the expectation.
const SHARE: f64 = 0.5;

/// What drafts of the present scene are expected to cost.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Pace {
    /// Seconds per pixel; `None` before the first draft.
    seconds_per_pixel: Option<f64>,
}

impl Pace {
    /// The step of the next draft of a picture: the finest that is expected to be in time.
    pub(super) fn step(&self, size: ImageSize) -> f64 {
        let Some(cost) = self.seconds_per_pixel else {
            return STEPS[STEPS.len() - 1];
        };
        let whole = cost * size.pixel_count() as f64;
        let in_time = STEPS
            .iter()
            .find(|step| whole / (*step * *step) <= BUDGET_SECONDS);
        *in_time.unwrap_or(&STEPS[STEPS.len() - 1])
    }

    /// Learns from a draft.
    pub(super) fn learn(&mut self, size: ImageSize, seconds: f64) {
        let new = seconds / size.pixel_count() as f64;
        self.seconds_per_pixel = Some(match self.seconds_per_pixel {
            Some(old) => old + SHARE * (new - old),
            None => new,
        });
    }
}

/// The size of a raster with this many pixels per point.
pub(super) fn coarser(size: ImageSize, step: f64) -> ImageSize {
    let side = |pixels: u32| ((f64::from(pixels) / step).round() as u32).max(1);
    ImageSize::new(side(size.width()), side(size.height())).unwrap_or(size)
}

/// Settings of a draft: those of the preset `draft` where the method allows it, and otherwise the picture's own without
/// anti-aliasing of edges.
pub(super) fn settings(
    scene: &Scene,
    camera: &Camera,
    own: &RenderSettings,
    size: ImageSize,
) -> RenderSettings {
    let flat = FlatSettings::from(*own);
    let plain = RenderSettings {
        size,
        coverage: Coverage::Off,
        ..*own
    };
    let has_draft = matches!(
        flat.compositing,
        Compositing::ImageSheets
            | Compositing::Xray
            | Compositing::Mip
            | Compositing::MinimumIntensity
            | Compositing::Mean
    );
    if !has_draft || own.method.sheets().is_none() {
        return plain;
    }
    let draft = FlatSettings {
        size,
        compositing: flat.compositing,
        classification: flat.classification,
        gaussians: flat.gaussians,
        lighting: flat.lighting,
        ..RenderSettings::draft().into()
    };
    let draft = RenderSettings::try_from(draft).ok();
    draft
        .filter(|draft| splatvol::check(scene, camera, draft).is_ok())
        .unwrap_or(plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drafts_get_coarser_until_they_are_in_time() {
        let size = ImageSize::new(1000, 1000).unwrap();
        let mut pace = Pace::default();
        assert_eq!(pace.step(size), 4.0);
        pace.learn(coarser(size, 4.0), 0.001);
        assert_eq!(pace.step(size), 1.0, "16 ms");
        for _ in 0..20 {
            pace.learn(size, 0.13);
        }
        assert_eq!(pace.step(size), 2.0, "130 ms");
        for _ in 0..20 {
            pace.learn(size, 3.0);
        }
        assert_eq!(pace.step(size), 4.0);
    }
}
