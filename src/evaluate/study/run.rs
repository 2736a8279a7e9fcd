//! Every episode by every setting.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::{Episode, ReferenceKind, Scores, Setting, SourceError, Sources, score, score::human_smoothness};
use crate::{
    evaluate::{metrics::Alignment, statistics::Bootstrap},
    progress::{Cancelled, Unwatched, Watch},
    retarget::{RetargetError, retarget},
    robot::RobotModel,
};

/// How a study is made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StudyParams {
    /// How paths are brought together.
    pub alignment: Alignment,
    /// How intervals are made.
    pub bootstrap: Bootstrap,
}

/// The figures of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// How it was made.
    pub params: StudyParams,
    /// What was compared.
    pub settings: Vec<Setting>,
    /// One an episode, in the order they were given.
    pub episodes: Vec<EpisodeResult>,
    /// What a reader should know about the sources.
    pub notes: Vec<String>,
}

/// The figures of an episode.
#[derive(Clone, Debug, PartialEq)]
pub struct EpisodeResult {
    /// Its name.
    pub name: String,
    /// What it was compared with.
    pub reference: ReferenceKind,
    /// Smoothness of the human hands themselves.
    pub human: Scores,
    /// One a setting.
    pub scores: Vec<Scores>,
}

/// Why there is no study.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// Nothing was given.
    #[error("nothing to evaluate: expected folders or files with hand tracks, or --synthetic N")]
    NoEpisodes,
    /// No method was given.
    #[error("no method to evaluate: expected at least one setting")]
    NoSettings,
    /// An episode cannot be read or made.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// A method failed on an episode.
    #[error("{setting} failed on {episode}: {source}")]
    Retarget {
        /// The setting.
        setting: String,
        /// The episode.
        episode: String,
        /// Why.
        source: RetargetError,
    },
    /// No longer wanted.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Retargets and scores every episode of `sources` by every one of `settings` on all threads of the pool at hand. The
/// result does not depend on their number.
///
/// # Errors
/// When there is nothing to do, an episode cannot be had, a method fails on one, or `watch` cancels.
pub fn run(
    sources: &Sources,
    settings: &[Setting],
    robot: &RobotModel,
    params: StudyParams,
    watch: &dyn Watch,
) -> Result<Study, StudyError> {
    if sources.is_empty() {
        return Err(StudyError::NoEpisodes);
    }
    if settings.is_empty() {
        return Err(StudyError::NoSettings);
    }
    let (done, total) = (AtomicUsize::new(0), sources.len() * settings.len());
    watch.advance(0, total);
    let results: Vec<Result<EpisodeResult, StudyError>> = (0..sources.len())
        .into_par_iter()
        .map(|index| {
            watch.check()?;
            let episode = sources.load(index)?;
            let mut scores = Vec::with_capacity(settings.len());
            for setting in settings {
                scores.push(one(&episode, setting, robot, params.alignment, watch)?);
                watch.advance(done.fetch_add(1, Ordering::Relaxed) + 1, total);
            }
            Ok(EpisodeResult {
                reference: episode.reference.kind,
                human: human_smoothness(&episode),
                scores,
                name: episode.name,
            })
        })
        .collect();
    let episodes = results.into_iter().collect::<Result<Vec<_>, _>>()?;
    Ok(Study { params, settings: settings.to_vec(), episodes, notes: sources.notes().to_vec() })
}

fn one(
    episode: &Episode,
    setting: &Setting,
    robot: &RobotModel,
    alignment: Alignment,
    watch: &dyn Watch,
) -> Result<Scores, StudyError> {
    watch.check()?;
    let motion = retarget(&episode.track, robot, &setting.params, &Unwatched).map_err(|source| {
        StudyError::Retarget { setting: setting.name.clone(), episode: episode.name.clone(), source }
    })?;
    Ok(score(episode, &motion, robot, alignment))
}
