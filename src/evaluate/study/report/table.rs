//! The figures as plain text.

use std::fmt::Write as _;

use super::{
    findings::{explanation, findings},
    notes,
};
use crate::evaluate::study::{Metric, Study, Summary};

/// A table of means with their intervals, then the paired differences, then what a reader has to know; `marks` sets a
/// star beside settings.
pub fn to_table(study: &Study, summary: &Summary, marks: Option<&[bool]>) -> String {
    const SHOWN: [Metric; 5] =
        [Metric::PositionError, Metric::Sparc, Metric::Sal, Metric::Ldlj, Metric::SightError];
    let mut text = String::new();
    let width =
        study.settings.iter().map(|setting| setting.name.chars().count() + 7).max().unwrap_or(0).max(12);
    let _ = write!(text, "{:width$}", "mean [95 %]");
    for metric in SHOWN {
        let _ = write!(text, "  {:>24}", metric.key());
    }
    text.push('\n');
    let mut line = |name: &str, row: &[Option<crate::evaluate::statistics::Estimate>]| {
        let _ = write!(text, "{name:width$}");
        for (_, value) in Metric::ALL.iter().zip(row).filter(|(metric, _)| SHOWN.contains(metric)) {
            let shown = value.map_or("–".to_owned(), |value| {
                format!("{:.3} [{:.3}, {:.3}]", value.mean, value.ci95[0], value.ci95[1])
            });
            let _ = write!(text, "  {shown:>24}");
        }
        text.push('\n');
    };
    for (index, setting) in study.settings.iter().enumerate() {
        let mark = marks.is_some_and(|marks| marks[index]);
        line(&format!("{}{}", setting.name, if mark { " *" } else { "" }), &summary.settings[index]);
    }
    line("human", &summary.human);
    for (index, row) in summary.paired.iter().enumerate().filter(|_| marks.is_none()) {
        line(&format!("{}-{}", study.settings[0].name, study.settings[index + 1].name), row);
    }
    if marks.is_none() {
        for finding in findings(study, summary) {
            let _ = writeln!(text, "{} {}", if finding.met { "met:    " } else { "not met:" }, finding.text);
        }
        if let Some(why) = explanation(study, summary) {
            let _ = writeln!(text, "why: {why}");
        }
    }
    for note in notes(study) {
        let _ = writeln!(text, "note: {note}");
    }
    text
}
