//! What a comparison is expected to show, and what it shows.

use crate::{
    evaluate::{
        statistics::Estimate,
        study::{Metric, Study, Summary},
    },
    retarget::Method,
};

/// Something that was expected of our method, in words, with what came out.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Finding {
    /// What was expected and what was found.
    pub text: String,
    /// Whether it came out so.
    pub met: bool,
}

/// The paper's claims as they come out on these episodes; empty unless ours comes first and a baseline follows.
pub(super) fn findings(study: &Study, summary: &Summary) -> Vec<Finding> {
    let mut found = Vec::new();
    if study.settings.first().is_none_or(|setting| setting.params.method != Method::Ours) {
        return found;
    }
    let mean =
        |setting: usize, metric: Metric| of(&summary.settings[setting], metric).map(|value| value.mean);
    let mut nearest: Option<(f64, usize)> = None;
    for (other, setting) in study.settings.iter().enumerate().skip(1) {
        let title = setting.params.method.title();
        for metric in [Metric::PositionError, Metric::Sparc, Metric::Sal, Metric::Ldlj] {
            if let Some(difference) = of(&summary.paired[other - 1], metric) {
                found.push(clear_of_zero(title, metric, difference));
            }
        }
        let share = match setting.params.method {
            Method::Masquerade => 7.0,
            Method::DoAsIDo => 14.0,
            Method::Ours => continue,
        };
        if let (Some(ours), Some(theirs)) = (mean(0, Metric::Sparc), mean(other, Metric::Sparc)) {
            let below = 100.0 * (1.0 - ours / theirs);
            let text = format!("|SPARC| is {below:.0} % below {title}'s; the paper has {share:.0} %");
            found.push(Finding { text, met: below >= share });
        }
        if let Some(error) = mean(other, Metric::PositionError)
            && nearest.is_none_or(|(least, _)| error < least)
        {
            nearest = Some((error, other));
        }
    }
    if let (Some(ours), Some((theirs, other))) = (mean(0, Metric::PositionError), nearest) {
        let title = study.settings[other].params.method.title();
        let share = 100.0 * ours / theirs;
        let text =
            format!("the wrist error is {share:.0} % of the better baseline's ({title}); wanted is half");
        found.push(Finding { text, met: share <= 50.0 });
    }
    found
}

fn of(row: &[Option<Estimate>], metric: Metric) -> Option<Estimate> {
    let place = Metric::ALL.iter().position(|other| *other == metric)?;
    row.get(place).copied().flatten()
}

/// Whether ours is better by more than chance.
fn clear_of_zero(title: &str, metric: Metric, difference: Estimate) -> Finding {
    let better = match metric {
        Metric::PositionError => difference.ci95[1] < 0.0,
        // Negative figures: ours is nearer to zero where the difference is positive.
        _ => difference.ci95[0] > 0.0,
    };
    let worse = difference.is_clear_of_zero() && !better;
    let word = match (better, worse) {
        (true, _) => "ours is better",
        (_, true) => "ours is worse",
        _ => "no difference that chance could not make",
    };
    let [low, high] = difference.ci95;
    let text = format!(
        "{} against {title}: {word}, paired difference {:.3} [{low:.3}, {high:.3}]",
        metric.key(),
        difference.mean
    );
    Finding { text, met: better }
}

/// Why spectral figures may prefer a method that follows the hands less well, where they do.
pub(super) fn explanation(study: &Study, summary: &Summary) -> Option<String> {
    let human = of(&summary.human, Metric::Sparc)?.mean;
    let jerk = of(&summary.human, Metric::Ldlj)?.mean;
    let smoother: Vec<String> = study
        .settings
        .iter()
        .zip(&summary.settings)
        .filter_map(|(setting, row)| {
            let (sparc, own_jerk) = (of(row, Metric::Sparc)?.mean, of(row, Metric::Ldlj)?.mean);
            let title = setting.params.method.title();
            (sparc > human && own_jerk < jerk).then(|| format!("{title} ({sparc:.2}, jerk {own_jerk:.2})"))
        })
        .collect();
    (!smoother.is_empty()).then(|| {
        format!(
            "By SPARC these look smoother than the human hands that they follow ({human:.2}, log dimensionless jerk \
             {jerk:.2}), though their jerk is larger: {}. Noise fills the pauses between the movements of a hand, raises \
             the mean speed by which the spectrum is normalised, and so shortens its outline, at a fixed cut-off too. A \
             method that keeps the pauses cannot come below the human's own value; the jerk, which noise cannot improve, \
             and the position error stand beside it for that reason.",
            smoother.join(", ")
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::study::{EpisodeResult, ReferenceKind, Scores, Setting, StudyParams, summary};

    #[test]
    fn claims_are_judged_and_their_failure_explained() {
        let scores = |error: f64, sparc: f64, jerk: f64| {
            let mut scores = Scores::default();
            scores.set(Metric::PositionError, Some(error));
            scores.set(Metric::Sparc, Some(sparc));
            scores.set(Metric::Ldlj, Some(jerk));
            scores
        };
        let episode = |k: u32| EpisodeResult {
            name: k.to_string(),
            reference: ReferenceKind::Truth,
            human: scores(0.0, -6.0, -11.0),
            scores: vec![
                scores(0.8, -5.5, -11.5),
                scores(5.0, -6.0, -14.0),
                scores(2.0 + 0.01 * f64::from(k), -5.0, -14.5),
            ],
        };
        let settings = [Method::Ours, Method::Masquerade, Method::DoAsIDo].map(Setting::of_method).to_vec();
        let study = Study {
            params: StudyParams::default(),
            settings,
            episodes: (0..8).map(episode).collect(),
            notes: Vec::new(),
        };
        let summary = summary(&study);
        let found = findings(&study, &summary);
        let met = |word: &str| found.iter().find(|finding| finding.text.contains(word)).unwrap().met;
        assert!(met("position_error_cm against Masquerade") && met("sparc against Masquerade"));
        assert!(met("8 % below Masquerade") && met("better baseline"));
        assert!(!met("sparc against Do as I Do") && !met("-10 % below Do as I Do"));
        let why = explanation(&study, &summary).unwrap();
        assert!(why.contains("Do as I Do (-5.00") && !why.contains("Masquerade"), "{why}");
    }
}
