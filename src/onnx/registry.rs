//! Which model files are known: the project's list and the user's own.

use std::{
    collections::BTreeMap,
    fs::File,
    io::{self, Read},
    path::Path,
};

use serde::Deserialize;
use sha2::{Digest, Sha256};

use super::{OnnxError, description::read_toml};

/// The project's own list.
const OURS: &str = include_str!("../../models/registry.toml");

/// A model of the list.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ListedModel {
    /// What people call it.
    pub name: String,
    /// The contract it keeps.
    pub contract: String,
    /// Its licence.
    pub licence: String,
    /// Whether that licence forbids commercial use.
    #[serde(default)]
    pub non_commercial: bool,
    /// Where it comes from and how it is exported.
    pub recipe: String,
    /// Hashes of files that are this model's, hexadecimal.
    #[serde(default)]
    pub sha256: Vec<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RegistryFile {
    #[serde(default)]
    model: Vec<ListedModel>,
}

/// All lists together.
#[derive(Clone, Debug, Default)]
pub struct Registry {
    models: Vec<ListedModel>,
    known: BTreeMap<String, usize>,
}

impl Registry {
    /// Name of the file in a folder of models.
    pub const FILE: &'static str = "registry.toml";

    /// The project's list, and the user's in `folder` where there is one.
    ///
    /// # Errors
    /// When the user's list cannot be read or is no such list.
    pub fn load(folder: Option<&Path>) -> Result<Self, OnnxError> {
        let ours: RegistryFile = toml::from_str(OURS).map_err(|error| OnnxError::Description {
            path: "models/registry.toml".into(),
            reason: error.to_string(),
        })?;
        let mut models = ours.model;
        if let Some(path) = folder.map(|folder| folder.join(Self::FILE)).filter(|path| path.exists()) {
            models.extend(read_toml::<RegistryFile>(&path)?.model);
        }
        let hashes = |(at, model): (usize, &ListedModel)| -> Vec<(String, usize)> {
            model.sha256.iter().map(|hash| (hash.to_lowercase(), at)).collect()
        };
        let known = models.iter().enumerate().flat_map(hashes).collect();
        Ok(Self { models, known })
    }

    /// The model a file with that hash belongs to.
    pub fn model(&self, sha256: &str) -> Option<&ListedModel> {
        self.known.get(&sha256.to_lowercase()).map(|at| &self.models[*at])
    }

    /// Every listed model.
    pub fn models(&self) -> &[ListedModel] {
        &self.models
    }
}

/// The SHA-256 of a file, hexadecimal; read in pieces.
///
/// # Errors
/// When it cannot be read.
pub fn hash_file(path: &Path) -> io::Result<String> {
    let mut file = File::open(path)?;
    let mut hasher = Sha256::new();
    let mut piece = vec![0; 1 << 20];
    loop {
        match file.read(&mut piece)? {
            0 => break,
            read => hasher.update(&piece[..read]),
        }
    }
    Ok(hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}
