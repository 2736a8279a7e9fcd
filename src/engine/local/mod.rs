//! The engine in this process: the batch's own pipeline on threads of its own.

mod desk;
mod drafts;
mod exporter;
mod keeper;
mod listener;
mod outbox;
mod painter;
mod scene;
mod survey;
mod worker;

use std::{
    path::PathBuf,
    sync::{Arc, Mutex, PoisonError, mpsc},
    thread::JoinHandle,
};

use super::{Engine, Event, PictureKind, Request};
use crate::{pipeline::Installation, session::MaskLayer};
use desk::Order;
use outbox::Outbox;
use scene::Shared;

/// Called whenever an event waits, from any thread.
pub type Waker = Arc<dyn Fn() + Send + Sync>;

/// The pipeline of this process, for one operator.
///
/// Threads: a desk that keeps the session, a worker that finds things out, a painter that makes pictures, and one for
/// an export while it runs. A panic in any of their jobs ends that job with a message, not the thread.
pub struct LocalEngine {
    shared: Arc<Shared>,
    orders: mpsc::Sender<Order>,
    events: Mutex<mpsc::Receiver<Event>>,
    threads: Vec<JoinHandle<()>>,
}

impl std::fmt::Debug for LocalEngine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LocalEngine").finish_non_exhaustive()
    }
}

impl LocalEngine {
    /// Starts the engine. Clips that are opened get their sessions and results in `out`.
    pub fn start(out: PathBuf, installation: Installation, waker: Waker) -> Self {
        let (sender, events) = mpsc::channel();
        let outbox = Outbox::new(sender, waker);
        let shared = Arc::new(Shared::new(out, installation, outbox));
        let (orders, incoming) = mpsc::channel();
        let threads = vec![
            spawn("desk", {
                let shared = Arc::clone(&shared);
                move || desk::run(&shared, &incoming)
            }),
            spawn("worker", {
                let shared = Arc::clone(&shared);
                move || worker::run(&shared)
            }),
            spawn("painter", {
                let shared = Arc::clone(&shared);
                move || painter::run(&shared)
            }),
        ];
        Self { shared, orders, events: Mutex::new(events), threads: threads.into_iter().flatten().collect() }
    }

    fn order(&self, order: Order) {
        if self.orders.send(order).is_err() {
            self.shared.outbox.note("the engine's desk is gone: close the window and start again");
        }
    }
}

fn spawn(name: &str, work: impl FnOnce() + Send + 'static) -> Option<JoinHandle<()>> {
    // Without a thread nothing can be done; the window says so when its first order finds nobody.
    std::thread::Builder::new().name(name.to_owned()).spawn(work).ok()
}

impl Engine for LocalEngine {
    fn send(&self, request: Request) {
        let shared = &self.shared;
        match request {
            Request::Open(path) => {
                shared.cancel_work();
                self.order(Order::Open(path));
            }
            Request::Close => {
                shared.cancel_work();
                self.order(Order::Close);
            }
            Request::Survey(path) => self.order(Order::Survey(path)),
            Request::Keep(change) => {
                shared.hold_masks(&change.masks);
                self.order(Order::Keep(Box::new(change)));
            }
            Request::RetrySave => self.order(Order::RetrySave),
            Request::SaveElsewhere(folder) => self.order(Order::SaveElsewhere(folder)),
            Request::Work { document, revision } => shared.want_work(document, revision),
            Request::Pause(paused) => shared.pause(paused),
            Request::Cancel => shared.cancel_work(),
            Request::Show(request) => shared.want_picture(request),
            Request::Segment { layer, frame, positive, negative } => {
                let arms_matter = layer == MaskLayer::Object;
                shared.want_draft(scene::DraftWish { layer, frame, positive, negative, arms_matter });
            }
            Request::FitHand { frame, side, keypoints } => {
                shared.want_hand(scene::HandWish { frame, side, keypoints });
            }
            Request::Export => self.order(Order::Export),
            Request::CancelExport => shared.cancel_export(),
        }
    }

    fn poll(&self) -> Option<Event> {
        self.events.lock().unwrap_or_else(PoisonError::into_inner).try_recv().ok()
    }
}

impl Drop for LocalEngine {
    fn drop(&mut self) {
        self.shared.stop();
        self.order(Order::Stop);
        for thread in self.threads.drain(..) {
            // A thread that panicked outside a job has said so on standard error.
            thread.join().ok();
        }
    }
}

/// Pictures of which only the newest wish counts have a place each.
fn place_of(kind: &PictureKind) -> Option<usize> {
    match kind {
        PictureKind::Source => Some(0),
        PictureKind::Composite => Some(1),
        PictureKind::Orbit { .. } => Some(2),
        PictureKind::Thumbnail { .. } => None,
    }
}

/// What a caught panic said.
fn panic_text(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no reason given");
    format!("a fault in the program ({text}): this step was left out, the session is safe; please report it")
}
