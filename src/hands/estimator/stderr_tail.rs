//! The last lines a process wrote to standard error, for error messages.

use std::{
    collections::VecDeque,
    io::{BufRead, BufReader, Read},
    sync::{Arc, Mutex, PoisonError},
};

const LINES_KEPT: usize = 12;
const BYTES_A_LINE: u64 = 4096;

/// Reads a process's standard error to its end and remembers the last lines.
#[derive(Debug)]
pub(super) struct StderrTail {
    lines: Arc<Mutex<VecDeque<String>>>,
}

impl StderrTail {
    /// Starts reading.
    pub fn watch(stream: impl Read + Send + 'static) -> Self {
        let lines = Arc::new(Mutex::new(VecDeque::new()));
        let kept = Arc::clone(&lines);
        std::thread::spawn(move || {
            let mut stream = BufReader::new(stream);
            let mut line = Vec::new();
            while matches!(stream.by_ref().take(BYTES_A_LINE).read_until(b'\n', &mut line), Ok(1..)) {
                let text = String::from_utf8_lossy(&line).trim_end().to_owned();
                line.clear();
                let mut lines = kept.lock().unwrap_or_else(PoisonError::into_inner);
                if !text.is_empty() {
                    lines.push_back(text);
                }
                if lines.len() > LINES_KEPT {
                    lines.pop_front();
                }
            }
        });
        Self { lines }
    }

    /// `; its last words were` and the lines, or nothing.
    pub fn quote(&self) -> String {
        let lines = self.lines.lock().unwrap_or_else(PoisonError::into_inner);
        if lines.is_empty() {
            return String::new();
        }
        let mut quote = "; its last words were".to_owned();
        for line in lines.iter() {
            quote.push_str("\n  | ");
            quote.push_str(line);
        }
        quote
    }
}
