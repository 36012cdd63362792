//! Splats: whole footprints, sorted by the depth of their centres, and composited one by one.
//!
//! 3-D Gaussians have the constants and the result of the published renderer (Kerbl, Kopanas, Leimkuehler and
//! Drettakis 2023, "3D Gaussian Splatting for Real-Time Radiance Field Rendering", sections 4 and 6); so do points
//! and samples of meshes beside them. Without Gaussians, or with volumetric ones, splats are optical depths in
//! linear light (Westover 1989; Zwicker et al. 2001), or are added up to X-rays (`blend`).
//!
//! ```text
//! V     = J M Sigma M^T J^T + low_pass I                       (Zwicker et al. 2002, "EWA Splatting", eq. 31)
//! alpha = min(0.99, o exp(-1/2 d^T V^-1 d))                    nothing where below 1/255
//! C    += T alpha rgb,   T *= 1 - alpha                        front to back; ends before T falls below 1e-4
//! ```
//!
//! | stage | module | what |
//! |---|---|---|
//! | project | `project`, `view`; `gaussians`, `kernels` | splats to ellipses on the screen; SIMD over splats |
//! | choose | `wanted` | splats that reach the tiles that a task asks for |
//! | order | `order` | all splats by the depth of their centres: stable radix sort, equal depths by index |
//! | bin | `bin` | splats in the lists of 32 x 32-pixel tiles, in order |
//! | cover | `cover` | which 4 x 4 blocks of a tile a splat's ellipse meets; SIMD over splats |
//! | composite | `composite`, `blend` | blocks of 16 pixels, SIMD over pixels; finished blocks are left out |
//! | resolve | `resolve` | blocks to the frame |
//!
//! `work` has what is compiled for each instruction set: project, and composite with cover and resolve.
//!
//! # Colours
//!
//! Gaussians are trained so that *display* (sRGB-encoded) colours are composited; linear compositing would change
//! the picture. So this engine composites display colours, too, and converts the finished picture:
//! un-premultiplied, decoded, premultiplied. A PNG written from it has the codes of the published renderer.
//! Composited over something in linear light, as [`splatvol_scene::Image::over`] does, half-transparent pixels
//! differ from that renderer's; a background of the settings is composited in display space.
//!
//! # Departures
//!
//! - Splats are cut off where their opacity falls below 1/255 instead of at the tiles that three standard deviations
//!   reach, *and* at these: the same pixels get the same contributions.
//! - The determinant of V is summed up without cancellation. Splats of more than some 1e9 pixels, which f32 cannot
//!   hold, are left out.
//! - The near limit, 0.2 there, is in the Gaussians' own units: scaling scene and camera changes nothing.
//! - Orthographic cameras (J constant, no limit of the angle, nothing behind the camera) do not exist there.
//! - Harmonics are evaluated in the Gaussians' frame, for a camera brought there; colours are cut at 1e4.
//!
//! Pictures are identical to the byte for any number of threads and any SIMD level. Cancellation takes effect
//! between chunks, parts and tiles, and within long lists.

mod bin;
mod blend;
mod composite;
mod cover;
mod engine;
mod gaussians;
mod kernels;
mod order;
mod project;
mod resolve;
mod settings;
mod view;
mod wanted;
mod work;

pub(crate) use engine::{Cloud, SplatEngine};
pub(crate) use settings::{BlendMode, CloudSettings, LowPass, Near};
pub(crate) use work::SplatWork;

#[cfg(test)]
mod tests;
