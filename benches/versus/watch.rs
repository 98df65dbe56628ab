//! Clocks and counters: CPU time of this process, and heap allocations.

use std::{
    alloc::{GlobalAlloc, Layout, System},
    fs, iter,
    path::Path,
    sync::atomic::{AtomicUsize, Ordering},
    thread,
    time::Instant,
};

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);
/// Taken and not given back.
static BYTES: AtomicUsize = AtomicUsize::new(0);

/// The system's allocator, counted.
struct Counting;

#[expect(unsafe_code, reason = "an allocator can't be counted otherwise; it only passes on")]
// SAFETY: all is passed on to the system's allocator as it comes.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        BYTES.fetch_add(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller's promises go on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        BYTES.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller's promises go on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Heap allocations so far.
pub(crate) fn allocations() -> usize {
    ALLOCATIONS.load(Ordering::Relaxed)
}

/// Bytes of the heap in use.
pub(crate) fn bytes_in_use() -> usize {
    BYTES.load(Ordering::Relaxed)
}

/// Nanoseconds that all threads of this process have run: other programs on the machine don't count.
/// `None` where the system doesn't tell.
fn cpu_time() -> Option<f64> {
    // The system counts up when a thread steps back, else a few milliseconds late.
    thread::yield_now();
    let tasks = fs::read_dir("/proc/self/task").ok()?;
    Some(tasks.flatten().filter_map(|task| run_time(&task.path())).sum())
}

/// Nanoseconds that a thread has run.
fn run_time(task: &Path) -> Option<f64> {
    fs::read_to_string(task.join("schedstat")).ok()?.split_whitespace().next()?.parse().ok()
}

/// As [`time`], but once, and of this thread alone: what reads one clock fits between two stages of microseconds.
#[cfg(feature = "render")]
pub(crate) fn thread_time(work: impl FnOnce()) -> f64 {
    let clock = || {
        thread::yield_now();
        run_time(Path::new("/proc/thread-self"))
    };
    let (cpu, wall) = (clock(), Instant::now());
    work();
    match (cpu, clock()) {
        (Some(before), Some(after)) => after - before,
        _ => wall.elapsed().as_nanos() as f64,
    }
}

/// Nanoseconds of CPU time that `work` takes, of wall time where CPU time is unknown: the mean of so many rounds that they
/// last long beside the reading of the clock.
pub(crate) fn time(rounds: usize, mut work: impl FnMut()) -> f64 {
    let (cpu, wall) = (cpu_time(), Instant::now());
    iter::repeat_n((), rounds).for_each(|()| work());
    let spent = match (cpu, cpu_time()) {
        (Some(before), Some(after)) => after - before,
        _ => wall.elapsed().as_nanos() as f64,
    };
    spent / rounds as f64
}

/// Nanoseconds of wall time.
pub(crate) fn wall_time(rounds: usize, mut work: impl FnMut()) -> f64 {
    let wall = Instant::now();
    iter::repeat_n((), rounds).for_each(|()| work());
    wall.elapsed().as_nanos() as f64 / rounds as f64
}

/// The middle one.
pub(crate) fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
}
