//! Makes a finding smaller while it still fails in the same way.

use std::path::Path;
use std::process::Stdio;

use anyhow::Result;

use crate::input::Input;
use crate::parent::{program, work_folder};
use crate::target::Target;

/// Most tries: each is a process.
const TRIES: usize = 150;

/// Replaces the folder's contents by fewer bytes, or zeros, that fail as they do.
pub(crate) fn minimise(target: &Target, folder: &Path) -> Result<()> {
    let open = opened(target, folder);
    let mut best = Input::read(folder, &open)?;
    let work = work_folder()?;
    let status = |input: &Input| -> Result<Option<i32>> {
        let path = work.path().join("smaller");
        input.write(&path)?;
        let mut replay = program()?;
        replay.arg("--replay").arg(&path).arg(target.name);
        let status = replay
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()?;
        Ok(status.code())
    };
    let wanted = status(&best)?;
    if wanted == Some(0) {
        return Ok(());
    }
    let mut tries = 0;
    for file in 0..best.files.len() {
        let mut block = best.files[file].1.len().div_ceil(2);
        while block > 0 && tries < TRIES {
            let mut at = 0;
            while at < best.files[file].1.len() && tries < TRIES {
                let kept = attempts(&best, file, at, block).into_iter().find(|smaller| {
                    tries += 1;
                    status(smaller).is_ok_and(|status| status == wanted)
                });
                let removed = kept.as_ref().is_some_and(|kept| kept.len() < best.len());
                best = kept.unwrap_or(best);
                at += if removed { 0 } else { block };
            }
            block /= 2;
        }
    }
    best.write(folder).map(drop)
}

/// Without a block, and with zeros in its place.
fn attempts(input: &Input, file: usize, at: usize, block: usize) -> Vec<Input> {
    let (mut without, mut zeros) = (input.clone(), input.clone());
    let bytes = &mut without.files[file].1;
    let end = (at + block).min(bytes.len());
    bytes.drain(at..end);
    zeros.files[file].1[at..end].fill(0);
    let mut attempts = vec![without];
    if zeros != *input {
        attempts.push(zeros);
    }
    attempts
}

/// Which path of a folder is opened: that of the seed with the same files.
pub(crate) fn opened(target: &Target, folder: &Path) -> String {
    let seeds = (target.seeds)();
    let fits = |name: &str| name.is_empty() || folder.join(name).is_file();
    let of_seed = seeds
        .iter()
        .find(|seed| !seed.open.is_empty() && fits(&seed.open));
    of_seed.map(|seed| seed.open.clone()).unwrap_or_default()
}
