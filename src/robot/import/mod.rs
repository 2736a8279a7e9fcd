//! A user's own robot description: checked, decimated for software rendering, and kept.
//!
//! A description is somebody else's file. It is read only behind guards (size, depth, no document type), its meshes
//! only from inside its own folder, and it becomes a model only when it is a sound tree of finite numbers.

mod decimate;
mod description;
mod error;
mod meshes;
mod mjcf;
mod scan;
mod store;
mod tree;

use std::path::Path;

use serde::{Deserialize, Serialize};

pub use error::ImportError;
pub use store::{ImportedRobot, default_robot};

use super::{RobotAsset, RobotModel};

/// What a description holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotReport {
    /// The robot's name in the description.
    pub name: String,
    /// Number of links.
    pub links: usize,
    /// Number of joints, fixed ones included.
    pub joints: usize,
    /// Joints that move on their own or follow another.
    pub moving: usize,
    /// Joints that follow another.
    pub mimics: usize,
    /// Number of mesh files used.
    pub meshes: usize,
    /// Triangles of all meshes as they are.
    pub triangles: usize,
    /// Triangles after decimation.
    pub triangles_kept: usize,
    /// What was read differently from how it is written.
    pub notes: Vec<String>,
}

/// A description that has passed every check, as our own model files.
#[derive(Debug)]
struct Prepared {
    report: RobotReport,
    mjcf: String,
    assets: Vec<RobotAsset>,
}

/// Checks the URDF file at `path`: everything [`import`] does, without keeping anything.
///
/// # Errors
/// When the file cannot be read, is hostile or unsound, or is no G1 with BrainCo hands; the error names the link, joint
/// or file.
pub fn check(path: &Path) -> Result<RobotReport, ImportError> {
    let prepared = prepare(path)?;
    RobotModel::from_mjcf(prepared.mjcf, &prepared.assets)?;
    Ok(prepared.report)
}

/// Imports the URDF file at `path` into `data_dir` (the user's data folder) and makes it the default robot.
///
/// # Errors
/// As [`check`], or when the data folder cannot be written.
pub fn import(path: &Path, data_dir: &Path) -> Result<ImportedRobot, ImportError> {
    let prepared = prepare(path)?;
    RobotModel::from_mjcf(prepared.mjcf.as_str(), &prepared.assets)?;
    store::keep(&prepared, data_dir)
}

fn prepare(path: &Path) -> Result<Prepared, ImportError> {
    let text = scan::read(path)?;
    let robot = description::parse(text)?;
    let tree = tree::Tree::new(&robot)?;
    let meshes = meshes::load(&robot, path)?;
    let mut notes = Vec::new();
    let mjcf = mjcf::write(&robot, &tree, &meshes, &mut notes);
    let report = RobotReport {
        name: robot.name.clone(),
        links: robot.links.len(),
        joints: robot.joints.len(),
        moving: robot.joints.iter().filter(|joint| description::moves(joint)).count(),
        mimics: robot
            .joints
            .iter()
            .filter(|joint| description::moves(joint) && joint.mimic.is_some())
            .count(),
        meshes: meshes.len(),
        triangles: meshes.values().map(|mesh| mesh.original).sum(),
        triangles_kept: meshes.values().map(|mesh| mesh.triangles.len()).sum(),
        notes,
    };
    let assets = meshes.values().map(meshes::Mesh::asset).collect();
    Ok(Prepared { report, mjcf, assets })
}

#[cfg(test)]
mod tests;
