//! The thread that opens sessions and keeps their changes.

use std::{
    collections::BTreeMap,
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
    sync::{Arc, mpsc},
    time::Duration,
};

use super::{
    exporter,
    keeper::Keeper,
    panic_text,
    scene::{OpenClip, Shared},
    survey,
};
use crate::{
    engine::{Access, Change, Event, Opened, SaveState, WorkFailure},
    pipeline::{ClipJob, Listener, Memory, Stage, jobs_from_inputs, open_session},
    session::{LockHolder, SessionLock},
};

/// What the desk is told to do, in order.
#[derive(Debug)]
pub(super) enum Order {
    Open(PathBuf),
    Close,
    Survey(PathBuf),
    Keep(Box<Change>),
    RetrySave,
    SaveElsewhere(PathBuf),
    Export,
    Stop,
}

/// How long the desk waits before it tries again what could not be written.
const RETRY: Duration = Duration::from_secs(2);

struct Desk<'a> {
    shared: &'a Arc<Shared>,
    keeper: Option<Keeper>,
    /// Jobs of the queue by what is opened: a manifest says more about a clip than its path.
    jobs: BTreeMap<PathBuf, ClipJob>,
}

pub(super) fn run(shared: &Arc<Shared>, orders: &mpsc::Receiver<Order>) {
    let mut desk = Desk { shared, keeper: None, jobs: BTreeMap::new() };
    loop {
        let behind = desk.keeper.as_ref().is_some_and(Keeper::is_behind);
        let order = if behind {
            match orders.recv_timeout(RETRY) {
                Ok(order) => order,
                Err(mpsc::RecvTimeoutError::Timeout) => Order::RetrySave,
                Err(mpsc::RecvTimeoutError::Disconnected) => Order::Stop,
            }
        } else {
            orders.recv().unwrap_or(Order::Stop)
        };
        let stop = matches!(order, Order::Stop);
        if let Err(panic) = catch_unwind(AssertUnwindSafe(|| desk.carry_out(order))) {
            shared.outbox.note(&panic_text(&*panic));
        }
        if stop {
            return;
        }
    }
}

impl Desk<'_> {
    fn carry_out(&mut self, order: Order) {
        match order {
            Order::Open(path) => self.open(&path),
            Order::Close | Order::Stop => self.close(),
            Order::Survey(path) => self.survey(&path),
            Order::Keep(change) => {
                if let Some(keeper) = &mut self.keeper {
                    let state = keeper.keep(*change);
                    self.shared.tell(Event::Save(state));
                }
            }
            Order::RetrySave => {
                if let Some(keeper) = &mut self.keeper {
                    let state = keeper.flush();
                    if matches!(state, SaveState::Saved(_))
                        && let Err(error) = keeper.snapshot()
                    {
                        self.shared.outbox.note(&error.to_string());
                    }
                    self.shared.tell(Event::Save(state));
                }
            }
            Order::SaveElsewhere(folder) => self.save_elsewhere(&folder),
            Order::Export => self.export(),
        }
    }

    fn open(&mut self, path: &Path) {
        self.close();
        match self.opened(path) {
            Ok((keeper, job, opened)) => {
                let memory = Arc::new(Memory::default());
                let folder = keeper.session().folder().to_owned();
                self.keeper = Some(keeper);
                self.shared.set_open(Some(OpenClip { job, folder, memory }));
                self.shared.tell(Event::Opened(Box::new(opened)));
            }
            Err(message) => self.shared.tell(Event::NotOpened { path: path.to_owned(), message }),
        }
    }

    fn opened(&self, path: &Path) -> Result<(Keeper, ClipJob, Opened), String> {
        let job = match self.jobs.get(path) {
            Some(job) => job.clone(),
            None => jobs_from_inputs(&[path.to_owned()])
                .map_err(|error| error.to_string())?
                .into_iter()
                .next()
                .ok_or_else(|| format!("{} holds no clip", path.display()))?,
        };
        if job.session.is_none() && !Path::new(&job.document.clip.path).is_file() {
            return Err(format!("{} is not there: choose another file", job.document.clip.path));
        }
        let notes = Notes::default();
        let session = open_session(&job, &self.shared.out, &notes).map_err(|failure| failure.message)?;
        let access = if session.is_writable() {
            Access::Writable
        } else {
            Access::ReadOnly(
                SessionLock::holder(session.folder())
                    .unwrap_or_else(|| LockHolder { program: "another program".to_owned(), pid: 0 }),
            )
        };
        let masks = session.masks().all().into_iter().map(|(id, mask)| (id, Arc::new(mask))).collect();
        let opened = Opened {
            folder: session.folder().to_owned(),
            history: session.history().clone(),
            masks,
            access,
            notes: notes.0.into_inner().unwrap_or_default(),
        };
        let id = if job.session.is_some() { session.document().clip.id.clone() } else { job.id.clone() };
        let id = if id.is_empty() { job.id.clone() } else { id };
        Ok((Keeper::new(session), ClipJob { id, ..job }, opened))
    }

    fn close(&mut self) {
        self.shared.set_open(None);
        let Some(mut keeper) = self.keeper.take() else { return };
        let state = keeper.flush();
        if let SaveState::NotSaved { reason, .. } = &state {
            self.shared.outbox.note(&format!("closed with changes that could not be saved: {reason}"));
        } else if let Err(error) = keeper.snapshot() {
            // The journal has everything; only the readable copy is old.
            self.shared.outbox.note(&error.to_string());
        }
    }

    fn survey(&mut self, path: &Path) {
        match jobs_from_inputs(&[path.to_owned()]) {
            Ok(jobs) => {
                self.jobs = jobs.iter().map(|job| (survey::path_of(job), job.clone())).collect();
                survey::start(self.shared, path.to_owned(), jobs);
            }
            Err(error) => {
                let message = error.to_string();
                self.shared.tell(Event::NotOpened { path: path.to_owned(), message });
            }
        }
    }

    fn save_elsewhere(&mut self, folder: &Path) {
        let Some(keeper) = &mut self.keeper else { return };
        match keeper.move_to(folder) {
            Ok(state) => {
                self.shared.move_open(folder.to_owned());
                self.shared.outbox.note(&format!("the session is kept in {} from now on", folder.display()));
                self.shared.tell(Event::Save(state));
            }
            Err(error) => self.shared.outbox.note(&format!("not saved elsewhere: {error}")),
        }
    }

    fn export(&mut self) {
        let (Some(keeper), Some(open)) = (&mut self.keeper, self.shared.open_clip()) else { return };
        // What is exported is what is on disk.
        if let SaveState::NotSaved { reason, .. } = keeper.flush() {
            let message = format!("not exported: changes are not saved yet ({reason})");
            self.shared.tell(Event::Exported(Err(Some(WorkFailure { stage: None, message }))));
            return;
        }
        exporter::start(self.shared, open.job, open.folder);
    }
}

/// Collects what opening a session has to say.
#[derive(Default)]
struct Notes(std::sync::Mutex<Vec<String>>);

impl Listener for Notes {
    fn progress(&self, _stage: Stage, _done: usize, _total: usize, _share: f64) {}

    fn note(&self, text: &str) {
        self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push(text.to_owned());
    }
}
