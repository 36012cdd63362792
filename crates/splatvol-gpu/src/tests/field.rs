//! Law 1: the field on planes is the reference's, to rounding and half a step of stored coefficients.

use glam::DVec3;
use splatvol_core::border::FADED;
use splatvol_reference::Reconstruction;
use splatvol_scene::RenderSettings;
use splatvol_testing::Random;

use super::{Subject, device};
use crate::layout::SheetData;

/// Sums of rounded products.
const ROUNDING: f64 = 2e-5;
/// Steps of coefficients that are stored in 16 bits per brick; ranges of coefficients are up to twice those of samples, and
/// products of weights sum to one.
const HALF_STEP: f64 = 2.0 * 0.5 / 65_535.0;

const PROBE: &str = "
@compute @workgroup_size(1)
fn probe(@builtin(workgroup_id) id: vec3<u32>) {
    let place = place_on(id.x, vec2(0.0));
    colors[id.x] = vec4(sum_at(place), share_at(place), coverage_at(place), sum_on(id.x, vec2(0.0)));
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
