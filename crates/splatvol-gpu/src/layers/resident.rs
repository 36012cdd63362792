//! Resident: voxels on the device, kept from picture to picture.

use splatvol_core::level::Level;
use splatvol_scene::SceneError;

use crate::atlas::{Assembler, Atlas};
use crate::shown::{Key, Shown};
use crate::voxels::{KeptSamples, Voxels};

/// Volumes kept on the device.
#[derive(Debug, Default)]
pub(super) struct OnDevice {
    pub resident: Vec<Resident>,
    samples: KeptSamples,
}

/// Voxels on the device, and what they are of.
#[derive(Debug)]
pub(super) struct Resident {
    of: Key,
    pub atlas: Atlas,
    pub voxels: Option<Voxels>,
}

impl OnDevice {
    /// Brings what is not there yet, and forgets what none of these volumes needs; returns each one's place in `resident`.
    ///
    /// # Errors
    /// A stopped picture, samples that cannot be read, and memory that the device refuses.
    pub(super) fn reside(
        &mut self,
        assembler: Assembler<'_>,
        (shown, levels): (&[&Shown<'_>], &[usize]),
        classified: &[&Level],
    ) -> Result<Vec<usize>, SceneError> {
        let keys: Vec<Key> = shown
            .iter()
            .zip(levels)
            .map(|(own, &level)| own.key(level))
            .collect();
        let Self { resident, samples } = self;
        samples.retain(shown.iter().map(|own| &own.volume));
        let mut before = std::mem::take(resident);
        let mut at = Vec::with_capacity(shown.len());
        for (own, (key, level)) in shown.iter().zip(keys.iter().zip(classified)) {
            let there = resident.iter().position(|known| known.of == *key);
            let kept = before.iter().position(|known| known.of == *key);
            at.push(there.unwrap_or(resident.len()));
            if there.is_none() {
                let share = |done: f64| {
                    (assembler.task.progress)((at.len() as f64 - 1.0 + done) / shown.len() as f64);
                };
                let part = Assembler {
                    task: assembler.task.unseen(&share),
                    ..assembler
                };
                let found = match kept.map(|kept| before.swap_remove(kept)) {
                    Some(kept) if !level.field.is_lazy() => kept,
                    // Which bricks of a volume in chunks are needed changes with the camera.
                    kept => {
                        let other = kept.or_else(|| other_look(&mut before, (key, &keys)));
                        bring((part, samples), own, (key, level), other)?
                    }
                };
                resident.push(found);
            }
        }
        // Other levels, which pictures blend with these.
        let is_other = |known: &Resident, key: &Key| key.is_like(&known.of) && key.level != known.of.level;
        before.retain(|known| keys.iter().any(|key| is_other(known, key)));
        resident.append(&mut before);
        Ok(at)
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        let atlases = self.resident.iter().map(|own| own.atlas.layout.bytes());
        atlases.sum::<u64>() + self.samples.bytes()
    }
}

/// The same level of the same volume with a look that no shown one has.
fn other_look(before: &mut Vec<Resident>, (key, keys): (&Key, &[Key])) -> Option<Resident> {
    let is_other = |known: &Resident| {
        known.voxels.is_none()
            && known.of.level == key.level
            && key.is_like(&known.of)
            && !keys.contains(&known.of)
    };
    let found = before.iter().position(is_other)?;
    Some(before.swap_remove(found))
}

/// Brings the needed voxels of a level to the device, or those of them that it lacks with another look.
fn bring(
    (assembler, samples): (Assembler<'_>, &mut KeptSamples),
    own: &Shown<'_>,
    (key, level): (&Key, &Level),
    other: Option<Resident>,
) -> Result<Resident, SceneError> {
    if let Some(mut other) = other
        && other.atlas.renew(assembler, &level.field)?
    {
        other.of = key.clone();
        return Ok(other);
    }
    let (atlas, voxels) = if own.mode().splats_classes() {
        let gpu = assembler.gpu;
        let samples = samples.of(gpu, &key.volume, (key.level, &level.field))?;
        let (atlas, voxels) = Voxels::new(gpu, level, &samples, own.taps())?;
        (atlas, Some(voxels))
    } else {
        (Atlas::new(assembler, &level.field, own.taps())?, None)
    };
    Ok(Resident {
        of: key.clone(),
        atlas,
        voxels,
    })
}
