//! A sheet with axes, drawn once into SVG and once into PNG.

use std::sync::Once;

use plotters::{
    coord::Shift,
    prelude::*,
    style::{
        FontTransform, register_font,
        text_anchor::{HPos, Pos, VPos},
    },
};

/// Size of a sheet.
const SHEET: [f64; 2] = [900.0, 560.0];
/// Dots of the drawing for each unit of the sheet: coordinates are whole dots.
const FINE: u32 = 4;
/// Dots of the PNG for each unit.
const PNG_SCALE: u32 = 2;
/// The part of the sheet that the axes enclose: left, top, right, bottom.
const PLOT: [f64; 4] = [92.0, 66.0, 872.0, 452.0];
/// How much lower bitmap text is set than asked for, in its size: the library centres it by its line, not its ink.
const BITMAP_SINK: f64 = 0.17;

pub(super) const INK: Colour = Colour(26, 26, 26);
const GRID: Colour = Colour(222, 222, 222);

/// A figure could not be drawn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a figure could not be drawn: {0}")]
pub struct FigureError(String);

/// Red, green, blue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Colour(pub u8, pub u8, pub u8);

impl Colour {
    fn at(self, opacity: f64) -> RGBAColor {
        RGBColor(self.0, self.1, self.2).mix(opacity)
    }
}

/// Where a text's given point lies in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Left,
    Centre,
    Right,
}

/// Something that can be drawn.
pub(super) trait Drawing {
    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<'_, DB>) -> Result<(), FigureError>;
}

/// A figure's files.
pub(super) struct Rendered {
    pub svg: String,
    pub png: Vec<u8>,
}

/// Draws into both kinds of file.
pub(super) fn render(drawing: &impl Drawing) -> Result<Rendered, FigureError> {
    static FONT: Once = Once::new();
    FONT.call_once(|| {
        // An embedded font that does not load would show in every figure's test.
        register_font("sans-serif", FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT).ok();
    });
    let [width, height] = SHEET.map(|side| side as u32);
    let dots = (width * FINE, height * FINE);
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, dots).into_drawing_area();
        draw_on(drawing, &root, 0.0)?;
    }
    let svg = svg.replacen(
        &format!("<svg width=\"{}\" height=\"{}\"", dots.0, dots.1),
        &format!("<svg width=\"{width}\" height=\"{height}\""),
        1,
    );
    let mut fine = vec![255; 3 * (dots.0 * dots.1) as usize];
    {
        let root = BitMapBackend::with_buffer(&mut fine, dots).into_drawing_area();
        draw_on(drawing, &root, BITMAP_SINK)?;
    }
    let reduce = FINE / PNG_SCALE;
    let png = write_png(&reduced(&fine, dots, reduce), (dots.0 / reduce, dots.1 / reduce))?;
    Ok(Rendered { svg, png })
}

fn draw_on<DB: DrawingBackend>(
    drawing: &impl Drawing,
    root: &DrawingArea<DB, Shift>,
    sink: f64,
) -> Result<(), FigureError> {
    root.fill(&WHITE).map_err(failed)?;
    drawing.draw(&Canvas { root, sink })?;
    root.present().map_err(failed)
}

fn failed(error: impl std::fmt::Display) -> FigureError {
    FigureError(error.to_string())
}

/// Means over squares of `by` × `by` dots: smooth edges.
fn reduced(fine: &[u8], (width, height): (u32, u32), by: u32) -> Vec<u8> {
    let (columns, rows) = (width / by, height / by);
    let mut coarse = Vec::with_capacity(3 * (columns * rows) as usize);
    for row in 0..rows {
        for column in 0..columns {
            for channel in 0..3 {
                let dots = (0..by * by).map(|dot| {
                    let (x, y) = (column * by + dot % by, row * by + dot / by);
                    u32::from(fine[3 * (y * width + x) as usize + channel])
                });
                coarse.push(((dots.sum::<u32>() + by * by / 2) / (by * by)) as u8);
            }
        }
    }
    coarse
}

fn write_png(rgb: &[u8], (width, height): (u32, u32)) -> Result<Vec<u8>, FigureError> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(rgb).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(file)
}

/// A sheet in units of [`SHEET`], whatever it is drawn into.
pub(super) struct Canvas<'a, DB: DrawingBackend> {
    root: &'a DrawingArea<DB, Shift>,
    sink: f64,
}

type Point = (f64, f64);

fn dot((x, y): Point) -> (i32, i32) {
    let fine = f64::from(FINE);
    ((x * fine).round() as i32, (y * fine).round() as i32)
}

fn dots(length: f64) -> u32 {
    (length * f64::from(FINE)).round().max(1.0) as u32
}

impl<DB: DrawingBackend> Canvas<'_, DB> {
    pub fn line(&self, points: &[Point], colour: Colour, width: f64) -> Result<(), FigureError> {
        let style = colour.at(1.0).stroke_width(dots(width));
        self.root
            .draw(&PathElement::new(points.iter().copied().map(dot).collect::<Vec<_>>(), style))
            .map_err(failed)
    }

    pub fn bar(&self, from: Point, to: Point, colour: Colour) -> Result<(), FigureError> {
        self.root.draw(&Rectangle::new([dot(from), dot(to)], colour.at(1.0).filled())).map_err(failed)
    }

    /// A disc, or a ring where it is not `filled`.
    pub fn disc(
        &self,
        centre: Point,
        radius: f64,
        colour: Colour,
        opacity: f64,
        filled: bool,
    ) -> Result<(), FigureError> {
        let style = colour.at(opacity).filled();
        self.root.draw(&Circle::new(dot(centre), dots(radius), style)).map_err(failed)?;
        if filled {
            return Ok(());
        }
        let inner = Circle::new(dot(centre), dots((radius - 1.8).max(0.5)), WHITE.filled());
        self.root.draw(&inner).map_err(failed)
    }

    pub fn square(&self, (x, y): Point, half: f64, colour: Colour) -> Result<(), FigureError> {
        self.bar((x - half, y - half), (x + half, y + half), colour)
    }

    pub fn diamond(&self, (x, y): Point, half: f64, colour: Colour) -> Result<(), FigureError> {
        let corners = [(x - half, y), (x, y - half), (x + half, y), (x, y + half)].map(dot).to_vec();
        self.root.draw(&Polygon::new(corners, colour.at(1.0).filled())).map_err(failed)
    }

    /// Text whose middle in height lies on the given point.
    pub fn text(
        &self,
        (x, y): Point,
        text: &str,
        size: f64,
        anchor: Anchor,
        colour: Colour,
    ) -> Result<(), FigureError> {
        let horizontal = match anchor {
            Anchor::Left => HPos::Left,
            Anchor::Centre => HPos::Center,
            Anchor::Right => HPos::Right,
        };
        let font = ("sans-serif", size * f64::from(FINE)).into_font();
        let ink = colour.at(1.0);
        let style = TextStyle::from(font).color(&ink).pos(Pos::new(horizontal, VPos::Center));
        let at = dot((x, y + self.sink * size));
        self.root.draw(&Text::new(text.to_owned(), at, style)).map_err(failed)
    }

    fn text_upwards(&self, (x, y): Point, text: &str, size: f64) -> Result<(), FigureError> {
        let font = ("sans-serif", size * f64::from(FINE)).into_font().transform(FontTransform::Rotate270);
        let ink = INK.at(1.0);
        let style = TextStyle::from(font).color(&ink).pos(Pos::new(HPos::Center, VPos::Center));
        let at = dot((x + self.sink * size, y));
        self.root.draw(&Text::new(text.to_owned(), at, style)).map_err(failed)
    }
}

/// The axes of a figure.
pub(super) struct Axes {
    pub title: String,
    pub footnote: Option<&'static str>,
    /// Title, range and tick step; no ticks with step 0.
    pub x: (String, [f64; 2], f64),
    pub y: (String, [f64; 2], f64),
}

impl Axes {
    /// Where a value lies on the sheet.
    pub fn at(&self, x: f64, y: f64) -> Point {
        let [left, top, right, bottom] = PLOT;
        let share = |[low, high]: [f64; 2], value: f64| (value - low) / (high - low);
        (left + share(self.x.1, x) * (right - left), bottom - share(self.y.1, y) * (bottom - top))
    }

    pub fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<'_, DB>) -> Result<(), FigureError> {
        let [left, top, right, bottom] = PLOT;
        canvas.text((left, 26.0), &self.title, 24.0, Anchor::Left, INK)?;
        for y in ticks(self.y.1, self.y.2) {
            let (_, height) = self.at(self.x.1[0], y);
            canvas.line(&[(left, height), (right, height)], GRID, 0.8)?;
            canvas.text((left - 9.0, height), &label(y, self.y.2), 17.0, Anchor::Right, INK)?;
        }
        for x in ticks(self.x.1, self.x.2) {
            let (place, _) = self.at(x, self.y.1[0]);
            canvas.line(&[(place, bottom), (place, bottom + 5.0)], INK, 1.0)?;
            canvas.text((place, bottom + 18.0), &label(x, self.x.2), 17.0, Anchor::Centre, INK)?;
        }
        canvas.line(&[(left, top), (left, bottom), (right, bottom)], INK, 1.2)?;
        canvas.text((0.5 * (left + right), bottom + 46.0), &self.x.0, 18.0, Anchor::Centre, INK)?;
        canvas.text_upwards((26.0, 0.5 * (top + bottom)), &self.y.0, 18.0)?;
        if let Some(note) = self.footnote {
            canvas.text((left, SHEET[1] - 22.0), note, 15.0, Anchor::Left, INK)?;
        }
        Ok(())
    }

    /// A whisker with short ends.
    pub fn whisker<DB: DrawingBackend>(
        &self,
        canvas: &Canvas<'_, DB>,
        from: Point,
        to: Point,
        (colour, width): (Colour, f64),
    ) -> Result<(), FigureError> {
        let (a, b) = (self.at(from.0, from.1), self.at(to.0, to.1));
        canvas.line(&[a, b], colour, width)?;
        let upright = (a.0 - b.0).abs() < (a.1 - b.1).abs();
        let half = if upright { (4.0 * width, 0.0) } else { (0.0, 4.0 * width) };
        for end in [a, b] {
            canvas.line(
                &[(end.0 - half.0, end.1 - half.1), (end.0 + half.0, end.1 + half.1)],
                colour,
                width,
            )?;
        }
        Ok(())
    }
}

/// A range that holds `values`, with a little room, and a step that makes about six ticks of it.
pub(super) fn range(values: impl Iterator<Item = f64>, room: f64) -> ([f64; 2], f64) {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for value in values.filter(|value| value.is_finite()) {
        (low, high) = (low.min(value), high.max(value));
    }
    if low > high {
        (low, high) = (0.0, 1.0);
    }
    let width = (high - low).max(1e-3 * high.abs()).max(1e-6);
    let rough = width / 5.0;
    let power = 10.0_f64.powf(rough.log10().floor());
    let step =
        [1.0, 2.0, 5.0, 10.0].map(|k| k * power).into_iter().find(|step| *step >= rough).unwrap_or(rough);
    ([low - room * width, high + room * width], step)
}

fn ticks([low, high]: [f64; 2], step: f64) -> Vec<f64> {
    if step <= 0.0 {
        return Vec::new();
    }
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    (first..=last).map(|k| k as f64 * step).collect()
}

fn label(value: f64, step: f64) -> String {
    let places = (-step.log10().floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{value:.places$}");
    let text = if text.trim_start_matches('-').bytes().all(|c| matches!(c, b'0' | b'.')) {
        text.trim_start_matches('-').to_owned()
    } else {
        text
    };
    text.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let (range, step) = range([0.31, 2.92].into_iter(), 0.05);
        assert!((step - 1.0).abs() < 1e-12, "{step}");
        assert_eq!(ticks(range, step), [1.0, 2.0, 3.0]);
        assert_eq!(label(-0.2, 0.2), "−0.2");
        assert_eq!(label(-0.0, 0.5), "0.0");
        assert_eq!(label(3.0, 1.0), "3");
    }
}
