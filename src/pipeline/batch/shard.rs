//! Shards: a share of the clips, chosen by the hash of each id.

use std::str::FromStr;

/// Shard `index` of `count`: clips whose hashed id falls on it, whatever the order of the manifest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: u64,
    count: u64,
}

/// Why a shard was refused.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
#[error("shard {0:?}: expected I/N with 0 ≤ I < N, for example 0/4")]
pub struct ShardError(String);

impl Default for Shard {
    fn default() -> Self {
        Self { index: 0, count: 1 }
    }
}

impl FromStr for Shard {
    type Err = ShardError;
    fn from_str(text: &str) -> Result<Self, ShardError> {
        let parse = || {
            let (index, count) = text.split_once('/')?;
            let (index, count) = (index.parse().ok()?, count.parse().ok()?);
            (index < count).then_some(Self { index, count })
        };
        parse().ok_or_else(|| ShardError(text.to_owned()))
    }
}

impl Shard {
    /// Whether the clip with this id belongs to the shard.
    pub fn contains(&self, id: &str) -> bool {
        let hash = blake3::hash(id.as_bytes());
        let mut first = [0; 8];
        first.copy_from_slice(&hash.as_bytes()[..8]);
        u64::from_le_bytes(first) % self.count == self.index
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_clip_lies_in_exactly_one_shard() {
        for id in ["put", "scrape", "cup_lid", "a", "b"] {
            let shards = (0..5).filter(|i| format!("{i}/5").parse::<Shard>().unwrap().contains(id));
            assert_eq!(shards.count(), 1, "{id}");
        }
    }

    #[test]
    fn nonsense_is_refused() {
        for text in ["", "1", "4/4", "-1/2", "1/0", "a/b", "1/2/3"] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }
}
