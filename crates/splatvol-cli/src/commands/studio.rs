//! The renderer, and the frames in which it works: single pictures and means of several.

use splatvol::{
    Camera, Control, EngineChoice, EngineConfig, Frame, Motion, RenderSettings, Renderer, Scene, most_threads,
};

use crate::failure::{During, Failure, Step};
use crate::terminal::Terminal;

/// One renderer for all frames of a scene: it keeps whatever it can between frames.
pub(crate) struct Studio {
    scene: Scene,
    settings: RenderSettings,
    renderer: Renderer,
    frame: Frame,
}

/// The threads to start: those asked for, where 0 is one per processor, with a warning if they are too many.
pub(crate) fn threads_within(asked: usize, terminal: &Terminal) -> Option<usize> {
    let most = most_threads();
    if asked > most {
        terminal.warn(format!(
            "--threads {asked}: {most} are started, the most on this machine"
        ));
    }
    Some(asked.min(most)).filter(|&threads| threads > 0)
}

/// What pictures are made with.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Means {
    /// The processor's or a GPU's engine.
    pub(crate) engine: EngineChoice,
    /// Threads; `None` for one per processor.
    pub(crate) threads: Option<usize>,
}

/// Starts the engine.
pub(crate) fn engine(means: Means) -> Result<Renderer, Failure> {
    let config = EngineConfig {
        threads: means.threads,
        ..EngineConfig::default()
    };
    Renderer::start(means.engine, config).during(Step::Render)
}

impl Studio {
    pub(crate) fn new(scene: &Scene, settings: RenderSettings, means: Means) -> Result<Self, Failure> {
        Ok(Self {
            scene: scene.clone(),
            settings,
            renderer: engine(means)?,
            frame: Frame::empty(settings.size),
        })
    }

    /// Sets the motion while the shutter is open.
    pub(crate) fn set_motion(&mut self, motion: &Motion) {
        for item in &mut self.scene.items {
            item.motion = Some(motion.clone());
        }
    }

    /// The picture of one camera, or the mean of the pictures of several: all that a shutter sees while it is
    /// open.
    pub(crate) fn expose(&mut self, cameras: &[Camera]) -> Result<&Frame, Failure> {
        let Self {
            scene,
            settings,
            renderer,
            frame,
        } = self;
        match cameras {
            [camera] => renderer.render_into(scene, camera, settings, frame),
            cameras => renderer.expose(scene, cameras, settings, frame, &Control::default()),
        }
        .during(Step::Render)?;
        Ok(&self.frame)
    }
}
