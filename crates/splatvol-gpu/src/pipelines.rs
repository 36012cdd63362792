//! Pipelines: shaders, composed of parts, and the layouts of their bindings.

use std::collections::HashMap;
use std::sync::Arc;

use splatvol_scene::SceneError;

use crate::atlas::ASSEMBLE;
use crate::clouds::{CloudMarch, CloudPasses, IntegralPasses};
use crate::device::GpuDevice;
use crate::error::GpuError;
use crate::mode::{CloudMode, Mode, classify_shader, mixture_shader};
use crate::pass::Pass;

const FRAME: &str = include_str!("../shaders/frame.wgsl");
const CULL: &str = include_str!("../shaders/cull.wgsl");
/// The text of `clear`.
pub(crate) const CLEAR: &str = include_str!("../shaders/clear.wgsl");

/// The text of `cull`.
pub(crate) fn cull_shader() -> String {
    [FRAME, CULL].join("\n")
}

/// Passes, compiled.
#[derive(Debug)]
pub(crate) struct Pipelines {
    pub cull: wgpu::ComputePipeline,
    pub cull_layout: wgpu::BindGroupLayout,
    pub clear: Pass,
    pub assemble: Pass,
    pub march_layout: wgpu::BindGroupLayout,
    pub nearest: wgpu::Sampler,
    /// Passes over planes, compiled when they are first used.
    marches: HashMap<Variant, Marches>,
    /// Passes that classify voxels, likewise.
    classify: HashMap<Classify, Arc<Pass>>,
    /// Composites several layers; compiled likewise.
    mixture: Option<Arc<Pass>>,
    /// Passes of clouds; compiled likewise.
    clouds: Option<Arc<CloudPasses>>,
    /// Passes of clouds' integrals; compiled likewise.
    integral: Option<Arc<IntegralPasses>>,
    /// Passes over planes of clouds; compiled likewise.
    cloud_marches: HashMap<(CloudMode, Arc<str>), Arc<CloudMarch>>,
}

/// How voxels are classified.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Classify {
    /// Voxels along an axis that a kernel meets: 4 or 6.
    pub taps: i32,
    /// Whether their classes are means of a finer level's.
    pub from_means: bool,
    /// Whether their values are labels.
    pub labels: bool,
}

/// A mode for a kernel and a camera.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct Variant {
    pub mode: Mode,
    /// The function `operate`, in the mode of effects.
    pub operators: Arc<str>,
    /// Voxels along an axis that a kernel meets: 4 or 6.
    pub taps: i32,
    /// Whether the kernel ends nearer than the outermost of them can be.
    pub is_cut: bool,
    /// Whether a plane has a low-pass.
    pub has_low_pass: bool,
    /// Whether the camera is within the volume.
    pub from_eye: bool,
    /// Whether samples are missing.
    pub has_holes: bool,
    /// Whether intervals are kept beside those of other layers.
    pub gathers: bool,
}

/// Passes over planes.
#[derive(Debug, Clone)]
pub(crate) struct Marches {
    pub march: wgpu::ComputePipeline,
    /// From what rays kept to colours.
    pub settle: Option<wgpu::ComputePipeline>,
}

fn entry(binding: u32, ty: wgpu::BindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty,
        count: None,
    }
}

fn buffer(ty: wgpu::BufferBindingType) -> wgpu::BindingType {
    wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    }
}

const UNIFORM: wgpu::BufferBindingType = wgpu::BufferBindingType::Uniform;
const READ: wgpu::BufferBindingType = wgpu::BufferBindingType::Storage { read_only: true };
const WRITE: wgpu::BufferBindingType = wgpu::BufferBindingType::Storage { read_only: false };

impl Pipelines {
    /// Compiles all passes.
    ///
    /// # Errors
    /// A driver that refuses a shader.
    pub(crate) fn new(gpu: &GpuDevice) -> Result<Self, GpuError> {
        gpu.scoped(Self::compile).map_err(|error| GpuError::Shader {
            adapter: gpu.name.clone(),
            reason: error.to_string(),
        })
    }

    fn compile(gpu: &GpuDevice) -> Self {
        let device = &gpu.device;
        let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries,
            })
        };
        let cull_layout = layout(
            "cull",
            &[
                entry(0, buffer(UNIFORM)),
                entry(2, buffer(READ)),
                entry(3, buffer(WRITE)),
            ],
        );
        let atlas = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2Array,
            multisampled: false,
        };
        let march_layout = layout(
            "march",
            &[
                entry(0, buffer(UNIFORM)),
                entry(1, buffer(READ)),
                entry(2, buffer(READ)),
                entry(3, buffer(READ)),
                entry(4, atlas),
                entry(
                    5,
                    wgpu::BindingType::Sampler(wgpu::SamplerBindingType::NonFiltering),
                ),
                entry(6, buffer(READ)),
                entry(7, buffer(WRITE)),
                entry(8, buffer(WRITE)),
                entry(9, buffer(READ)),
                entry(10, buffer(WRITE)),
            ],
        );
        Self {
            cull: pipeline(device, ("cull", &cull_shader()), &cull_layout, &[]),
            cull_layout,
            clear: Pass::new(gpu, ("clear", CLEAR), &[]),
            assemble: Pass::new(gpu, ("assemble", ASSEMBLE), &[]),
            march_layout,
            nearest: device.create_sampler(&wgpu::SamplerDescriptor::default()),
            marches: HashMap::new(),
            classify: HashMap::new(),
            mixture: None,
            clouds: None,
            integral: None,
            cloud_marches: HashMap::new(),
        }
    }

    /// The passes of a variant.
    ///
    /// # Errors
    /// A driver that refuses a shader.
    pub(crate) fn marches(&mut self, gpu: &GpuDevice, variant: Variant) -> Result<Marches, SceneError> {
        if let Some(known) = self.marches.get(&variant) {
            return Ok(known.clone());
        }
        let made = gpu.scoped(|gpu| self.compile_march(gpu, &variant))?;
        self.marches.insert(variant, made.clone());
        Ok(made)
    }

    /// The pass that classifies voxels.
    ///
    /// # Errors
    /// A driver that refuses a shader.
    pub(crate) fn classify(&mut self, gpu: &GpuDevice, how: Classify) -> Result<Arc<Pass>, SceneError> {
        if let Some(known) = self.classify.get(&how) {
            return Ok(Arc::clone(known));
        }
        let constants = [
            ("TAPS", f64::from(how.taps)),
            ("FROM_MEANS", f64::from(u8::from(how.from_means))),
            ("LABELS", f64::from(u8::from(how.labels))),
        ];
        let text = classify_shader();
        let made = Arc::new(gpu.scoped(|gpu| Pass::new(gpu, ("classify", &text), &constants))?);
        self.classify.insert(how, Arc::clone(&made));
        Ok(made)
    }

    /// The pass that composites several layers.
    ///
    /// # Errors
    /// A driver that refuses a shader.
    pub(crate) fn mixture(&mut self, gpu: &GpuDevice) -> Result<Arc<Pass>, SceneError> {
        let made = match self.mixture.take() {
            Some(known) => known,
            None => Arc::new(gpu.scoped(|gpu| Pass::new(gpu, ("mixture", &mixture_shader()), &[]))?),
        };
        Ok(Arc::clone(self.mixture.insert(made)))
    }

    /// The passes that all clouds have.
    ///
    /// # Errors
    /// A driver that refuses a shader.
    pub(crate) fn clouds(&mut self, gpu: &GpuDevice) -> Result<Arc<CloudPasses>, SceneError> {
        let made = match self.clouds.take() {
            Some(known) => known,
            None => Arc::new(CloudPasses::new(gpu)?),
        };
        Ok(Arc::clone(self.clouds.insert(made)))
    }

    /// The passes of a cloud's integrals.
    ///
    /// # Errors
    /// A driver that refuses a shader.
    pub(crate) fn integral(&mut self, gpu: &GpuDevice) -> Result<Arc<IntegralPasses>, SceneError> {
        let made = match self.integral.take() {
            Some(known) => known,
            None => Arc::new(IntegralPasses::new(gpu)?),
        };
        Ok(Arc::clone(self.integral.insert(made)))
    }

    /// The passes over a cloud's planes.
    ///
    /// # Errors
    /// A driver that refuses a shader.
    pub(crate) fn cloud_march(
        &mut self,
        gpu: &GpuDevice,
        (mode, operators): (CloudMode, &Arc<str>),
    ) -> Result<Arc<CloudMarch>, SceneError> {
        let key = (mode, Arc::clone(operators));
        if let Some(known) = self.cloud_marches.get(&key) {
            return Ok(Arc::clone(known));
        }
        let made = Arc::new(CloudMarch::new(gpu, mode, operators)?);
        self.cloud_marches.insert(key, Arc::clone(&made));
        Ok(made)
    }

    fn compile_march(&self, gpu: &GpuDevice, variant: &Variant) -> Marches {
        let Variant {
            mode,
            ref operators,
            taps,
            is_cut,
            has_low_pass,
            from_eye,
            has_holes,
            gathers,
        } = *variant;
        let text = mode.text([has_holes, gathers], operators);
        let mut constants = mode.constants(from_eye);
        constants.extend([
            ("TAPS", f64::from(taps)),
            ("IS_CUT", f64::from(u8::from(is_cut))),
            ("HAS_LOW_PASS", f64::from(u8::from(has_low_pass))),
        ]);
        let entry = |name| pipeline(&gpu.device, (name, &text), &self.march_layout, &constants);
        Marches {
            march: entry("march"),
            settle: (mode.settles() && !gathers).then(|| entry("settle")),
        }
    }
}

/// The pass of an entry point.
pub(crate) fn pipeline(
    device: &wgpu::Device,
    (name, text): (&str, &str),
    bindings: &wgpu::BindGroupLayout,
    constants: &[(&str, f64)],
) -> wgpu::ComputePipeline {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(name),
        source: wgpu::ShaderSource::Wgsl(text.into()),
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(name),
        bind_group_layouts: &[Some(bindings)],
        immediate_size: 0,
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(name),
        layout: Some(&layout),
        module: &module,
        entry_point: Some(name),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants,
            zero_initialize_workgroup_memory: true,
        },
        cache: None,
    })
}
