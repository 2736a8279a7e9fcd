//! ONNX Runtime: loaded once, with the execution providers that were asked for.

use std::{
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
};

use ort::{
    environment::Environment,
    ep::{self, ExecutionProviderDispatch},
    session::{Session, builder::GraphOptimizationLevel},
};
use serde::{Deserialize, Serialize};

use super::OnnxError;

/// The library that this process loaded. It is a C library with state of its own, one a process: a second
/// environment is refused, so whoever comes later shares the first.
static LOADED: Mutex<Option<(PathBuf, Environment)>> = Mutex::new(None);

/// What runs a graph.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Provider {
    /// The processor (default).
    #[default]
    Cpu,
    /// An NVIDIA GPU.
    Cuda,
    /// An NVIDIA GPU by way of compiled engines.
    TensorRt,
    /// Apple's neural engine.
    CoreMl,
}

impl Provider {
    /// Every provider.
    pub const ALL: [Self; 4] = [Self::Cpu, Self::Cuda, Self::TensorRt, Self::CoreMl];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cpu => "cpu",
            Self::Cuda => "cuda",
            Self::TensorRt => "tensorrt",
            Self::CoreMl => "coreml",
        }
    }

    /// In the order in which they are tried; the processor needs no asking.
    fn dispatch(self) -> Vec<ExecutionProviderDispatch> {
        match self {
            Self::Cpu => Vec::new(),
            Self::Cuda => vec![ep::CUDA::default().build().error_on_failure()],
            Self::TensorRt => {
                vec![ep::TensorRT::default().build().error_on_failure(), ep::CUDA::default().build()]
            }
            Self::CoreMl => vec![ep::CoreML::default().build().error_on_failure()],
        }
    }
}

/// How graphs are run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RuntimeOptions {
    /// What runs them (default: the processor).
    pub provider: Provider,
    /// Threads within one operator (default 2); a bound, so that clips side by side do not crowd each other out.
    pub threads: usize,
}

impl Default for RuntimeOptions {
    fn default() -> Self {
        Self { provider: Provider::Cpu, threads: 2 }
    }
}

/// The loaded library. Cheap to clone.
#[derive(Clone)]
pub struct Runtime {
    environment: Environment,
    library: PathBuf,
    options: RuntimeOptions,
}

impl std::fmt::Debug for Runtime {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Runtime").field("library", &self.library).field("options", &self.options).finish()
    }
}

impl Runtime {
    /// Loads the library at `library`; a process loads one, so later calls share the first.
    ///
    /// # Errors
    /// When it cannot be loaded or is older than this program needs.
    pub fn load(library: &Path, options: RuntimeOptions) -> Result<Self, OnnxError> {
        let unusable = |reason: String| OnnxError::Runtime { path: library.to_owned(), reason };
        if !library.is_file() {
            return Err(unusable("no such file".to_owned()));
        }
        let mut loaded = LOADED.lock().unwrap_or_else(PoisonError::into_inner);
        let (library, environment) = match loaded.as_ref() {
            Some(first) => first.clone(),
            None => {
                let builder = ort::init_from(library).map_err(|error| unusable(error.to_string()))?;
                let builder = builder.with_name("agenticfocus").with_telemetry(false);
                let environment = builder.build().map_err(|error| unusable(error.to_string()))?;
                loaded.insert((library.to_owned(), environment)).clone()
            }
        };
        Ok(Self { environment, library, options })
    }

    /// Loads the graph in a file that was checked before.
    pub(super) fn open(&self, path: &Path) -> Result<Session, OnnxError> {
        let broken = |reason: String| OnnxError::NotAGraph { path: path.to_owned(), reason };
        let failed = |error: ort::Error<ort::session::builder::SessionBuilder>| broken(error.to_string());
        let builder = Session::builder(&self.environment).map_err(|error| broken(error.to_string()))?;
        let builder = builder.with_optimization_level(GraphOptimizationLevel::Level3).map_err(failed)?;
        let builder = builder.with_intra_threads(self.options.threads.max(1)).map_err(failed)?;
        let builder = builder.with_inter_threads(1).map_err(failed)?;
        let builder = builder.with_deterministic_compute(true).map_err(failed)?;
        let provider = self.options.provider;
        let mut builder = builder
            .with_execution_providers(provider.dispatch())
            .map_err(|error| OnnxError::Provider { provider: provider.name(), reason: error.to_string() })?;
        builder.commit_from_file(path).map_err(|error| broken(error.to_string()))
    }
}
