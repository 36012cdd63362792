//! Operators in WGSL against their Rust, over random samples.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use splatvol_scene::{
    Appearance, Bounds, BumpMap, EnvironmentMap, GradientOpacity, GradientOpacityPoint, Image, ImageSize,
    PixelOperator, Region, SheetSample, SolidTexture, Stuff, TransferFunction2d,
};
use splatvol_testing::random::Random;

use super::{device, read};
use crate::device::GpuDevice;
use crate::pass::{Pass, groups};

/// A sample and an appearance before, or an appearance after.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Row {
    gradient: [f32; 3],
    value: f32,
    position: [f32; 3],
    depth: f32,
    view: [f32; 3],
    extinction: f32,
    normal: [f32; 3],
    surfaceness: f32,
    color: [f32; 3],
    reflectance: f32,
    reflection: [f32; 3],
    unused: f32,
}

/// What an operator's author may rely on.
const SAMPLE: &str = include_str!("../../shaders/sample.wgsl");
/// An entry point that applies an operator to each row.
const HARNESS: &str = "
struct Row {
    gradient: vec3<f32>,
    value: f32,
    position: vec3<f32>,
    depth: f32,
    view: vec3<f32>,
    extinction: f32,
    normal: vec3<f32>,
    surfaceness: f32,
    color: vec3<f32>,
    reflectance: f32,
    reflection: vec3<f32>,
    unused: f32,
}
@group(0) @binding(0) var<storage, read> operands: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> rows: array<Row>;

fn operand(at: u32) -> vec4<f32> {
    return operands[at];
}

@compute @workgroup_size(64)
fn probe(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&rows) {
        return;
    }
    let row = rows[id.x];
    let sample = SheetSample(row.value, row.gradient, row.position, row.view, row.depth);
    var own = Appearance(row.color, row.extinction, row.normal, row.surfaceness, row.reflection, row.reflectance);
    OPERATOR(sample, &own, 0u);
    rows[id.x].color = own.color;
    rows[id.x].extinction = own.extinction;
    rows[id.x].normal = own.normal;
    rows[id.x].reflection = own.reflection;
    rows[id.x].reflectance = own.reflectance;
}
";

/// Random samples of values from 0 to 100 in a box of 20, gradients up to 50.
fn samples(count: usize) -> Vec<Row> {
    let mut random = Random::new(18);
    let mut float = |low, high| random.range(low, high) as f32;
    let mut rows = vec![Row::zeroed(); count];
    for row in &mut rows {
        row.value = float(0.0, 100.0);
        row.gradient = [(); 3].map(|()| float(-28.0, 28.0));
        row.position = [(); 3].map(|()| float(-10.0, 10.0));
        row.extinction = float(0.0, 3.0);
        row.surfaceness = float(0.0, 1.0);
        row.color = [(); 3].map(|()| float(0.0, 1.0));
        let mut direction = || Vec3::from_array([(); 3].map(|()| float(-1.0, 1.0)));
        [row.view, row.normal] = [direction(), direction()].map(|v| v.normalize_or(Vec3::Z).to_array());
    }
    rows
}

/// The appearance of a row after an operator in Rust.
fn applied(operator: &dyn PixelOperator, row: &Row) -> Appearance {
    let sample = SheetSample {
        value: row.value,
        gradient: row.gradient.into(),
        position: row.position.into(),
        view: row.view.into(),
        depth: row.depth,
    };
    let mut appearance = Appearance {
        color: row.color.into(),
        extinction: row.extinction,
        normal: row.normal.into(),
        surfaceness: row.surfaceness,
        reflection: row.reflection.into(),
        reflectance: row.reflectance,
    };
    operator.apply(&sample, &mut appearance);
    appearance
}

/// The rows after an operator in WGSL.
fn on_device(gpu: &GpuDevice, operator: &dyn PixelOperator, rows: &[Row]) -> Vec<Row> {
    use wgpu::BufferUsages as Usage;
    let own = operator.wgsl().unwrap();
    let text = [
        SAMPLE,
        &own.texts.join("\n"),
        &HARNESS.replace("OPERATOR", own.name),
    ]
    .join("\n");
    let pass = gpu.scoped(|gpu| Pass::new(gpu, ("probe", &text), &[])).unwrap();
    let operands = gpu.buffer_of("operands", &own.operands);
    let bytes: &[u8] = bytemuck::cast_slice(rows);
    let buffer = gpu.buffer(
        "rows",
        bytes.len() as u64,
        Usage::STORAGE | Usage::COPY_DST | Usage::COPY_SRC,
    );
    gpu.queue.write_buffer(&buffer, 0, bytes);
    let mut commands = gpu.commands();
    pass.run(
        gpu,
        &mut commands,
        &[(0, &operands), (1, &buffer)],
        groups(rows.len() as u32, 64),
    );
    gpu.queue.submit([commands.finish()]);
    read(gpu, &buffer, rows.len())
}

/// A picture of noise.
fn picture() -> Image {
    let mut random = Random::new(3);
    let pixels = (0..17 * 9)
        .map(|_| [(); 4].map(|()| random.unit() as f32))
        .collect();
    Image::from_pixels(ImageSize::new(17, 9).unwrap(), pixels).unwrap()
}

/// Every operator.
pub(super) fn all() -> Vec<(&'static str, Box<dyn PixelOperator>)> {
    let bounds = Bounds {
        min: DVec3::splat(-10.0),
        max: DVec3::new(10.0, 12.0, 9.0),
    };
    // Two factors at one gradient are a step.
    let curve = [(2.0, 0.1), (20.0, 0.9), (20.0, 0.4), (35.0, 1.0)]
        .map(|(gradient, factor)| GradientOpacityPoint { gradient, factor });
    let region = |value, gradient, softness| Region {
        value,
        gradient,
        rgb: [0.9, 0.5, 0.1],
        opacity: 0.7,
        softness,
    };
    let regions = [
        region([10.0, 60.0], [0.0, 30.0], 0.3),
        region([40.0, 90.0], [20.0, 48.0], 1.0),
    ];
    vec![
        (
            "gradient opacity",
            Box::new(GradientOpacity::new(&curve).unwrap()),
        ),
        ("one factor", Box::new(GradientOpacity::new(&curve[..1]).unwrap())),
        (
            "regions",
            Box::new(TransferFunction2d::new(&regions, 1.5).unwrap()),
        ),
        (
            "picture",
            Box::new(TransferFunction2d::from_image(&picture(), [5.0, 95.0], [0.0, 45.0], 2.0).unwrap()),
        ),
        (
            "marble",
            Box::new(SolidTexture::new(Stuff::Marble, &bounds, 0.2).unwrap()),
        ),
        (
            "wood",
            Box::new(SolidTexture::new(Stuff::Wood, &bounds, 0.2).unwrap()),
        ),
        (
            "bump map",
            Box::new(BumpMap::new(&picture(), &bounds, 0.1).unwrap()),
        ),
        (
            "environment map",
            Box::new(EnvironmentMap::new(&picture(), 0.6).unwrap()),
        ),
    ]
}

#[test]
fn operators_agree_with_their_rust() {
    let Some(gpu) = device() else { return };
    let rows = samples(4000);
    for (name, operator) in all() {
        let found = on_device(&gpu, &*operator, &rows);
        let mut most = 0.0f32;
        for (before, row) in rows.iter().zip(&found) {
            let wanted = applied(&*operator, before);
            let differences = [
                Vec3::from(row.color) - wanted.color,
                Vec3::from(row.normal) - wanted.normal,
                Vec3::from(row.reflection) - wanted.reflection,
                Vec3::new(
                    row.extinction - wanted.extinction,
                    row.reflectance - wanted.reflectance,
                    0.0,
                ),
            ];
            let own = differences
                .iter()
                .fold(0.0f32, |most, d| most.max(d.abs().max_element()));
            assert!(own.is_finite(), "{name}: {row:?} {wanted:?}");
            most = most.max(own);
        }
        // Drivers compute sines and arcs to some 1e-4 of a turn, which a picture of noise multiplies.
        assert!(most < 2e-3, "{name}: {most:e}");
    }
}
