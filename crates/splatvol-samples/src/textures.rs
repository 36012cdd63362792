//! Volumes for the papers' figures and for benchmarks: checkers, stripes and shells.

use glam::Vec3;

use crate::fill::voxels;
use crate::noise;

/// Value of the dark squares; air is 0.
pub(crate) const DARK: u8 = 100;
/// Value of the light squares.
pub(crate) const LIGHT: u8 = 200;

/// Squares of 10 voxels in the plane (swan1997, figure 7: 498 x 398 x 1, alternate 10 x 10 squares).
pub(crate) fn checker_sheet(dims: [usize; 3]) -> Vec<u8> {
    voxels(dims, |[x, y, _]| shade(x / 10 + y / 10))
}

/// A hollow tube along z, checkered on its wall (mueller1998, figure 5: 160 x 160 x 300). The paper does not give
/// the size of the squares: 10 voxels long, 32 around.
pub(crate) fn tunnel(dims: [usize; 3]) -> Vec<u8> {
    const AROUND: f32 = 32.0;
    let half = dims[0].min(dims[1]) as f32 / 2.0;
    let (inner, outer) = (0.80 * half, 0.95 * half);
    voxels(dims, |[x, y, z]| {
        let dx = x as f32 + 0.5 - dims[0] as f32 / 2.0;
        let dy = y as f32 + 0.5 - dims[1] as f32 / 2.0;
        if !(inner..=outer).contains(&libm::hypotf(dx, dy)) {
            return 0;
        }
        let turn = libm::atan2f(dy, dx) / std::f32::consts::TAU + 0.5;
        shade((turn * AROUND) as usize % AROUND as usize + z / 10)
    })
}

/// Wavy stripes across a thin slab (zwicker2001, figure 8 shows a zebra texture of 1024 x 512; its pattern is not
/// given). Stripes narrow from 48 to 12 voxels along y, so that one picture crosses the pixel size.
pub(crate) fn zebra(dims: [usize; 3]) -> Vec<u8> {
    let scale = dims[0] as f32 / 1024.0;
    voxels(dims, |[x, y, _]| {
        let (u, v) = (x as f32 / dims[0].max(1) as f32, y as f32 / dims[1].max(1) as f32);
        let bend = noise::smooth(Vec3::new(5.0 * u, 3.0 * v, 0.0), 11)
            + 0.4 * noise::smooth(Vec3::new(14.0 * u, 9.0 * v, 0.0), 12);
        let width = 48.0 - 36.0 * v;
        let phase = std::f32::consts::PI * (x as f32 / scale + 60.0 * bend) / width;
        // A soft edge of about one voxel: the texture is band-limited, as a scanned one would be.
        let edge = (libm::sinf(phase) * width / std::f32::consts::PI * scale).clamp(-1.0, 1.0);
        let (dark, light) = (f32::from(DARK), f32::from(LIGHT));
        (0.5 * (dark + light) + 0.5 * (light - dark) * edge) as u8
    })
}

fn shade(square: usize) -> u8 {
    if square.is_multiple_of(2) { DARK } else { LIGHT }
}

/// Three nested shells with noisy radii, 0 between them: about a tenth of the voxels are not empty, as in the
/// usual benchmark scenes for renderers.
pub(crate) fn shells(dims: [usize; 3]) -> Vec<u8> {
    /// Radius, share of the half side; thickness in voxels of 256; peak.
    const SHELLS: [(f32, f32, f32); 3] = [(0.86, 4.0, 110.0), (0.60, 4.5, 180.0), (0.34, 5.0, 250.0)];
    let half = Vec3::from_array(dims.map(|n| n as f32 / 2.0));
    let voxel = 128.0 / half.min_element();
    voxels(dims, |[x, y, z]| {
        let p = (Vec3::new(x as f32, y as f32, z as f32) + Vec3::splat(0.5) - half) / half;
        let radius = p.length();
        if radius > 1.0 {
            return 0;
        }
        let bump = 0.03 * noise::smooth(6.0 * p, 21) + 0.012 * noise::smooth(17.0 * p, 22);
        let mut value = 0.0f32;
        for (shell, thickness, peak) in SHELLS {
            let offset = (radius + bump - shell) * 128.0 / thickness.max(voxel);
            value = value.max(peak * (1.0 - offset * offset));
        }
        if value <= 0.0 {
            return 0;
        }
        let grain = noise::white(x as i32, y as i32, z as i32, 23);
        (value * (1.0 + 0.06 * grain)).clamp(1.0, 255.0) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checkers_alternate_every_ten_voxels() {
        let dims = [40, 30, 1];
        let values = checker_sheet(dims);
        for (i, &value) in values.iter().enumerate() {
            let even = (i % 40 / 10 + i / 40 / 10) % 2 == 0;
            assert_eq!(value, if even { DARK } else { LIGHT });
        }
    }

    #[test]
    fn tunnel_is_hollow_and_its_wall_has_both_shades() {
        let values = tunnel([40, 40, 20]);
        assert_eq!(values[10 * 1600 + 20 * 40 + 20], 0);
        assert_eq!(values[0], 0);
        let count = |shade| values.iter().filter(|&&v| v == shade).count() as f64;
        assert!((count(DARK) / count(LIGHT) - 1.0).abs() < 0.05);
    }

    #[test]
    fn zebra_keeps_between_its_shades() {
        let values = zebra([256, 128, 1]);
        assert!(values.iter().all(|v| (DARK..=LIGHT).contains(v)));
        let light = values.iter().filter(|&&v| v > 150).count() as f64 / values.len() as f64;
        assert!((0.4..0.6).contains(&light), "{light}");
    }

    #[test]
    fn a_tenth_of_the_shells_is_filled() {
        let values = shells([96, 96, 96]);
        let filled = values.iter().filter(|&&v| v > 0).count() as f64 / values.len() as f64;
        assert!((0.08..0.16).contains(&filled), "{filled}");
    }
}
