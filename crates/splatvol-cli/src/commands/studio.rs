//! The renderer, and the frames in which it works: single pictures and means of several.

use splatvol::{Camera, EngineConfig, Exposure, Frame, Motion, RenderSettings, Renderer, Scene};

use crate::failure::{During, Failure, Step};

/// One renderer for all frames of a scene: what it can keep between frames, it keeps.
pub(crate) struct Studio {
    scene: Scene,
    settings: RenderSettings,
    renderer: Renderer,
    exposure: Option<Exposure>,
    frame: Frame,
}

/// An engine with so many threads, or one per processor.
pub(crate) fn engine(threads: Option<usize>) -> Result<Renderer, Failure> {
    Renderer::new(EngineConfig {
        threads,
        ..EngineConfig::default()
    })
    .during(Step::Render)
}

impl Studio {
    pub(crate) fn new(
        scene: &Scene,
        settings: RenderSettings,
        threads: Option<usize>,
    ) -> Result<Self, Failure> {
        Ok(Self {
            scene: scene.clone(),
            settings,
            renderer: engine(threads)?,
            exposure: None,
            frame: Frame::empty(settings.size),
        })
    }

    /// Sets the motion while the shutter is open.
    pub(crate) fn set_motion(&mut self, motion: &Motion) {
        for item in &mut self.scene.items {
            item.motion = Some(motion.clone());
        }
    }

    /// The picture of a camera, or the mean of those of several: all that a shutter sees while it is open.
    pub(crate) fn expose(&mut self, cameras: &[Camera]) -> Result<&Frame, Failure> {
        for camera in cameras {
            self.renderer
                .render_into(&self.scene, camera, &self.settings, &mut self.frame)
                .during(Step::Render)?;
            if cameras.len() > 1 {
                let exposure = self
                    .exposure
                    .get_or_insert_with(|| Exposure::new(self.settings.size));
                exposure.add(&self.frame).during(Step::Render)?;
            }
        }
        if let Some(exposure) = self.exposure.as_mut().filter(|_| cameras.len() > 1) {
            exposure.take(&mut self.frame).during(Step::Render)?;
        }
        Ok(&self.frame)
    }

    pub(crate) fn renderer(&self) -> &Renderer {
        &self.renderer
    }
}
