//! The table of figures: keys, bounds, collected values.

use std::{collections::BTreeMap, fmt::Write as _};

/// Which side of its bound a figure must be on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// At least this.
    AtLeast(f64),
    /// At most this.
    AtMost(f64),
}

impl Bound {
    /// Whether `value` is as good as asked for.
    pub fn is_met(self, value: f64) -> bool {
        match self {
            Self::AtLeast(bound) => value >= bound,
            Self::AtMost(bound) => value <= bound,
        }
    }
}

/// How a figure of several episodes is summed up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Summary {
    /// The mean over episodes.
    Mean,
    /// The largest of all.
    Largest,
    /// The sum.
    Sum,
}

/// One row of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FigureSpec {
    /// Key in the JSON.
    pub key: &'static str,
    /// What it says.
    pub label: &'static str,
    /// How good it must be.
    pub bound: Bound,
    /// How episodes are summed up.
    pub summary: Summary,
}

const fn row(key: &'static str, label: &'static str, bound: Bound, summary: Summary) -> FigureSpec {
    FigureSpec { key, label, bound, summary }
}

/// Every figure of the bench, in the table's order.
pub const FIGURES: [FigureSpec; 14] = [
    row("object_mask_j", "object mask J, from one box prompt", Bound::AtLeast(0.90), Summary::Mean),
    row("arm_mask_j", "arm + hand mask J", Bound::AtLeast(0.90), Summary::Mean),
    row(
        "template_iou_occluded",
        "IoU of the placed template with the full mask, frames ≥ 30 % occluded",
        Bound::AtLeast(0.90),
        Summary::Mean,
    ),
    row("inpaint_psnr_db", "background inside the hole, dB", Bound::AtLeast(32.0), Summary::Mean),
    row(
        "composite_psnr_db",
        "composite against the ideal one, hand ∪ object, dB",
        Bound::AtLeast(28.0),
        Summary::Mean,
    ),
    row(
        "wrist_reprojection_px",
        "wrist of the robot, reachable frames, RMS px",
        Bound::AtMost(1.0),
        Summary::Mean,
    ),
    row("hand_depth_error_pct", "wrist depth error, %", Bound::AtMost(2.0), Summary::Mean),
    row("hand_joint_error_mm", "wrist-relative joint error, mm", Bound::AtMost(6.0), Summary::Mean),
    row("ik_position_error_mm", "mean IK position error, mm", Bound::AtMost(0.1), Summary::Mean),
    row("limit_violations", "joint or velocity limit violations", Bound::AtMost(0.0), Summary::Sum),
    row("ik_time_ms", "IK, both arms and hands, one frame, one core, ms", Bound::AtMost(0.2), Summary::Mean),
    row("pipeline_fps", "whole pipeline, 640×480, two cores, frames/s", Bound::AtLeast(4.0), Summary::Mean),
    row("peak_memory_mib", "peak memory, MiB", Bound::AtMost(1536.0), Summary::Largest),
    row(
        "memory_growth_pct",
        "growth of the peak from 10 s to 60 s, %",
        Bound::AtMost(10.0),
        Summary::Largest,
    ),
];

/// Values collected over episodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figures {
    values: BTreeMap<&'static str, Vec<f64>>,
    /// Each episode's seed and its own figures, in the order they came.
    episodes: Vec<(u64, Figures)>,
}

impl Figures {
    /// Adds an episode's value; values that are not finite and keys that are not in [`FIGURES`] are left out.
    pub fn add(&mut self, key: &str, value: f64) {
        if let Some(spec) = FIGURES.iter().find(|spec| spec.key == key).filter(|_| value.is_finite()) {
            self.values.entry(spec.key).or_default().push(value);
        }
    }

    /// Adds a value where there is one.
    pub fn add_some(&mut self, key: &str, value: Option<f64>) {
        if let Some(value) = value {
            self.add(key, value);
        }
    }

    /// The summed up value of `spec`; `None` when no episode gave one.
    pub fn value(&self, spec: &FigureSpec) -> Option<f64> {
        let values = self.values.get(spec.key)?;
        Some(match spec.summary {
            Summary::Mean => values.iter().sum::<f64>() / values.len() as f64,
            Summary::Largest => values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            Summary::Sum => values.iter().sum(),
        })
    }

    /// Takes over the figures of the episode of `seed`, which stay readable one by one.
    pub fn add_episode(&mut self, seed: u64, episode: Self) {
        for (key, values) in &episode.values {
            self.values.entry(key).or_default().extend(values);
        }
        self.episodes.push((seed, episode));
    }

    /// `{"figures": {KEY: number, …}, "episodes": [{"seed": S, KEY: number, …}, …]}` with what was measured.
    pub fn to_json(&self) -> serde_json::Value {
        let episode = |(seed, figures): &(u64, Self)| {
            let mut measured = figures.measured();
            measured.insert("seed".to_owned(), (*seed).into());
            measured
        };
        let episodes: Vec<_> = self.episodes.iter().map(episode).collect();
        serde_json::json!({ "figures": self.measured(), "episodes": episodes })
    }

    fn measured(&self) -> serde_json::Map<String, serde_json::Value> {
        FIGURES.iter().filter_map(|spec| Some((spec.key.to_owned(), self.value(spec)?.into()))).collect()
    }

    /// One line with every figure that was measured, for progress.
    pub fn to_line(&self) -> String {
        let measured =
            FIGURES.iter().filter_map(|spec| Some(format!("{} {:.3}", spec.key, self.value(spec)?)));
        measured.collect::<Vec<_>>().join(", ")
    }

    /// The table in Markdown.
    pub fn to_table(&self) -> String {
        let mut table =
            String::from("| figure | key | measured | asked for | met |\n|---|---|---|---|---|\n");
        for spec in &FIGURES {
            let (sign, bound) = match spec.bound {
                Bound::AtLeast(bound) => ('≥', bound),
                Bound::AtMost(bound) => ('≤', bound),
            };
            let (value, met) = match self.value(spec) {
                Some(value) => (format!("{value:.3}"), if spec.bound.is_met(value) { "yes" } else { "no" }),
                None => ("–".to_owned(), "–"),
            };
            let _ = writeln!(table, "| {} | `{}` | {value} | {sign} {bound} | {met} |", spec.label, spec.key);
        }
        table
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_means_largest_values_and_sums() {
        let mut figures = Figures::default();
        for value in [0.8, 1.0, f64::NAN] {
            figures.add("arm_mask_j", value);
            figures.add("peak_memory_mib", value * 100.0);
            figures.add("limit_violations", value * 10.0);
            figures.add("unheard_of", value);
        }
        let json = figures.to_json();
        let value = |key: &str| json["figures"][key].as_f64();
        assert!((value("arm_mask_j").unwrap() - 0.9).abs() < 1e-12);
        assert!((value("peak_memory_mib").unwrap() - 100.0).abs() < 1e-9);
        assert!((value("limit_violations").unwrap() - 18.0).abs() < 1e-9);
        assert_eq!(value("unheard_of"), None);
        assert_eq!(value("ik_time_ms"), None);
    }

    #[test]
    fn episodes_count_in_the_sum_and_stay_readable_one_by_one() {
        let mut figures = Figures::default();
        for (seed, value) in [(7, 0.5), (8, 1.0)] {
            let mut episode = Figures::default();
            episode.add("arm_mask_j", value);
            figures.add_episode(seed, episode);
        }
        let json = figures.to_json();
        assert_eq!(json["figures"]["arm_mask_j"].as_f64(), Some(0.75));
        assert_eq!(json["episodes"][1]["seed"].as_u64(), Some(8));
        assert_eq!(json["episodes"][1]["arm_mask_j"].as_f64(), Some(1.0));
        assert_eq!(figures.to_line(), "arm_mask_j 0.750");
    }

    #[test]
    fn the_table_says_which_figures_are_met() {
        let mut figures = Figures::default();
        figures.add("ik_time_ms", 0.3);
        figures.add("pipeline_fps", 4.5);
        let table = figures.to_table();
        assert!(table.contains("`ik_time_ms` | 0.300 | ≤ 0.2 | no"), "{table}");
        assert!(table.contains("`pipeline_fps` | 4.500 | ≥ 4 | yes"), "{table}");
    }
}
