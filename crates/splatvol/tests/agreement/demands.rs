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
    ("ball-perspective-mip", 95.0, 0.00043, 1.0e-5),
    ("ball-perspective-pre", 77.6, 0.0018, 5.8e-5),
    ("ball-perspective-unlit", 73.7, 0.0022, 1.5e-4),
    ("ball-perspective-xray", 91.1, 0.00043, 1.7e-5),
    ("head-orthographic-lit", 58.5, 0.023, 8.7e-4),
    ("head-orthographic-mean", 92.8, 0.00077, 1.0e-5),
    ("head-orthographic-minip", 120.0, 0.0002, 1.0e-5),
    ("head-orthographic-mip", 72.8, 0.0052, 1.5e-5),
    ("head-orthographic-pre", 64.7, 0.0069, 2.9e-4),
    ("head-orthographic-unlit", 72.1, 0.0069, 9.4e-5),
    ("head-orthographic-xray", 76.0, 0.0027, 6.0e-5),
    ("head-perspective-lit", 59.4, 0.019, 6.8e-4),
    ("head-perspective-mean", 103.2, 0.0006, 1.0e-5),
    ("head-perspective-minip", 120.0, 0.0002, 1.0e-5),
    ("head-perspective-mip", 77.8, 0.0029, 5.3e-5),
    ("head-perspective-plain", 66.8, 0.011, 2.8e-4),
    ("head-perspective-pre", 66.0, 0.0073, 2.3e-4),
    ("head-perspective-unlit", 72.8, 0.0083, 7.9e-5),
    ("head-perspective-xray", 76.4, 0.0035, 4.3e-5),
    ("marschner-lobb-orthographic-lit", 48.3, 0.047, 4.3e-3),
    ("marschner-lobb-orthographic-mean", 76.0, 0.005, 4.0e-5),
    ("marschner-lobb-orthographic-minip", 68.0, 0.015, 2.0e-4),
    ("marschner-lobb-orthographic-mip", 66.0, 0.02, 2.0e-4),
    ("marschner-lobb-orthographic-pre", 69.5, 0.003, 4.1e-4),
    ("marschner-lobb-orthographic-unlit", 62.2, 0.027, 9.0e-4),
    ("marschner-lobb-orthographic-xray", 88.2, 0.00043, 3.6e-5),
    ("marschner-lobb-perspective-lit", 49.6, 0.049, 2.9e-3),
    ("marschner-lobb-perspective-mean", 74.0, 0.01, 5.0e-5),
    ("marschner-lobb-perspective-minip", 68.0, 0.015, 2.0e-4),
    ("marschner-lobb-perspective-mip", 66.6, 0.014, 1.1e-4),
    ("marschner-lobb-perspective-pre", 71.2, 0.0029, 3.1e-4),
    ("marschner-lobb-perspective-unlit", 62.6, 0.027, 5.9e-4),
    ("marschner-lobb-perspective-xray", 88.3, 0.0006, 2.8e-5),
    ("noise-orthographic-lit", 59.4, 0.046, 7.2e-4),
    ("noise-orthographic-mean", 99.3, 0.00043, 1.0e-5),
    ("noise-orthographic-minip", 88.9, 0.0025, 1.0e-5),
    ("noise-orthographic-mip", 86.0, 0.0013, 2.3e-5),
    ("noise-orthographic-none", 58.7, 0.026, 8.0e-4),
    ("noise-orthographic-pre", 75.1, 0.002, 7.9e-5),
    ("noise-orthographic-unlit", 67.4, 0.012, 1.3e-4),
    ("noise-orthographic-wide", 62.7, 0.021, 1.9e-4),
    ("noise-orthographic-xray", 87.5, 0.0006, 3.8e-5),
    ("noise-perspective-lit", 60.8, 0.029, 5.3e-4),
    ("noise-perspective-mean", 101.5, 0.00026, 1.0e-5),
    ("noise-perspective-minip", 97.0, 0.0006, 1.0e-5),
    ("noise-perspective-mip", 87.9, 0.00077, 1.9e-5),
    ("noise-perspective-none", 60.9, 0.024, 5.7e-4),
    ("noise-perspective-pre", 76.2, 0.002, 5.8e-5),
    ("noise-perspective-unlit", 68.6, 0.012, 9.6e-5),
    ("noise-perspective-wide", 63.2, 0.024, 7.4e-5),
    ("noise-perspective-xray", 85.3, 0.0013, 2.8e-5),
];

/// The demand on a picture.
pub(crate) fn of(name: &str) -> (f64, f64, f64) {
    let found = DEMANDS.iter().find(|demand| demand.0 == name);
    let &(_, psnr, largest, bias) = found.unwrap_or_else(|| panic!("no demand on {name}"));
    (psnr, largest, bias)
}
