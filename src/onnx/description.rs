//! `model.toml`: what lies beside a model's graphs and says what they are.

use std::{
    collections::BTreeMap,
    fs,
    path::{Component, Path, PathBuf},
};

use serde::{Deserialize, Serialize, de::DeserializeOwned};

use super::{GraphSpec, OnnxError};

/// Longest `model.toml` or `registry.toml` that is read, bytes.
const LONGEST: u64 = 1 << 20;

/// Order of a picture tensor's axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Layout {
    /// Channels, rows, columns.
    Nchw,
    /// Rows, columns, channels.
    Nhwc,
}

/// Order of a picture's channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ChannelOrder {
    /// Red first.
    Rgb,
    /// Blue first.
    Bgr,
}

/// What a picture's values run over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Normalisation {
    /// 0 to 255.
    #[serde(rename = "0-255")]
    Bytes,
    /// 0 to 1.
    #[serde(rename = "0-1")]
    Unit,
    /// 0 to 1, minus ImageNet's mean (0.485, 0.456, 0.406), over its deviation (0.229, 0.224, 0.225).
    #[serde(rename = "imagenet")]
    ImageNet,
}

/// How a model wants its pictures, where it differs from its contract.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PictureDescription {
    /// Order of axes (default: the contract's).
    pub layout: Option<Layout>,
    /// Order of channels (default: the contract's).
    pub colour: Option<ChannelOrder>,
    /// Range of values (default: the contract's).
    pub normalisation: Option<Normalisation>,
}

/// A model as `model.toml` describes it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelDescription {
    /// The contract that its graphs keep, for example `sam2-video/1`.
    pub contract: String,
    /// What people call it.
    pub name: String,
    /// Its licence.
    pub licence: String,
    /// Whether that licence forbids commercial use (default false).
    #[serde(default)]
    pub non_commercial: bool,
    /// File of each graph (default: the graph's name and `.onnx`).
    #[serde(default)]
    pub files: BTreeMap<String, String>,
    /// Hash of each file, hexadecimal; those of external weights too.
    #[serde(default)]
    pub sha256: BTreeMap<String, String>,
    /// Sizes that the graphs leave symbolic, by their names in the contract.
    #[serde(default)]
    pub sizes: BTreeMap<String, u32>,
    /// How it wants pictures.
    #[serde(default)]
    pub picture: PictureDescription,
    /// What else the contract lets a model choose.
    #[serde(default)]
    pub parameters: toml::Table,
}

impl ModelDescription {
    /// Name of the file in a model's folder.
    pub const FILE: &'static str = "model.toml";

    /// Reads the description in `folder`.
    ///
    /// # Errors
    /// When it cannot be read, is too long or is not such a description; the reason names key and line.
    pub fn read(folder: &Path) -> Result<Self, OnnxError> {
        read_toml(&folder.join(Self::FILE))
    }

    /// The file of a graph.
    ///
    /// # Errors
    /// When its name is no plain file name, or it is not a file inside `folder`.
    pub fn graph_file(&self, folder: &Path, graph: &GraphSpec) -> Result<PathBuf, OnnxError> {
        let name = self.files.get(graph.name).cloned().unwrap_or_else(|| format!("{}.onnx", graph.name));
        inside(folder, &folder.join(Self::FILE), &name)
    }
}

/// Reads a short TOML file.
pub(super) fn read_toml<T: DeserializeOwned>(path: &Path) -> Result<T, OnnxError> {
    let unreadable = |reason: String| OnnxError::Unreadable { path: path.to_owned(), reason };
    let length = fs::metadata(path).map_err(|error| unreadable(error.to_string()))?.len();
    if length > LONGEST {
        return Err(unreadable(format!("{length} bytes; such a file has at most {LONGEST}")));
    }
    let text = fs::read_to_string(path).map_err(|error| unreadable(error.to_string()))?;
    toml::from_str(&text).map_err(|error| OnnxError::Description {
        path: path.to_owned(),
        reason: error.to_string().trim_end().replace('\n', " | "),
    })
}

/// The file called `name` in `folder`, as `by` names it: a regular file that lies there in truth, links followed.
pub(super) fn inside(folder: &Path, by: &Path, name: &str) -> Result<PathBuf, OnnxError> {
    let outside = || OnnxError::Outside { path: by.to_owned(), name: name.to_owned() };
    let mut parts = Path::new(name).components();
    let (Some(Component::Normal(_)), None) = (parts.next(), parts.next()) else { return Err(outside()) };
    let path = folder.join(name);
    let real = |path: &Path| {
        fs::canonicalize(path)
            .map_err(|error| OnnxError::Unreadable { path: path.to_owned(), reason: error.to_string() })
    };
    if !real(&path)?.starts_with(real(folder)?) {
        return Err(outside());
    }
    if !path.is_file() {
        return Err(OnnxError::Unreadable { path, reason: "it is not a regular file".to_owned() });
    }
    Ok(path)
}
