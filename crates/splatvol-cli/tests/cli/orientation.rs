//! Scans of one object, stored in several formats and voxel orders, make the same picture without any flags.

use std::path::{Path, PathBuf};

use splatvol_recorded::recorded;

use crate::sandbox::{Sandbox, png};

/// Voxel orders of the same head, with the letters L and R on either side of it.
const ORDERS: [&str; 8] = ["RAS", "LPI", "PSR", "ASL", "IAR", "SPL", "ILP", "ARS"];

fn shared_volumes() -> Option<PathBuf> {
    recorded("volumes")
}

fn picture(sandbox: &Sandbox, path: &Path, view: &str) -> (u32, u32, Vec<u8>) {
    sandbox
        .run(&format!(
            "render {} --size 128 {view} -w -o a.png",
            path.display()
        ))
        .succeeds();
    png(&sandbox.path("a.png"))
}

pub(crate) fn psnr(a: &(u32, u32, Vec<u8>), b: &(u32, u32, Vec<u8>)) -> f64 {
    assert_eq!((a.0, a.1, a.2.len()), (b.0, b.1, b.2.len()));
    let squares =
        a.2.iter()
            .zip(&b.2)
            .map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2));
    let mean = squares.sum::<f64>() / a.2.len() as f64;
    10.0 * (255.0 * 255.0 / mean.max(1e-9)).log10()
}

#[test]
fn eight_voxel_orders_of_a_head_make_one_picture() {
    let Some(folder) = shared_volumes() else { return };
    let sandbox = Sandbox::new();
    let of = |order: &str| {
        picture(
            &sandbox,
            &folder.join(format!("nifti_space/{order}.nii.gz")),
            "--preset best",
        )
    };
    let first = of(ORDERS[0]);
    for order in &ORDERS[1..] {
        let psnr = psnr(&of(order), &first);
        // Sums in another order round to a different code in one of a thousand channels.
        assert!(psnr >= 60.0, "{order}: {psnr:.2} dB");
    }
}

#[test]
fn the_letters_can_be_read_and_left_is_left_from_above() {
    let Some(folder) = shared_volumes() else { return };
    let sandbox = Sandbox::new();
    for order in ["RAS", "SPL"] {
        let (width, _, codes) = picture(
            &sandbox,
            &folder.join(format!("nifti_space/{order}.nii.gz")),
            "--view top",
        );
        let channels = codes.len() / (128 * 128);
        // The letters are the brightest material, almost white; the brain is amber.
        let white: Vec<[f64; 2]> = codes
            .chunks_exact(channels)
            .enumerate()
            .filter(|(_, rgb)| rgb[2] > 130 && f64::from(rgb[2]) > 0.85 * f64::from(rgb[0]))
            .map(|(i, _)| [(i as u32 % width) as f64, (i as u32 / width) as f64])
            .filter(|[x, _]| *x < 64.0)
            .collect();
        assert!(white.len() > 200, "{order}: {}", white.len());
        // An L weighs most to its left and at its bottom: the other letter, a mirrored or a standing one does not.
        let lean = |axis: usize| {
            let along = white.iter().map(|place| place[axis]);
            let low = along.clone().fold(f64::INFINITY, f64::min);
            let high = along.clone().fold(f64::NEG_INFINITY, f64::max);
            (along.sum::<f64>() / white.len() as f64 - low) / (high - low)
        };
        let (x, y) = (lean(0), lean(1));
        assert!(x < 0.45 && y > 0.55, "{order}: {x:.3} {y:.3}");
    }
}

#[test]
fn formats_of_one_scan_make_one_picture() {
    let Some(folder) = shared_volumes() else { return };
    let sandbox = Sandbox::new();
    let [nifti, nrrd] = ["FLAIR.nii.gz", "FLAIR.nrrd"].map(|name| picture(&sandbox, &folder.join(name), ""));
    let psnr = psnr(&nifti, &nrrd);
    assert!(psnr >= 60.0, "{psnr:.2} dB");
}
