//! A figure of every episode, with a rolling mean.

use plotters::prelude::DrawingBackend;

use super::{
    HUMAN, Metric, Study,
    canvas::{Anchor, Axes, Canvas, Colour, Drawing, FigureError, INK, range},
    colour_of, footnote, label_of,
};

/// Episodes of the rolling mean.
const WINDOW: usize = 7;

/// One line a setting over the episodes.
pub(super) struct Episodes {
    axes: Axes,
    series: Vec<(String, Colour, Vec<Option<f64>>)>,
}

impl Episodes {
    pub fn new(study: &Study, metric: Metric) -> Self {
        let mut series: Vec<_> = (0..study.settings.len())
            .map(|index| {
                let colour = colour_of(study.settings[index].params.method);
                (label_of(study, index), colour, study.values(index, metric))
            })
            .collect();
        series.push(("human".to_owned(), HUMAN, study.human_values(metric)));
        let count = study.episodes.len();
        let (y, y_step) =
            range(series.iter().flat_map(|(_, _, values)| values.iter().flatten().copied()), 0.04);
        let (_, x_step) = range([1.0, count as f64].into_iter(), 0.0);
        let axes = Axes {
            title: format!("SPARC of the wrist path by episode, {WINDOW}-episode rolling mean"),
            footnote: footnote(study),
            x: ("episode".to_owned(), [0.5, count as f64 + 0.5], x_step.max(1.0).round()),
            y: ("SPARC (nearer 0 is smoother)".to_owned(), y, y_step),
        };
        Self { axes, series }
    }
}

/// The mean of the known values within half a window of each place; fewer at the ends.
fn rolling(values: &[Option<f64>]) -> Vec<Option<f64>> {
    let around = |at: usize| {
        let near = at.saturating_sub(WINDOW / 2)..(at + WINDOW / 2 + 1).min(values.len());
        let known: Vec<f64> = values[near].iter().flatten().copied().collect();
        (!known.is_empty()).then(|| known.iter().sum::<f64>() / known.len() as f64)
    };
    (0..values.len()).map(around).collect()
}

impl Drawing for Episodes {
    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<'_, DB>) -> Result<(), FigureError> {
        self.axes.draw(canvas)?;
        let at = |index: usize, value: f64| self.axes.at(index as f64 + 1.0, value);
        for (_, colour, values) in &self.series {
            for (index, value) in values.iter().enumerate() {
                if let Some(value) = value {
                    canvas.disc(at(index, *value), 2.6, *colour, 0.45, true)?;
                }
            }
        }
        for (name, colour, values) in &self.series {
            let mean: Vec<(f64, f64)> = rolling(values)
                .into_iter()
                .enumerate()
                .filter_map(|(index, value)| Some(at(index, value?)))
                .collect();
            let width = if name == "human" { 1.6 } else { 2.8 };
            if mean.len() > 1 {
                canvas.line(&mean, *colour, width)?;
            }
        }
        let mut x = 92.0;
        for (name, colour, _) in &self.series {
            canvas.line(&[(x, 52.0), (x + 26.0, 52.0)], *colour, 2.8)?;
            canvas.text((x + 33.0, 52.0), name, 17.0, Anchor::Left, INK)?;
            x += 60.0 + 8.4 * name.chars().count() as f64;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rolling_mean_is_centred_and_skips_what_is_not_known() {
        let values: Vec<Option<f64>> = (0..20).map(|k| (k != 10).then_some(f64::from(k))).collect();
        let found = rolling(&values);
        assert_eq!(found[5], Some(5.0));
        assert_eq!(found[0], Some(1.5));
        assert_eq!(found[10], Some(10.0));
        assert_eq!(rolling(&[None, None]), [None, None]);
    }
}
