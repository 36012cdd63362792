//! Law 1: the field on planes is the reference's, to rounding and half a step of stored coefficients.

use glam::DVec3;
use splatvol_core::border::FADED;
use splatvol_reference::Reconstruction;
use splatvol_scene::RenderSettings;
use splatvol_testing::Random;

use super::{Subject, device};
use crate::layout::SheetData;
use crate::mode::Mode;

/// Sums of rounded products.
const ROUNDING: f64 = 2e-5;
/// Steps of coefficients that are stored in 16 bits per brick; ranges of coefficients are up to twice those of samples, and
/// products of weights sum to one.
const HALF_STEP: f64 = 2.0 * 0.5 / 65_535.0;

const PROBE: &str = "
@compute @workgroup_size(1)
fn probe(@builtin(workgroup_id) id: vec3<u32>) {
    let place = place_on(id.x, vec2(0.0));
    colors[id.x] = vec4(sums_at(place).x, share_at(place), coverage_at(place), sums_on(id.x, vec2(0.0)).x);
}
";

#[test]
fn values_are_those_of_the_reference() {
    let Some(gpu) = device() else { return };
    for (seed, settings) in [
        (1, RenderSettings::fast()),
        (2, RenderSettings::balanced()),
        (3, RenderSettings::best()),
    ] {
        let dims = [23, 17, 20];
        let subject = Subject::new(settings, dims);
        let mut random = Random::new(seed);
        // In lattice coordinates: a sample beyond each face.
        let places: Vec<DVec3> = (0..4000)
            .map(|_| DVec3::from_array(dims.map(|n| random.range(-0.5, n as f64 + 1.5))))
            .collect();
        let inputs: Vec<_> = places
            .iter()
            .map(|place| SheetData {
                cell: place.floor().as_ivec3().to_array(),
                rest: (place - place.floor()).as_vec3().to_array(),
                ..super::input([0.0; 3], [0.0; 3], 0.0)
            })
            .collect();
        let (found, facts) = subject.run(&gpu, PROBE, &inputs);
        let kernel = subject.settings.method.kernel.into();
        let reference =
            Reconstruction::new(&subject.volume, &kernel, subject.settings.method.prefilter).unwrap();
        let mut largest = 0.0f64;
        for (place, &[sum, share, coverage, filtered]) in places.iter().zip(&found) {
            assert_eq!(sum, filtered);
            let sums = reference.sums(*place - 1.0);
            let share = f64::from(share);
            if share > f64::from(FADED) {
                let value = f64::from(sum) / share + f64::from(facts.background);
                largest = largest.max((value - sums.s / sums.w).abs());
            }
            let wanted = ((sums.b - 0.5) / 0.98 + 0.5).clamp(0.0, 1.0);
            assert!(
                (f64::from(coverage) - wanted).abs() < 1e-3,
                "{place}: {coverage} {wanted}"
            );
        }
        assert!(largest < ROUNDING + HALF_STEP, "{seed}: {largest:e}");
    }
}

const JET_PROBE: &str = "
@compute @workgroup_size(1)
fn probe(@builtin(workgroup_id) id: vec3<u32>) {
    let jet = jet_at(place_on(id.x, vec2(0.0)), 0);
    colors[id.x] = vec4(jet.sum, jet.slope);
}
";

/// Sum of a kernel's weights around a place along one axis, and its derivative.
fn weight_sums(at: f64, sigma: f64, radius: f64) -> [f64; 2] {
    let offsets = (-4..=4).map(|step| at - (at.floor() + f64::from(step)));
    let within = offsets.filter(|offset| offset.abs() <= radius);
    within.fold([0.0; 2], |[sum, slope], offset| {
        let weight = (-0.5 * (offset / sigma).powi(2)).exp();
        [sum + weight, slope - weight * offset / (sigma * sigma)]
    })
}

/// Inside, where the share of the weights is one: `grad v = (grad S - v grad W) / W`.
#[test]
fn gradients_are_those_of_the_reference() {
    let Some(gpu) = device() else { return };
    for (seed, settings) in [(4, RenderSettings::fast()), (5, RenderSettings::best())] {
        let dims = [23, 17, 20];
        let mut subject = Subject::new(settings, dims);
        subject.mode = Mode::Analytic;
        let kernel = subject.settings.method.kernel;
        let mut random = Random::new(seed);
        let places: Vec<DVec3> = (0..3000)
            .map(|_| DVec3::from_array(dims.map(|n| random.range(5.0, n as f64 - 4.0))))
            .collect();
        let inputs: Vec<_> = places
            .iter()
            .map(|place| SheetData {
                cell: place.floor().as_ivec3().to_array(),
                rest: (place - place.floor()).as_vec3().to_array(),
                ..super::input([0.0; 3], [0.0; 3], 0.0)
            })
            .collect();
        let (found, facts) = subject.run(&gpu, JET_PROBE, &inputs);
        let reference =
            Reconstruction::new(&subject.volume, &kernel.into(), subject.settings.method.prefilter).unwrap();
        for (place, &[sum, x, y, z]) in places.iter().zip(&found) {
            let sums = reference.sums(*place - 1.0);
            let [wx, wy, wz] = place
                .to_array()
                .map(|at| weight_sums(at, kernel.sigma, kernel.radius));
            let relative = DVec3::new(wx[1] / wx[0], wy[1] / wy[0], wz[1] / wz[0]);
            let wanted = sums.grad_s / sums.w - sums.value() * relative;
            let own = DVec3::new(f64::from(x), f64::from(y), f64::from(z));
            let value = f64::from(sum) + f64::from(facts.background);
            assert!(
                (value - sums.value()).abs() < ROUNDING + HALF_STEP,
                "{seed} {place}"
            );
            // Weights' derivatives add up to at most 2 per voxel.
            assert!(
                (own - wanted).abs().max_element() < 3.0 * (ROUNDING + HALF_STEP),
                "{seed} {place}: {own} {wanted}"
            );
        }
    }
}
