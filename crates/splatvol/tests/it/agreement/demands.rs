//! What `best` is demanded to keep against the reference, picture by picture.
//!
//! PSNR in dB is one below what is measured; the largest error and the bias are at most twice, or what a rounding of the
//! figures leaves.

/// Name of a picture, least PSNR in dB, largest error and bias of any channel.
type Demand = (&'static str, f64, f64, f64);

#[rustfmt::skip]
const DEMANDS: &[Demand] = &[
    ("ball-orthographic-lit", 73.1, 0.0022, 2.1e-4),
    ("ball-orthographic-mean", 120.0, 0.0002, 1.0e-5),
    ("ball-orthographic-minip", 120.0, 0.0002, 1.0e-5),
    ("ball-orthographic-mip", 92.4, 0.00077, 1.0e-5),
    ("ball-orthographic-pre", 76.1, 0.0018, 8.2e-5),
    ("ball-orthographic-unlit", 72.5, 0.0022, 2.1e-4),
    ("ball-orthographic-xray", 89.9, 0.00043, 2.3e-5),
    ("ball-perspective-lit", 74.2, 0.0022, 1.5e-4),
    ("ball-perspective-mean", 120.0, 0.0002, 1.0e-5),
    ("ball-perspective-minip", 120.0, 0.0002, 1.0e-5),
    ("ball-perspective-mip", 95.7, 0.00043, 1.0e-5),
    ("ball-perspective-pre", 77.6, 0.0018, 5.8e-5),
    ("ball-perspective-unlit", 73.7, 0.0022, 1.5e-4),
    ("ball-perspective-xray", 91.1, 0.00043, 1.7e-5),
    ("head-orthographic-lit", 58.5, 0.023, 8.7e-4),
    ("head-orthographic-mean", 95.8, 0.00077, 1.0e-5),
    ("head-orthographic-minip", 120.0, 0.0002, 1.0e-5),
    ("head-orthographic-mip", 73.2, 0.0052, 1.2e-4),
    ("head-orthographic-pre", 64.7, 0.0069, 2.9e-4),
    ("head-orthographic-unlit", 72.9, 0.0069, 9.4e-5),
    ("head-orthographic-xray", 76.0, 0.0027, 6.0e-5),
    ("head-perspective-lit", 59.4, 0.019, 6.8e-4),
    ("head-perspective-mean", 109.0, 0.0002, 1.0e-5),
    ("head-perspective-minip", 120.0, 0.0002, 1.0e-5),
    ("head-perspective-mip", 77.8, 0.0029, 5.3e-5),
    ("head-perspective-plain", 66.8, 0.011, 2.8e-4),
    ("head-perspective-pre", 66.0, 0.0073, 2.3e-4),
    ("head-perspective-unlit", 72.8, 0.0083, 7.9e-5),
    ("head-perspective-xray", 76.4, 0.0035, 4.3e-5),
    ("marschner-lobb-orthographic-lit", 50.0, 0.047, 4.3e-3),
    ("marschner-lobb-orthographic-mean", 82.2, 0.0027, 1.0e-5),
    ("marschner-lobb-orthographic-minip", 70.4, 0.0078, 1.1e-4),
    ("marschner-lobb-orthographic-mip", 71.1, 0.013, 9.4e-5),
    ("marschner-lobb-orthographic-pre", 69.5, 0.003, 4.1e-4),
    ("marschner-lobb-orthographic-unlit", 64.6, 0.015, 4.8e-4),
    ("marschner-lobb-orthographic-xray", 88.2, 0.00043, 3.6e-5),
    ("marschner-lobb-perspective-lit", 51.5, 0.049, 2.9e-3),
    ("marschner-lobb-perspective-mean", 79.8, 0.0044, 1.9e-5),
    ("marschner-lobb-perspective-minip", 74.4, 0.0062, 4.8e-5),
    ("marschner-lobb-perspective-mip", 68.0, 0.014, 1.1e-4),
    ("marschner-lobb-perspective-pre", 71.2, 0.0029, 3.1e-4),
    ("marschner-lobb-perspective-unlit", 64.5, 0.019, 6.0e-4),
    ("marschner-lobb-perspective-xray", 88.3, 0.0006, 2.8e-5),
    ("noise-orthographic-lit", 62.9, 0.018, 5.6e-4),
    ("noise-orthographic-mean", 102.5, 0.0002, 1.0e-5),
    ("noise-orthographic-minip", 93.2, 0.0014, 1.0e-5),
    ("noise-orthographic-mip", 89.8, 0.001, 2.3e-5),
    ("noise-orthographic-none", 62.7, 0.017, 5.4e-4),
    ("noise-orthographic-pre", 75.1, 0.002, 7.9e-5),
    ("noise-orthographic-unlit", 68.1, 0.012, 1.3e-4),
    ("noise-orthographic-wide", 62.7, 0.021, 1.2e-4),
    ("noise-orthographic-xray", 87.5, 0.0006, 3.8e-5),
    ("noise-perspective-lit", 64.6, 0.015, 4.0e-4),
    ("noise-perspective-mean", 103.4, 0.0002, 1.0e-5),
    ("noise-perspective-minip", 98.8, 0.0006, 1.0e-5),
    ("noise-perspective-mip", 91.3, 0.0006, 1.9e-5),
    ("noise-perspective-none", 64.4, 0.011, 4.4e-4),
    ("noise-perspective-pre", 76.2, 0.002, 5.8e-5),
    ("noise-perspective-unlit", 69.6, 0.012, 9.6e-5),
    ("noise-perspective-wide", 63.2, 0.024, 5.8e-5),
    ("noise-perspective-xray", 85.3, 0.0013, 2.8e-5),
];

/// The demand on a picture.
pub(crate) fn of(name: &str) -> (f64, f64, f64) {
    let found = DEMANDS.iter().find(|demand| demand.0 == name);
    let &(_, psnr, largest, bias) = found.unwrap_or_else(|| panic!("no demand on {name}"));
    (psnr, largest, bias)
}
