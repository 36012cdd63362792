//! Memory that the machine or its container grants to this process.

use std::sync::OnceLock;

/// Where nothing says more: an ordinary computer.
const UNKNOWN: u64 = 16 << 30;

/// Bytes that this process may take: the memory of the machine, or of its container (a control group on Linux), and
/// no more than its own limit of address space (`ulimit -v`). What others use at the moment does not count: a command
/// that works now works later. Found once per process.
pub fn granted() -> u64 {
    static GRANTED: OnceLock<u64> = OnceLock::new();
    *GRANTED.get_or_init(|| {
        let limits = [machine(), address_space()];
        limits.into_iter().flatten().min().unwrap_or(UNKNOWN)
    })
}

#[cfg(not(target_family = "wasm"))]
fn machine() -> Option<u64> {
    use sysinfo::{MemoryRefreshKind, RefreshKind, System};

    let memory = RefreshKind::nothing().with_memory(MemoryRefreshKind::nothing().with_ram());
    let system = System::new_with_specifics(memory);
    let installed = Some(system.total_memory());
    let container = system.cgroup_limits().map(|limits| limits.total_memory);
    let known = installed.into_iter().chain(container);
    known.filter(|&bytes| bytes > 0).min()
}

/// WebAssembly has 32-bit addresses.
#[cfg(target_family = "wasm")]
fn machine() -> Option<u64> {
    Some(2 << 30)
}

#[cfg(unix)]
fn address_space() -> Option<u64> {
    rustix::process::getrlimit(rustix::process::Resource::As).current
}

#[cfg(not(unix))]
fn address_space() -> Option<u64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn some_memory_is_granted_and_no_more_than_any_machine_has() {
        let bytes = granted();
        assert!((1 << 20..1 << 50).contains(&bytes), "{bytes}");
        assert_eq!(bytes, granted());
    }
}
