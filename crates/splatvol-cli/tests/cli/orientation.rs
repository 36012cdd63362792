//! Scans of one object, stored in several formats and voxel orders, make the same picture without any flags.

use std::path::{Path, PathBuf};

use glam::{DMat3, DVec3};
use splatvol_recorded::recorded;

use crate::nifti_file::NiftiFile;
use crate::sandbox::{Sandbox, png};

/// Voxel orders of the same head, with the letters L and R on either side of it.
const ORDERS: [&str; 8] = ["RAS", "LPI", "PSR", "ASL", "IAR", "SPL", "ILP", "ARS"];

/// Voxels of a generated scan to the right, to the front and up.
const DIMS: [usize; 3] = [40, 36, 28];

/// A value of the generated scan at a voxel in the order of RAS+: an L of bone at the left, that is read from above.
fn letter([x, y, z]: [usize; 3]) -> u8 {
    let stroke = (4..8).contains(&x) && (8..28).contains(&y);
    let foot = (4..17).contains(&x) && (8..12).contains(&y);
    if (stroke || foot) && (10..18).contains(&z) {
        250
    } else {
        0
    }
}

/// The same beside an egg that leans.
fn head([x, y, z]: [usize; 3]) -> u8 {
    let places = [(x, 24.0, 12.0), (y, 20.0, 11.0), (z, 15.0, 9.0)];
    let [a, b, c] = places.map(|(place, middle, radius)| (place as f64 - middle) / radius);
    let egg = 110.0 * (1.6 - (a + 0.3 * b).powi(2) - b * b - c * c).clamp(0.0, 1.0);
    letter([x, y, z]).max(egg as u8)
}

/// A scan with its voxels in the order of three letters, where its first voxel lies, and the steps of its axes, RAS+.
struct Stored {
    dims: [usize; 3],
    samples: Vec<u8>,
    first: DVec3,
    steps: DMat3,
}

impl Stored {
    fn of(scan: fn([usize; 3]) -> u8, order: &str) -> Self {
        // The axis of the patient along each stored one, and whether it runs the other way.
        let axes: Vec<(usize, bool)> = order
            .chars()
            .map(|letter| {
                let axis = ["RL", "AP", "SI"].iter().position(|pair| pair.contains(letter));
                (axis.expect("a direction"), "LPI".contains(letter))
            })
            .collect();
        let dims = [0, 1, 2].map(|k| DIMS[axes[k].0]);
        let patient = |stored: [usize; 3]| {
            let mut place = [0; 3];
            for (k, &(axis, turned)) in axes.iter().enumerate() {
                place[axis] = if turned {
                    DIMS[axis] - 1 - stored[k]
                } else {
                    stored[k]
                };
            }
            place
        };
        let voxel = |i: usize| [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])];
        let step = |k: usize| DVec3::AXES[axes[k].0] * if axes[k].1 { -1.0 } else { 1.0 };
        Self {
            dims,
            samples: (0..dims.iter().product())
                .map(|i| scan(patient(voxel(i))))
                .collect(),
            first: DVec3::from_array(patient([0; 3]).map(|place| place as f64)),
            steps: DMat3::from_cols(step(0), step(1), step(2)),
        }
    }

    fn nifti(&self) -> Vec<u8> {
        let mut file = NiftiFile::new(&self.dims.map(|size| size as i64), 2);
        file.set_sform(1, self.steps, self.first);
        file.bytes(&self.samples)
    }

    fn nrrd(&self) -> Vec<u8> {
        let vector = |v: DVec3| format!("({},{},{})", v.x, v.y, v.z);
        let [nx, ny, nz] = self.dims;
        let header = format!(
            "NRRD0004\ntype: uchar\ndimension: 3\nspace: right-anterior-superior\nsizes: {nx} {ny} {nz}\n\
             space directions: {} {} {}\nspace origin: {}\nspace units: \"mm\" \"mm\" \"mm\"\nencoding: raw\n\n",
            vector(self.steps.x_axis),
            vector(self.steps.y_axis),
            vector(self.steps.z_axis),
            vector(self.first)
        );
        [header.as_bytes(), &self.samples].concat()
    }
}

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
fn eight_voxel_orders_of_a_generated_scan_make_one_picture_in_two_formats() {
    let sandbox = Sandbox::new();
    let of = |name: &str, bytes: Vec<u8>| {
        sandbox.write(name, bytes);
        picture(&sandbox, &sandbox.path(name), "--preset best")
    };
    let first = of("RAS.nrrd", Stored::of(head, "RAS").nrrd());
    for order in ORDERS {
        let psnr = psnr(&of("a.nii", Stored::of(head, order).nifti()), &first);
        assert!(psnr >= 60.0, "{order}: {psnr:.2} dB");
    }
}

#[test]
fn a_generated_letter_is_read_from_above() {
    let sandbox = Sandbox::new();
    for order in ["RAS", "SPL"] {
        sandbox.write("a.nii", Stored::of(letter, order).nifti());
        let (width, _, codes) = picture(&sandbox, &sandbox.path("a.nii"), "--view top");
        let channels = codes.len() / (128 * 128);
        let background = &codes[..channels];
        let lit: Vec<[f64; 2]> = codes
            .chunks_exact(channels)
            .enumerate()
            .filter(|(_, code)| *code != background)
            .map(|(i, _)| [(i as u32 % width) as f64, (i as u32 / width) as f64])
            .collect();
        assert!(lit.len() > 200, "{order}: {}", lit.len());
        let [x, y] = lean(&lit);
        assert!(x < 0.45 && y > 0.55, "{order}: {x:.3} {y:.3}");
    }
}

/// The mean of places within their extent, 0 to 1 rightwards and downwards. An L weighs most to its left and at its bottom: another
/// letter, a mirrored or a standing one does not.
fn lean(places: &[[f64; 2]]) -> [f64; 2] {
    [0, 1].map(|axis| {
        let along = places.iter().map(|place| place[axis]);
        let low = along.clone().fold(f64::INFINITY, f64::min);
        let high = along.clone().fold(f64::NEG_INFINITY, f64::max);
        (along.sum::<f64>() / places.len() as f64 - low) / (high - low)
    })
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
        let [x, y] = lean(&white);
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
