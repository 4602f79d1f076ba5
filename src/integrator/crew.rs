//! The threads that a run may use.

use std::sync::OnceLock;

/// The threads of a rendering.
pub trait Crew: Sync {
    /// Calls a task with every number below `count`, each once, in any order and at the same time;
    /// returns when all are done.
    fn each(&self, count: usize, task: &(dyn Fn(usize) + Sync));
}

impl dyn Crew + '_ {
    /// The results of a task for every number below `count`, in the order of the numbers.
    pub fn collect<T: Send + Sync>(
        &self,
        count: usize,
        task: impl Fn(usize) -> T + Sync,
    ) -> Vec<T> {
        let slots: Vec<OnceLock<T>> = (0..count).map(|_| OnceLock::new()).collect();
        self.each(count, &|i| {
            slots[i].get_or_init(|| task(i));
        });
        slots.into_iter().filter_map(OnceLock::into_inner).collect()
    }
}

/// The calling thread alone.
#[derive(Clone, Copy, Debug, Default)]
pub struct Caller;

impl Crew for Caller {
    fn each(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        (0..count).for_each(task);
    }
}
