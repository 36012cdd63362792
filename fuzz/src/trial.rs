//! One input through one reader: what it answers, the time and the memory that it takes.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use anyhow::Result;

use crate::allocator;
use crate::input::Input;
use crate::target::{Reader, render};

/// What reading any input may take.
const READING: Duration = Duration::from_millis(100);
/// What rendering it may take: most of it is the renderer's tables, the first use of a thread, and the discs of triangles,
/// of which any mesh may have 262,144.
const RENDERING: Duration = Duration::from_millis(500);
/// What each byte of an input may take on top.
const TIME_PER_BYTE: Duration = Duration::from_micros(2);
/// Memory that any input may take, bytes.
const MEMORY: u64 = 64 << 20;
/// Memory that each byte of an input may take on top.
const MEMORY_PER_BYTE: u64 = 8;
/// Time of the processor after which an input is taken to go on for ever.
const PATIENCE: Duration = Duration::from_secs(10);
/// The same by the clock, for what waits.
const LONGEST_WAIT: Duration = Duration::from_secs(120);
/// Times that a slow input is tried again before it counts.
const REPEATS: usize = 3;

/// How the process ends for what it cannot survive.
pub(crate) const HUNG: i32 = 13;

/// What an input must not do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Fault {
    Panic { message: String, place: String },
    Time { took: Duration, answer: String },
    Memory { bytes: u64, answer: String },
}

impl Fault {
    /// The same for inputs that show the same fault.
    pub(crate) fn place(&self) -> String {
        match self {
            Self::Panic { place, .. } => place.clone(),
            Self::Time { answer, .. } => format!("time {answer}"),
            Self::Memory { answer, .. } => format!("memory {answer}"),
        }
    }

    pub(crate) fn line(&self) -> String {
        let text = match self {
            Self::Panic { message, place } => format!("panic at {place}: {message}"),
            Self::Time { took, answer } => format!("{took:?} of time for: {answer}"),
            Self::Memory { bytes, answer } => format!("{bytes} bytes of memory for: {answer}"),
        };
        text.replace(['\n', '\r'], " ")
    }

    /// The exit status of a replay.
    pub(crate) fn status(&self) -> i32 {
        match self {
            Self::Panic { .. } => 10,
            Self::Time { .. } => 11,
            Self::Memory { .. } => 12,
        }
    }
}

pub(crate) struct Outcome {
    pub(crate) accepted: bool,
    pub(crate) answer: String,
    pub(crate) rendered: bool,
    pub(crate) fault: Option<Fault>,
}

/// Whether slow inputs are faults.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Clock {
    /// Time counts: for campaigns, on a machine that is known.
    Judges,
    /// Only what goes on for ever is a fault: tests run on any machine, beside anything.
    Ignored,
}

/// Tries inputs in a folder of its own.
pub(crate) struct Trial {
    reader: Reader,
    work: PathBuf,
    clock: Clock,
}

impl Trial {
    pub(crate) fn new(reader: Reader, work: PathBuf, clock: Clock) -> Self {
        std::panic::set_hook(Box::new(|info| {
            let place = info.location().map_or_else(String::new, ToString::to_string);
            let message = said(info.payload());
            // Panics of inputs are findings, unless the reader catches them; others are mistakes here.
            if BEGUN.load(Ordering::Relaxed) == 0 {
                eprintln!("panic at {place}: {message}");
            }
            if let Ok(mut last) = LAST_PANIC.lock() {
                *last = (message, place);
            }
        }));
        std::thread::spawn(watch);
        Self { reader, work, clock }
    }

    pub(crate) fn run(&self, input: &Input, renders: bool) -> Result<Outcome> {
        let path = input.write(&self.work.join("input"))?;
        let length = input.len() as u64;
        let (mut accepted, mut rendered) = (false, false);
        let mut text = String::new();
        let mut item = None;
        let limit = |time| match self.clock {
            Clock::Judges => time + TIME_PER_BYTE * u32::try_from(length).unwrap_or(u32::MAX),
            Clock::Ignored => Duration::MAX,
        };
        let mut fault = measured(length, limit(READING), &mut || {
            let answer = self.reader.read(&path);
            (accepted, text, item) = (answer.accepted, answer.text, answer.item);
            text.clone()
        });
        if let (None, true, Some(item)) = (&fault, renders, item) {
            rendered = true;
            fault = measured(length, limit(RENDERING), &mut || {
                let answer = render(item.clone()).map_err(|error| error.to_string());
                format!("{text}, rendered: {answer:?}")
            });
        }
        Ok(Outcome {
            accepted,
            answer: text,
            rendered,
            fault,
        })
    }
}

/// What went wrong, if anything did. Slow work is repeated: another program may have been in the way.
fn measured(length: u64, limit: Duration, work: &mut dyn FnMut() -> String) -> Option<Fault> {
    let mut fault = None;
    for _ in 0..=REPEATS {
        fault = measured_once(length, limit, work);
        if !matches!(fault, Some(Fault::Time { .. })) {
            break;
        }
    }
    fault
}

fn measured_once(length: u64, limit: Duration, work: &mut dyn FnMut() -> String) -> Option<Fault> {
    let live = allocator::restart();
    let start = processor_time();
    BEGUN.store(start.as_nanos() as u64 + 1, Ordering::Relaxed);
    let result = catch_unwind(AssertUnwindSafe(work));
    BEGUN.store(0, Ordering::Relaxed);
    let took = processor_time().saturating_sub(start);
    let bytes = allocator::peak().saturating_sub(live) as u64;
    let Ok(answer) = result else {
        let (message, place) = LAST_PANIC.lock().map(|last| last.clone()).unwrap_or_default();
        return Some(Fault::Panic { message, place });
    };
    if bytes > MEMORY + MEMORY_PER_BYTE * length {
        return Some(Fault::Memory { bytes, answer });
    }
    (took > limit).then_some(Fault::Time { took, answer })
}

/// The text of a panic.
fn said(payload: &dyn std::any::Any) -> String {
    let text = payload.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| payload.downcast_ref::<&str>().copied());
    text.unwrap_or_default().to_owned()
}

static LAST_PANIC: Mutex<(String, String)> = Mutex::new((String::new(), String::new()));
/// Time of the processor at which the input's reading began, nanoseconds, and 1; 0 between inputs.
static BEGUN: AtomicU64 = AtomicU64::new(0);

/// Ends the process where an input takes for ever.
fn watch() {
    let mut since = (0, Instant::now());
    loop {
        std::thread::sleep(Duration::from_millis(250));
        let begun = BEGUN.load(Ordering::Relaxed);
        if begun != since.0 {
            since = (begun, Instant::now());
        }
        let took = processor_time().saturating_sub(Duration::from_nanos(begun));
        if begun != 0 && (took > PATIENCE || since.1.elapsed() > LONGEST_WAIT) {
            std::process::exit(HUNG);
        }
    }
}

/// Time that the process has had of the processors: other programs do not count.
#[cfg(unix)]
pub(crate) fn processor_time() -> Duration {
    use rustix::time::{ClockId, clock_gettime};
    clock_gettime(ClockId::ProcessCPUTime)
        .try_into()
        .unwrap_or_default()
}

/// The clock, where the processor's time cannot be asked for.
#[cfg(not(unix))]
pub(crate) fn processor_time() -> Duration {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    START.get_or_init(Instant::now).elapsed()
}
