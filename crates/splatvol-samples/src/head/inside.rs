//! Contents of the solids: soft tissue, brain, eyes, airways, and the texture of bone. Hounsfield units.

use glam::Vec3;

use super::solid::{Part, Solid, cone, ellipsoid};
use crate::noise::smooth;

fn step(low: f32, high: f32, value: f32) -> f32 {
    let t = ((value - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + t * (b - a)
}

/// Skin, the fat below it, then muscle with fatty planes.
pub(super) fn soft_tissue(p: Vec3, distance_to_skin: f32) -> f32 {
    let depth = -distance_to_skin;
    let layer = 5.0 + 1.5 * smooth(p * 0.08, 41);
    let fat = step(1.6, 2.6, depth) * (1.0 - step(layer - 0.6, layer + 0.6, depth));
    let planes = step(0.25, 0.5, smooth(p * Vec3::new(0.10, 0.10, 0.05), 42));
    let muscle = mix(56.0, 8.0, planes);
    mix(mix(28.0, muscle, step(2.0, 3.0, depth)), -85.0, fat)
}

/// Air that is not within bone: the nose and throat.
pub(super) fn airways() -> Solid {
    Solid::new([
        cone([7.0, 95.0, -12.0], [6.5, 70.0, -14.0], [4.0, 4.5]).mirrored(),
        ellipsoid([6.0, 60.0, -8.0], [5.0, 32.0, 14.0])
            .mirrored()
            .blend(2.0),
        cone([0.0, 24.0, -14.0], [0.0, 16.0, -60.0], [8.0, 6.0]).blend(4.0),
        cone([0.0, 16.0, -60.0], [0.0, 16.0, -90.0], [7.0, 6.0]).blend(4.0),
        cone([0.0, 17.0, -88.0], [0.0, 6.0, -150.0], [6.5, 8.0]).blend(4.0),
        ellipsoid([26.0, 65.0, -13.0], [11.5, 14.0, 12.0]).mirrored(),
        ellipsoid([9.0, 82.0, 40.0], [7.0, 3.4, 8.0]).mirrored(),
        ellipsoid([6.5, 24.0, 3.0], [5.4, 10.4, 7.4]).mirrored(),
        cone([80.0, -3.0, 1.0], [34.0, 2.0, 1.0], [2.6, 2.4]).mirrored(),
        ellipsoid([50.0, -14.0, -10.0], [4.0, 3.2, 7.0]).mirrored(),
        // Conchae and septum remain.
        cone([8.0, 80.0, -14.0], [8.0, 45.0, -13.0], [3.6, 3.6])
            .mirrored()
            .cut(1.0),
        cone([8.0, 76.0, -2.0], [8.0, 45.0, -1.0], [3.2, 3.4])
            .mirrored()
            .cut(1.0),
        ellipsoid([0.0, 64.0, -4.0], [1.8, 60.0, 30.0]).cut(1.0),
    ])
}

/// Eyeballs and optic nerves.
pub(super) fn globes() -> Solid {
    Solid::new([
        ellipsoid([31.5, 75.5, 16.0], [12.2, 12.2, 12.2]).mirrored(),
        cone([30.0, 64.0, 16.5], [15.0, 38.0, 18.0], [2.4, 2.2])
            .mirrored()
            .blend(2.0),
    ])
}

/// Vitreous, with the lens in front.
pub(super) fn globe(p: Vec3) -> f32 {
    let from_lens = (Vec3::new(p.x.abs(), p.y, p.z) - Vec3::new(31.5, 83.5, 16.0)) / Vec3::new(4.6, 2.4, 4.6);
    mix(80.0, 12.0, step(0.7, 1.3, from_lens.length()))
}

/// Lateral ventricles (bodies, frontal, occipital and temporal horns), third and fourth.
pub(super) fn ventricles() -> Solid {
    let horn = |a, b, radii| cone(a, b, radii).mirrored().blend(4.0);
    let parts: [Part; 6] = [
        horn([6.0, 30.0, 52.0], [11.0, -14.0, 62.0], [5.0, 5.5]),
        horn([11.0, -14.0, 62.0], [25.0, -34.0, 44.0], [5.5, 6.0]),
        horn([25.0, -34.0, 44.0], [21.0, -58.0, 40.0], [5.0, 2.5]),
        horn([25.0, -34.0, 44.0], [33.0, 4.0, 22.0], [4.0, 2.5]),
        ellipsoid([0.0, 2.0, 40.0], [2.2, 13.0, 10.0]).blend(3.0),
        ellipsoid([0.0, -30.0, 10.0], [6.0, 6.0, 11.0]).blend(3.0),
    ];
    Solid::new(parts)
}

/// Brain within its cavity at signed distance `distance_to_cavity`: fluid at the rim and in the sulci, a grey
/// cortex over white matter, grey nuclei, the falx in the midplane, and the ventricles (`ventricle`: share filled).
pub(super) fn brain(p: Vec3, distance_to_cavity: f32, ventricle: f32) -> f32 {
    const FLUID: f32 = 8.0;
    const GREY: f32 = 40.0;
    const WHITE: f32 = 29.0;
    let depth = -distance_to_cavity;
    if p.z < -25.0 {
        return mix(FLUID, 34.0, step(2.0, 3.2, depth));
    }
    let cerebellum = p.z < 14.0 && p.y < -18.0;
    let (scale, deepest) = if cerebellum {
        (Vec3::new(0.06, 0.10, 0.34), 6.0)
    } else {
        (Vec3::splat(0.085), 15.0)
    };
    let tissue = if depth < deepest + 6.0 {
        // Folds: the zero set of a warped smooth noise winds through the cortex as sulci do.
        let warp = Vec3::new(smooth(p * 0.05, 51), smooth(p * 0.05, 52), smooth(p * 0.05, 53));
        let fold = smooth(p * scale + 1.1 * warp, 54).abs() + 0.16 * (depth / deepest).max(0.0).powi(2);
        let sulcus = 1.0 - step(0.03, 0.09, fold);
        let to_surface = (12.0 * fold).min(depth - 2.0);
        let matter = mix(GREY, WHITE, step(3.2, 4.6, to_surface));
        mix(matter, FLUID, sulcus.max(1.0 - step(1.2, 2.4, depth)))
    } else {
        let nuclei =
            (Vec3::new(p.x.abs(), p.y, p.z) - Vec3::new(18.0, 4.0, 40.0)) / Vec3::new(9.0, 22.0, 12.0);
        mix(GREY, WHITE, step(0.85, 1.1, nuclei.length()))
    };
    let gap = 1.0 - step(0.8, 2.0, p.x.abs());
    let longitudinal = gap * step(46.0, 54.0, p.z + 0.5 * p.y.abs());
    mix(mix(tissue, FLUID, longitudinal), FLUID, ventricle)
}

/// Compact outside, spongy inside, by the signed distance to the surface.
pub(super) fn bone(p: Vec3, distance: f32) -> f32 {
    let depth = -distance;
    let spongy = step(1.7, 2.9, depth);
    if spongy <= 0.0 {
        return 1250.0 + 60.0 * smooth(p * 0.25, 61);
    }
    let pores = 170.0 * smooth(p * 0.55, 62) + 110.0 * smooth(p * 1.1, 63);
    mix(1250.0, 620.0 + pores, spongy)
}

/// Enamel on the crowns, dentine in the roots.
pub(super) fn tooth(p: Vec3) -> f32 {
    mix(1800.0, 1350.0, step(7.5, 10.5, (p.z + 43.0).abs()))
}

/// Depth (mm) of the sutures at a point of the vault's outer table: coronal, sagittal and lambdoid seams,
/// winding as the real ones do.
pub(super) fn suture(p: Vec3) -> f32 {
    let wind = 2.4 * smooth(p * 0.20, 71) + 1.5 * smooth(p * 0.55, 72);
    let coronal_y = 26.0 - 0.10 * (p.z - 110.0);
    let lambda_y = -66.0 + 0.34 * (p.x.abs() - 40.0).clamp(-40.0, 30.0) - 0.42 * (60.0 - p.z).max(-40.0);
    let coronal = (p.y - coronal_y + 0.7 * wind).abs();
    let sagittal = if p.y < coronal_y && p.z > 60.0 {
        (p.x + wind).abs()
    } else {
        9.0
    };
    let lambdoid = if p.y < -40.0 {
        0.8 * (p.y - lambda_y + 1.3 * wind).abs()
    } else {
        9.0
    };
    let nearest = coronal.min(sagittal).min(lambdoid);
    0.9 * (1.0 - step(0.5, 1.4, nearest))
}
