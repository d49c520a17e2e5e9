//! Ranks that are threads of one process and send each other bytes through channels.

use core::sync::atomic::{AtomicUsize, Ordering};
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use thurible_core::exec::Ranks;

/// A rank, with a channel to and from each.
#[derive(Debug)]
pub struct Channels {
    rank: usize,
    to: Vec<Sender<Vec<u8>>>,
    from: Vec<Mutex<Receiver<Vec<u8>>>>,
    /// Messages that were sent, and their bytes.
    pub sent: [AtomicUsize; 2],
}

impl Ranks for Channels {
    fn rank(&self) -> usize {
        self.rank
    }

    fn count(&self) -> usize {
        self.to.len()
    }

    fn swap(&self, to: Option<usize>, send: &[u8], from: Option<usize>, receive: &mut [u8]) {
        if let Some(to) = to {
            self.sent[0].fetch_add(1, Ordering::Relaxed);
            self.sent[1].fetch_add(send.len(), Ordering::Relaxed);
            self.to[to].send(send.to_vec()).unwrap();
        }
        if let Some(from) = from {
            let bytes = self.from[from].lock().unwrap().recv().unwrap();
            receive.copy_from_slice(&bytes);
        }
    }
}

/// So many ranks, in their order.
pub fn ranks(count: usize) -> Vec<Channels> {
    let mut ranks: Vec<Channels> = (0..count)
        .map(|rank| Channels {
            rank,
            to: Vec::new(),
            from: Vec::new(),
            sent: Default::default(),
        })
        .collect();
    for sender in 0..count {
        for receiver in 0..count {
            let (to, from) = channel();
            ranks[sender].to.push(to);
            ranks[receiver].from.push(Mutex::new(from));
        }
    }
    ranks
}

/// Calls `work` once for each of `count` ranks, all at the same time; what they return, in their order.
pub fn with_ranks<R: Send>(count: usize, work: impl Fn(&Channels) -> R + Sync) -> Vec<R> {
    let work = &work;
    thread::scope(|scope| {
        let threads: Vec<_> = ranks(count)
            .into_iter()
            .map(|rank| scope.spawn(move || work(&rank)))
            .collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    })
}
