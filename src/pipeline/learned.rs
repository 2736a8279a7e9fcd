//! Learned models of this installation: where they are looked for, which may be used, what they are.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::{Arc, Mutex, PoisonError},
};

use super::Installation;
use crate::{
    hands::network::{HAND_POSE, HandNetwork},
    inpaint::{
        network::{IMAGE_INPAINT, ImageNetwork},
        video::{Blend, VIDEO_INPAINT, VideoNetwork},
    },
    onnx::{CheckedModel, Contract, ModelFolder, OnnxError, Registry, Runtime, RuntimeOptions, Trust},
    segment::sam2::{ImageSegmenter, SAM2_IMAGE, SAM2_VIDEO, VideoSegmenter},
};

/// Which learned models may be used, and how.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ModelOptions {
    /// Folders that are looked through before the usual ones.
    pub folders: Vec<PathBuf>,
    /// Whether files that no registry lists are run (default: no).
    pub allow_unlisted: bool,
    /// Whether learned models are left alone altogether (default: no).
    pub off: bool,
    /// How graphs are run.
    pub runtime: RuntimeOptions,
    /// How the background network's windows are blended.
    pub blend: Blend,
    /// The program that finds hands, with its arguments, in place of a hand model and of the shipped estimator (default:
    /// none).
    pub estimator: Vec<String>,
}

/// What was found for a contract with the options it was looked for with.
type Finding = (ModelOptions, Result<Option<CheckedModel>, OnnxError>);

/// What was found for each contract. Files are large and a run comes to its models at every stage, a window at every
/// change, so they are looked for and hashed once; models that are put there later need a new start.
#[derive(Clone, Debug, Default)]
pub struct Findings(Arc<Mutex<BTreeMap<&'static str, Finding>>>);

/// A model as `doctor` shows it.
#[derive(Clone, Debug)]
pub struct ModelReport {
    /// What people call it, or its folder where that is not known.
    pub name: String,
    /// Its contract.
    pub contract: String,
    /// `Ok` where it is active; else why it is not.
    pub state: Result<(), OnnxError>,
    /// A warning about its licence.
    pub warning: Option<String>,
}

/// Every contract that the pipeline has a use for.
const CONTRACTS: [Contract; 5] = [SAM2_IMAGE, SAM2_VIDEO, VIDEO_INPAINT, IMAGE_INPAINT, HAND_POSE];

impl Installation {
    /// Folders with models, the first to win: those asked for, the user's own, the project's.
    pub fn model_folders(&self) -> Vec<PathBuf> {
        let usual = [self.user_models(), PathBuf::from("models")];
        self.models.folders.iter().cloned().chain(usual).collect()
    }

    fn user_models(&self) -> PathBuf {
        self.data.join("models")
    }

    /// The first model that keeps `contract` and may be used; `None` where there is none.
    ///
    /// # Errors
    /// Why the first one that says it keeps the contract cannot be used, or why a model that does not say so cannot be
    /// read where there is no other.
    pub fn model(&self, contract: &Contract) -> Result<Option<CheckedModel>, OnnxError> {
        let mut findings = self.findings.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((options, found)) = findings.get(contract.id)
            && *options == self.models
        {
            return found.clone();
        }
        let found = self.find_model(contract);
        findings.insert(contract.id, (self.models.clone(), found.clone()));
        found
    }

    fn find_model(&self, contract: &Contract) -> Result<Option<CheckedModel>, OnnxError> {
        let mut unreadable = None;
        for found in self.folders_of_models() {
            match found {
                Ok(model) if model.description.contract == contract.id => {
                    return self.check_model(&model, contract).map(Some);
                }
                Ok(_) => {}
                Err(error) => unreadable = unreadable.or(Some(error)),
            }
        }
        unreadable.map_or(Ok(None), Err)
    }

    /// Every model in the folders of models; a folder that was asked for and holds none is one that cannot be used.
    fn folders_of_models(&self) -> Vec<Result<ModelFolder, OnnxError>> {
        if self.models.off {
            return Vec::new();
        }
        let asked_for = &self.models.folders;
        let empty =
            asked_for.iter().filter(|folder| ModelFolder::find(std::slice::from_ref(folder)).is_empty());
        let reason = || "no model is there (a folder with model.toml)".to_owned();
        let faults = empty.map(|path| Err(OnnxError::Unreadable { path: path.clone(), reason: reason() }));
        ModelFolder::find(&self.model_folders()).into_iter().chain(faults).collect()
    }

    fn check_model(&self, model: &ModelFolder, contract: &Contract) -> Result<CheckedModel, OnnxError> {
        let registry = Registry::load(Some(&self.user_models()))?;
        let trust = Trust { registry: &registry, unlisted: self.models.allow_unlisted };
        model.checked(contract.graphs, trust)
    }

    /// What every model in use is, for the record of what went into a result. Those that cannot be used do not count.
    pub fn model_identities(&self) -> Vec<(&'static str, String)> {
        let identity =
            |contract: &Contract| Some((contract.id, self.model(contract).ok()??.identity().to_owned()));
        CONTRACTS.iter().filter_map(identity).collect()
    }

    /// ONNX Runtime.
    ///
    /// # Errors
    /// When it is missing or does not load.
    pub fn runtime(&self) -> Result<Runtime, OnnxError> {
        Runtime::load(&self.onnx_runtime(), self.models.runtime)
    }

    /// Every model that is there, for `doctor`: none where learned models are left alone.
    pub fn examine_models(&self) -> Vec<ModelReport> {
        let report = |found: Result<ModelFolder, OnnxError>| match found {
            Ok(model) => self.examine_model(&model),
            Err(error) => ModelReport {
                name: "model".to_owned(),
                contract: "unknown".to_owned(),
                state: Err(error),
                warning: None,
            },
        };
        self.folders_of_models().into_iter().map(report).collect()
    }

    fn examine_model(&self, model: &ModelFolder) -> ModelReport {
        let description = &model.description;
        let contract = CONTRACTS.iter().find(|contract| contract.id == description.contract);
        let state = match contract {
            Some(contract) => self.check_model(model, contract).and_then(|checked| self.try_model(&checked)),
            None => Err(unknown_contract(&model.folder, &description.contract)),
        };
        let warning = description.non_commercial.then(|| {
            format!("{}: its licence ({}) forbids commercial use", description.name, description.licence)
        });
        ModelReport { name: description.name.clone(), contract: description.contract.clone(), state, warning }
    }

    /// Loads a model as its stage would.
    fn try_model(&self, model: &CheckedModel) -> Result<(), OnnxError> {
        let runtime = self.runtime()?;
        match model.description().contract.as_str() {
            id if id == VIDEO_INPAINT.id => VideoNetwork::open(&runtime, model).map(drop),
            id if id == IMAGE_INPAINT.id => ImageNetwork::open(&runtime, model).map(drop),
            id if id == HAND_POSE.id => HandNetwork::open(&runtime, model).map(drop),
            id if id == SAM2_IMAGE.id => ImageSegmenter::open(&runtime, model).map(drop),
            id if id == SAM2_VIDEO.id => VideoSegmenter::open(&runtime, model).map(drop),
            other => Err(model.wrong(format!("no stage uses the contract {other}"))),
        }
    }
}

/// The back end of a stage that uses `contract`, by what was found: `embedded` unless the first model that keeps it is
/// active.
pub(super) fn backend(models: &[ModelReport], contract: &Contract, embedded: &str) -> String {
    let keeper = models.iter().find(|model| model.contract == contract.id);
    let active = keeper.filter(|model| model.state.is_ok());
    active.map_or_else(|| embedded.to_owned(), |model| format!("{}, else {embedded}", model.name))
}

fn unknown_contract(folder: &Path, found: &str) -> OnnxError {
    let known: Vec<&str> = CONTRACTS.iter().map(|contract| contract.id).collect();
    OnnxError::Description {
        path: folder.join("model.toml"),
        reason: format!("contract `{found}` is not one of {}", known.join(", ")),
    }
}
