//! The hand estimator in use: the shipped one, or a program that somebody named.

use std::path::Path;

use crate::{
    hands::{EstimatorCommand, HandsError},
    pipeline::{Cache, Installation},
    session::write_durably,
};

/// The shipped estimator; embedded so that the program needs no files beside it.
const SCRIPT: &str = include_str!("../../../models/estimators/mediapipe_hands.py");
/// Longest file named on the command line that is taken for a script, bytes.
const LONGEST_SCRIPT: u64 = 1 << 20;

/// What tells this estimator from another: its words, and the content of every script among them.
pub(super) fn identity(installation: &Installation) -> Vec<String> {
    let own = &installation.models.estimator;
    if own.is_empty() {
        return vec![hash_of(SCRIPT.as_bytes())];
    }
    let scripts = own.iter().map(Path::new).filter(|path| {
        path.is_file() && path.metadata().is_ok_and(|metadata| metadata.len() <= LONGEST_SCRIPT)
    });
    let content = scripts.filter_map(|path| Some(hash_of(&std::fs::read(path).ok()?)));
    own.iter().cloned().chain(content).collect()
}

fn hash_of(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

/// How it is run; the shipped script is put into `cache` first.
pub(super) fn command(installation: &Installation, cache: &Cache) -> Result<EstimatorCommand, HandsError> {
    if let Some((program, arguments)) = installation.models.estimator.split_first() {
        return Ok(EstimatorCommand::new(program, arguments.iter().cloned()));
    }
    let script = cache.folder().join("mediapipe_hands.py");
    write_durably(&script, SCRIPT.as_bytes())
        .map_err(|source| HandsError::Start { program: script.clone(), source })?;
    Ok(EstimatorCommand::new(installation.estimator_python(), [script.to_string_lossy().into_owned()]))
}
