//! Artifacts on disk, each named by its stage and the hash of everything that went into it.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use serde::{Serialize, de::DeserializeOwned};

use super::Stage;
use crate::session::write_durably;

/// Counts up when a stage's algorithm changes, so that no artifact of an older program is taken.
const ALGORITHM_VERSION: u32 = 7;

/// The hash of everything that went into an artifact.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Key(String);

impl Key {
    /// The key of `stage` whose inputs have the keys `inputs` and whose parameters are `params`.
    ///
    /// # Errors
    /// When the parameters cannot be written as JSON.
    pub fn new(stage: Stage, inputs: &[&Self], params: &impl Serialize) -> io::Result<Self> {
        let mut hasher = blake3::Hasher::new();
        let params = serde_json::to_vec(params).map_err(io::Error::other)?;
        hasher.update(
            format!("{ALGORITHM_VERSION} {} {}\n", env!("CARGO_PKG_VERSION"), stage.name()).as_bytes(),
        );
        for input in inputs {
            hasher.update(input.0.as_bytes());
            hasher.update(b"\n");
        }
        hasher.update(&params);
        Ok(Self(hasher.finalize().to_hex().to_string()))
    }

    /// The hash itself, hexadecimal.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

/// A folder of artifacts that may be deleted at any time.
#[derive(Clone, Debug)]
pub struct Cache {
    folder: PathBuf,
}

impl Cache {
    /// The cache in `folder`, which is created.
    ///
    /// # Errors
    /// When it cannot be created.
    pub fn open(folder: &Path) -> io::Result<Self> {
        fs::create_dir_all(folder)?;
        Ok(Self { folder: folder.to_owned() })
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Where `stage` keeps an artifact that is not JSON.
    pub fn path(&self, stage: Stage, key: &Key, extension: &str) -> PathBuf {
        let short = &key.0[..24];
        self.folder.join(format!("{}-{short}.{extension}", stage.name()))
    }

    /// The artifact of `stage` with `key`, made by `make` unless it is there already.
    ///
    /// A damaged artifact is made again. Those of other keys are left alone: going back to an
    /// earlier setting costs nothing.
    ///
    /// # Errors
    /// What `make` says, or when the artifact cannot be written.
    pub fn get_or_make<T, E>(
        &self,
        stage: Stage,
        key: &Key,
        make: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E>
    where
        T: Serialize + DeserializeOwned,
        E: From<io::Error>,
    {
        let path = self.path(stage, key, "json");
        if let Some(artifact) = read_sealed(&path) {
            return Ok(artifact);
        }
        let artifact = make()?;
        let body = serde_json::to_vec(&artifact).map_err(io::Error::other)?;
        let mut sealed = blake3::hash(&body).to_hex().to_string().into_bytes();
        sealed.push(b'\n');
        sealed.extend_from_slice(&body);
        write_durably(&path, &sealed)?;
        Ok(artifact)
    }
}

/// The artifact in `path` if it is whole: its first line is the hash of the rest.
fn read_sealed<T: DeserializeOwned>(path: &Path) -> Option<T> {
    let bytes = fs::read(path).ok()?;
    let (hash, body) = bytes.split_at_checked(65)?;
    if &hash[..64] != blake3::hash(body).to_hex().as_bytes() {
        return None;
    }
    serde_json::from_slice(body).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_artifact_is_made_once_and_again_when_it_is_damaged() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::open(folder.path()).unwrap();
        let key = Key::new(Stage::Arms, &[], &1).unwrap();
        let make = |value: i32| cache.get_or_make(Stage::Arms, &key, || io::Result::Ok(value)).unwrap();
        assert_eq!(make(5), 5);
        assert_eq!(make(6), 5);
        fs::write(cache.path(Stage::Arms, &key, "json"), b"torn").unwrap();
        assert_eq!(make(7), 7);
    }

    #[test]
    fn another_parameter_or_input_is_another_key() {
        let a = Key::new(Stage::Arms, &[], &1).unwrap();
        let b = Key::new(Stage::Arms, &[], &2).unwrap();
        let c = Key::new(Stage::Arms, &[&a], &1).unwrap();
        assert!(a != b && a != c && b != c);
    }
}
