//! FastSplats as section 6 sets them up, and their times.

use splatvol::{
    Camera, EngineConfig, FlatSettings, Frame, ImageSize, Rasterizer, RenderSettings, RenderStatistics,
    Renderer, Scene,
};

use crate::measure::{Rounds, Timed, median_seconds};
use crate::{LabError, Workbench};

/// 2 x 2 positions within the pixel, as in section 3.2.
pub(super) const TWO_D: Rasterizer = Rasterizer::Blit2d { subpixels: 2 };
/// 100 x 100 positions within the pixel, as in section 3.3.
pub(super) const RLUT: Rasterizer = Rasterizer::Rlut { subpixels: 100 };

/// The four FastSplats, by the names of the paper's figures.
pub(super) const FASTSPLATS: [(&str, Rasterizer); 4] = [
    ("2D", TWO_D),
    ("linear", Rasterizer::Linear1d),
    ("square", Rasterizer::Square1d),
    ("RLUT", RLUT),
];

/// 512 x 512 pixels; with `--quick` a quarter as wide.
pub(super) fn picture_size(bench: &Workbench<'_>) -> Result<ImageSize, LabError> {
    let edge = bench.choose(512, 128);
    Ok(ImageSize::new(edge, edge)?)
}

/// FastSplats with one of the rasterisers.
pub(super) fn fastsplats(size: ImageSize, rasterizer: Rasterizer) -> FlatSettings {
    FlatSettings {
        size,
        rasterizer,
        ..RenderSettings::fastsplats2000().into()
    }
}

/// Something to render again and again, by an engine of its own, which keeps what it derives from scene and settings.
pub(super) struct Subject<'a> {
    scene: &'a Scene,
    camera: &'a Camera,
    settings: RenderSettings,
    renderer: Renderer,
}

impl<'a> Subject<'a> {
    /// A subject rendered by one thread, as on the paper's machine.
    pub(super) fn new(
        scene: &'a Scene,
        camera: &'a Camera,
        settings: impl Into<FlatSettings>,
    ) -> Result<Self, LabError> {
        let config = EngineConfig {
            threads: Some(1),
            ..EngineConfig::default()
        };
        Ok(Self {
            scene,
            camera,
            settings: RenderSettings::try_from(settings.into())?,
            renderer: Renderer::new(config)?,
        })
    }

    /// Renders a frame.
    pub(super) fn render(&mut self) -> Result<Frame, LabError> {
        Ok(self.renderer.render(self.scene, self.camera, &self.settings)?)
    }

    /// Statistics of the last frame.
    pub(super) fn statistics(&self) -> &RenderStatistics {
        self.renderer.statistics()
    }
}

/// Five rounds, or as many as fit into ten seconds; with `--quick` three.
pub(super) fn rounds(bench: &Workbench<'_>) -> Rounds {
    Rounds {
        least: bench.choose(5, 3),
        seconds: bench.choose(10.0, 0.0),
    }
}

/// Median seconds of a frame of each.
pub(super) fn seconds(subjects: &mut [Subject<'_>], rounds: Rounds) -> Result<Vec<f64>, LabError> {
    let mut timed: Vec<Timed<'_>> = Vec::with_capacity(subjects.len());
    for subject in subjects {
        timed.push(Box::new(|| subject.render().map(drop)));
    }
    median_seconds(&mut timed, rounds)
}
