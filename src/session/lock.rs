//! One writer a session.

use std::{
    fs::{File, OpenOptions, TryLockError},
    io::{Read as _, Seek as _, Write as _},
    path::Path,
};

use serde::{Deserialize, Serialize};

use super::SessionError;

/// Who writes to a session.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LockHolder {
    /// The program.
    pub program: String,
    /// Its process id.
    pub pid: u32,
}

impl std::fmt::Display for LockHolder {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} (process {})", self.program, self.pid)
    }
}

/// Held while a session is open for writing; the system releases it when the process ends, however it ends.
#[derive(Debug)]
pub struct SessionLock {
    file: File,
}

impl SessionLock {
    /// Who wrote its name into the lock of the session in `folder` last; `None` where that cannot be told.
    pub fn holder(folder: &Path) -> Option<LockHolder> {
        serde_json::from_str(&std::fs::read_to_string(folder.join("lock")).ok()?).ok()
    }

    /// Takes the lock of the session in `folder`.
    ///
    /// # Errors
    /// [`SessionError::Locked`] with the holder when another process has it.
    pub fn take(folder: &Path) -> Result<Self, SessionError> {
        let path = folder.join("lock");
        let io = |action| move |source| SessionError::Io { action, path: folder.join("lock"), source };
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)
            .map_err(io("open"))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut text = String::new();
                file.read_to_string(&mut text).map_err(io("read"))?;
                // A holder that is just writing its name leaves it empty for a moment: say so rather than fail.
                let holder = serde_json::from_str(&text)
                    .unwrap_or(LockHolder { program: "another program".to_owned(), pid: 0 });
                return Err(SessionError::Locked(holder));
            }
            Err(TryLockError::Error(source)) => return Err(io("lock")(source)),
        }
        let holder = LockHolder { program: "agenticfocus".to_owned(), pid: std::process::id() };
        let text = serde_json::to_string(&holder).map_err(SessionError::Encode)?;
        file.set_len(0).map_err(io("write"))?;
        file.rewind().map_err(io("write"))?;
        file.write_all(text.as_bytes()).map_err(io("write"))?;
        Ok(Self { file })
    }
}

impl Drop for SessionLock {
    /// Closing alone is not enough: a process that another thread is just starting holds a copy of the file until its
    /// program runs, and the lock with it.
    fn drop(&mut self) {
        // Where the system cannot, closing has to do.
        let _ = self.file.unlock();
    }
}
