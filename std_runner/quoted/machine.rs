//! The program and the machine that made the figures of a page.

use crate::report;
use crate::threads;

/// "thurible 0.1.0, in f32 on 2 threads of 2 (a processor)".
pub(crate) fn machine(version: &str, precision: &str, count: usize) -> String {
    let build = if cfg!(debug_assertions) {
        ", a debug build, whose times say little"
    } else {
        ""
    };
    let threads = report::count(count, "thread");
    let (all, processor) = (threads::available(), processor());
    format!("thurible {version}{build}, in {precision} on {threads} of {all} ({processor})")
}

/// The processor's name from /proc/cpuinfo.
fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text
        .lines()
        .find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    name.map_or_else(|| "processor unknown".into(), |(_, name)| name.trim().to_owned())
}
