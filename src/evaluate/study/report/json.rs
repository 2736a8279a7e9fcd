//! `report.json`.

use serde_json::{Map, Value, json};

use super::{
    findings::{explanation, findings},
    measured_how, notes, params_json,
};
use crate::{
    evaluate::{
        statistics::Estimate,
        study::{Metric, Setting, Sources, Study, Summary, frontier},
    },
    retarget::RetargetParams,
};

/// The report: `methods.NAME.METRIC` with `mean`, `ci95` and `episodes` (null where not measured), `paired` the first
/// setting minus each other one, `human` the smoothness of the human hands, and everything the numbers depend on.
pub fn report_json(study: &Study, summary: &Summary, sources: &Sources) -> Value {
    let mut methods = Map::new();
    let mut paired = Map::new();
    for (index, setting) in study.settings.iter().enumerate() {
        let mut figures = figures(&summary.settings[index], |metric| study.values(index, metric));
        figures.insert("parameters".to_owned(), params_json(setting));
        methods.insert(setting.name.clone(), Value::Object(figures));
        if index > 0 {
            let name = format!("{}-{}", study.settings[0].name, setting.name);
            paired.insert(name, Value::Object(estimates(&summary.paired[index - 1])));
        }
    }
    let how: Map<String, Value> =
        measured_how(study).into_iter().map(|(key, text)| (key.to_owned(), text.into())).collect();
    let episodes: Vec<Value> = study
        .episodes
        .iter()
        .map(|episode| json!({ "name": episode.name, "reference": episode.reference.name() }))
        .collect();
    let seeds = sources.seeds();
    json!({
        "version": 1,
        "program": concat!("agenticfocus ", env!("CARGO_PKG_VERSION")),
        "methods": methods,
        "paired": paired,
        "human": figures(&summary.human, |metric| study.human_values(metric)),
        "episodes": episodes,
        "alignment": study.params.alignment.name(),
        "bootstrap": study.params.bootstrap,
        "measured": how,
        "error_model": (!seeds.is_empty()).then(|| sources.error_model()),
        "seeds": seeds,
        "findings": findings(study, summary)
            .into_iter()
            .map(|finding| json!({ "text": finding.text, "met": finding.met }))
            .collect::<Vec<_>>(),
        "explanation": explanation(study, summary),
        "notes": notes(study),
    })
}

/// The settings of a sweep in order: name, parameters, means with intervals, and whether nothing beats it.
pub fn sweep_json(study: &Study, summary: &Summary) -> Value {
    let best = frontier(summary);
    let rows = study.settings.iter().zip(&summary.settings).zip(best);
    let row = |((setting, row), best): ((&Setting, &Vec<Option<Estimate>>), bool)| {
        let params: &RetargetParams = &setting.params;
        let mut map = estimates(row);
        map.insert("name".to_owned(), setting.name.clone().into());
        map.insert("alpha".to_owned(), params.alpha.into());
        map.insert("beta".to_owned(), json!(params.beta));
        map.insert("smoothing".to_owned(), json!(params.smoothing));
        map.insert("frontier".to_owned(), best.into());
        Value::Object(map)
    };
    rows.map(row).collect()
}

fn estimate(estimate: &Estimate) -> Map<String, Value> {
    let mut map = Map::new();
    map.insert("mean".to_owned(), json!(estimate.mean));
    map.insert("ci95".to_owned(), json!(estimate.ci95));
    map
}

fn estimates(row: &[Option<Estimate>]) -> Map<String, Value> {
    let known = Metric::ALL.iter().zip(row);
    known
        .filter_map(|(metric, value)| {
            Some((metric.key().to_owned(), Value::Object(estimate(value.as_ref()?))))
        })
        .collect()
}

fn figures(row: &[Option<Estimate>], values: impl Fn(Metric) -> Vec<Option<f64>>) -> Map<String, Value> {
    let mut figures = estimates(row);
    for metric in Metric::ALL {
        if let Some(Value::Object(figure)) = figures.get_mut(metric.key()) {
            figure.insert("episodes".to_owned(), json!(values(metric)));
        }
    }
    figures
}
