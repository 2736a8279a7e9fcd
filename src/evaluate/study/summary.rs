//! Means, intervals and paired differences of a study.

use super::{Metric, Study};
use crate::evaluate::statistics::Estimate;

/// Figures over the episodes of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Of each setting and each of [`Metric::ALL`].
    pub settings: Vec<Vec<Option<Estimate>>>,
    /// First setting minus each of the others, by [`Metric::ALL`].
    pub paired: Vec<Vec<Option<Estimate>>>,
    /// Of the human hands themselves: smoothness alone.
    pub human: Vec<Option<Estimate>>,
}

impl Study {
    /// The figures of `metric` for setting number `setting`, one an episode.
    pub fn values(&self, setting: usize, metric: Metric) -> Vec<Option<f64>> {
        self.episodes.iter().map(|episode| episode.scores[setting].get(metric)).collect()
    }

    /// The same of the human hands.
    pub fn human_values(&self, metric: Metric) -> Vec<Option<f64>> {
        self.episodes.iter().map(|episode| episode.human.get(metric)).collect()
    }
}

/// The means of `study`, with the intervals it asks for.
pub fn summary(study: &Study) -> Summary {
    let bootstrap = study.params.bootstrap;
    let known = |values: Vec<Option<f64>>| values.into_iter().flatten().collect::<Vec<f64>>();
    let of = |setting: usize| {
        let estimate = |metric: Metric| bootstrap.mean(&known(study.values(setting, metric)));
        Metric::ALL.into_iter().map(estimate).collect()
    };
    let against = |other: usize| {
        let estimate =
            |metric: Metric| bootstrap.paired(&study.values(0, metric), &study.values(other, metric));
        Metric::ALL.into_iter().map(estimate).collect()
    };
    Summary {
        settings: (0..study.settings.len()).map(of).collect(),
        paired: (1..study.settings.len()).map(against).collect(),
        human: Metric::ALL
            .into_iter()
            .map(|metric| bootstrap.mean(&known(study.human_values(metric))))
            .collect(),
    }
}
