//! A model: a folder with its description and graphs, found, checked and loaded.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

use serde::de::DeserializeOwned;

use super::{
    GraphSpec, Mismatch, ModelDescription, OnnxError, Registry, Sizes, description::inside,
    references::external_files, registry::hash_file,
};

/// A model's folder and its description; nothing of it was checked yet.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelFolder {
    /// The folder.
    pub folder: PathBuf,
    /// Its `model.toml`.
    pub description: ModelDescription,
}

/// The file of one graph, checked.
#[derive(Clone, Debug, PartialEq, Eq)]
struct GraphFile {
    /// The graph's name in its contract.
    graph: &'static str,
    path: PathBuf,
}

/// A model whose files were all looked at: inside their folder, unaltered, trusted.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckedModel {
    folder: PathBuf,
    description: ModelDescription,
    files: Vec<GraphFile>,
    identity: String,
}

impl CheckedModel {
    /// Its `model.toml`.
    pub fn description(&self) -> &ModelDescription {
        &self.description
    }

    /// A hash of everything that decides what it computes: description, graphs, weights.
    pub fn identity(&self) -> &str {
        &self.identity
    }

    /// Whether it has the contract's graph called `name`.
    pub fn has(&self, name: &str) -> bool {
        self.files.iter().any(|file| file.graph == name)
    }

    /// The file of the contract's graph called `name`.
    ///
    /// # Errors
    /// When the model does without it.
    pub fn file(&self, name: &str) -> Result<&Path, OnnxError> {
        let found = self.files.iter().find(|file| file.graph == name).map(|file| file.path.as_path());
        found.ok_or_else(|| self.wrong(format!("the graph `{name}` is missing")))
    }

    /// What the contract lets a model choose.
    ///
    /// # Errors
    /// When a parameter is unknown or of another kind.
    pub fn parameters<T: DeserializeOwned>(&self) -> Result<T, OnnxError> {
        let parameters = self.description.parameters.clone();
        parameters
            .try_into()
            .map_err(|error: toml::de::Error| self.wrong(format!("[parameters]: {}", error.message())))
    }

    /// The size called `symbol`: what the graphs declare, else what the description says.
    ///
    /// # Errors
    /// When neither says it.
    pub fn size(&self, sizes: &Sizes, symbol: &'static str) -> Result<usize, OnnxError> {
        let described = self.description.sizes.get(symbol).map(|size| *size as usize);
        let found = sizes.get(symbol).ok().or(described);
        found.ok_or_else(|| self.wrong(Mismatch::Open { symbol }.to_string()))
    }

    /// What is wrong with this model's description.
    pub fn wrong(&self, reason: String) -> OnnxError {
        OnnxError::Description { path: self.folder.join(ModelDescription::FILE), reason }
    }
}

/// Whose files may be run.
#[derive(Clone, Copy, Debug)]
pub struct Trust<'a> {
    /// The known files.
    pub registry: &'a Registry,
    /// Whether others are run too.
    pub unlisted: bool,
}

impl ModelFolder {
    /// Every model in the folders below each of `roots`, in the order of the roots and of names; those whose
    /// description is wrong as what is wrong with them.
    pub fn find(roots: &[PathBuf]) -> Vec<Result<Self, OnnxError>> {
        let mut found = Vec::new();
        for root in roots {
            let Ok(entries) = fs::read_dir(root) else { continue };
            let mut folders: BTreeSet<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
            folders.insert(root.clone());
            folders.retain(|folder| folder.join(ModelDescription::FILE).is_file());
            found.extend(folders.into_iter().map(|folder| {
                let description = ModelDescription::read(&folder)?;
                Ok(Self { folder, description })
            }));
        }
        found
    }

    /// This model, if the files of all its graphs and of their weights lie inside its folder, are unaltered and
    /// trusted. Nothing is run.
    ///
    /// # Errors
    /// The first file that is missing, lies elsewhere, is no ONNX graph, was altered or is not listed.
    pub fn checked(&self, graphs: &[GraphSpec], trust: Trust<'_>) -> Result<CheckedModel, OnnxError> {
        let by = self.folder.join(ModelDescription::FILE);
        for name in self.description.sha256.keys() {
            inside(&self.folder, &by, name)?;
        }
        let mut files = Vec::new();
        let mut hashes = BTreeMap::new();
        for spec in graphs {
            let named = self.description.files.contains_key(spec.name);
            if spec.optional && !named && !self.folder.join(format!("{}.onnx", spec.name)).exists() {
                continue;
            }
            let path = self.description.graph_file(&self.folder, spec)?;
            for part in external_files(&path)?.into_iter().chain([path.clone()]) {
                let hash = self.check_hash(&part, trust)?;
                hashes.insert(part.strip_prefix(&self.folder).unwrap_or(&part).to_owned(), hash);
            }
            files.push(GraphFile { graph: spec.name, path });
        }
        let identity =
            blake3::hash(format!("{:?} {hashes:?}", self.description).as_bytes()).to_hex().to_string();
        let (folder, description) = (self.folder.clone(), self.description.clone());
        Ok(CheckedModel { folder, description, files, identity })
    }

    fn check_hash(&self, path: &Path, trust: Trust<'_>) -> Result<String, OnnxError> {
        let found = hash_file(path)
            .map_err(|error| OnnxError::Unreadable { path: path.to_owned(), reason: error.to_string() })?;
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        if let Some(expected) = self.description.sha256.get(&name)
            && !expected.eq_ignore_ascii_case(&found)
        {
            return Err(OnnxError::Altered { path: path.to_owned(), expected: expected.clone(), found });
        }
        if !trust.unlisted && trust.registry.model(&found).is_none() {
            return Err(OnnxError::Unlisted { path: path.to_owned(), sha256: found });
        }
        Ok(found)
    }
}
