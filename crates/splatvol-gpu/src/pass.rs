//! A compute pass whose bindings follow from its shader.

use bytemuck::Pod;

use crate::device::GpuDevice;

/// Most workgroups along an axis of a dispatch, as every device has them.
const ROW: u32 = 32_768;

/// A compiled entry point.
#[derive(Debug)]
pub(crate) struct Pass {
    name: String,
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
}

impl Pass {
    /// Compiles an entry point of a text with its constants.
    pub(crate) fn new(gpu: &GpuDevice, (entry, text): (&str, &str), constants: &[(&str, f64)]) -> Self {
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(entry),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        let pipeline = gpu
            .device
            .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: None,
                module: &module,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants,
                    zero_initialize_workgroup_memory: true,
                },
                cache: None,
            });
        let layout = pipeline.get_bind_group_layout(0);
        Self {
            name: entry.to_owned(),
            pipeline,
            layout,
        }
    }

    /// Adds a dispatch of so many workgroups along x, y to commands, with these buffers bound.
    pub(crate) fn run(
        &self,
        gpu: &GpuDevice,
        commands: &mut wgpu::CommandEncoder,
        buffers: &[(u32, &wgpu::Buffer)],
        [x, y]: [u32; 2],
    ) {
        let bindings: Vec<_> = buffers
            .iter()
            .map(|&(binding, buffer)| (binding, buffer.as_entire_binding()))
            .collect();
        self.dispatch(gpu, commands, &bindings, [x, y, 1]);
    }

    /// Adds a dispatch of so many workgroups along x, y and z to commands, with these resources bound.
    pub(crate) fn dispatch(
        &self,
        gpu: &GpuDevice,
        commands: &mut wgpu::CommandEncoder,
        bindings: &[(u32, wgpu::BindingResource<'_>)],
        [x, y, z]: [u32; 3],
    ) {
        let entries: Vec<_> = bindings
            .iter()
            .map(|(binding, resource)| wgpu::BindGroupEntry {
                binding: *binding,
                resource: resource.clone(),
            })
            .collect();
        let bound = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.layout,
            entries: &entries,
        });
        let mut pass = gpu.pass(commands, &self.name);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &bound, &[]);
        pass.dispatch_workgroups(x, y, z);
    }
}

/// Workgroups along x and y for so many invocations, `per_group` each; shaders count them row by row.
pub(crate) fn groups(invocations: u32, per_group: u32) -> [u32; 2] {
    let groups = invocations.div_ceil(per_group).max(1);
    [groups.min(ROW), groups.div_ceil(ROW)]
}

/// A buffer of one struct that all invocations read.
pub(crate) fn uniform<T: Pod>(gpu: &GpuDevice, data: &T) -> wgpu::Buffer {
    use wgpu::BufferUsages as Usage;
    let bytes = bytemuck::bytes_of(data);
    let buffer = gpu.buffer("uniform", bytes.len() as u64, Usage::UNIFORM | Usage::COPY_DST);
    gpu.queue.write_buffer(&buffer, 0, bytes);
    buffer
}

/// A buffer of numbers that shaders read and write.
pub(crate) fn numbers(gpu: &GpuDevice, label: &str, count: u32) -> wgpu::Buffer {
    use wgpu::BufferUsages as Usage;
    let usage = Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST;
    gpu.buffer(label, 4 * u64::from(count.max(1)), usage)
}
