//! What ranks send each other, by MPI.

use core::fmt;
use core::sync::atomic::{AtomicU64, Ordering};
use mpi::point_to_point::{Destination, Source};
use mpi::request;
use mpi::topology::{Communicator, Rank, SimpleCommunicator};
use std::time::Instant;
use thurible_core::exec::Ranks;

/// The most bytes of a message: MPI counts in `int`.
const MOST: usize = 1 << 30;

/// The most bytes of a message of a sum or a maximum: of all products of L-BFGS with up to 8 pairs at once, and less than a plane of 24^3 cells.
const NUMBERS: usize = 160;

/// This rank among all that MPI started.
#[derive(Debug)]
pub struct Messages {
    rank: usize,
    count: usize,
    beside: usize,
    /// Messages that were sent, their bytes, those of them of at most [`NUMBERS`], and nanoseconds from the call to its end.
    sent: [AtomicU64; 4],
}

impl Messages {
    /// This rank in `world`.
    pub fn new(world: &SimpleCommunicator) -> Self {
        let machine = world.split_shared(world.rank());
        let numbers = [world.rank(), world.size(), machine.size()];
        let [rank, count, beside] = numbers.map(|number| usize::try_from(number).unwrap_or(0));
        Self {
            rank,
            count: count.max(1),
            beside: beside.max(1),
            sent: Default::default(),
        }
    }

    /// Sends and receives at most [`MOST`] bytes each.
    fn piece(&self, send: Option<(Rank, &[u8])>, receive: Option<(Rank, &mut [u8])>) {
        let world = SimpleCommunicator::world();
        if let Some((_, send)) = send {
            self.sent[0].fetch_add(1, Ordering::Relaxed);
            self.sent[1].fetch_add(send.len() as u64, Ordering::Relaxed);
            self.sent[2].fetch_add(u64::from(send.len() <= NUMBERS), Ordering::Relaxed);
        }
        let send = || {
            if let Some((to, send)) = send {
                world.process_at_rank(to).send(send);
            }
        };
        match receive {
            Some((from, receive)) => request::scope(|scope| {
                let receiving = world.process_at_rank(from).immediate_receive_into(scope, receive);
                send();
                receiving.wait();
            }),
            None => send(),
        }
    }
}

impl Ranks for Messages {
    fn rank(&self) -> usize {
        self.rank
    }

    fn count(&self) -> usize {
        self.count
    }

    fn on_this_machine(&self) -> usize {
        self.beside
    }

    /// An error of MPI, as where a rank was lost, ends all of them: that is what MPI does with errors by default.
    fn swap(&self, to: Option<usize>, send: &[u8], from: Option<usize>, receive: &mut [u8]) {
        let number = |rank: usize| Rank::try_from(rank).ok();
        let (to, from) = (to.and_then(number), from.and_then(number));
        let mut sends = send.chunks(MOST).filter(|_| to.is_some());
        let mut receives = receive.chunks_mut(MOST).filter(|_| from.is_some());
        let begun = Instant::now();
        loop {
            match (to.zip(sends.next()), from.zip(receives.next())) {
                (None, None) => break,
                (send, receive) => self.piece(send, receive),
            }
        }
        let nanoseconds = u64::try_from(begun.elapsed().as_nanos()).unwrap_or(u64::MAX);
        self.sent[3].fetch_add(nanoseconds, Ordering::Relaxed);
    }
}

impl fmt::Display for Messages {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [messages, bytes, numbers, nanoseconds] =
            self.sent.each_ref().map(|sent| sent.load(Ordering::Relaxed));
        write!(
            f,
            "thurible-mpi: rank {} of {} sent {messages} messages, {bytes} bytes, {numbers} messages of numbers, in {:.3} s",
            self.rank,
            self.count,
            nanoseconds as f64 * 1e-9
        )
    }
}
