//! The program `thurible-mpi`: `thurible` whose scene the ranks of MPI share.
//!
//! ```text
//! mpirun -n 8 thurible-mpi simulate SCENE
//! ```
//!
//! Everything but the messages is in the library: [`thurible::program::main_shared`].

mod messages;

use messages::Messages;
use mpi::Threading;
use mpi::topology::{Communicator, SimpleCommunicator};
use std::panic::catch_unwind;
use std::process::ExitCode;
use thurible::program;

/// Where it is set, every rank says what it sent.
const TRAFFIC: &str = "THURIBLE_MPI_TRAFFIC";

/// Where Open MPI and MPICH tell a program how many were started with it.
const STARTED: [&str; 2] = ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE"];

/// Where Slurm tells it, which may have started an mpirun.
const BY_SLURM: &str = "SLURM_STEP_NUM_TASKS";

fn main() -> ExitCode {
    // Whoever opens a parallel region sends, which is one thread, if not always the first.
    let Some((universe, given)) = mpi::initialize_with_threading(Threading::Serialized) else {
        eprintln!("thurible-mpi: MPI cannot be initialised; run it by mpirun");
        return ExitCode::FAILURE;
    };
    let world = universe.world();
    if let Some(refused) = refused(world.size(), given) {
        if world.rank() == 0 {
            eprintln!("thurible-mpi: {refused}");
        }
        return ExitCode::FAILURE;
    }
    let ranks: &'static Messages = Box::leak(Box::new(Messages::new(&world)));
    // The others would wait for one that panics: they are ended too.
    match catch_unwind(|| program::main_shared(ranks)).unwrap_or(Err(PANICKED)) {
        Ok(code) => {
            if std::env::var_os(TRAFFIC).is_some() {
                eprintln!("{ranks}");
            }
            ExitCode::from(code)
        }
        // The others wait for this one: they are ended.
        Err(code) => SimpleCommunicator::world().abort(code.into()),
    }
}

/// The exit code of a panic, as Rust has it.
const PANICKED: u8 = 101;

/// Why nothing can be shared, if that is so, in a world of so many ranks with this leave for threads.
fn refused(size: i32, given: Threading) -> Option<String> {
    if given < Threading::Serialized {
        return Some("this MPI gives threads no leave to send (MPI_THREAD_SERIALIZED); take one that was built with threads".into());
    }
    let said = |name: &str| std::env::var(name).ok()?.parse::<i32>().ok();
    let started = STARTED.into_iter().filter_map(said).max();
    let started = started.or_else(|| said(BY_SLURM));
    let started = started.filter(|&started| started > 1 && size == 1)?;
    Some(format!(
        "{started} programs were started that know nothing of each other, by an mpirun or srun that is not for the MPI that thurible-mpi was built with; start \
         it with that one's mpirun, or by srun with its --mpi (docs/mpi.md)"
    ))
}
