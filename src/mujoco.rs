//! What every user of MuJoCo has to keep to.

use std::sync::{Mutex, PoisonError};

/// Runs `compile`, which reads a model description, while no other thread reads one.
///
/// MuJoCo's XML reader keeps state outside the model: two threads that read at once now and then
/// fail on perfectly good numbers ("unknown error in attribute").
pub fn compile_alone<T>(compile: impl FnOnce() -> T) -> T {
    static READER: Mutex<()> = Mutex::new(());
    // The lock guards no data of ours, so a panic in another reader leaves nothing broken behind.
    let _guard = READER.lock().unwrap_or_else(PoisonError::into_inner);
    compile()
}
