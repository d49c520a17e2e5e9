//! Byte counts as people write and read them, and those of the machine.

use sysinfo::{MemoryRefreshKind, Process, ProcessRefreshKind, ProcessesToUpdate, RefreshKind, System};

/// The units of `--memory-limit`, longest names first.
const UNITS: [(&str, f64); 14] = [
    ("bytes", 1.0),
    ("byte", 1.0),
    ("kib", 1024.0),
    ("mib", 1_048_576.0),
    ("gib", 1_073_741_824.0),
    ("tib", 1_099_511_627_776.0),
    ("kb", 1e3),
    ("mb", 1e6),
    ("gb", 1e9),
    ("tb", 1e12),
    ("b", 1.0),
    // As schedulers of clusters write them.
    ("k", 1024.0),
    ("m", 1_048_576.0),
    ("g", 1_073_741_824.0),
];

/// Reads `1GiB`, `512 MiB`, `1.5GB`, `4096`; the error says what is allowed.
pub fn parse(text: &str) -> Result<usize, String> {
    let lower = text.trim().to_ascii_lowercase();
    let (number, scale) = UNITS
        .iter()
        .find_map(|&(unit, scale)| lower.strip_suffix(unit).map(|number| (number, scale)))
        .unwrap_or((lower.as_str(), 1.0));
    let refuse = || {
        format!(
            "found \"{text}\", allowed is a number above 0 with KiB, MiB, GiB, TiB, KB, MB, GB, TB or bytes, as in 1GiB"
        )
    };
    let number = number.trim();
    if scale == 1.0
        && let Ok(bytes) = number.parse::<usize>()
        && bytes > 0
    {
        return Ok(bytes);
    }
    let bytes = number.parse::<f64>().map_err(|_| refuse())? * scale;
    if (1.0..9e18).contains(&bytes) {
        Ok(bytes as usize)
    } else {
        Err(refuse())
    }
}

/// A count with commas, as in `1,150,437,668`.
pub fn grouped(bytes: usize) -> String {
    let digits = bytes.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A size to three digits, as in `1.07 GiB`.
pub fn rounded(bytes: usize) -> String {
    let mut value = bytes as f64;
    for unit in ["bytes", "KiB", "MiB", "GiB"] {
        if value < 1024.0 {
            return if unit == "bytes" {
                format!("{bytes} bytes")
            } else {
                format!("{value:.2} {unit}")
            };
        }
        value /= 1024.0;
    }
    format!("{value:.2} TiB")
}

/// What the system says of memory: bytes that there are, and that programs may still take, of swap too.
struct Told {
    all: usize,
    free: usize,
}

/// Of this machine, or of the container or the cluster's job that this process is in, where that is given less.
fn told() -> Option<Told> {
    let memory = RefreshKind::nothing().with_memory(MemoryRefreshKind::everything());
    let mut system = System::new_with_specifics(memory).ok()?;
    let own = sysinfo::get_current_pid().ok()?;
    let what = ProcessRefreshKind::nothing();
    system.refresh_processes_specifics(ProcessesToUpdate::Some(&[own]), false, what);
    let (mut all, mut free) = (system.total_memory(), system.available_memory());
    if let Some(group) = system.process(own).and_then(Process::cgroup_limits) {
        all = all.min(group.total_memory);
        // What it holds of files is given back when it is asked for.
        free = free.min(group.total_memory.saturating_sub(group.rss));
    }
    let free = free.saturating_add(system.free_swap());
    let told = |bytes: u64| usize::try_from(bytes).unwrap_or(usize::MAX);
    (all > 0).then(|| Told {
        all: told(all),
        free: told(free),
    })
}

/// Bytes of this machine's memory, where the system says so.
pub fn of_machine() -> Option<usize> {
    told().map(|told| told.all)
}

/// What programs may still take of memory and swap, where the system says so.
fn available() -> Option<usize> {
    told().map(|told| told.free)
}

/// Bytes above which the system is asked what is available. That takes a tenth of a millisecond, which thousands of small files would wait for.
const MANY: usize = 1 << 20;

/// Whether `count` bytes can be allocated now. Linux grants more than there is, and ends the program when it is written to; so of many what is
/// available is asked first.
pub fn are_free(count: usize) -> bool {
    if count > MANY && available().is_some_and(|available| count > available) {
        return false;
    }
    let mut block = Vec::<u8>::new();
    let given = block.try_reserve_exact(count).is_ok();
    // Without this the compiler may remove an allocation that is never used.
    core::hint::black_box(block);
    given
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn reads_what_people_write() {
        for (text, bytes) in [
            ("1GiB", 1 << 30),
            ("512 mib", 512 << 20),
            ("1.5GB", 1_500_000_000),
            ("4096", 4096),
            ("7 bytes", 7),
            ("3KB", 3000),
            ("64G", 64 << 30),
            ("1.5TiB", 3 << 39),
        ] {
            assert_eq!(parse(text), Ok(bytes), "{text}");
        }
        for text in [
            "", "GiB", "-1GiB", "0", "nan", "inf GB", "1e30GB", "1 TiB?", "lots",
        ] {
            assert!(parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn asks_the_system() {
        assert!(are_free(0) && are_free(1 << 20));
        assert!(!are_free(usize::MAX / 2));
    }

    #[test]
    fn the_machine_has_what_linux_says_at_most() {
        let told = told().unwrap();
        assert!(told.all >= 1 << 28, "{} bytes", told.all);
        if let Ok(text) = std::fs::read_to_string("/proc/meminfo") {
            let line = text.lines().find(|line| line.starts_with("MemTotal:")).unwrap();
            let kibibytes: usize = line.split_whitespace().nth(1).unwrap().parse().unwrap();
            assert!(told.all <= 1024 * kibibytes, "{} of {kibibytes} KiB", told.all);
        }
    }

    #[test]
    fn more_than_is_available_is_not_free() {
        // Half as much again may be granted, but not kept.
        if let Some(available) = available() {
            assert!(!are_free(available.saturating_mul(3) / 2));
        }
    }

    #[test]
    fn writes_what_people_read() {
        assert_eq!(grouped(0), "0");
        assert_eq!(grouped(999), "999");
        assert_eq!(grouped(1_150_437_668), "1,150,437,668");
        assert_eq!(rounded(64), "64 bytes");
        assert_eq!(rounded(1_150_437_668), "1.07 GiB");
    }
}
