//! What the engine's thread is asked for: requests in their order, and the view that is wanted last.
//!
//! A new view replaces one that waits, and stops the refinement of an earlier one. A draft that has begun is finished:
//! it is short, and otherwise fast input would show nothing at all.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// What is being made.
#[derive(Debug)]
struct Running {
    stop: Arc<AtomicBool>,
    /// Whether newer views wait for it.
    is_draft: bool,
}

#[derive(Debug)]
struct Waiting<Request, View> {
    requests: VecDeque<Request>,
    view: Option<View>,
    running: Option<Running>,
    closed: bool,
}

/// Next work.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Work<Request, View> {
    /// A request; requests come first.
    Request(Request),
    /// The last view that was asked for.
    View(View),
}

/// The mailbox.
#[derive(Debug)]
pub(super) struct Mailbox<Request, View> {
    waiting: Mutex<Waiting<Request, View>>,
    filled: Condvar,
}

impl<Request, View> Mailbox<Request, View> {
    pub(super) fn new() -> Self {
        Self {
            waiting: Mutex::new(Waiting {
                requests: VecDeque::new(),
                view: None,
                running: None,
                closed: false,
            }),
            filled: Condvar::new(),
        }
    }

    fn lock(&self) -> MutexGuard<'_, Waiting<Request, View>> {
        // Nothing panics while it is held, and a queue is whole after every statement.
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Leaves a request, and stops what refines a view.
    pub(super) fn request(&self, request: Request) {
        let mut waiting = self.lock();
        waiting.requests.push_back(request);
        stop(&waiting, false);
        self.filled.notify_one();
    }

    /// Leaves a view in place of the one that waits.
    pub(super) fn view(&self, view: View) {
        let mut waiting = self.lock();
        waiting.view = Some(view);
        stop(&waiting, false);
        self.filled.notify_one();
    }

    /// Ends the engine's thread, and stops whatever it makes.
    pub(super) fn close(&self) {
        let mut waiting = self.lock();
        waiting.closed = true;
        stop(&waiting, true);
        self.filled.notify_one();
    }

    /// Waits for work; `None` when there will be none.
    pub(super) fn next(&self) -> Option<Work<Request, View>> {
        let mut waiting = self.lock();
        loop {
            if waiting.closed {
                return None;
            }
            if let Some(request) = waiting.requests.pop_front() {
                return Some(Work::Request(request));
            }
            if let Some(view) = waiting.view.take() {
                return Some(Work::View(view));
            }
            waiting = self.filled.wait(waiting).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Says that a picture is begun, and returns the flag that stops it. Where something newer waits already, a
    /// refinement is stopped before it starts.
    pub(super) fn begin(&self, is_draft: bool) -> Arc<AtomicBool> {
        let mut waiting = self.lock();
        let newer = waiting.view.is_some() || !waiting.requests.is_empty();
        let flag = Arc::new(AtomicBool::new(waiting.closed || (newer && !is_draft)));
        waiting.running = Some(Running {
            stop: Arc::clone(&flag),
            is_draft,
        });
        flag
    }

    /// Says that the picture is complete, or stopped.
    pub(super) fn end(&self) {
        self.lock().running = None;
    }
}

fn stop<Request, View>(waiting: &Waiting<Request, View>, drafts_too: bool) {
    if let Some(running) = &waiting.running
        && (drafts_too || !running.is_draft)
    {
        running.stop.store(true, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_view_wins_and_requests_come_first() {
        let mailbox = Mailbox::new();
        mailbox.view(1);
        mailbox.view(2);
        mailbox.request("open");
        assert_eq!(mailbox.next(), Some(Work::Request("open")));
        assert_eq!(mailbox.next(), Some(Work::View(2)));
        mailbox.close();
        assert_eq!(mailbox.next(), None);
    }

    #[test]
    fn newer_views_stop_refinements_and_let_drafts_finish() {
        let mailbox = Mailbox::<(), u32>::new();
        let stopped = |flag: &AtomicBool| flag.load(Ordering::Relaxed);
        let refinement = mailbox.begin(false);
        mailbox.view(1);
        assert!(stopped(&refinement));
        assert!(stopped(&mailbox.begin(false)), "something newer waits");
        let draft = mailbox.begin(true);
        mailbox.view(2);
        assert!(!stopped(&draft));
        mailbox.close();
        assert!(stopped(&draft));
    }
}
