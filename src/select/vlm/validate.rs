//! Whether what a model meant can be an object on the frames that it was sent.

use super::{letterbox::Letterbox, parse::Answer, profile::Profile};
use crate::{
    clip::FrameIndex,
    geometry::{Pixel, PixelBox, Size},
    image::Mask,
};

/// Least and largest area of a box, shares of the frame.
const AREA: [f64; 2] = [0.0002, 0.6];
/// Share of a box that hands and arms may cover.
const COVERED: f64 = 0.8;
/// Share of a box that must lie on the frame.
const INSIDE: f64 = 0.5;
/// Longest name and reason that are kept, characters.
const LONGEST_LABEL: usize = 60;
const LONGEST_REASON: usize = 300;
/// Trust in an answer that says nothing about it.
const UNSAID: f64 = 0.5;

/// What the answer is held against.
#[derive(Clone, Copy)]
pub(super) struct Shown<'a> {
    pub profile: Profile,
    pub frames: &'a [FrameIndex],
    pub letterbox: &'a Letterbox,
    /// Hands and arms on a frame that was sent.
    pub arms: &'a dyn Fn(FrameIndex) -> Mask,
}

/// Where the object is, pixels of the clip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place {
    Box(PixelBox),
    Point(Pixel),
}

/// An answer that can be used.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Selection {
    pub frame: FrameIndex,
    pub place: Place,
    pub label: String,
    pub confidence: f64,
    pub reason: String,
    /// What somebody should know about how it was taken.
    pub remarks: Vec<String>,
}

/// Why an answer cannot be used. The text is shown to the model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(super) enum Invalid {
    #[error("it names no frame: say one of {0}")]
    NoFrame(String),
    #[error("frame {found} was not sent: say one of {sent}")]
    OtherFrame { found: f64, sent: String },
    #[error("it gives no box")]
    NoBox,
    #[error("it gives no point")]
    NoPoint,
    #[error("its coordinates are not finite numbers")]
    NotFinite,
    #[error(
        "the box {corners} lies mostly outside of the image, whose corner is {limit}: are the coordinates {convention}?"
    )]
    Outside { corners: String, limit: String, convention: String },
    #[error("the box covers {percent:.3} % of the image: expected 0.02 % to 60 %")]
    Area { percent: f64 },
    #[error("{percent:.0} % of the box is hand or arm: the box must be around the object, not the hand")]
    OnHand { percent: f64 },
    #[error("the point lies on the hand or arm: it must lie on the object")]
    PointOnHand,
}

/// Holds `answer` against what was shown.
pub(super) fn validate(answer: &Answer, shown: &Shown<'_>) -> Result<Selection, Invalid> {
    let frame = frame_of(answer, shown.frames)?;
    let mut remarks: Vec<String> = answer.remarks.iter().map(|remark| (*remark).to_owned()).collect();
    let place = if shown.profile.is_point() {
        Place::Point(point_of(answer, shown, frame)?)
    } else {
        Place::Box(box_of(answer, shown, frame, &mut remarks)?)
    };
    let label = line(answer.label.as_deref().unwrap_or_default(), LONGEST_LABEL);
    let mut reason = line(answer.reason.as_deref().unwrap_or_default(), LONGEST_REASON);
    if let Some(hand) = answer.hand.as_deref().filter(|hand| matches!(*hand, "left" | "right" | "both")) {
        let which = if hand == "both" { "both hands".to_owned() } else { format!("{hand} hand") };
        reason = if reason.is_empty() { which } else { format!("{reason} ({which})") };
    }
    Ok(Selection {
        frame,
        place,
        label: if label.is_empty() { "object".to_owned() } else { label },
        confidence: confidence_of(answer, &mut remarks),
        reason: if reason.is_empty() { "the model gave no reason".to_owned() } else { reason },
        remarks,
    })
}

fn frame_of(answer: &Answer, frames: &[FrameIndex]) -> Result<FrameIndex, Invalid> {
    let sent = || frames.iter().map(|frame| frame.0.to_string()).collect::<Vec<_>>().join(", ");
    match (answer.frame, frames) {
        (None, [only]) => Ok(*only),
        (None, _) => Err(Invalid::NoFrame(sent())),
        (Some(found), _) => frames
            .iter()
            .find(|frame| f64::from(frame.0) == found)
            .copied()
            .ok_or_else(|| Invalid::OtherFrame { found, sent: sent() }),
    }
}

fn to_clip(at: Pixel, shown: &Shown<'_>) -> Pixel {
    shown.letterbox.to_clip(shown.profile.to_sent(at, shown.letterbox.sent))
}

fn box_of(
    answer: &Answer,
    shown: &Shown<'_>,
    frame: FrameIndex,
    remarks: &mut Vec<String>,
) -> Result<PixelBox, Invalid> {
    let [a, b] = answer.corners.ok_or(Invalid::NoBox)?;
    if ![a.x, a.y, b.x, b.y].iter().all(|value| value.is_finite()) {
        return Err(Invalid::NotFinite);
    }
    let size = shown.letterbox.clip;
    let whole = PixelBox::from_corners(to_clip(a, shown), to_clip(b, shown));
    let clipped = whole.clipped(size);
    let inside = clipped.map_or(0.0, |clipped| clipped.area());
    // An empty box is too small, wherever it lies.
    if whole.area() > 0.0 && inside < INSIDE * whole.area() {
        let (x, y) = shown.profile.unit(shown.letterbox.sent);
        return Err(Invalid::Outside {
            corners: format!("({}, {}) to ({}, {})", a.x, a.y, b.x, b.y),
            limit: format!("({x}, {y})"),
            convention: shown.profile.convention(shown.letterbox.sent),
        });
    }
    let share = inside / size.area() as f64;
    let bounds = clipped
        .filter(|_| (AREA[0]..=AREA[1]).contains(&share))
        .ok_or(Invalid::Area { percent: 100.0 * share })?;
    if inside < 0.98 * whole.area() {
        let percent = 100.0 * (1.0 - inside / whole.area());
        remarks.push(format!("{percent:.0} % of the box lay outside of the frame and were cut off"));
    }
    let covered = covered_share(&bounds, &(shown.arms)(frame));
    if covered > COVERED {
        return Err(Invalid::OnHand { percent: 100.0 * covered });
    }
    Ok(bounds)
}

fn point_of(answer: &Answer, shown: &Shown<'_>, frame: FrameIndex) -> Result<Pixel, Invalid> {
    let point = answer.point.or_else(|| {
        let [a, b] = answer.corners?;
        Some(Pixel::new(0.5 * (a.x + b.x), 0.5 * (a.y + b.y)))
    });
    let point = point.ok_or(Invalid::NoPoint)?;
    if !(point.x.is_finite() && point.y.is_finite()) {
        return Err(Invalid::NotFinite);
    }
    let at = to_clip(point, shown);
    let Size { width, height } = shown.letterbox.clip;
    let inside = PixelBox { x0: 0.0, y0: 0.0, x1: f64::from(width), y1: f64::from(height) };
    if !inside.contains(at) {
        return Err(Invalid::Outside {
            corners: format!("({}, {})", point.x, point.y),
            limit: "(100, 100)".to_owned(),
            convention: shown.profile.convention(shown.letterbox.sent),
        });
    }
    if (shown.arms)(frame).get(at.x as u32, at.y as u32) { Err(Invalid::PointOnHand) } else { Ok(at) }
}

/// Share of the pixels in `bounds` that `mask` covers.
fn covered_share(bounds: &PixelBox, mask: &Mask) -> f64 {
    let size = mask.size();
    let columns = (bounds.x0.floor() as u32)..(bounds.x1.ceil() as u32).min(size.width);
    let rows = (bounds.y0.floor() as u32)..(bounds.y1.ceil() as u32).min(size.height);
    let (mut inside, mut all) = (0_u64, 0_u64);
    for y in rows {
        for x in columns.clone() {
            all += 1;
            inside += u64::from(mask.get(x, y));
        }
    }
    inside as f64 / all.max(1) as f64
}

fn confidence_of(answer: &Answer, remarks: &mut Vec<String>) -> f64 {
    match answer.confidence.filter(|value| value.is_finite()) {
        None => UNSAID,
        Some(value) if value > 1.0 && value <= 100.0 => {
            remarks.push(format!("the confidence {value} was taken as percent"));
            value / 100.0
        }
        Some(value) => value.clamp(0.0, 1.0),
    }
}

/// One line of at most `longest` characters, without anything that a terminal would obey.
pub(super) fn line(text: &str, longest: usize) -> String {
    let plain: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let words = plain.split_whitespace().collect::<Vec<_>>().join(" ");
    if words.chars().count() <= longest {
        return words;
    }
    words.chars().take(longest).chain(['…']).collect()
}

#[cfg(test)]
mod tests;
