//! `report.html`: everything in one file, without scripts.

use std::fmt::Write as _;

use super::{
    findings::{explanation, findings},
    measured_how, notes,
};
use crate::evaluate::{
    statistics::Estimate,
    study::{Metric, Study, Summary},
};

const STYLE: &str = "\
body{font:16px/1.5 system-ui,sans-serif;color:#1a1a1a;background:#fff;max-width:62rem;margin:2rem auto;padding:0 1rem}\
h1{font-size:1.6rem}h2{font-size:1.2rem;margin-top:2.2rem}\
table{border-collapse:collapse;font-variant-numeric:tabular-nums;font-size:.92rem;width:100%}\
th,td{padding:.3rem .6rem;border-bottom:1px solid #ddd;text-align:right;white-space:nowrap}\
th:first-child,td:first-child{text-align:left;white-space:normal}\
td small{color:#555}figure{margin:1.5rem 0}figure svg{width:100%;height:auto}figcaption{color:#444}\
.scroll{overflow-x:auto}.note{border-left:4px solid #0072b2;padding:.2rem .8rem;background:#f4f8fb}dt{font-weight:600}";

/// The page; `figures` are titles, captions and SVG documents, in order.
pub fn to_html(study: &Study, summary: &Summary, figures: &[(&str, &str, String)]) -> String {
    let mut page = String::new();
    let _ = write!(
        page,
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\"><title>Retargeting methods compared</title><style>{STYLE}</style></head><body>\n\
         <h1>Retargeting methods compared</h1>\n<p>{} episodes, {} settings. Means over episodes with 95 % intervals \
         ({}).</p>\n",
        study.episodes.len(),
        study.settings.len(),
        escaped(&study.params.bootstrap.describe())
    );
    for note in notes(study) {
        let _ = writeln!(page, "<p class=\"note\">{}</p>", escaped(&note));
    }
    let names: Vec<&str> = study.settings.iter().map(|setting| setting.name.as_str()).collect();
    page.push_str("<h2>Figures of every method</h2>\n");
    let mut rows: Vec<(&str, &[Option<Estimate>])> =
        names.iter().copied().zip(summary.settings.iter().map(Vec::as_slice)).collect();
    rows.push(("human", &summary.human));
    table(&mut page, &rows);
    if !summary.paired.is_empty() {
        page.push_str("<h2>Paired differences</h2>\n<p>On the same episodes; an interval clear of zero is in bold.</p>\n");
        let titles: Vec<String> = names[1..].iter().map(|other| format!("{} − {other}", names[0])).collect();
        let rows: Vec<(&str, &[Option<Estimate>])> =
            titles.iter().map(String::as_str).zip(summary.paired.iter().map(Vec::as_slice)).collect();
        table(&mut page, &rows);
    }
    let expected = findings(study, summary);
    if !expected.is_empty() {
        page.push_str("<h2>What was expected, and what came out</h2>\n<ul>\n");
        for finding in expected {
            let word = if finding.met { "met" } else { "not met" };
            let _ = writeln!(page, "<li><b>{word}</b>: {}</li>", escaped(&finding.text));
        }
        page.push_str("</ul>\n");
    }
    if let Some(why) = explanation(study, summary) {
        let _ = writeln!(page, "<p>{}</p>", escaped(&why));
    }
    for (title, caption, svg) in figures {
        let _ = write!(
            page,
            "<figure aria-label=\"{}\">\n{svg}\n<figcaption>{}</figcaption></figure>\n",
            escaped(title),
            escaped(caption)
        );
    }
    page.push_str("<h2>How it was measured</h2>\n<dl>\n");
    for (what, how) in measured_how(study) {
        let _ = writeln!(page, "<dt>{}</dt><dd>{}</dd>", escaped(what), escaped(&how));
    }
    page.push_str("</dl>\n</body></html>\n");
    page
}

/// Metrics as rows, methods as columns.
fn table(page: &mut String, columns: &[(&str, &[Option<Estimate>])]) {
    page.push_str("<div class=\"scroll\"><table><thead><tr><th>metric (better)</th>");
    for (name, _) in columns {
        let _ = write!(page, "<th>{}</th>", escaped(name));
    }
    page.push_str("</tr></thead><tbody>\n");
    let is_difference = columns.iter().any(|(name, _)| name.contains(" − "));
    for (index, metric) in Metric::ALL.into_iter().enumerate() {
        if columns.iter().all(|(_, row)| row[index].is_none()) {
            continue;
        }
        let _ = write!(page, "<tr><td>{} <small>({})</small></td>", escaped(metric.label()), metric.better());
        for (_, row) in columns {
            match row[index] {
                Some(value) => {
                    let shown = format!(
                        "{:.3} <small>[{:.3}, {:.3}]</small>",
                        value.mean, value.ci95[0], value.ci95[1]
                    );
                    let bold = is_difference && value.is_clear_of_zero();
                    let shown = if bold { format!("<b>{shown}</b>") } else { shown };
                    let _ = write!(page, "<td>{shown}</td>");
                }
                None => page.push_str("<td>–</td>"),
            }
        }
        page.push_str("</tr>\n");
    }
    page.push_str("</tbody></table></div>\n");
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
