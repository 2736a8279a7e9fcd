//! Content-addressed masks: a mask's name is the hash of its bytes, so equal masks are stored once.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::{Arc, Mutex, PoisonError},
};

use serde::{Deserialize, Serialize};

use super::{SessionError, write_durably};
use crate::segment::RleMask;

/// The blake3 hash of a mask's stored bytes, 64 hexadecimal digits.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct MaskId(String);

impl TryFrom<String> for MaskId {
    type Error = String;
    fn try_from(text: String) -> Result<Self, String> {
        // Anything else could name a file outside the store.
        if text.len() == 64 && text.bytes().all(|b| b.is_ascii_digit() || (b'a'..=b'f').contains(&b)) {
            Ok(Self(text))
        } else {
            Err(format!("{text:?} is not a mask id: expected 64 lower-case hexadecimal digits"))
        }
    }
}

impl MaskId {
    /// The id `mask` has in every store.
    ///
    /// # Errors
    /// When it cannot be written as JSON.
    pub fn of(mask: &RleMask) -> Result<Self, SessionError> {
        Ok(Self::of_bytes(&serde_json::to_vec(mask).map_err(SessionError::Encode)?))
    }

    fn of_bytes(bytes: &[u8]) -> Self {
        Self(blake3::hash(bytes).to_hex().to_string())
    }
}

impl From<MaskId> for String {
    fn from(id: MaskId) -> Self {
        id.0
    }
}

impl std::fmt::Display for MaskId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

/// Masks that somebody made and that may not be on disk yet.
#[derive(Clone, Debug, Default)]
pub struct FreshMasks(Arc<Mutex<BTreeMap<MaskId, Arc<RleMask>>>>);

impl FreshMasks {
    /// Holds a mask.
    pub fn hold(&self, id: MaskId, mask: Arc<RleMask>) {
        // A map of immutable values: a panic elsewhere cannot leave it half-made.
        self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(id, mask);
    }

    fn get(&self, id: &MaskId) -> Option<Arc<RleMask>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get(id).map(Arc::clone)
    }
}

/// The folder `masks/` of a session.
#[derive(Clone, Debug)]
pub struct MaskStore {
    folder: PathBuf,
    fresh: FreshMasks,
}

impl MaskStore {
    /// The store in `folder`, which need not exist yet.
    pub fn new(folder: &Path) -> Self {
        Self::with_fresh(folder, FreshMasks::default())
    }

    /// As [`Self::new`]; what `fresh` holds is taken from there.
    pub fn with_fresh(folder: &Path, fresh: FreshMasks) -> Self {
        Self { folder: folder.to_owned(), fresh }
    }

    /// Stores `mask` durably and returns its name.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn put(&self, mask: &RleMask) -> Result<MaskId, SessionError> {
        let bytes = serde_json::to_vec(mask).map_err(SessionError::Encode)?;
        let id = MaskId::of_bytes(&bytes);
        let path = self.path(&id);
        let io = |action| {
            let path = path.clone();
            move |source| SessionError::Io { action, path, source }
        };
        if !path.exists() {
            std::fs::create_dir_all(&self.folder).map_err(|source| SessionError::Io {
                action: "create",
                path: self.folder.clone(),
                source,
            })?;
            write_durably(&path, &bytes).map_err(io("write"))?;
        }
        Ok(id)
    }

    /// Reads a mask and checks it against its name.
    ///
    /// # Errors
    /// When it is missing, damaged or not a mask.
    pub fn get(&self, id: &MaskId) -> Result<RleMask, SessionError> {
        if let Some(mask) = self.fresh.get(id) {
            return Ok(RleMask::clone(&mask));
        }
        let fault = |reason: String| SessionError::Mask { id: id.clone(), reason };
        let bytes = std::fs::read(self.path(id)).map_err(|error| fault(error.to_string()))?;
        if blake3::hash(&bytes).to_hex().as_str() != id.0 {
            return Err(fault("its bytes do not match its name".to_owned()));
        }
        serde_json::from_slice(&bytes).map_err(|error| fault(error.to_string()))
    }

    /// Every whole mask in the store; what is damaged or is no mask is left out, and reported when it is needed.
    pub fn all(&self) -> Vec<(MaskId, RleMask)> {
        let entries = std::fs::read_dir(&self.folder).into_iter().flatten().flatten();
        let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
        let ids = names.filter_map(|name| MaskId::try_from(name.strip_suffix(".rle")?.to_owned()).ok());
        ids.filter_map(|id| self.get(&id).ok().map(|mask| (id, mask))).collect()
    }

    fn path(&self, id: &MaskId) -> PathBuf {
        self.folder.join(format!("{id}.rle"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{geometry::Size, image::Mask};

    #[test]
    fn a_mask_that_is_still_being_written_is_read_from_memory() {
        let mask = RleMask::encode(&Mask::from_fn(Size::new(8, 6), |x, y| x > y));
        let id = MaskId::of(&mask).unwrap();
        let folder = Path::new("/nowhere/at/all");
        let fresh = FreshMasks::default();
        let store = MaskStore::with_fresh(folder, fresh.clone());
        assert!(matches!(store.get(&id), Err(SessionError::Mask { .. })));
        fresh.hold(id.clone(), Arc::new(mask.clone()));
        assert_eq!(store.get(&id).unwrap(), mask);
        assert!(matches!(MaskStore::new(folder).get(&id), Err(SessionError::Mask { .. })));
    }
}
