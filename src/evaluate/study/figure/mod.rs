//! The figures of a study, as SVG and PNG.

mod bars;
mod canvas;
mod episodes;
mod tradeoff;

use super::{Metric, Study, Summary};
use crate::retarget::Method;

pub use canvas::FigureError;
use canvas::{Colour, Rendered, render};
pub use tradeoff::TradeOff;

/// Names of the files, without extension, with titles and captions.
pub const FIGURES: [(&str, &str, &str); 4] = [
    (
        "position_error",
        "Mean wrist position error",
        "Mean 3-D distance of the robot's wrist to the human's, taken back to the scene; bars are means over episodes, \
         whiskers 95 % bootstrap intervals.",
    ),
    (
        "sparc_episodes",
        "SPARC by episode",
        "SPARC of the wrist's path on every episode (dots) and its mean over 7 neighbouring episodes (lines). Nearer \
         to zero is smoother.",
    ),
    (
        "sparc",
        "Mean SPARC",
        "Means over episodes with 95 % bootstrap intervals. Nearer to zero is smoother; white jitter can make SPARC \
         look better, so read it beside position error and the fixed-cut-off arc length.",
    ),
    (
        "tradeoff",
        "Position error against smoothness",
        "One point a setting, means over episodes: up and to the left is better. Rings are settings of our method: the \
         published moving average over α, its zero-phase form over α, and steadier wrist smoothers, by their cut-off \
         across the line of sight, which take the wrist off its pixel (sight_error_mrad); whiskers are 95 % intervals.",
    ),
];

/// A drawn figure.
#[derive(Clone, Debug)]
pub struct Figure {
    /// The file's name without extension.
    pub name: &'static str,
    /// Title.
    pub title: &'static str,
    /// Caption.
    pub caption: &'static str,
    /// The SVG document.
    pub svg: String,
    /// The PNG file.
    pub png: Vec<u8>,
}

/// Draws all of [`FIGURES`]; `sweep` adds settings of our method to the last.
///
/// # Errors
/// When the drawing library refuses.
pub fn draw_figures(
    study: &Study,
    summary: &Summary,
    sweep: Option<(&Study, &Summary)>,
) -> Result<Vec<Figure>, FigureError> {
    let drawn: [Rendered; 4] = [
        render(&bars::Bars::new(study, summary, Metric::PositionError))?,
        render(&episodes::Episodes::new(study, Metric::Sparc))?,
        render(&bars::Bars::new(study, summary, Metric::Sparc))?,
        render(&TradeOff::new(study, summary, sweep))?,
    ];
    let named = FIGURES.into_iter().zip(drawn);
    Ok(named
        .map(|((name, title, caption), Rendered { svg, png })| Figure { name, title, caption, svg, png })
        .collect())
}

/// Colours that readers of every colour vision tell apart (Okabe and Ito 2008).
fn colour_of(method: Method) -> Colour {
    match method {
        Method::Ours => Colour(0, 114, 178),
        Method::Masquerade => Colour(213, 94, 0),
        Method::DoAsIDo => Colour(0, 158, 115),
    }
}

const HUMAN: Colour = Colour(90, 90, 90);

/// What a figure calls a setting.
fn label_of(study: &Study, setting: usize) -> String {
    let setting = &study.settings[setting];
    let title = setting.params.method.title();
    match setting.params.method {
        _ if setting.name != setting.params.method.name() => setting.name.clone(),
        Method::DoAsIDo => format!("{title}*"),
        _ => title.to_owned(),
    }
}

/// What stands below a figure with Do as I Do in it.
fn footnote(study: &Study) -> Option<&'static str> {
    let there = study.settings.iter().any(|setting| setting.params.method == Method::DoAsIDo);
    there.then_some("* kinematic part alone, without its physics refinement")
}
