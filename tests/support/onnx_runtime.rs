//! The real ONNX Runtime, where `make setup` put it.

use std::path::Path;

use agenticfocus::onnx::{Runtime, RuntimeOptions};

/// ONNX Runtime; `None`, which is said, where it is missing.
pub fn runtime() -> Option<Runtime> {
    let library = Path::new(env!("CARGO_MANIFEST_DIR")).join(".deps/onnxruntime/libonnxruntime.so.1.31.1");
    if !library.is_file() {
        println!("skipped: no ONNX Runtime at {}", library.display());
        return None;
    }
    Some(Runtime::load(&library, RuntimeOptions::default()).unwrap())
}
