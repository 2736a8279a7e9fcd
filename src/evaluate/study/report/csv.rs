//! `episodes.csv`.

use std::fmt::Write as _;

use crate::evaluate::study::{Metric, Study};

/// One row an episode and method, in order; what was not measured is empty.
pub fn to_csv(study: &Study) -> String {
    let mut text = String::from("episode,reference,method");
    for metric in Metric::ALL {
        let _ = write!(text, ",{}", metric.key());
    }
    text.push('\n');
    for episode in &study.episodes {
        let rows = study.settings.iter().map(|setting| setting.name.as_str()).zip(&episode.scores);
        for (name, scores) in rows.chain([("human", &episode.human)]) {
            let _ = write!(text, "{},{},{}", quoted(&episode.name), episode.reference.name(), quoted(name));
            for metric in Metric::ALL {
                let value = scores.get(metric).map(|value| value.to_string()).unwrap_or_default();
                let _ = write!(text, ",{value}");
            }
            text.push('\n');
        }
    }
    text
}

/// Quoted where a name would break the row (RFC 4180).
fn quoted(name: &str) -> String {
    if name.contains(['"', ',', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_with_commas_and_quotes_stay_one_field() {
        assert_eq!(quoted("seed0001"), "seed0001");
        assert_eq!(quoted("a,\"b\""), "\"a,\"\"b\"\"\"");
    }
}
