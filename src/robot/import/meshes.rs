//! Mesh files: found inside the description's folder only, read, decimated.

use std::{
    collections::BTreeMap,
    fs,
    path::{Component, Path, PathBuf},
};

use urdf_rs::{Geometry, Robot};

use super::{ImportError, decimate::decimate};
use crate::robot::RobotAsset;

/// Largest mesh file, bytes.
const MAX_BYTES: u64 = 64 << 20;
/// Most triangles of all meshes together; the official description has 626,921.
const MAX_TRIANGLES: usize = 4_000_000;

/// A decimated mesh.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mesh {
    /// Unique, and safe as a file name and in XML.
    pub(super) name: String,
    /// Triangles before decimation.
    pub(super) original: usize,
    /// Corners, metres before the scale of the visual.
    pub(super) triangles: Vec<[[f32; 3]; 3]>,
}

impl Mesh {
    /// Name of the mesh's file in our own folder.
    pub(super) fn file(&self) -> String {
        format!("{}.stl", self.name)
    }

    /// The mesh as a binary STL file.
    pub(super) fn asset(&self) -> RobotAsset {
        let mut bytes = vec![0_u8; 80];
        bytes.extend((self.triangles.len() as u32).to_le_bytes());
        for triangle in &self.triangles {
            bytes.extend([0_u8; 12]);
            triangle.iter().flatten().for_each(|value| bytes.extend(value.to_le_bytes()));
            bytes.extend([0_u8; 2]);
        }
        RobotAsset { name: self.file(), bytes }
    }
}

/// All meshes that links show, by the file name as the description writes it.
pub(super) fn load(robot: &Robot, description: &Path) -> Result<BTreeMap<String, Mesh>, ImportError> {
    let folder = description.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let folder =
        folder.canonicalize().map_err(|source| ImportError::Io { path: folder.to_owned(), source })?;
    let mut meshes = BTreeMap::new();
    let mut total = 0;
    for link in &robot.links {
        for visual in &link.visual {
            let Geometry::Mesh { filename, .. } = &visual.geometry else { continue };
            if meshes.contains_key(filename) {
                continue;
            }
            let path = resolve(&link.name, filename, &folder)?;
            let broken = |reason: String| ImportError::Mesh {
                link: link.name.clone(),
                file: filename.clone(),
                reason,
            };
            let triangles = read_stl(&path).map_err(broken)?;
            let original = triangles.len();
            total += original;
            if total > MAX_TRIANGLES {
                return Err(broken(format!(
                    "more than {MAX_TRIANGLES} triangles in all meshes up to this one"
                )));
            }
            let name = format!("mesh_{:03}", meshes.len());
            meshes.insert(filename.clone(), Mesh { name, original, triangles: decimate(&triangles) });
        }
    }
    Ok(meshes)
}

/// The file that `written` means: relative to `folder` (a canonical path), never outside it.
fn resolve(link: &str, written: &str, folder: &Path) -> Result<PathBuf, ImportError> {
    let outside = || ImportError::MeshOutside { link: link.to_owned(), file: written.to_owned() };
    // `package://NAME/…`: the package is the description's own folder, no other is known.
    let relative = match written.strip_prefix("package://") {
        Some(rest) => rest.split_once('/').ok_or_else(outside)?.1,
        None => written,
    };
    let plain = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
    if relative.contains("://") || relative.contains('\0') || !Path::new(relative).components().all(plain) {
        return Err(outside());
    }
    let missing = || ImportError::MissingMesh { link: link.to_owned(), file: written.to_owned() };
    let path = folder.join(relative).canonicalize().map_err(|_| missing())?;
    if !path.starts_with(folder) {
        return Err(outside());
    }
    if path.is_file() { Ok(path) } else { Err(missing()) }
}

/// Triangles of a binary STL file.
fn read_stl(path: &Path) -> Result<Vec<[[f32; 3]; 3]>, String> {
    let extension = path.extension().map(|extension| extension.to_ascii_lowercase());
    if extension.is_none_or(|extension| extension != "stl") {
        return Err("expected a binary STL file".to_owned());
    }
    let length = fs::metadata(path).map_err(|error| error.to_string())?.len();
    if length > MAX_BYTES {
        return Err(format!("{length} bytes, expected at most {MAX_BYTES}"));
    }
    let bytes = fs::read(path).map_err(|error| error.to_string())?;
    let count = match bytes.get(80..84) {
        Some(&[a, b, c, d]) => u32::from_le_bytes([a, b, c, d]) as usize,
        _ => return Err(format!("{} bytes: too short for a binary STL file", bytes.len())),
    };
    let (records, _) = bytes[84..].as_chunks::<50>();
    if records.len() != count || count == 0 {
        return Err(format!("the header announces {count} triangles, the file holds {}", records.len()));
    }
    let value = |record: &[u8; 50], at: usize| {
        f32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]])
    };
    let corner = |record: &[u8; 50], k: usize| [0, 4, 8].map(|offset| value(record, 12 + 12 * k + offset));
    let triangles: Vec<_> = records.iter().map(|record| [0, 1, 2].map(|k| corner(record, k))).collect();
    match triangles.iter().position(|t| t.iter().flatten().any(|v| !v.is_finite() || v.abs() > 1e6)) {
        Some(number) => Err(format!("triangle {number} has a corner that is no finite number below 1e6")),
        None => Ok(triangles),
    }
}
