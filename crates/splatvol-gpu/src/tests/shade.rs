//! Shading: WGSL functions against their Rust twins.

use splatvol_core::shade_table::PixelSegment;
use splatvol_scene::RenderSettings;
use splatvol_testing::Random;

use super::{Subject, device, input};

#[test]
fn values_are_classified_as_on_the_cpu() {
    const PROBE: &str = "
@compute @workgroup_size(1)
fn probe(@builtin(workgroup_id) id: vec3<u32>) {
    let ends = sheets[id.x].rest.xy;
    let material = segment(ends, classify(ends.x), classify(ends.y));
    colors[id.x] = vec4(material.extinction, material.place, material.value, color_of(ends.x).g);
}
";
    let Some(gpu) = device() else { return };
    let subject = Subject::new(RenderSettings::fast(), [9, 9, 9]);
    let mut random = Random::new(7);
    let inputs: Vec<_> = (0..3000)
        .map(|i| {
            let first = random.range(-0.4, 1.9) as f32;
            // Pairs that are far apart, close to each other, and equal.
            let apart = [1.0, 3e-3, 1e-3, 0.0][i % 4] * random.range(-1.0, 1.0) as f32;
            input([first, first + apart, 0.0], [0.0; 3], 0.0)
        })
        .collect();
    let (found, facts) = subject.run(&gpu, PROBE, &inputs);
    for (input, &[extinction, place, value, green]) in inputs.iter().zip(&found) {
        let ends = [input.rest[0], input.rest[1]];
        let classified = ends.map(|end| facts.table.point(end));
        let wanted = PixelSegment::between(ends, [&classified[0], &classified[1]]);
        let scale = 1e-3 * facts.table.densest.max(wanted.extinction);
        assert!((extinction - wanted.extinction).abs() < scale, "{ends:?}");
        // The place is a ratio of differences: rounding weighs most where ends are close.
        let rise = (ends[1] - ends[0]).abs().max(1e-6);
        assert!(
            (place - wanted.place).abs() < 1e-3 + 2e-6 / rise,
            "{ends:?}: {place} {}",
            wanted.place
        );
        let at = (ends[1] - ends[0]) * place + ends[0];
        assert!((value - at).abs() < 1e-6, "{ends:?}");
        assert!(
            (green - facts.table.color_of(ends[0])[1]).abs() < 1e-6,
            "{ends:?}"
        );
    }
}

#[test]
fn light_is_that_of_the_model() {
    const PROBE: &str = "
@compute @workgroup_size(1)
fn probe(@builtin(workgroup_id) id: vec3<u32>) {
    colors[id.x] = vec4(phong(sheets[id.x].rest), cumulative(sheets[id.x].step_x.x), 0.0);
}
";
    let Some(gpu) = device() else { return };
    let subject = Subject::new(RenderSettings::fast(), [9, 9, 9]);
    let light = subject.settings.lighting.unwrap();
    let towards = glam::DVec3::from_array(light.direction).normalize();
    let half_way = (towards - glam::DVec3::Z).normalize();
    let mut random = Random::new(8);
    let inputs: Vec<_> = (0..2000)
        .map(|i| {
            let length = 10f64.powf(random.range(-5.0, 1.0)) * f64::from(u8::from(i > 0));
            let gradient = std::array::from_fn(|_| (length * random.range(-1.0, 1.0)) as f32);
            input(gradient, [random.range(-6.0, 6.0) as f32, 0.0, 0.0], 0.0)
        })
        .collect();
    let (found, _) = subject.run(&gpu, PROBE, &inputs);
    for (input, &[diffuse, specular, share, _]) in inputs.iter().zip(&found) {
        let gradient = glam::DVec3::from_array(input.rest.map(f64::from));
        let squared = gradient.length_squared().max(1e-12);
        let surface = squared / (squared + light.gradient_floor.powi(2));
        let cosine = |v: glam::DVec3| (gradient.dot(v).abs() / squared.sqrt()).min(1.0);
        let wanted = light.ambient + light.diffuse * (1.0 + surface * (cosine(towards) - 1.0));
        assert!((f64::from(diffuse) - wanted).abs() < 1e-5, "{gradient}");
        let wanted = light.specular * surface * cosine(half_way).powf(light.specular_power);
        assert!((f64::from(specular) - wanted).abs() < 2e-5, "{gradient}");
        let x = f64::from(input.step_x[0]);
        assert!(
            (f64::from(share) - libm::erfc(-x / 2f64.sqrt()) / 2.0).abs() < 3e-4,
            "{x}"
        );
    }
}

#[test]
fn slopes_are_derivatives_of_cubics() {
    const PROBE: &str = "
@compute @workgroup_size(1)
fn probe(@builtin(workgroup_id) id: vec3<u32>) {
    let own = sheets[id.x];
    let values = vec4(own.rest, own.step_x.x);
    colors[id.x] = vec4(depth_slope(values, own.low_pass, 1.0 / 24.0), 0.0, 0.0, 0.0);
}
";
    let Some(gpu) = device() else { return };
    let subject = Subject::new(RenderSettings::fast(), [9, 9, 9]);
    let mut random = Random::new(9);
    let cubics: Vec<[f32; 5]> = (0..500)
        .map(|_| std::array::from_fn(|_| random.range(-1.0, 1.0) as f32))
        .collect();
    // Values of a cubic at -1, 0, 1 and 2: with a sharpness of 1/24 slopes are those of its derivative.
    let inputs: Vec<_> = cubics
        .iter()
        .map(|&[a, b, c, d, u]| {
            let at = |x: f32| ((d * x + c) * x + b) * x + a;
            input([at(-1.0), at(0.0), at(1.0)], [at(2.0), 0.0, 0.0], u.abs())
        })
        .collect();
    let (found, facts) = subject.run(&gpu, PROBE, &inputs);
    assert!(facts.spacing > 0.0);
    for (&[_, b, c, d, u], &[slope, ..]) in cubics.iter().zip(&found) {
        let u = u.abs();
        let wanted = (3.0 * d * u + 2.0 * c) * u + b;
        assert!((slope - wanted).abs() < 2e-5, "{slope} {wanted}");
    }
}
