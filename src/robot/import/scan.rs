//! Guards in front of the URDF parser, which recurses without a limit and trusts what it reads.

use std::{fs::File, io::Read as _, path::Path};

use quick_xml::{Reader, events::Event};

use super::ImportError;

/// Largest description, bytes; the official one has 72 kB.
const MAX_BYTES: u64 = 8 << 20;
/// Deepest nesting; URDF needs six.
const MAX_DEPTH: usize = 32;

/// Reads the description at `path` when it is small, shallow, well-formed and without a document type.
pub(super) fn read(path: &Path) -> Result<String, ImportError> {
    let io = |source| ImportError::Io { path: path.to_owned(), source };
    let mut text = String::new();
    File::open(path).map_err(io)?.take(MAX_BYTES + 1).read_to_string(&mut text).map_err(io)?;
    if text.len() as u64 > MAX_BYTES {
        return Err(ImportError::TooLarge {
            what: format!("{}", path.display()),
            found: "larger".to_owned(),
            limit: format!("{} MiB", MAX_BYTES >> 20),
        });
    }
    scan(&text)?;
    Ok(text)
}

/// Walks over the document in one pass and constant memory.
pub(super) fn scan(text: &str) -> Result<(), ImportError> {
    let line_of = |offset: u64| {
        let end = usize::try_from(offset).unwrap_or(usize::MAX).min(text.len());
        1 + text.as_bytes()[..end].iter().filter(|byte| **byte == b'\n').count()
    };
    let mut reader = Reader::from_str(text);
    let mut depth = 0_usize;
    loop {
        match reader.read_event() {
            Ok(Event::Start(_)) => {
                depth += 1;
                if depth > MAX_DEPTH {
                    let line = line_of(reader.buffer_position());
                    return Err(ImportError::TooDeep { line, depth, limit: MAX_DEPTH });
                }
            }
            Ok(Event::End(_)) => depth = depth.saturating_sub(1),
            Ok(Event::DocType(_)) => {
                return Err(ImportError::DocumentType { line: line_of(reader.buffer_position()) });
            }
            Ok(Event::Eof) if depth == 0 => return Ok(()),
            Ok(Event::Eof) => {
                let reason = format!("{depth} elements are not closed");
                return Err(ImportError::Malformed { line: line_of(text.len() as u64), reason });
            }
            Ok(_) => {}
            Err(error) => {
                let line = line_of(reader.error_position());
                return Err(ImportError::Malformed { line, reason: error.to_string() });
            }
        }
    }
}
