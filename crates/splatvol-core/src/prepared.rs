//! Prepared volumes, kept between frames: those of the current scene, and the last used ones of earlier scenes
//! within a memory budget.
//!
//! Switching between a few volumes finds them prepared; going through hundreds takes no more memory than the
//! budget. Of volumes in chunks, whose pictures have a budget of their own, others keep nothing.

use std::sync::Arc;

use splatvol_scene::{RenderSettings, SheetSettings, Volume};

use crate::level::Pyramid;

/// Default budget for volumes of earlier scenes, bytes.
pub const SPARE: usize = 1 << 30;

/// Prepared volumes: those of the current scene, then the others, last used first.
#[derive(Debug)]
pub struct PreparedVolumes {
    pyramids: Vec<Pyramid>,
    /// Number of volumes of the current scene.
    own: usize,
    spare: usize,
}

impl Default for PreparedVolumes {
    fn default() -> Self {
        Self::with_spare(SPARE)
    }
}

impl PreparedVolumes {
    /// An empty cache; `spare`: bytes for volumes of earlier scenes.
    pub fn with_spare(spare: usize) -> Self {
        Self {
            pyramids: Vec::new(),
            own: 0,
            spare,
        }
    }

    /// The volumes of a scene, in its order. Other volumes are freed before any of these allocates memory.
    pub fn of_scene<'v>(
        &mut self,
        volumes: impl Iterator<Item = &'v Arc<Volume>>,
        settings: &RenderSettings<SheetSettings>,
    ) -> &mut [Pyramid] {
        self.own = 0;
        for volume in volumes {
            let others = &mut self.pyramids[self.own..];
            match others.iter().position(|pyramid| pyramid.is_of(volume, settings)) {
                Some(at) => others[..=at].rotate_right(1),
                None => {
                    let new = Pyramid::new(volume.source(), settings);
                    self.pyramids.insert(self.own, new);
                }
            }
            self.own += 1;
        }
        let mut left = self.spare;
        let mut kept = self.own;
        for other in &self.pyramids[self.own..] {
            let Some(less) = left.checked_sub(other.bytes()) else {
                break;
            };
            (left, kept) = (less, kept + 1);
        }
        self.pyramids.truncate(kept);
        self.pyramids[self.own..].iter().for_each(Pyramid::rest);
        &mut self.pyramids[..self.own]
    }

    /// Forgets the levels whose samples could not be read.
    pub fn forget_failed(&mut self) {
        self.pyramids.iter_mut().for_each(Pyramid::forget_failed);
    }

    /// Bytes of the volumes of the current scene, and of others.
    pub fn bytes(&self) -> [usize; 2] {
        let (own, others) = self.pyramids.split_at(self.own);
        [own, others].map(|pyramids| pyramids.iter().map(Pyramid::bytes).sum())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Weak;

    use splatvol_testing::fields::Constant;
    use splatvol_testing::sample;

    use super::*;

    fn volume(n: usize) -> Arc<Volume> {
        let grid = splatvol_scene::Grid::centred([n; 3], glam::DVec3::ONE).unwrap();
        Arc::new(sample(&Constant(0.5), &grid))
    }

    #[test]
    fn volumes_used_last_stay_as_long_as_they_fit() {
        let settings = RenderSettings::default().with(SheetSettings::default());
        // Room for two volumes of 16 cubed, 4 bytes per voxel, besides the scene's.
        let mut prepared = PreparedVolumes::with_spare(2 * 4 * 4096 + 1000);
        let mut weak: Vec<Weak<Volume>> = Vec::new();
        for _ in 0..4 {
            let volume = volume(16);
            weak.push(Arc::downgrade(&volume));
            prepared.of_scene([&volume].into_iter(), &settings);
        }
        let alive = |weak: &[Weak<Volume>]| weak.iter().map(|w| w.strong_count() > 0).collect::<Vec<_>>();
        assert_eq!(alive(&weak), [false, true, true, true]);
        // The second comes back, so the third is now the one that was used longest ago.
        let second = weak[1].upgrade().unwrap();
        prepared.of_scene([&second].into_iter(), &settings);
        drop(second);
        let last = volume(16);
        prepared.of_scene([&last].into_iter(), &settings);
        assert_eq!(alive(&weak), [false, true, false, true]);
        // A scene may have any size.
        let both = [&last, &volume(64)].map(Arc::clone);
        assert_eq!(prepared.of_scene(both.iter(), &settings).len(), 2);
        let [own, others] = prepared.bytes();
        assert!(own > 4 * 64 * 64 * 64 && others <= 2 * 4 * 4096 + 1000);
    }
}
