//! Where imported robots are kept.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};

use super::{ImportError, Prepared, RobotReport};
use crate::robot::{RobotAsset, RobotModel};

const MODEL: &str = "robot.xml";
const REPORT: &str = "report.json";
const DEFAULT: &str = "default";

/// A robot in the user's data folder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImportedRobot {
    /// Its folder, `DATA/robots/ID`; `ID` is the hash of its content.
    pub folder: PathBuf,
    /// What it holds.
    pub report: RobotReport,
}

impl ImportedRobot {
    /// Loads the model.
    ///
    /// # Errors
    /// When a file is missing or MuJoCo refuses the model.
    pub fn load(&self) -> Result<RobotModel, ImportError> {
        load(&self.folder)
    }
}

/// The robot that was imported last into `data_dir`, or `None` where there is none.
///
/// # Errors
/// When there is one that cannot be loaded.
pub fn default_robot(data_dir: &Path) -> Result<Option<RobotModel>, ImportError> {
    let robots = data_dir.join("robots");
    let pointer = robots.join(DEFAULT);
    let id = match fs::read_to_string(&pointer) {
        Ok(id) => id,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(ImportError::Io { path: pointer, source }),
    };
    // Only names that `keep` writes, so that the pointer cannot lead anywhere else.
    let id = id.trim();
    if id.is_empty() || !id.bytes().all(|byte| byte.is_ascii_hexdigit()) {
        let source = io::Error::new(io::ErrorKind::InvalidData, "expected the name of an imported robot");
        return Err(ImportError::Io { path: pointer, source });
    }
    load(&robots.join(id)).map(Some)
}

/// Writes the robot beside its final place, renames it there, and points the default to it.
pub(super) fn keep(prepared: &Prepared, data_dir: &Path) -> Result<ImportedRobot, ImportError> {
    let robots = data_dir.join("robots");
    let id = identity(prepared);
    let folder = robots.join(&id);
    let fresh = robots.join(format!(".{id}.{}", std::process::id()));
    let at = |path: &Path| {
        let path = path.to_owned();
        move |source| ImportError::Io { path, source }
    };
    if !folder.is_dir() {
        fs::create_dir_all(&fresh).map_err(at(&fresh))?;
        let report = serde_json::to_vec_pretty(&prepared.report)
            .map_err(|error| at(&fresh)(io::Error::other(error)))?;
        let files = [(MODEL, prepared.mjcf.as_bytes()), (REPORT, &report)];
        let assets = prepared.assets.iter().map(|asset| (asset.name.as_str(), asset.bytes.as_slice()));
        for (name, bytes) in files.into_iter().chain(assets) {
            let path = fresh.join(name);
            fs::write(&path, bytes).map_err(at(&path))?;
        }
        fs::rename(&fresh, &folder).map_err(at(&folder))?;
    }
    let pointer = robots.join(DEFAULT);
    let next = robots.join(format!(".{DEFAULT}.{}", std::process::id()));
    fs::write(&next, &id).map_err(at(&next))?;
    fs::rename(&next, &pointer).map_err(at(&pointer))?;
    Ok(ImportedRobot { folder, report: prepared.report.clone() })
}

fn identity(prepared: &Prepared) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(prepared.mjcf.as_bytes());
    for asset in &prepared.assets {
        hasher.update(asset.name.as_bytes());
        hasher.update(&asset.bytes);
    }
    hasher.finalize().to_hex()[..16].to_owned()
}

fn load(folder: &Path) -> Result<RobotModel, ImportError> {
    let at = |path: &Path| {
        let path = path.to_owned();
        move |source| ImportError::Io { path, source }
    };
    let model = folder.join(MODEL);
    let mjcf = fs::read_to_string(&model).map_err(at(&model))?;
    let mut names: Vec<_> =
        fs::read_dir(folder).map_err(at(folder))?.flatten().map(|entry| entry.file_name()).collect();
    names.sort();
    let mut assets = Vec::new();
    for name in names {
        let Some(name) = name.to_str().filter(|name| name.ends_with(".stl")) else { continue };
        let path = folder.join(name);
        assets.push(RobotAsset { name: name.to_owned(), bytes: fs::read(&path).map_err(at(&path))? });
    }
    Ok(RobotModel::from_mjcf(mjcf, &assets)?)
}
