//! Processor time and memory of this process, from the operating system.

use std::time::Duration;

/// Processor time, user and system, of all threads since the process began; `None` if the system does not report
/// it.
#[cfg(unix)]
pub(super) fn cpu_time() -> Option<Duration> {
    use rustix::time::{ClockId, clock_gettime};

    clock_gettime(ClockId::ProcessCPUTime).try_into().ok()
}

#[cfg(not(unix))]
pub(super) fn cpu_time() -> Option<Duration> {
    None
}

/// Largest resident size since the last [`reset_peak_memory`], bytes; `None` if the system does not report
/// it.
pub(super) fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = peak.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}

/// Begins a new period for [`peak_memory`]; without effect if the system does not allow it.
pub(super) fn reset_peak_memory() {
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn work_costs_time_and_memory() {
        let before = cpu_time().unwrap();
        let block = vec![1u8; 96 << 20];
        let sum: u64 = block
            .iter()
            .map(|&byte| u64::from(std::hint::black_box(byte)))
            .sum();
        assert_eq!(sum, 96 << 20);
        assert!(cpu_time().unwrap() > before);
        assert!(peak_memory().unwrap() >= 96 << 20);
    }
}
