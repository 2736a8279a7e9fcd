//! The session document: commands, journal, undo, review state.
