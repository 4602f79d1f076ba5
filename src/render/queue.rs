//! The chunks of all passes in the order of their numbers: which may be begun, and which are done.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// The queue of chunks that the threads of a rendering share. `T` is the result of a chunk.
#[derive(Debug)]
pub(super) struct Queue<T> {
    state: Mutex<State<T>>,
    changed: Condvar,
}

#[derive(Debug)]
struct State<T> {
    /// The chunk to begin next.
    next: u64,
    /// Those before this one may be begun.
    end: u64,
    /// Done, and yet to be taken.
    done: BTreeMap<u64, T>,
    /// Threads at work beside the calling one.
    workers: usize,
    has_failed: bool,
}

/// The next task of the calling thread.
pub(super) enum Turn<T> {
    /// These chunks come next and are done.
    Take(Vec<T>),
    /// The next one is not done. This one is to be rendered meanwhile.
    Render(u64),
    /// A worker panicked.
    End,
}

impl<T> Queue<T> {
    /// A queue that begins with the chunk of this number.
    pub fn new(next: u64) -> Self {
        Self {
            state: Mutex::new(State {
                next,
                end: 0,
                done: BTreeMap::new(),
                workers: 0,
                has_failed: false,
            }),
            changed: Condvar::new(),
        }
    }

    /// Lets chunks before `end` be begun, and counts in so many workers that there are `workers`;
    /// returns how many that is.
    pub fn open(&self, end: u64, workers: usize) -> usize {
        let mut state = self.lock();
        state.end = end;
        workers - std::mem::replace(&mut state.workers, workers)
    }

    /// Lets no more chunks be begun.
    pub fn close(&self) {
        self.lock().end = 0;
    }

    /// For the calling thread, which wants the chunks of a range that is not empty: waits if there
    /// is nothing else to do.
    pub fn turn(&self, wanted: Range<u64>) -> Turn<T> {
        let mut state = self.lock();
        loop {
            let done: Vec<T> =
                wanted.clone().map_while(|number| state.done.remove(&number)).collect();
            if !done.is_empty() {
                return Turn::Take(done);
            }
            if state.has_failed {
                return Turn::End;
            }
            if let Some(number) = state.begin() {
                return Turn::Render(number);
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// For a worker: lets it render chunks until none may be begun. It does not wait, because it
    /// may run on a thread on which another one was interrupted.
    pub fn work(&self, mut render: impl FnMut(u64)) {
        /// Reports a panic, or the calling thread would wait for the chunk.
        struct Alarm<'q, T>(&'q Queue<T>);
        impl<T> Drop for Alarm<'_, T> {
            fn drop(&mut self) {
                if std::thread::panicking() {
                    self.0.lock().has_failed = true;
                    self.0.changed.notify_one();
                }
            }
        }
        let _alarm = Alarm(self);
        loop {
            let mut state = self.lock();
            let Some(number) = state.begin() else {
                state.workers -= 1;
                return;
            };
            drop(state);
            render(number);
        }
    }

    /// Hands in a chunk that is done.
    pub fn finish(&self, number: u64, done: T) {
        self.lock().done.insert(number, done);
        self.changed.notify_one();
    }

    /// A thread that panicked ends the rendering anyway.
    fn lock(&self) -> MutexGuard<'_, State<T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<T> State<T> {
    fn begin(&mut self) -> Option<u64> {
        (self.next < self.end).then(|| {
            self.next += 1;
            self.next - 1
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_are_taken_in_their_order_up_to_the_end_of_what_is_wanted() {
        let queue = Queue::new(0);
        assert_eq!((queue.open(3, 2), queue.open(4, 2)), (2, 0));
        let begun = |turn| {
            if let Turn::Render(number) = turn { number } else { panic!("nothing to render") }
        };
        let taken =
            |turn| if let Turn::Take(chunks) = turn { chunks } else { panic!("nothing to take") };
        assert_eq!([begun(queue.turn(0..2)), begun(queue.turn(0..2))], [0, 1]);
        queue.finish(1, "b");
        assert_eq!(begun(queue.turn(0..2)), 2);
        queue.finish(2, "c");
        queue.finish(0, "a");
        assert_eq!(taken(queue.turn(0..2)), ["a", "b"]);
        assert_eq!(taken(queue.turn(2..4)), ["c"]);
        let mut rendered = Vec::new();
        queue.work(|number| rendered.push(number));
        assert_eq!((rendered, queue.open(6, 2)), (vec![3], 1));
        queue.close();
        queue.work(|number| panic!("{number} begun"));
    }
}
