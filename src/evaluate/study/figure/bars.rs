//! Bars of means with their intervals.

use plotters::prelude::DrawingBackend;

use super::{
    Metric, Study, Summary,
    canvas::{Anchor, Axes, Canvas, Colour, Drawing, FigureError, INK, range},
    colour_of, footnote, label_of,
};
use crate::evaluate::statistics::Estimate;

/// One bar a setting.
pub(super) struct Bars {
    axes: Axes,
    bars: Vec<(String, Colour, Option<Estimate>)>,
    human: Option<f64>,
}

impl Bars {
    pub fn new(study: &Study, summary: &Summary, metric: Metric) -> Self {
        let place = Metric::ALL.iter().position(|other| *other == metric).unwrap_or(0);
        let bar = |index: usize| {
            let colour = colour_of(study.settings[index].params.method);
            (label_of(study, index), colour, summary.settings[index][place])
        };
        let bars: Vec<_> = (0..study.settings.len()).map(bar).collect();
        let human = summary.human[place].map(|estimate| estimate.mean);
        let ends = bars.iter().filter_map(|(_, _, estimate)| *estimate).flat_map(|estimate| estimate.ci95);
        let (mut span, step) = range(ends.chain(human).chain([0.0]), 0.0);
        // Room for the number beyond the whisker, none on the side of zero.
        let room = 0.14 * (span[1] - span[0]);
        if span[1] > 0.0 {
            span[1] += room
        } else {
            span[0] -= room
        }
        let episodes = study.episodes.len();
        let what = if metric == Metric::Sparc {
            "SPARC (nearer 0 is smoother)".to_owned()
        } else {
            metric.label().to_owned()
        };
        let axes = Axes {
            title: format!("{}, mean of {episodes} episodes, 95 % CI", title(metric)),
            footnote: footnote(study),
            x: (String::new(), [0.0, bars.len().max(1) as f64], 0.0),
            y: (what, span, step),
        };
        Self { axes, bars, human }
    }
}

fn title(metric: Metric) -> &'static str {
    match metric {
        Metric::PositionError => "Wrist position error",
        Metric::Sparc => "SPARC of the wrist path",
        _ => metric.label(),
    }
}

impl Drawing for Bars {
    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<'_, DB>) -> Result<(), FigureError> {
        self.axes.draw(canvas)?;
        let downwards = self.axes.y.1[1] <= 0.0;
        for (index, (name, colour, estimate)) in self.bars.iter().enumerate() {
            let middle = index as f64 + 0.5;
            let (x, bottom) = self.axes.at(middle, self.axes.y.1[0]);
            canvas.text((x, bottom + 22.0), name, 18.0, Anchor::Centre, INK)?;
            let Some(estimate) = estimate else { continue };
            canvas.bar(
                self.axes.at(middle - 0.28, 0.0),
                self.axes.at(middle + 0.28, estimate.mean),
                *colour,
            )?;
            let [low, high] = estimate.ci95;
            self.axes.whisker(canvas, (middle, low), (middle, high), (INK, 1.8))?;
            let end = if downwards {
                self.axes.at(middle, low).1 + 16.0
            } else {
                self.axes.at(middle, high).1 - 16.0
            };
            let number = format!("{:.2}", estimate.mean).replace('-', "−");
            canvas.text((x, end), &number, 19.0, Anchor::Centre, INK)?;
        }
        if let Some(human) = self.human {
            let count = self.bars.len() as f64;
            let (left, height) = self.axes.at(0.0, human);
            let right = self.axes.at(count, human).0;
            let dashes = ((right - left) / 12.0) as usize;
            for dash in 0..dashes {
                let from = left + 12.0 * dash as f64;
                canvas.line(&[(from, height), (from + 7.0, height)], super::HUMAN, 1.4)?;
            }
            canvas.text((left + 4.0, height - 12.0), "human", 15.0, Anchor::Left, super::HUMAN)?;
        }
        Ok(())
    }
}
