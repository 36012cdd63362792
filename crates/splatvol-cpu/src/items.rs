//! The cloud of everything that is classified before it is splatted, kept between frames.

use splatvol_core::scene_cloud::SceneCloud;
use splatvol_core::splats::SplatCloud;
use splatvol_scene::{Camera, RenderSettings, Scene};

use crate::run::Run;

/// The cloud last made.
#[derive(Debug, Default)]
pub(crate) struct ItemStore {
    kept: Option<SceneCloud>,
}

impl ItemStore {
    /// Memory held, bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.kept.as_ref().map_or(0, SceneCloud::bytes)
    }

    /// The cloud of a scene in this camera's view; `None` if the picture is cancelled while the cloud is being
    /// made.
    pub(crate) fn cloud(
        &mut self,
        run: Run<'_>,
        scene: &Scene,
        (camera, settings): (&Camera, &RenderSettings),
    ) -> Option<&SplatCloud> {
        if !self.kept.as_ref().is_some_and(|kept| kept.is_of(scene, settings)) {
            // First, so that the memory of two clouds is never needed.
            self.kept = None;
        }
        if self.kept.is_none() {
            let (scene, settings) = (scene.clone(), *settings);
            let made = run.pool.prepare(run.task.stop, move |patience| {
                SceneCloud::new(scene, &settings, &|| patience.go_on().is_some())
            })?;
            self.kept = Some(made);
        }
        let kept = self.kept.as_mut()?;
        run.pool.install(|| kept.color(camera));
        Some(kept.cloud())
    }
}
