//! Timer: what passes take on the device, by timestamps, where it has them.

use std::sync::{Mutex, PoisonError};

use splatvol_core::engine::PassSeconds;
use splatvol_scene::SceneError;

use crate::device::GpuDevice;

/// Passes of a frame that are timed at most; those behind them are not.
const MOST: u32 = 2048;
/// Bytes of a timestamp.
const STAMP: u64 = 8;

/// Timestamps of a frame's passes.
pub(crate) struct Timer {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    host: wgpu::Buffer,
    seconds_per_tick: f64,
    /// Passes that it has room for.
    most: u32,
    /// Names of the passes so far.
    names: Mutex<Vec<String>>,
}

impl Timer {
    /// A timer, if the device has timestamps.
    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Option<Self> {
        use wgpu::BufferUsages as Usage;
        if !device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return None;
        }
        let room = device.limits().max_buffer_size / (2 * STAMP);
        let most = u32::try_from(room).map_or(MOST, |room| room.min(MOST));
        let buffer = |usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("timestamps"),
                size: u64::from(2 * most) * STAMP,
                usage,
                mapped_at_creation: false,
            })
        };
        Some(Self {
            queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * most,
            }),
            resolved: buffer(Usage::QUERY_RESOLVE | Usage::COPY_SRC),
            host: buffer(Usage::MAP_READ | Usage::COPY_DST),
            seconds_per_tick: f64::from(queue.get_timestamp_period()) * 1e-9,
            most,
            names: Mutex::default(),
        })
    }

    /// Timestamps for the next pass.
    pub(crate) fn writes(&self, name: &str) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let mut names = self.names.lock().unwrap_or_else(PoisonError::into_inner);
        let at = 2 * names.len() as u32;
        (at < 2 * self.most).then(|| {
            names.push(name.to_owned());
            wgpu::ComputePassTimestampWrites {
                query_set: &self.queries,
                beginning_of_pass_write_index: Some(at),
                end_of_pass_write_index: Some(at + 1),
            }
        })
    }

    /// Forgets the passes so far.
    pub(crate) fn forget(&self) {
        self.names.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }

    /// Seconds of the passes since the last call, added up by name, in the order of their first.
    ///
    /// # Errors
    /// A device that fails.
    pub(crate) async fn read(&self, gpu: &GpuDevice) -> Result<Vec<PassSeconds>, SceneError> {
        let names = std::mem::take(&mut *self.names.lock().unwrap_or_else(PoisonError::into_inner));
        if names.is_empty() {
            return Ok(Vec::new());
        }
        let count = 2 * names.len() as u32;
        gpu.scoped(|gpu| {
            let mut commands = gpu.commands();
            commands.resolve_query_set(&self.queries, 0..count, &self.resolved, 0);
            commands.copy_buffer_to_buffer(&self.resolved, 0, &self.host, 0, u64::from(count) * STAMP);
            gpu.queue.submit([commands.finish()]);
        })?;
        gpu.map(&self.host, |bytes| {
            let stamps: Vec<u64> = bytes
                .chunks_exact(STAMP as usize)
                .map(bytemuck::pod_read_unaligned)
                .collect();
            let mut all: Vec<PassSeconds> = Vec::new();
            for (name, ends) in names.into_iter().zip(stamps.chunks_exact(2)) {
                let seconds = ends[1].saturating_sub(ends[0]) as f64 * self.seconds_per_tick;
                match all.iter_mut().find(|known| known.pass == name) {
                    Some(known) => known.seconds += seconds,
                    None => all.push(PassSeconds { pass: name, seconds }),
                }
            }
            all
        })
        .await
    }
}
