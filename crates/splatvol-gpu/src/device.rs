//! Device: an adapter that was opened, with the limits that every WebGPU device has, and larger buffers where there are.

use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use bytemuck::Pod;
use futures_channel::oneshot;
use splatvol_core::engine::PassSeconds;
use splatvol_scene::SceneError;

use crate::error::GpuError;
use crate::timer::Timer;

/// Settings of an engine's lifetime.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct GpuConfig {
    /// Part of an adapter's name; `None` takes the fastest adapter.
    pub adapter: Option<String>,
    /// Budget for each volume's coefficients on the device, bytes; `None` for half of the largest buffer, 1 GiB at most.
    /// Larger volumes give the same pictures, and take longer: their pages are brought to the device by turns.
    pub budget: Option<usize>,
    /// Samples of planes that one dispatch takes; `None` for 64 Mi, tens of milliseconds of a small device, and 1 Gi on a card
    /// of its own. Systems reset devices that answer late, and a desktop shares them. Pictures do not depend on it.
    pub samples_per_dispatch: Option<u64>,
}

/// Budget for coefficients, bytes, where none is set.
const BUDGET: u64 = 1 << 30;
/// Samples of a dispatch on a small device, where none are set.
const SAMPLES: u64 = 1 << 26;
/// How many times as many a device on a card of its own takes.
const CARD: u64 = 16;

/// An open device.
pub(crate) struct GpuDevice {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    /// Name of the adapter and of the interface to its driver.
    pub name: String,
    /// Whether the processor does the device's work.
    pub is_imitated: bool,
    /// Bytes for coefficients.
    pub budget: u64,
    /// Samples of planes that one dispatch takes.
    pub samples_per_dispatch: u64,
    /// What the device reported by itself.
    faults: Faults,
    timer: Option<Timer>,
}

/// What a device reports by itself: that it is lost, for good; or an error that no scope caught, once.
#[derive(Clone, Default)]
struct Faults(Arc<Mutex<[Option<String>; 2]>>);

impl Faults {
    /// Listens to a device.
    fn of(device: &wgpu::Device) -> Self {
        let faults = Self::default();
        let lost = faults.clone();
        device.set_device_lost_callback(move |reason, message| {
            lost.put(0, format!("it was lost ({reason:?}): {message}"));
        });
        let stray = faults.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            stray.put(1, error.to_string());
        }));
        faults
    }

    fn put(&self, at: usize, fault: String) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)[at] = Some(fault);
    }

    fn take(&self) -> Option<String> {
        let [lost, stray] = &mut *self.0.lock().unwrap_or_else(PoisonError::into_inner);
        lost.clone().or_else(|| stray.take())
    }
}

impl fmt::Debug for GpuDevice {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("GpuDevice")
            .field("name", &self.name)
            .field("budget", &self.budget)
            .finish_non_exhaustive()
    }
}

impl GpuDevice {
    /// Opens an adapter.
    ///
    /// # Errors
    /// No such adapter, or a driver that refuses.
    pub(crate) async fn open(config: &GpuConfig) -> Result<Self, GpuError> {
        Self::open_with(config, |most| {
            (most.max_buffer_size, most.max_storage_buffer_binding_size)
        })
        .await
    }

    /// As [`Self::open`]; the limits of a buffer and of its binding are chosen from the adapter's.
    pub(crate) async fn open_with(
        config: &GpuConfig,
        buffers: impl Fn(&wgpu::Limits) -> (u64, u64),
    ) -> Result<Self, GpuError> {
        let adapters = adapters().await;
        let names: Vec<_> = adapters.iter().map(|adapter| adapter.get_info().name).collect();
        let wanted = |name: &str| match &config.adapter {
            Some(part) => name.to_lowercase().contains(&part.to_lowercase()),
            None => true,
        };
        let fastest = adapters
            .into_iter()
            .filter(|adapter| wanted(&adapter.get_info().name))
            .min_by_key(|adapter| rank(adapter.get_info().device_type));
        let adapter = fastest.ok_or_else(|| GpuError::NoAdapter {
            wanted: config
                .adapter
                .as_ref()
                .map_or_else(String::new, |part| format!(" whose name has {part:?}")),
            there: match names.is_empty() {
                true => "this system shows none".to_owned(),
                false => format!("there are {}", names.join(", ")),
            },
        })?;
        let info = adapter.get_info();
        // Browsers name no adapter.
        let name = match info.name.as_str() {
            "" => format!("a GPU ({})", info.backend),
            name => format!("{name} ({})", info.backend),
        };
        let most = adapter.limits();
        let (max_buffer_size, max_storage_buffer_binding_size) = buffers(&most);
        let limits = wgpu::Limits {
            max_buffer_size,
            max_storage_buffer_binding_size,
            max_storage_buffers_per_shader_stage: 8,
            ..wgpu::Limits::default()
        };
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("splatvol"),
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            required_limits: limits,
            ..wgpu::DeviceDescriptor::default()
        };
        let opened = adapter.request_device(&descriptor).await;
        let (device, queue) = opened.map_err(|error| GpuError::Device {
            adapter: name.clone(),
            reason: error.to_string(),
        })?;
        let budget = match config.budget {
            Some(bytes) => bytes as u64,
            None => (max_buffer_size / 2).min(BUDGET),
        };
        let samples = match info.device_type {
            wgpu::DeviceType::DiscreteGpu => CARD * SAMPLES,
            _ => SAMPLES,
        };
        Ok(Self {
            faults: Faults::of(&device),
            timer: Timer::new(&device, &queue),
            device,
            queue,
            name,
            is_imitated: info.device_type == wgpu::DeviceType::Cpu,
            budget,
            samples_per_dispatch: config.samples_per_dispatch.unwrap_or(samples),
        })
    }

    /// Runs work on the device; an error that it reports is an error, not a panic. Browsers report errors later: there it is an
    /// error of the next call, or of [`Self::map`].
    ///
    /// # Errors
    /// Memory that the device refuses, and commands that it does not take.
    #[cfg(target_family = "wasm")]
    pub(crate) fn scoped<T>(&self, work: impl FnOnce(&Self) -> T) -> Result<T, SceneError> {
        let done = work(self);
        self.check_faults().map(|()| done)
    }

    /// Runs work on the device; an error that it reports is an error, not a panic.
    ///
    /// # Errors
    /// Memory that the device refuses, and commands that it does not take.
    #[cfg(not(target_family = "wasm"))]
    pub(crate) fn scoped<T>(&self, work: impl FnOnce(&Self) -> T) -> Result<T, SceneError> {
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let validation = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let internal = self.device.push_error_scope(wgpu::ErrorFilter::Internal);
        let done = work(self);
        let errors = [internal.pop(), validation.pop()].map(pollster::block_on);
        let memory = pollster::block_on(memory.pop());
        // A lost device tells of it here.
        let polled = self.device.poll(wgpu::PollType::Poll);
        self.check_faults()?;
        polled.map_err(|error| self.failed(&error))?;
        match errors.into_iter().chain([memory]).flatten().next() {
            Some(error) => Err(self.failed(&error)),
            None => Ok(done),
        }
    }

    /// Checks that the device has reported nothing by itself.
    ///
    /// # Errors
    /// What it reported.
    fn check_faults(&self) -> Result<(), SceneError> {
        self.faults
            .take()
            .map_or(Ok(()), |fault| Err(self.failed(&fault)))
    }

    /// Checks that the budget has room for something.
    ///
    /// # Errors
    /// More bytes than the budget.
    pub(crate) fn afford(&self, what: &str, bytes: u64) -> Result<(), SceneError> {
        if bytes > self.budget {
            return Err(self.failed(&format!(
                "{what} needs {} MiB, the budget is {} MiB",
                bytes >> 20,
                self.budget >> 20
            )));
        }
        Ok(())
    }

    /// A buffer of zeros.
    pub(crate) fn buffer(&self, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: size.next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT),
            usage,
            mapped_at_creation: false,
        })
    }

    /// A buffer of data that shaders read.
    pub(crate) fn buffer_of<T: Pod>(&self, label: &str, data: &[T]) -> wgpu::Buffer {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let buffer = self.buffer(label, bytes.len().max(16) as u64, usage);
        self.queue.write_buffer(&buffer, 0, bytes);
        buffer
    }

    /// Commands to be submitted.
    pub(crate) fn commands(&self) -> wgpu::CommandEncoder {
        self.device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }

    /// Begins a pass of this name among commands.
    pub(crate) fn pass<'c>(
        &self,
        commands: &'c mut wgpu::CommandEncoder,
        name: &str,
    ) -> wgpu::ComputePass<'c> {
        commands.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(name),
            timestamp_writes: self.timer.as_ref().and_then(|timer| timer.writes(name)),
        })
    }

    /// Forgets the passes of a frame that has failed.
    pub(crate) fn forget_passes(&self) {
        if let Some(timer) = &self.timer {
            timer.forget();
        }
    }

    /// Seconds of the passes since the last call; none where the device has no timestamps.
    ///
    /// # Errors
    /// A device that fails.
    pub(crate) async fn pass_seconds(&self) -> Result<Vec<PassSeconds>, SceneError> {
        match &self.timer {
            None => Ok(Vec::new()),
            Some(timer) => timer.read(self).await,
        }
    }

    /// Waits for some submitted work, or for all; in browsers, where nothing may wait, goes on.
    ///
    /// # Errors
    /// A device that is lost.
    pub(crate) fn wait(&self, submitted: Option<wgpu::SubmissionIndex>) -> Result<(), SceneError> {
        let wait = wgpu::PollType::Wait {
            submission_index: submitted,
            timeout: None,
        };
        self.device
            .poll(wait)
            .map(|_| ())
            .map_err(|error| self.failed(&error))
    }

    /// Waits for all work, and reads a buffer of the host.
    ///
    /// # Errors
    /// A device that fails.
    pub(crate) async fn map<T>(
        &self,
        host: &wgpu::Buffer,
        take: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, SceneError> {
        let (sender, receiver) = oneshot::channel();
        host.map_async(wgpu::MapMode::Read, .., move |mapped| {
            // The receiver waits below.
            let _ = sender.send(mapped);
        });
        self.wait(None)?;
        let mapped = receiver.await;
        self.check_faults()?;
        match mapped {
            Ok(mapped) => mapped.map_err(|error| self.failed(&error))?,
            Err(error) => return Err(self.failed(&error)),
        }
        let taken = {
            let bytes = host.get_mapped_range(..).map_err(|error| self.failed(&error))?;
            take(&bytes)
        };
        host.unmap();
        Ok(taken)
    }

    /// A number of a buffer on the device.
    ///
    /// # Errors
    /// A device that fails.
    pub(crate) async fn number(&self, buffer: &wgpu::Buffer, at: u32) -> Result<u32, SceneError> {
        use wgpu::BufferUsages as Usage;
        let host = self.scoped(|gpu| {
            let host = gpu.buffer("a number", 4, Usage::MAP_READ | Usage::COPY_DST);
            let mut commands = gpu.commands();
            commands.copy_buffer_to_buffer(buffer, 4 * u64::from(at), &host, 0, 4);
            gpu.queue.submit([commands.finish()]);
            host
        })?;
        self.map(&host, |bytes| bytemuck::pod_read_unaligned(&bytes[..4]))
            .await
    }

    /// The error of a device.
    pub(crate) fn failed(&self, reason: &dyn fmt::Display) -> SceneError {
        SceneError::Device {
            name: self.name.clone(),
            reason: reason.to_string(),
        }
    }
}

/// The adapters that there are.
#[cfg(not(target_family = "wasm"))]
async fn adapters() -> Vec<wgpu::Adapter> {
    let instance = wgpu::Instance::default();
    instance.enumerate_adapters(wgpu::Backends::PRIMARY).await
}

/// The adapter that the browser takes for the fastest.
#[cfg(target_family = "wasm")]
async fn adapters() -> Vec<wgpu::Adapter> {
    let options = wgpu::RequestAdapterOptions {
        power_preference: wgpu::PowerPreference::HighPerformance,
        ..wgpu::RequestAdapterOptions::default()
    };
    let adapter = wgpu::Instance::default().request_adapter(&options).await;
    adapter.into_iter().collect()
}

/// Order of adapters, the fastest first.
fn rank(kind: wgpu::DeviceType) -> u8 {
    match kind {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}
