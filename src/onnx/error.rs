//! Why a learned model cannot be used.

use std::path::PathBuf;

/// Why a learned model cannot be used. Every variant says which file, what was expected, and what to do.
#[derive(Clone, Debug, thiserror::Error)]
pub enum OnnxError {
    /// ONNX Runtime itself does not load.
    #[error("ONNX Runtime at {path} cannot be used: {reason}; `make setup` installs it", path = path.display())]
    Runtime {
        /// The library.
        path: PathBuf,
        /// What the loader says.
        reason: String,
    },
    /// The loaded runtime lacks an execution provider that was asked for.
    #[error("execution provider {provider} is not offered by the loaded ONNX Runtime: {reason}; use `cpu`")]
    Provider {
        /// Its name.
        provider: &'static str,
        /// What the runtime says.
        reason: String,
    },
    /// A file or folder cannot be read.
    #[error("{path}: {reason}", path = path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: String,
    },
    /// `model.toml` or `registry.toml` is wrong.
    #[error("{path}: {reason}", path = path.display())]
    Description {
        /// The file.
        path: PathBuf,
        /// What is wrong, with its line where one is known.
        reason: String,
    },
    /// A named file lies outside the model's folder.
    #[error("{path}: names `{name}`, which is not a plain file inside the model's own folder", path = path.display())]
    Outside {
        /// The file that names it.
        path: PathBuf,
        /// The name.
        name: String,
    },
    /// A file is larger than what can be an ONNX graph.
    #[error(
        "{path}: {bytes} bytes; an ONNX graph is at most 2 GiB (export it with external data in the same folder)",
        path = path.display()
    )]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
    },
    /// A file's hash is in no registry.
    #[error(
        "{path}: sha256 {sha256} is listed in no registry.toml; add it to the one in your data folder if you made \
         this file yourself, or pass --allow-unlisted-model",
        path = path.display()
    )]
    Unlisted {
        /// The file.
        path: PathBuf,
        /// Its hash, hexadecimal.
        sha256: String,
    },
    /// A file is not the one its `model.toml` describes.
    #[error(
        "{path}: sha256 is {found}, model.toml says {expected}; copy the file again or correct model.toml",
        path = path.display()
    )]
    Altered {
        /// The file.
        path: PathBuf,
        /// The hash of `model.toml`.
        expected: String,
        /// The file's.
        found: String,
    },
    /// The file is no ONNX graph, or one that names operators which read other files.
    #[error("{path}: not a usable ONNX graph: {reason}", path = path.display())]
    NotAGraph {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// A tensor is not what the contract asks for.
    #[error("{path}: {mismatch}", path = path.display())]
    Signature {
        /// The graph's file.
        path: PathBuf,
        /// The tensor, as expected and as found.
        mismatch: super::Mismatch,
    },
    /// A tensor cannot be made or read as asked.
    #[error("a tensor is not as asked: {reason}")]
    Tensor {
        /// What ONNX Runtime says.
        reason: String,
    },
    /// The graph failed while it ran.
    #[error("{graph}: {reason}")]
    Run {
        /// Which graph of the contract.
        graph: &'static str,
        /// What ONNX Runtime says.
        reason: String,
    },
}
