//! The layer stack.
