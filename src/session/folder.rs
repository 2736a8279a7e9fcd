//! A session on disk: `NAME.afs/` with snapshot, journal, masks and cache.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, Write as _},
    path::{Path, PathBuf},
    time::{SystemTime, UNIX_EPOCH},
};

use serde::{Deserialize, Serialize};

use super::{
    Author, Command, Document, Entry, FORMAT_VERSION, History, JournalLine, MaskStore, SessionError,
    SessionLock, durable::sync_folder, parse_journal, write_durably,
};

/// An open session.
#[derive(Debug)]
pub struct Session {
    folder: PathBuf,
    history: History,
    initial: Document,
    human_edits: u64,
    next_seq: u64,
    last_crc: u32,
    writer: Option<Writer>,
}

/// Present where the session is open for writing.
#[derive(Debug)]
struct Writer {
    journal: File,
    /// Bytes of whole lines: where the next one starts.
    length: u64,
    _lock: SessionLock,
}

impl Writer {
    /// Appends a whole line and waits until it is on disk; on failure nothing of it stays.
    fn write(&mut self, text: &str) -> io::Result<()> {
        let written = self.journal.write_all(text.as_bytes()).and_then(|()| self.journal.sync_data());
        match written {
            Ok(()) => self.length += text.len() as u64,
            // Cut a half-written line off so that a later attempt starts on a clean end.
            Err(_) => {
                self.journal.set_len(self.length).ok();
            }
        }
        written
    }
}

/// What loading had to mend.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LoadReport {
    /// Bytes of a torn last line that were dropped; its command was never acknowledged.
    pub torn_bytes: usize,
}

#[derive(Serialize, Deserialize)]
struct Snapshot {
    version: u32,
    /// Journal lines the snapshot contains.
    seq: u64,
    document: Document,
}

impl Session {
    /// Creates `folder` with `document` as its first journal line.
    ///
    /// # Errors
    /// When the folder holds a session already or cannot be written.
    pub fn create(folder: &Path, document: Document) -> Result<Self, SessionError> {
        let journal_path = folder.join("journal.jsonl");
        if journal_path.exists() {
            let reason = "it holds a session already: open it instead".to_owned();
            return Err(SessionError::NotASession { path: folder.to_owned(), reason });
        }
        fs::create_dir_all(folder).map_err(io_error("create", folder))?;
        let lock = SessionLock::take(folder)?;
        let journal = open_journal(&journal_path)?;
        let mut session = Self {
            folder: folder.to_owned(),
            history: History::default(),
            initial: document.clone(),
            human_edits: 0,
            next_seq: 0,
            last_crc: 0,
            writer: Some(Writer { journal, length: 0, _lock: lock }),
        };
        session.append(Author::Manifest, Entry::Create(Box::new(document)))?;
        session.save_snapshot()?;
        sync_folder(folder).map_err(io_error("sync", folder))?;
        Ok(session)
    }

    /// Opens `folder` for writing. A torn last journal line is cut off and reported.
    ///
    /// # Errors
    /// When another process writes to it, it is damaged, or a newer program wrote it (nothing is touched then).
    pub fn open(folder: &Path) -> Result<(Self, LoadReport), SessionError> {
        let (mut session, report, length) = Self::read(folder)?;
        let lock = SessionLock::take(folder)?;
        let journal = open_journal(&folder.join("journal.jsonl"))?;
        journal.set_len(length).map_err(io_error("cut the torn line off", folder))?;
        session.writer = Some(Writer { journal, length, _lock: lock });
        Ok((session, report))
    }

    /// Opens `folder` for reading only, whoever writes to it.
    ///
    /// # Errors
    /// When it is damaged or a newer program wrote it.
    pub fn open_read_only(folder: &Path) -> Result<(Self, LoadReport), SessionError> {
        let (session, report, _) = Self::read(folder)?;
        Ok((session, report))
    }

    fn read(folder: &Path) -> Result<(Self, LoadReport, u64), SessionError> {
        let seen = read_snapshot(folder)?;
        let path = folder.join("journal.jsonl");
        let bytes = fs::read(&path).map_err(|source| match source.kind() {
            io::ErrorKind::NotFound => SessionError::NotASession {
                path: folder.to_owned(),
                reason: "journal.jsonl is missing".to_owned(),
            },
            _ => SessionError::Io { action: "read", path, source },
        })?;
        let parsed = parse_journal(&bytes)?;
        let found = parsed.lines.len() as u64;
        if let Some(expected) = seen.filter(|expected| *expected > found) {
            return Err(SessionError::JournalShort { expected, found });
        }
        let mut history = History::default();
        let mut initial = Document::default();
        let human_edits = parsed.lines.iter().filter(|line| line.author == Author::Human).count() as u64;
        for line in parsed.lines {
            if let Entry::Create(document) = &line.entry {
                initial = Document::clone(document);
            }
            history.apply(line.entry)?;
        }
        let session = Self {
            folder: folder.to_owned(),
            history,
            initial,
            human_edits,
            next_seq: found,
            last_crc: parsed.last_crc,
            writer: None,
        };
        Ok((session, LoadReport { torn_bytes: parsed.torn }, parsed.length as u64))
    }

    /// The session's folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The document now.
    pub fn document(&self) -> &Document {
        self.history.document()
    }

    /// The document the session was created with.
    pub fn initial_document(&self) -> &Document {
        &self.initial
    }

    /// Journal lines written by a person.
    pub fn human_edits(&self) -> u64 {
        self.human_edits
    }

    /// Whether changes are possible.
    pub fn is_writable(&self) -> bool {
        self.writer.is_some()
    }

    /// Undo and redo depth.
    pub fn history(&self) -> &History {
        &self.history
    }

    /// The session's masks.
    pub fn masks(&self) -> MaskStore {
        MaskStore::new(&self.folder.join("masks"))
    }

    /// Takes an entry of any kind; returns once its journal line is on disk, `false` when there was nothing to
    /// undo or redo.
    ///
    /// # Errors
    /// When it is refused or cannot be written: the session is as before.
    pub fn take(&mut self, author: Author, entry: Entry) -> Result<bool, SessionError> {
        self.append(author, entry)
    }

    /// Applies `command`; returns once its journal line is on disk.
    ///
    /// # Errors
    /// When the command is refused or cannot be written: the document is as before.
    pub fn apply(&mut self, author: Author, command: Command) -> Result<(), SessionError> {
        self.append(author, Entry::Do(command)).map(|_| ())
    }

    /// Takes the last step back; `false` when there is none.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn undo(&mut self, author: Author) -> Result<bool, SessionError> {
        self.append(author, Entry::Undo)
    }

    /// Does the last undone step again; `false` when there is none.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn redo(&mut self, author: Author) -> Result<bool, SessionError> {
        self.append(author, Entry::Redo)
    }

    fn append(&mut self, author: Author, entry: Entry) -> Result<bool, SessionError> {
        let writer = self.writer.as_mut().ok_or(SessionError::ReadOnly)?;
        // Applied first: a refused command leaves neither a line nor a change.
        let Some(applied) = self.history.apply_revertibly(entry.clone())? else { return Ok(false) };
        let time = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_millis() as u64);
        let by_human = u64::from(author == Author::Human);
        let sealed = JournalLine { seq: self.next_seq, time, author, entry }.seal(self.last_crc);
        let path = self.folder.join("journal.jsonl");
        let written = sealed.and_then(|(text, crc)| match writer.write(&text) {
            Ok(()) => Ok(crc),
            Err(source) => Err(SessionError::Io { action: "append to", path, source }),
        });
        let crc = match written {
            Ok(crc) => crc,
            Err(error) => {
                self.history.revert(applied)?;
                return Err(error);
            }
        };
        self.human_edits += by_human;
        self.next_seq += 1;
        self.last_crc = crc;
        Ok(true)
    }

    /// Copies what is on disk into `folder`, which must hold no session yet, and opens the copy for writing.
    ///
    /// # Errors
    /// When something cannot be read or written; this session stays as it is.
    pub fn copy_to(&self, folder: &Path) -> Result<Self, SessionError> {
        let journal = folder.join("journal.jsonl");
        if journal.exists() {
            let reason = "it holds a session already: choose another folder".to_owned();
            return Err(SessionError::NotASession { path: folder.to_owned(), reason });
        }
        let masks = folder.join("masks");
        fs::create_dir_all(&masks).map_err(io_error("create", &masks))?;
        let old = self.folder.join("masks");
        if old.is_dir() {
            for entry in fs::read_dir(&old).map_err(io_error("read", &old))? {
                let from = entry.map_err(io_error("read", &old))?.path();
                let Some(name) = from.file_name() else { continue };
                fs::copy(&from, masks.join(name)).map_err(io_error("copy", &from))?;
            }
        }
        let from = self.folder.join("journal.jsonl");
        let bytes = fs::read(&from).map_err(io_error("read", &from))?;
        // Only whole lines: a torn one was never acknowledged.
        let whole = parse_journal(&bytes)?.length;
        write_durably(&journal, &bytes[..whole]).map_err(io_error("write", &journal))?;
        let (copy, _) = Self::open(folder)?;
        copy.save_snapshot()?;
        Ok(copy)
    }

    /// Writes `session.json`, the readable snapshot. The journal stays the truth.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn save_snapshot(&self) -> Result<(), SessionError> {
        let document = self.document().clone();
        let snapshot = Snapshot { version: FORMAT_VERSION, seq: self.next_seq, document };
        let mut text = serde_json::to_string_pretty(&snapshot).map_err(SessionError::Encode)?;
        text.push('\n');
        let path = self.folder.join("session.json");
        write_durably(&path, text.as_bytes()).map_err(io_error("write", &path))
    }
}

fn io_error<'a>(action: &'static str, path: &'a Path) -> impl Fn(io::Error) -> SessionError + use<'a> {
    move |source| SessionError::Io { action, path: path.to_owned(), source }
}

fn open_journal(path: &Path) -> Result<File, SessionError> {
    OpenOptions::new().append(true).create(true).open(path).map_err(io_error("open", path))
}

/// Journal lines the snapshot has seen; `None` without a snapshot. Refuses newer versions.
fn read_snapshot(folder: &Path) -> Result<Option<u64>, SessionError> {
    let path = folder.join("session.json");
    let text = match fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(SessionError::Io { action: "read", path, source }),
    };
    let not_one = |reason: String| SessionError::NotASession { path: folder.to_owned(), reason };
    let value: serde_json::Value =
        serde_json::from_str(&text).map_err(|error| not_one(format!("session.json: {error}")))?;
    let found = value.get("version").and_then(serde_json::Value::as_u64);
    let found = found.ok_or_else(|| not_one("session.json has no version".to_owned()))?;
    if found > u64::from(FORMAT_VERSION) {
        let path = folder.to_owned();
        return Err(SessionError::NewerVersion { path, found, supported: FORMAT_VERSION });
    }
    Ok(value.get("seq").and_then(serde_json::Value::as_u64))
}
