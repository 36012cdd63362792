//! X-rays of several things: each is drawn as if it were alone, and its optical depths are added to those of the others.
//!
//! With the optical depths `tau_i` of a pixel, and their mean colours `c_i` and depths `z_i`,
//!
//! `tau = sum_i tau_i`, `c = sum_i tau_i c_i / tau`, `z = sum_i tau_i z_i / tau`,
//!
//! shown as one homogeneous slab (docs/numerics.md, mode xray): opacity `1 - exp(-tau)`, the transmittances' product. So a volume
//! has the picture among others that it has alone, with its levels of detail, of which a transmittance may be a mean.

use rayon::prelude::*;
use splatvol_scene::Frame;

/// Pixels that a thread takes together at least.
const TOGETHER: usize = 16_384;

/// Adds another X-ray of the same size to a frame.
pub(crate) fn add(frame: &mut Frame, other: &Frame) {
    let own = (
        &mut frame.image.pixels,
        &mut frame.depth,
        &mut frame.optical_depth,
    );
    let others = (&other.image.pixels, &other.depth, &other.optical_depth);
    own.into_par_iter().zip(others).with_min_len(TOGETHER).for_each(
        |((pixel, depth, tau), (others, others_depth, &others_tau))| {
            // What is too thin for an opacity has no colour either.
            if others[3] <= 0.0 {
                return;
            }
            if pixel[3] <= 0.0 {
                (*pixel, *depth, *tau) = (*others, *others_depth, others_tau);
                return;
            }
            let sum = *tau + others_tau;
            let share = others_tau / sum;
            let alpha = pixel[3] + others[3] - pixel[3] * others[3];
            let [own, mean] = [&*pixel, others].map(|&[r, g, b, a]| [r, g, b].map(|level| level / a));
            for channel in 0..3 {
                pixel[channel] = (own[channel] + (mean[channel] - own[channel]) * share) * alpha;
            }
            pixel[3] = alpha;
            *depth += (others_depth - *depth) * share;
            *tau = sum;
        },
    );
}

#[cfg(test)]
mod tests {
    use splatvol_scene::ImageSize;

    use super::*;

    /// A frame whose pixels all are slabs of these optical depths.
    fn slab(tau: f32, [r, g, b]: [f32; 3], depth: f32) -> Frame {
        let mut frame = Frame::empty(ImageSize::new(3, 2).unwrap());
        let alpha = -libm::expm1f(-tau);
        frame.image.pixels.fill([r * alpha, g * alpha, b * alpha, alpha]);
        frame.depth.fill(depth);
        frame.optical_depth.fill(tau);
        frame
    }

    #[test]
    fn slabs_add_up_whatever_their_order() {
        let parts = [
            slab(0.2, [1.0, 0.5, 0.0], 3.0),
            slab(1.3, [0.0, 0.25, 1.0], 5.0),
            slab(1e-4, [0.3, 0.3, 0.3], 1.0),
        ];
        let sum = 1.5001_f32;
        let mean = |values: [f32; 3]| (0.2 * values[0] + 1.3 * values[1] + 1e-4 * values[2]) / sum;
        let color = [
            mean([1.0, 0.0, 0.3]),
            mean([0.5, 0.25, 0.3]),
            mean([0.0, 1.0, 0.3]),
        ];
        let wanted = slab(sum, color, mean([3.0, 5.0, 1.0]));
        for order in [[0, 1, 2], [2, 1, 0], [1, 2, 0]] {
            let mut found = Frame::empty(ImageSize::new(3, 2).unwrap());
            for at in order {
                add(&mut found, &parts[at]);
            }
            for (found, wanted) in found.image.pixels.iter().zip(&wanted.image.pixels) {
                assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-6));
            }
            assert!((found.depth[0] - wanted.depth[0]).abs() < 1e-5);
            assert!((found.optical_depth[0] - sum).abs() < 1e-6);
        }
    }

    /// Where two levels of detail fade, transmittance and optical depth are a mean each, and not of each other.
    #[test]
    fn next_to_nothing_changes_next_to_nothing() {
        let mut faded = slab(2.0, [0.5, 0.4, 0.3], 2.0);
        for pixel in &mut faded.image.pixels {
            *pixel = pixel.map(|level| 0.6 * level);
        }
        for order in [false, true] {
            let mut found = faded.clone();
            let mut other = slab(1e-4, [0.1, 0.2, 0.9], 3.0);
            if order {
                std::mem::swap(&mut found, &mut other);
            }
            add(&mut found, &other);
            for (found, wanted) in found.image.pixels.iter().zip(&faded.image.pixels) {
                assert!(
                    found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 2e-4),
                    "{found:?}"
                );
            }
        }
    }

    /// Depths of which no opacity is left in single precision have no colour.
    #[test]
    fn nothing_changes_nothing() {
        let wanted = slab(0.7, [0.1, 0.2, 0.3], 2.0);
        let mut thin = slab(0.0, [0.0; 3], 2.0);
        thin.optical_depth.fill(1e-12);
        for nothing in [Frame::empty(ImageSize::new(3, 2).unwrap()), thin] {
            let mut found = wanted.clone();
            add(&mut found, &nothing);
            assert_eq!(found, wanted);
            let mut found = nothing;
            add(&mut found, &wanted);
            assert_eq!(found, wanted);
        }
    }
}
