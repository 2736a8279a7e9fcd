//! Position error against smoothness.

use plotters::prelude::DrawingBackend;

use super::{
    Metric, Study, Summary,
    canvas::{Anchor, Axes, Canvas, Colour, Drawing, FigureError, INK, range},
    colour_of, footnote, label_of,
};
use crate::{
    evaluate::statistics::Estimate,
    retarget::{Method, RetargetParams, Smoothing},
};

const EMA: Colour = Colour(204, 121, 167);
const ZERO_PHASE: Colour = Colour(86, 180, 233);
const STEADY: Colour = Colour(230, 159, 0);

/// One point a setting.
pub struct TradeOff {
    axes: Axes,
    methods: Vec<(String, Colour, Method, Estimate, Estimate)>,
    lines: Vec<Line>,
}

/// Name, colour, and α or cut-off, error, smoothness of each point.
type Line = (&'static str, Colour, Vec<(f64, f64, f64)>);

impl TradeOff {
    pub(super) fn new(study: &Study, summary: &Summary, sweep: Option<(&Study, &Summary)>) -> Self {
        let place = |metric: Metric| Metric::ALL.iter().position(|other| *other == metric).unwrap_or(0);
        let (error, smooth) = (place(Metric::PositionError), place(Metric::Sal));
        let methods: Vec<_> = (0..study.settings.len())
            .filter_map(|index| {
                let method = study.settings[index].params.method;
                let row = &summary.settings[index];
                Some((label_of(study, index), colour_of(method), method, row[error]?, row[smooth]?))
            })
            .collect();
        let shipped = RetargetParams::default().cutoff;
        // What is α's doing, and what the wrist smoother's.
        let line = |chosen: &dyn Fn(&RetargetParams) -> Option<f64>| {
            let Some((study, summary)) = sweep else { return Vec::new() };
            let rows = study.settings.iter().zip(&summary.settings);
            rows.filter_map(|(setting, row)| {
                Some((chosen(&setting.params)?, row[error]?.mean, row[smooth]?.mean))
            })
            .collect::<Vec<_>>()
        };
        let alpha = |smoothing: Smoothing| {
            line(&|params| {
                (params.smoothing == smoothing && params.cutoff == shipped).then_some(params.alpha)
            })
        };
        let cutoff = line(&|params| {
            let steadier = params.smoothing == Smoothing::ZeroPhase && params.cutoff != shipped;
            steadier.then_some(params.cutoff.across_hz)
        });
        let mut lines: Vec<Line> = vec![
            ("average, α", EMA, alpha(Smoothing::Ema)),
            ("zero-phase, α", ZERO_PHASE, alpha(Smoothing::ZeroPhase)),
            ("smoother, Hz", STEADY, cutoff),
        ];
        lines.retain(|(_, _, points)| !points.is_empty());
        let points = || lines.iter().flat_map(|(_, _, points)| points);
        let errors = methods.iter().flat_map(|(_, _, _, error, _)| error.ci95);
        let (mut x, x_step) = range(errors.chain(points().map(|point| point.1)).chain([0.0]), 0.04);
        x[0] = 0.0;
        let smoothness = methods.iter().flat_map(|(_, _, _, _, smooth)| smooth.ci95);
        let (y, y_step) = range(smoothness.chain(points().map(|point| point.2)), 0.1);
        let axes = Axes {
            title: "Position error against smoothness".to_owned(),
            footnote: footnote(study),
            x: ("mean wrist position error, cm".to_owned(), x, x_step),
            y: ("spectral arc length, 10 Hz (up is smoother)".to_owned(), y, y_step),
        };
        Self { axes, methods, lines }
    }

    fn marker<DB: DrawingBackend>(
        canvas: &Canvas<'_, DB>,
        at: (f64, f64),
        colour: Colour,
        method: Method,
    ) -> Result<(), FigureError> {
        match method {
            Method::Ours => canvas.disc(at, 7.0, colour, 1.0, true),
            Method::Masquerade => canvas.square(at, 6.0, colour),
            Method::DoAsIDo => canvas.diamond(at, 8.0, colour),
        }
    }
}

impl Drawing for TradeOff {
    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<'_, DB>) -> Result<(), FigureError> {
        self.axes.draw(canvas)?;
        let mut x = 92.0;
        for (name, colour, method, error, smooth) in &self.methods {
            let at = self.axes.at(error.mean, smooth.mean);
            let whisker = (*colour, 1.5);
            self.axes.whisker(canvas, (error.ci95[0], smooth.mean), (error.ci95[1], smooth.mean), whisker)?;
            self.axes.whisker(canvas, (error.mean, smooth.ci95[0]), (error.mean, smooth.ci95[1]), whisker)?;
            Self::marker(canvas, at, *colour, *method)?;
            Self::marker(canvas, (x + 8.0, 52.0), *colour, *method)?;
            canvas.text((x + 21.0, 52.0), name, 16.0, Anchor::Left, INK)?;
            x += 38.0 + 7.7 * name.chars().count() as f64;
        }
        for (name, colour, points) in &self.lines {
            let line: Vec<(f64, f64)> = points.iter().map(|(_, x, y)| self.axes.at(*x, *y)).collect();
            if line.len() > 1 {
                canvas.line(&line, *colour, 1.6)?;
            }
            // Where smoothing hardly moves the point, labels would lie on each other.
            let spread = line.iter().map(|at| (at.0 - line[0].0).hypot(at.1 - line[0].1)).fold(0.0, f64::max);
            for (at, (alpha, _, _)) in line.iter().zip(points) {
                canvas.disc(*at, 4.5, *colour, 1.0, false)?;
                let is_end = [points.first(), points.last()].iter().flatten().any(|end| end.0 == *alpha);
                if is_end && spread > 30.0 {
                    canvas.text((at.0 + 8.0, at.1 + 11.0), &format!("{alpha}"), 14.0, Anchor::Left, INK)?;
                }
            }
            canvas.line(&[(x, 52.0), (x + 20.0, 52.0)], *colour, 1.6)?;
            canvas.disc((x + 10.0, 52.0), 4.5, *colour, 1.0, false)?;
            canvas.text((x + 26.0, 52.0), name, 16.0, Anchor::Left, INK)?;
            x += 44.0 + 7.4 * name.chars().count() as f64;
        }
        Ok(())
    }
}
