//! Structural similarity.

const SIDE: usize = 8;
/// Constants of the paper for 8 bits: `(0.01 * 255)²`, `(0.03 * 255)²`.
const C: [f64; 2] = [2.55 * 2.55, 7.65 * 7.65];

/// Structural similarity (Wang et al. 2004) of two pictures of `width` pixels, rows one after another: the mean over
/// windows of 8 x 8 pixels, of the worst channel. As the crate `image-compare` has it, (co)variances are sums.
pub(crate) fn structural_similarity(a: &[[u8; 3]], b: &[[u8; 3]], width: usize) -> f64 {
    let of_channel = |channel: usize| {
        let plane = |pixels: &[[u8; 3]]| pixels.iter().map(|pixel| pixel[channel]).collect::<Vec<_>>();
        similarity(&plane(a), &plane(b), width)
    };
    [0, 1, 2].map(of_channel).into_iter().fold(1.0, f64::min)
}

fn similarity(a: &[u8], b: &[u8], width: usize) -> f64 {
    let height = a.len() / width;
    let (mut sum, mut area) = (0.0, 0.0);
    for top in (0..height).step_by(SIDE) {
        for left in (0..width).step_by(SIDE) {
            let rows = top..height.min(top + SIDE);
            let columns = left..width.min(left + SIDE);
            let places = rows.flat_map(|y| columns.clone().map(move |x| y * width + x));
            let pairs: Vec<_> = places.map(|i| [a[i], b[i]].map(f64::from)).collect();
            sum += of_window(&pairs) * pairs.len() as f64;
            area += pairs.len() as f64;
        }
    }
    sum / area
}

fn of_window(pairs: &[[f64; 2]]) -> f64 {
    let mean = [0, 1].map(|i| pairs.iter().map(|pair| pair[i]).sum::<f64>() / pairs.len() as f64);
    let product = |i: usize, j: usize| -> f64 {
        let parts = pairs.iter().map(|pair| (pair[i] - mean[i]) * (pair[j] - mean[j]));
        parts.sum()
    };
    let luminance = (2.0 * mean[0] * mean[1] + C[0]) / (mean[0].powi(2) + mean[1].powi(2) + C[0]);
    let structure = (2.0 * product(0, 1) + C[1]) / (product(0, 0) + product(1, 1) + C[1]);
    luminance * structure
}

#[cfg(test)]
mod tests {
    use super::*;
    use image_compare::Algorithm;
    use image_compare::prelude::RgbImage;

    #[test]
    fn it_is_that_of_image_compare() {
        let [width, height] = [37, 21];
        let picture = |step: u32| -> Vec<[u8; 3]> {
            let code =
                |i: u32, c: u32| (i.wrapping_mul(7 + step).wrapping_add(c * 50 + i * i / 90) % 251) as u8;
            (0..width * height)
                .map(|i| [code(i, 0), code(i, 1), code(i / 3, step)])
                .collect()
        };
        let [a, b] = [picture(0), picture(1)];
        let image =
            |pixels: &[[u8; 3]]| RgbImage::from_raw(width, height, pixels.as_flattened().to_vec()).unwrap();
        let expected =
            image_compare::rgb_similarity_structure(&Algorithm::MSSIMSimple, &image(&a), &image(&b)).unwrap();
        let found = structural_similarity(&a, &b, width as usize);
        assert!(
            (found - expected.score).abs() < 1e-9,
            "{found}, {}",
            expected.score
        );
        assert!(found < 0.9);
        assert_eq!(structural_similarity(&a, &a, width as usize), 1.0);
    }
}
