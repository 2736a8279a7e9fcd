//! The append-only journal: one JSON object a line, each with a checksum chained to the one before.

use serde::{Deserialize, Serialize};

use super::{Author, Entry, SessionError};

/// One line of `journal.jsonl`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JournalLine {
    /// Position, from 0.
    pub seq: u64,
    /// Unix time in milliseconds.
    pub time: u64,
    /// Who did it.
    pub author: Author,
    /// What was done.
    pub entry: Entry,
}

#[derive(Serialize, Deserialize)]
struct Sealed {
    crc: u32,
    /// The checksum of the line before, so that a lost line in the middle is noticed.
    prev: u32,
    line: serde_json::Value,
}

/// Checksum over the canonical text (keys sorted) of a line and its predecessor's checksum.
fn checksum(prev: u32, line: &serde_json::Value) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&prev.to_le_bytes());
    hasher.update(line.to_string().as_bytes());
    hasher.finalize()
}

impl JournalLine {
    /// The line's text with its newline, and its checksum.
    ///
    /// # Errors
    /// When the entry cannot be written as JSON.
    pub fn seal(&self, prev: u32) -> Result<(String, u32), SessionError> {
        let line = serde_json::to_value(self).map_err(SessionError::Encode)?;
        let crc = checksum(prev, &line);
        let mut text = serde_json::to_string(&Sealed { crc, prev, line }).map_err(SessionError::Encode)?;
        text.push('\n');
        Ok((text, crc))
    }
}

/// A journal as read back.
#[derive(Debug)]
pub struct ParsedJournal {
    /// The whole lines, in order.
    pub lines: Vec<JournalLine>,
    /// Checksum of the last whole line, 0 when there is none.
    pub last_crc: u32,
    /// Bytes the whole lines take.
    pub length: usize,
    /// Bytes behind them: the torn end of a line that was never acknowledged.
    pub torn: usize,
}

/// Reads a journal's bytes. A torn or damaged last line is dropped and counted; damage before it is an error.
///
/// # Errors
/// Damage in the middle, a sequence gap, or a command this build does not know.
pub fn parse_journal(bytes: &[u8]) -> Result<ParsedJournal, SessionError> {
    let mut parsed = ParsedJournal { lines: Vec::new(), last_crc: 0, length: 0, torn: 0 };
    while parsed.length < bytes.len() {
        let rest = &bytes[parsed.length..];
        let Some(end) = rest.iter().position(|byte| *byte == b'\n') else {
            parsed.torn = rest.len();
            break;
        };
        let number = parsed.lines.len() as u64;
        match unseal(&rest[..end], parsed.last_crc, number) {
            Ok((line, crc)) => {
                parsed.lines.push(line);
                parsed.last_crc = crc;
                parsed.length += end + 1;
            }
            Err(SessionError::Damaged { .. }) if end + 1 == rest.len() => {
                parsed.torn = rest.len();
                break;
            }
            Err(error) => return Err(error),
        }
    }
    Ok(parsed)
}

fn unseal(text: &[u8], prev: u32, number: u64) -> Result<(JournalLine, u32), SessionError> {
    let damaged = |reason: String| SessionError::Damaged { line: number + 1, reason };
    let sealed: Sealed = serde_json::from_slice(text).map_err(|error| damaged(error.to_string()))?;
    if sealed.prev != prev || sealed.crc != checksum(prev, &sealed.line) {
        return Err(damaged("checksum differs".to_owned()));
    }
    // The checksum holds, so what does not parse was written by another version.
    let line: JournalLine = serde_json::from_value(sealed.line)
        .map_err(|error| SessionError::UnknownCommand { line: number + 1, reason: error.to_string() })?;
    if line.seq != number {
        return Err(damaged(format!("sequence number {} where {number} was expected", line.seq)));
    }
    Ok((line, sealed.crc))
}
