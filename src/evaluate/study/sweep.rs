//! Sweeps over parameters of our method, and the frontier between error and smoothness.

use std::str::FromStr;

use super::{Metric, Setting, Summary};
use crate::retarget::{Beta, Smoothing};

/// Most settings of a sweep.
const MOST: usize = 200;

/// What is swept, from `alpha=0.1..0.9,beta=fit,smoothing=ema/zero_phase`.
///
/// `alpha` is a number, several joined by `/`, or `FROM..TO` in steps of 0.1, `FROM..TO:STEP` in others; `beta` the
/// same, or `fit`; `smoothing` one or several of `ema`, `zero_phase` and `none`; `across` and `depth` the half-power
/// frequencies, Hz, of the smoother that the wrist passes before solving. What is not stated: α, `across` and `depth` as
/// they ship, β fitted, both smoothings.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// Smoothing α.
    pub alpha: Vec<f64>,
    /// Scale β.
    pub beta: Vec<Beta>,
    /// How α is applied.
    pub smoothing: Vec<Smoothing>,
    /// Cut-off of the wrist across the line of sight, Hz.
    pub across: Vec<f64>,
    /// Cut-off of the wrist along the line of sight, Hz.
    pub depth: Vec<f64>,
}

/// A sweep that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("sweep `{given}`: {what}; expected for example alpha=0.1..0.9,beta=fit,smoothing=ema/zero_phase")]
pub struct SweepError {
    given: String,
    what: String,
}

impl Default for Sweep {
    fn default() -> Self {
        let default = crate::retarget::RetargetParams::default();
        Self {
            alpha: vec![default.alpha],
            beta: vec![default.beta],
            smoothing: vec![Smoothing::Ema, Smoothing::ZeroPhase],
            across: vec![default.cutoff.across_hz],
            depth: vec![default.cutoff.depth_hz],
        }
    }
}

impl FromStr for Sweep {
    type Err = SweepError;

    fn from_str(given: &str) -> Result<Self, SweepError> {
        let wrong = |what: String| SweepError { given: given.to_owned(), what };
        let mut sweep = Self::default();
        for part in given.split(',').map(str::trim) {
            let (key, values) = part.split_once('=').ok_or_else(|| wrong(format!("no `=` in `{part}`")))?;
            match key.trim() {
                "alpha" => {
                    sweep.alpha = numbers(values).map_err(wrong)?;
                    if let Some(bad) = sweep.alpha.iter().find(|alpha| !(**alpha > 0.0 && **alpha <= 1.0)) {
                        return Err(wrong(format!("alpha {bad} is not above 0 and at most 1")));
                    }
                }
                "beta" if values.trim() == "fit" => sweep.beta = vec![Beta::Fit],
                "beta" => {
                    let scales = numbers(values).map_err(wrong)?;
                    if let Some(bad) = scales.iter().find(|beta| **beta <= 0.0) {
                        return Err(wrong(format!("beta {bad} is not above 0")));
                    }
                    sweep.beta = scales.into_iter().map(Beta::Fixed).collect();
                }
                key @ ("across" | "depth") => {
                    let cutoffs = numbers(values).map_err(wrong)?;
                    if let Some(bad) = cutoffs.iter().find(|cutoff| **cutoff <= 0.0) {
                        return Err(wrong(format!("{key} {bad} is not above 0 Hz")));
                    }
                    if key == "across" { sweep.across = cutoffs } else { sweep.depth = cutoffs }
                }
                "smoothing" => {
                    let words = values.split('/').map(|word| match word.trim() {
                        "ema" => Ok(Smoothing::Ema),
                        "zero_phase" | "zero-phase" => Ok(Smoothing::ZeroPhase),
                        "none" => Ok(Smoothing::None),
                        other => Err(wrong(format!("no smoothing `{other}`"))),
                    });
                    sweep.smoothing = words.collect::<Result<_, _>>()?;
                }
                other => return Err(wrong(format!("nothing to sweep is called `{other}`"))),
            }
        }
        match sweep.settings().len() {
            0..=MOST => Ok(sweep),
            many => Err(wrong(format!("{many} settings, at most {MOST}"))),
        }
    }
}

/// Numbers joined by `/`, each a value, `FROM..TO` or `FROM..TO:STEP`.
fn numbers(text: &str) -> Result<Vec<f64>, String> {
    let number = |text: &str| -> Result<f64, String> {
        let found: Result<f64, _> = text.trim().parse();
        found.ok().filter(|value| value.is_finite()).ok_or_else(|| format!("`{text}` is no number"))
    };
    let mut all = Vec::new();
    for part in text.split('/') {
        let Some((from, to)) = part.split_once("..") else {
            all.push(number(part)?);
            continue;
        };
        let (to, step) = to.split_once(':').unwrap_or((to, "0.1"));
        let (from, to, step) = (number(from)?, number(to)?, number(step)?);
        let steps = ((to - from) / step + 1e-9).floor();
        if !(step > 0.0 && (0.0..=MOST as f64).contains(&steps)) {
            return Err(format!("`{part}` is no range"));
        }
        // Rounded, so that 0.1 + 2 · 0.1 is called 0.3.
        all.extend((0..=steps as usize).map(|k| ((from + k as f64 * step) * 1e9).round() / 1e9));
    }
    Ok(all)
}

impl Sweep {
    /// Every combination, a smoothing at a time; without smoothing α does not matter and is there once.
    pub fn settings(&self) -> Vec<Setting> {
        let mut settings = Vec::new();
        for beta in &self.beta {
            for smoothing in &self.smoothing {
                let alphas = if *smoothing == Smoothing::None { &[1.0][..] } else { &self.alpha };
                for alpha in alphas {
                    self.add_cutoffs(Setting::smoothed(*alpha, *smoothing, *beta), &mut settings);
                }
            }
        }
        settings
    }

    /// `setting` with every pair of cut-offs, which it is named after where they are not as they ship.
    fn add_cutoffs(&self, setting: Setting, settings: &mut Vec<Setting>) {
        let shipped = setting.params.cutoff;
        for across in &self.across {
            for depth in &self.depth {
                let mut setting = setting.clone();
                setting.params.cutoff.across_hz = *across;
                setting.params.cutoff.depth_hz = *depth;
                for (word, value, shipped, count) in [
                    ("across", *across, shipped.across_hz, self.across.len()),
                    ("depth", *depth, shipped.depth_hz, self.depth.len()),
                ] {
                    if count > 1 || value != shipped {
                        setting.name += &format!(" {word}={value}");
                    }
                }
                settings.push(setting);
            }
        }
    }
}

/// Which settings no other one beats in both mean position error and mean fixed-cut-off arc length.
pub fn frontier(summary: &Summary) -> Vec<bool> {
    let place = |metric: Metric| Metric::ALL.iter().position(|other| *other == metric).unwrap_or(0);
    let (error, smooth) = (place(Metric::PositionError), place(Metric::Sal));
    let points: Vec<Option<(f64, f64)>> =
        summary.settings.iter().map(|row| Some((row[error]?.mean, -row[smooth]?.mean))).collect();
    let beaten = |(e, s): (f64, f64)| {
        points
            .iter()
            .flatten()
            .any(|(other_e, other_s)| *other_e <= e && *other_s <= s && (*other_e < e || *other_s < s))
    };
    points.iter().map(|point| point.is_some_and(|point| !beaten(point))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::statistics::Estimate;

    #[test]
    fn ranges_lists_and_words_are_read() {
        let sweep: Sweep = "alpha=0.1..0.9,beta=fit".parse().unwrap();
        assert_eq!(sweep.alpha, [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9]);
        assert_eq!((sweep.beta.as_slice(), sweep.settings().len()), (&[Beta::Fit][..], 18));
        let sweep: Sweep = "alpha=0.2/0.5..1.0:0.25, beta=0.7/0.8, smoothing=ema/none".parse().unwrap();
        assert_eq!(sweep.alpha, [0.2, 0.5, 0.75, 1.0]);
        assert_eq!(sweep.settings().len(), 2 * (4 + 1));
        let names: Vec<String> = sweep.settings().into_iter().map(|setting| setting.name).collect();
        assert_eq!(names[0], "ema alpha=0.2 beta=0.7");
        assert_eq!(names[4], "none beta=0.7");
        let sweep: Sweep = "smoothing=zero_phase,across=2/8,depth=1.5".parse().unwrap();
        let settings = sweep.settings();
        assert_eq!(
            (settings.len(), settings[1].name.as_str()),
            (2, "zero_phase alpha=0.5 across=8 depth=1.5")
        );
        assert_eq!(settings[0].params.cutoff.depth_hz, 1.5);
    }

    #[test]
    fn nonsense_is_named() {
        for (text, word) in [
            ("alpha", "no `=`"),
            ("gamma=1", "gamma"),
            ("alpha=0", "above 0"),
            ("alpha=0.9..0.1", "no range"),
            ("beta=-1", "beta -1"),
            ("depth=0", "depth 0"),
            ("smoothing=gauss", "gauss"),
            ("alpha=0.0001..1:0.0001", "no range"),
            ("alpha=x", "no number"),
        ] {
            let error = text.parse::<Sweep>().unwrap_err().to_string();
            assert!(error.contains(word), "{error}");
        }
    }

    #[test]
    fn the_frontier_holds_what_nothing_beats() {
        let row = |error: f64, sal: f64| {
            let mut row = vec![None; Metric::ALL.len()];
            row[0] = Some(Estimate { mean: error, ci95: [error; 2] });
            row[2] = Some(Estimate { mean: sal, ci95: [sal; 2] });
            row
        };
        let settings = vec![row(1.0, -5.0), row(2.0, -4.0), row(2.5, -4.5), row(0.5, -6.0)];
        let summary = Summary { settings, paired: Vec::new(), human: Vec::new() };
        assert_eq!(frontier(&summary), [true, true, false, true]);
    }
}
