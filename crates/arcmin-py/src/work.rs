//! Long computations on separate threads: the caller waits without the interpreter lock, reacts to Ctrl-C, and
//! shows progress.

use std::mem;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::errors;
use crate::host::PyHost;

/// Interval at which the caller checks for Ctrl-C and shows progress.
const INTERVAL: Duration = Duration::from_millis(50);
/// Time for which cancelled work is awaited. Longer work ends by itself, and its result is discarded.
const GRACE: Duration = Duration::from_millis(150);
/// Time for which caller and thread poll before they sleep: waking takes as long as a short call.
const SPIN: Duration = Duration::from_micros(100);
/// The usual size for the main thread of a process.
const STACK_BYTES: usize = 8 << 20;
/// Number of idle threads kept for the next calls.
const KEPT: usize = 8;

/// Work that returns a function that reports its end.
type Job = Box<dyn FnOnce() -> Tell + Send>;
type Tell = Box<dyn FnOnce() + Send>;

/// Threads of one process; threads do not survive a fork.
struct Threads {
    process: u32,
    idle: Vec<Sender<Job>>,
    pools: Vec<(usize, Arc<ThreadPool>)>,
}

fn threads() -> MutexGuard<'static, Threads> {
    static THREADS: OnceLock<Mutex<Threads>> = OnceLock::new();
    let fresh = || Threads { process: std::process::id(), idle: Vec::new(), pools: Vec::new() };
    let mut threads =
        THREADS.get_or_init(|| Mutex::new(fresh())).lock().unwrap_or_else(PoisonError::into_inner);
    if threads.process != std::process::id() {
        // The other ends belong to the parent process: they are neither notified nor awaited.
        mem::forget(mem::replace(&mut *threads, fresh()));
    }
    threads
}

/// The process that computed first, which has the threads of rayon's common pool.
fn is_first_process() -> bool {
    static FIRST: OnceLock<u32> = OnceLock::new();
    *FIRST.get_or_init(std::process::id) == std::process::id()
}

/// Pool for parallel parts; `None` is rayon's common pool.
fn pool(count: Option<usize>) -> Result<Option<Arc<ThreadPool>>, String> {
    if count.is_none() && is_first_process() {
        return Ok(None);
    }
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    let count = count.unwrap_or_else(cores);
    let mut threads = threads();
    if let Some((_, pool)) = threads.pools.iter().find(|(size, _)| *size == count) {
        return Ok(Some(pool.clone()));
    }
    let pool = ThreadPoolBuilder::new().num_threads(count).build();
    let pool = Arc::new(pool.map_err(|cause| format!("cannot start {count} threads: {cause}"))?);
    threads.pools.push((count, pool.clone()));
    Ok(Some(pool))
}

/// Polls `poll` as long as this is cheaper than sleeping.
fn soon<T>(mut poll: impl FnMut() -> Option<T>) -> Option<T> {
    let started = Instant::now();
    loop {
        let found = poll();
        if found.is_some() || started.elapsed() > SPIN {
            return found;
        }
        std::hint::spin_loop();
    }
}

fn serve(mut job: Job) -> std::io::Result<()> {
    // A thread that has ended (which does not occur) returns the job.
    while let Some(idle) = { threads().idle.pop() } {
        match idle.send(job) {
            Ok(()) => return Ok(()),
            Err(refused) => job = refused.0,
        }
    }
    let (sender, receiver) = channel::<Job>();
    let work = move || {
        let mut next = Some(job);
        while let Some(job) = next.take() {
            let notify = job();
            let keep = {
                let mut threads = threads();
                let keep = threads.idle.len() < KEPT;
                if keep {
                    threads.idle.push(sender.clone());
                }
                keep
            };
            // Notified after the thread is free again, so that the next call can use it.
            notify();
            next = keep.then(|| soon(|| receiver.try_recv().ok()).or_else(|| receiver.recv().ok())).flatten();
        }
    };
    std::thread::Builder::new().name("arcmin".to_owned()).stack_size(STACK_BYTES).spawn(work)?;
    Ok(())
}

type Answer<T> = Arc<(Mutex<Option<std::thread::Result<T>>>, Condvar)>;

/// The result, if it is there and the lock is free.
fn take_result<T>(answer: &Answer<T>) -> Option<std::thread::Result<T>> {
    answer.0.try_lock().ok()?.take()
}

fn wait<T>(answer: &Answer<T>, time: Duration) -> Option<std::thread::Result<T>> {
    let end = Instant::now() + time;
    let mut slot = answer.0.lock().unwrap_or_else(PoisonError::into_inner);
    while slot.is_none() {
        let left = end.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return None;
        }
        slot = answer.1.wait_timeout(slot, left).unwrap_or_else(PoisonError::into_inner).0;
    }
    slot.take()
}

/// Runs `job` on a separate thread and waits for it without the interpreter lock. `progress` is called with
/// stage and share about twenty times a second, from the calling thread.
///
/// # Errors
/// An exception raised by a signal handler or `progress` (the job is then cancelled), or a panic of the job.
pub fn wait_for<T: Send + 'static>(
    py: Python<'_>,
    host: &Arc<PyHost>,
    threads: Option<usize>,
    progress: Option<&Bound<'_, PyAny>>,
    job: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    let pool = pool(threads).map_err(pyo3::exceptions::PyRuntimeError::new_err)?;
    let answer: Answer<T> = Arc::new((Mutex::new(None), Condvar::new()));
    let slot = answer.clone();
    let job: Job = Box::new(move || {
        let result = catch_unwind(AssertUnwindSafe(|| match pool {
            Some(pool) => pool.install(job),
            None => job(),
        }));
        Box::new(move || {
            *slot.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
            slot.1.notify_all();
        })
    });
    serve(job)?;
    let mut answered = py.detach(|| soon(|| take_result(&answer)).or_else(|| wait(&answer, INTERVAL)));
    loop {
        if let Some(result) = answered {
            return result.map_err(|cause| errors::panic(cause.as_ref()));
        }
        let signals = py.check_signals().and_then(|()| match (progress, host.progress()) {
            (Some(progress), Some(at)) => progress.call1(at).map(|_| ()),
            _ => Ok(()),
        });
        if let Err(error) = signals {
            host.cancel();
            py.detach(|| wait(&answer, GRACE));
            return Err(error);
        }
        answered = py.detach(|| wait(&answer, INTERVAL));
    }
}
