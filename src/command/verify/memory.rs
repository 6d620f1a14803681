//! The limit for the memory of a verification.

use crate::numbers::number;

/// Limit where the memory of the machine is not known, in MiB.
const UNKNOWN_MACHINE: u64 = 4096;

/// Files with the memory of the machine, and of the control group that the process is in.
const MACHINE: &str = "/proc/meminfo";
const GROUP: &str = "/sys/fs/cgroup/memory.max";

/// A limit for the memory, in MiB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MemoryLimit {
    /// From `--memory`.
    Given(u64),
    /// Half of the memory of the machine.
    HalfOfMachine(u64),
    /// For a machine whose memory is not known.
    Fixed,
}

impl MemoryLimit {
    /// Returns the limit that is given, or else one that depends on the machine.
    pub fn of(given: Option<u64>) -> Self {
        // a control group has a file of this name only if it limits the memory
        let read = |path| std::fs::read_to_string(path).unwrap_or_default();
        match (given, memory(&read(MACHINE), &read(GROUP))) {
            (Some(mib), _) => Self::Given(mib),
            (None, Some(bytes)) => Self::HalfOfMachine((bytes / 2) >> 20),
            (None, None) => Self::Fixed,
        }
    }

    pub fn bytes(self) -> u64 {
        self.mib().saturating_mul(1 << 20)
    }

    fn mib(self) -> u64 {
        match self {
            Self::Given(mib) | Self::HalfOfMachine(mib) => mib,
            Self::Fixed => UNKNOWN_MACHINE,
        }
    }

    /// Says that the limit was reached.
    pub fn reached(self) -> String {
        let mib = number(self.mib());
        match self {
            Self::Given(_) => {
                format!("the memory reached its limit of {mib} MiB, which `--memory` sets")
            }
            Self::HalfOfMachine(_) => format!(
                "the memory reached its limit of {mib} MiB, half of that of this machine; `--memory` sets another one"
            ),
            Self::Fixed => {
                format!("the memory reached its limit of {mib} MiB; `--memory` sets another one")
            }
        }
    }
}

/// Returns the memory of a machine in bytes, from the texts of the files; `None` if they do not say it.
fn memory(machine: &str, group: &str) -> Option<u64> {
    let total = machine.lines().find_map(|line| {
        let words = line.strip_prefix("MemTotal:")?.trim();
        words.strip_suffix("kB")?.trim().parse::<u64>().ok()
    });
    let total = total?.saturating_mul(1024);
    let group = group.trim().parse::<u64>().ok();
    Some(group.map_or(total, |group| group.min(total)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_memory_is_that_of_the_machine_or_its_control_group() {
        let machine = "MemFree:  1 kB\nMemTotal:       24689248 kB\nSwapTotal: 0 kB\n";
        assert_eq!(memory(machine, ""), Some(24_689_248 << 10));
        assert_eq!(memory(machine, "max\n"), Some(24_689_248 << 10));
        assert_eq!(memory(machine, "1073741824\n"), Some(1 << 30));
        assert_eq!(memory("", "1073741824"), None);
    }
}
