//! A run under an address-space limit: the plan and one MiB above the process's size at start are enough, 64 KiB less than the
//! plan is a clean error.
#![allow(unsafe_code, reason = "system calls")]

use crate::fields::cases::{Scene, admm};
use core::mem::MaybeUninit;
use std::process::{Command, Output};
use thurible_core::{D3, Params, Serial, Silent, Solver, Status};

/// Set for the process that runs under the limit: bytes above its size at start.
const VARIABLE: &str = "THURIBLE_TEST_CEILING";
const MIB: usize = 1 << 20;

fn scene() -> Scene {
    Scene {
        params: Params {
            iterations: 1,
            ..admm()
        },
        ..Scene::small(&[30, 28, 26], "wpw", 8)
    }
}

/// The address space of this process, in bytes.
fn size() -> usize {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmSize:"))
        .unwrap();
    line.trim().trim_end_matches(" kB").parse::<usize>().unwrap() * 1024
}

/// Runs one of the tests below again, in a process of its own that will limit itself.
fn limited(test: &str, above: usize) -> Output {
    let program = std::env::current_exe().unwrap();
    Command::new(program)
        .args(["--exact", test, "--nocapture", "--test-threads=1"])
        .env(VARIABLE, above.to_string())
        .output()
        .unwrap()
}

/// In the limited process: takes the limit and returns a page-aligned block of `bytes` bytes, or `None` if there is none.
fn block_under_limit(above: usize, bytes: usize) -> Option<&'static mut [MaybeUninit<u8>]> {
    let limit = (size() + above) as libc::rlim_t;
    let limit = libc::rlimit {
        rlim_cur: limit,
        rlim_max: limit,
    };
    // SAFETY: a plain system call on a value that lives.
    assert_eq!(unsafe { libc::setrlimit(libc::RLIMIT_AS, &limit) }, 0);
    // SAFETY: a fresh private mapping, never unmapped.
    let start = unsafe {
        libc::mmap(
            core::ptr::null_mut(),
            bytes,
            libc::PROT_READ | libc::PROT_WRITE,
            libc::MAP_PRIVATE | libc::MAP_ANONYMOUS,
            -1,
            0,
        )
    };
    // SAFETY: the mapping has `bytes` bytes and no other owner.
    (start != libc::MAP_FAILED).then(|| unsafe { core::slice::from_raw_parts_mut(start.cast(), bytes) })
}

/// What the limited process does: it prints how the solve ended.
fn solve_under_limit(above: usize) {
    let scene = scene();
    let (problem, plan) = (scene.problem(), scene.plan::<f32, D3>());
    let densities: Vec<Vec<f32>> = scene
        .densities
        .iter()
        .map(|density| crate::fields::cast(density))
        .collect();
    let Some(block) = block_under_limit(above, plan.bytes()) else {
        println!("no block");
        return;
    };
    let mut solver = Solver::<f32, D3>::new(&problem, &scene.params, block).unwrap();
    solver.set_source(&densities[0]).unwrap();
    solver.set_keyframe(0, &densities[1]).unwrap();
    let status = solver.solve(&Serial, &mut Silent, &mut |_| {});
    assert_eq!(status, Status::MaxIterations);
    println!("solved: {}", solver.objective().total());
}

#[test]
fn the_plan_and_a_mebibyte_are_enough() {
    if let Ok(above) = std::env::var(VARIABLE) {
        return solve_under_limit(above.parse().unwrap());
    }
    let plan = scene().plan::<f32, D3>().bytes();
    assert!(
        plan > 4 * MIB,
        "the plan of {plan} bytes does not show against what the process has"
    );
    let text = |output: &Output| String::from_utf8_lossy(&output.stdout).into_owned();
    let enough = limited("ceiling::the_plan_and_a_mebibyte_are_enough", plan + MIB);
    assert!(
        enough.status.success() && text(&enough).contains("solved: "),
        "{enough:?}"
    );
    let short = limited("ceiling::the_plan_and_a_mebibyte_are_enough", plan - 65_536);
    assert!(
        short.status.success() && text(&short).contains("no block"),
        "{short:?}"
    );
}
