//! Whether memory is there, asked before it is taken: an allocation that fails ends the program.

use std::fs;
use std::path::Path;

/// Why memory is not to be had.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{} of memory, {}", self.needed_in_words(), self.why())]
pub struct ShortOfMemory {
    /// Bytes asked for.
    pub needed: u64,
    /// Bytes that are free; `None` where they are not what is in the way.
    pub available: Option<u64>,
}

impl ShortOfMemory {
    /// What was asked for, as `1.5 GB`.
    #[must_use]
    pub fn needed_in_words(self) -> String {
        in_words(self.needed)
    }

    /// What is in the way, as `but 1.0 GB are free`.
    #[must_use]
    pub fn why(self) -> String {
        self.available.map_or_else(
            || "which the system does not grant".to_owned(),
            |bytes| format!("but {} are free", in_words(bytes)),
        )
    }
}

fn in_words(bytes: u64) -> String {
    format!("{:.1} GB", bytes as f64 / 1e9)
}

/// Says whether so many bytes could be had now.
///
/// # Errors
/// That they could not.
pub fn require(needed: u64) -> Result<(), ShortOfMemory> {
    let available = available_bytes();
    let is_there = available.is_none_or(|available| needed <= available);
    // What the system refuses to promise, as a limit on the process does, is not to be had either.
    let is_granted = usize::try_from(needed)
        .is_ok_and(|needed| Vec::<u8>::new().try_reserve_exact(needed).is_ok());
    if is_there && is_granted {
        return Ok(());
    }
    Err(ShortOfMemory {
        needed,
        available: available.filter(|_| !is_there),
    })
}

/// The most memory this process has held, where the system tells (Linux).
#[must_use]
pub fn peak_bytes() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    value_of(&status, "VmHWM:").map(|kilobytes| kilobytes * 1024)
}

/// What the system could give this process without pushing other memory out to a disk, where it tells (Linux).
fn available_bytes() -> Option<u64> {
    let machine = fs::read_to_string("/proc/meminfo").ok();
    let machine = machine.and_then(|text| value_of(&text, "MemAvailable:"));
    let of_machine = machine.map(|kilobytes| kilobytes * 1024);
    of_machine.into_iter().chain(left_in_groups()).min()
}

/// The files by which a control group tells of its memory.
struct GroupFiles {
    /// Where groups lie.
    root: &'static str,
    limit: &'static str,
    usage: &'static str,
    /// What of the usage is given back when it is needed: the name of a line in `memory.stat`.
    reclaimable: &'static str,
}

/// Source: the kernel's documentation of control groups, version 2.
const GROUPS: GroupFiles = GroupFiles {
    root: "/sys/fs/cgroup",
    limit: "memory.max",
    usage: "memory.current",
    reclaimable: "inactive_file ",
};

/// The same, version 1.
const OLD_GROUPS: GroupFiles = GroupFiles {
    root: "/sys/fs/cgroup/memory",
    limit: "memory.limit_in_bytes",
    usage: "memory.usage_in_bytes",
    reclaimable: "total_inactive_file ",
};

/// What the control groups of this process, such as those of a container, leave it: the least of them all.
fn left_in_groups() -> Option<u64> {
    let groups = fs::read_to_string("/proc/self/cgroup").ok()?;
    let left = groups.lines().filter_map(|line| {
        let (_, name) = line.split_once(':')?;
        let (controllers, path) = name.split_once(':')?;
        let files = match controllers {
            "" => &GROUPS,
            _ if controllers.split(',').any(|name| name == "memory") => &OLD_GROUPS,
            _ => return None,
        };
        // Within a container its own group may be the root.
        let folder = Path::new(files.root).join(path.trim_start_matches('/'));
        let folders = folder
            .ancestors()
            .take_while(|at| at.starts_with(files.root));
        folders.filter_map(|at| left_in_group(at, files)).min()
    });
    left.min()
}

/// What is left in the group whose files lie in `folder`; `None` where it has no limit.
fn left_in_group(folder: &Path, files: &GroupFiles) -> Option<u64> {
    let read = |name| fs::read_to_string(folder.join(name)).ok();
    let number = |name| read(name)?.trim().parse::<u64>().ok();
    let reclaimable = read("memory.stat").and_then(|text| value_of(&text, files.reclaimable));
    let kept = number(files.usage)?.saturating_sub(reclaimable.unwrap_or(0));
    Some(number(files.limit)?.saturating_sub(kept))
}

/// The number behind `key` at the beginning of a line.
fn value_of(text: &str, key: &str) -> Option<u64> {
    let rest = text.lines().find_map(|line| line.strip_prefix(key))?;
    rest.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_there_is_refused_in_words() {
        assert_eq!(require(1000), Ok(()));
        let short = require(1 << 60).expect_err("is not there");
        let said = short.to_string();
        assert!(said.starts_with("1152921504.6 GB of memory, "), "{said}");
        let short = ShortOfMemory {
            needed: 1_500_000_000,
            available: Some(1_000_000_000),
        };
        let expected = "1.5 GB of memory, but 1.0 GB are free";
        assert_eq!(short.to_string(), expected);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn the_system_tells_what_was_held() {
        let held = std::hint::black_box(vec![1_u8; 64 << 20]);
        let peak = peak_bytes().expect("Linux tells");
        assert!(peak >= held.len() as u64, "{peak}");
    }

    #[test]
    fn a_group_leaves_its_limit_less_what_it_keeps() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let write = |name: &str, text: &str| {
            fs::write(folder.path().join(name), text).expect("written");
        };
        let left = || left_in_group(folder.path(), &GROUPS);
        assert_eq!(left(), None);
        write("memory.max", "max\n");
        write("memory.current", "700\n");
        assert_eq!(left(), None);
        write("memory.max", "1000\n");
        assert_eq!(left(), Some(300));
        write(
            "memory.stat",
            "anon 400\ninactive_file 200\nactive_file 100\n",
        );
        assert_eq!(left(), Some(500));
        write("memory.max", "100\n");
        assert_eq!(left(), Some(0));
    }
}
