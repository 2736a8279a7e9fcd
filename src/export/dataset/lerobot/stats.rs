//! Statistics in LeRobot's own layout.

use serde_json::{Map, Value, json};

use crate::export::dataset::{FeatureStats, Histogram, ledger::EpisodeNote};

/// `{"min": [...], …, "count": [N]}`.
pub(super) fn of_vector(stats: &FeatureStats) -> Value {
    layout(stats, |values| json!(values))
}

/// The same with `[[[c]], [[c]], [[c]]]` for the channels of pictures.
pub(super) fn of_channels(stats: &FeatureStats) -> Value {
    layout(stats, |values| json!(values.iter().map(|value| [[value]]).collect::<Vec<_>>()))
}

fn layout(stats: &FeatureStats, shape: impl Fn(&[f64]) -> Value) -> Value {
    let mut all: Map<String, Value> =
        stats.named().into_iter().map(|(name, values)| (name.to_owned(), shape(values))).collect();
    all.insert("count".to_owned(), json!([stats.count]));
    Value::Object(all)
}

/// Of the pictures of one episode or several.
pub(super) fn of_pictures<'a>(episodes: impl Iterator<Item = &'a EpisodeNote>) -> FeatureStats {
    let mut channels: [Histogram; 3] = std::array::from_fn(|_| Histogram::default());
    let mut pictures = 0;
    for (histograms, count) in episodes.filter_map(|episode| episode.pictures.as_ref()) {
        pictures += count;
        for (channel, histogram) in channels.iter_mut().zip(histograms) {
            channel.merge(histogram);
        }
    }
    FeatureStats::of_pictures(&channels, pictures)
}
