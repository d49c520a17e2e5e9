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
use std::process::ExitCode;
use thurible::program;

/// Where it is set, every rank says what it sent.
const TRAFFIC: &str = "THURIBLE_MPI_TRAFFIC";

fn main() -> ExitCode {
    // Whoever opens a parallel region sends, which is one thread, if not always the first.
    let Some((universe, _)) = mpi::initialize_with_threading(Threading::Serialized) else {
        eprintln!("thurible-mpi: MPI cannot be initialised; run it by mpirun");
        return ExitCode::FAILURE;
    };
    let ranks: &'static Messages = Box::leak(Box::new(Messages::new(&universe.world())));
    match program::main_shared(ranks) {
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
