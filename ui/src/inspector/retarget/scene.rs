//! The robot from outside, with the human hands, the camera and the reached space drawn over it.

use agenticfocus::{
    clip::ClipInfo,
    engine::OrbitCamera,
    geometry::{Pixel, Position, Side, Size, Torso},
    landmarks::keypoint,
    retarget::{CameraMap, RobotMotion, SideReport},
};
use egui::{Align2, Color32, FontId, Painter, PointerButton, Rect, Sense, Shape, Stroke, Ui, pos2, vec2};
use nalgebra::Vector3;

use super::view::{View, shifted, turned, zoomed};
use crate::{
    inspector::{
        hands::mark_of,
        parts::{TextureKey, Textures, empty, hint, picture_of_rgb},
    },
    state::{Context, Workspace},
};

/// How far in front of the camera its picture is drawn, metres.
const FRUSTUM_DEPTH: f64 = 0.12;
/// Height of the view, points.
const HEIGHT: f32 = 200.0;

pub(super) fn show(
    ui: &mut Ui,
    cx: &mut Context<'_>,
    workspace: &Workspace,
    motion: Option<&RobotMotion>,
    textures: &mut Textures,
) {
    let (place, response) =
        ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::click_and_drag());
    response.widget_info(|| {
        egui::WidgetInfo::labeled(egui::accesskit::Role::Canvas, true, "3-D view: drag turns, wheel zooms")
    });
    navigate(ui, cx, place, &response);
    let scale = ui.pixels_per_point();
    let size = Size::new((place.width() * scale).round() as u32, (place.height() * scale).round() as u32);
    let camera = cx.options.orbit;
    let painter = ui.painter().with_clip_rect(place.intersect(ui.clip_rect()));
    painter.rect_filled(place, 4.0, cx.tokens.ground);
    if let Some(motion) = motion {
        if let Some(picture) = cx.pictures.orbit(workspace.playhead, workspace.revision, camera, size) {
            let texture = textures.of(ui, TextureKey::Orbit, &picture, picture_of_rgb);
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            painter.image(texture.id(), place, whole, Color32::WHITE);
        }
        let over = Overlay { view: View::new(&camera, size, place), painter: &painter };
        over.draw(cx, workspace, motion);
    } else {
        let inside =
            egui::UiBuilder::new().max_rect(place).layout(egui::Layout::top_down(egui::Align::Center));
        let mut inside = ui.new_child(inside);
        inside.add_space(0.5 * HEIGHT - 40.0);
        empty(&mut inside, cx.tokens, "No motion yet", "It follows the hands; parameters hold already");
    }
    ui.painter().rect_stroke(place, 4.0, Stroke::new(1.0, cx.tokens.line), egui::StrokeKind::Inside);
    if motion.is_some() {
        hint(ui, cx.tokens, "Drag turns, wheel zooms, double click resets");
    }
}

fn navigate(ui: &Ui, cx: &mut Context<'_>, place: Rect, response: &egui::Response) {
    let moved = response.drag_delta();
    let camera = &mut cx.options.orbit;
    if response.dragged_by(PointerButton::Primary) {
        *camera = turned(camera, moved.x, moved.y);
    } else if response.dragged() {
        *camera = shifted(camera, moved.x, moved.y, place.height());
    }
    if response.contains_pointer() {
        // The wheel belongs to the view while the pointer is over it, not to the panel around it.
        let scroll = ui.input_mut(|input| std::mem::take(&mut input.smooth_scroll_delta.y));
        if scroll != 0.0 {
            *camera = zoomed(camera, scroll);
        }
    }
    if response.double_clicked() {
        *camera = OrbitCamera::default();
    }
}

struct Overlay<'a> {
    view: View,
    painter: &'a Painter,
}

impl Overlay<'_> {
    fn draw(&self, cx: &Context<'_>, workspace: &Workspace, motion: &RobotMotion) {
        let frame = workspace.playhead.as_usize();
        if let Some(clip) = &workspace.found.clip {
            self.frustum(clip, &motion.map, Stroke::new(1.0, cx.tokens.muted));
        }
        for side in Side::BOTH {
            let (colour, letter) = mark_of(cx.tokens, side);
            if let Some(corners) = reached_box(&motion.sides[side]) {
                self.dotted_box(corners, colour);
            }
            let report = motion.sides[side].get(frame);
            if let Some(report) = report.filter(|report| report.driven && !report.reachable) {
                self.miss(report, cx.tokens.hole);
            }
            let hand = workspace.found.hands.as_ref().and_then(|track| track.hands[side].get(frame));
            if let Some(hand) = hand.filter(|hand| hand.is_valid()) {
                let joints = hand.joints.map(|joint| in_torso(&motion.map, &joint.xyz));
                self.hand(&joints, colour, letter);
            }
        }
    }

    fn line(&self, from: &Position<Torso>, to: &Position<Torso>, stroke: Stroke) {
        if let Some(ends) = self.view.line(from, to) {
            self.painter.line_segment(ends, stroke);
        }
    }

    fn hand(&self, joints: &[Position<Torso>; 21], colour: Color32, letter: &str) {
        for (joint, parent) in keypoint::PARENT.iter().enumerate() {
            self.line(&joints[*parent], &joints[joint], Stroke::new(1.5, colour));
        }
        for at in keypoint::TIPS.into_iter().filter_map(|tip| self.view.point(&joints[tip])) {
            self.painter.circle_filled(at, 2.0, colour);
        }
        if let Some(at) = self.view.point(&joints[keypoint::WRIST]) {
            self.painter.text(at, Align2::CENTER_TOP, letter, FontId::proportional(11.0), colour);
        }
    }

    /// Where the wrist should be and cannot: a cross, joined to where it is.
    fn miss(&self, report: &SideReport, colour: Color32) {
        let (target, reached) = (report.target.position(), report.reached.position());
        self.line(&reached, &target, Stroke::new(1.5, colour));
        if let Some(at) = self.view.point(&target) {
            let stroke = Stroke::new(2.0, colour);
            self.painter.line_segment([at + vec2(-4.0, -4.0), at + vec2(4.0, 4.0)], stroke);
            self.painter.line_segment([at + vec2(-4.0, 4.0), at + vec2(4.0, -4.0)], stroke);
        }
    }

    fn frustum(&self, clip: &ClipInfo, map: &CameraMap, stroke: Stroke) {
        let (right, bottom) = (f64::from(clip.size.width) - 0.5, f64::from(clip.size.height) - 0.5);
        let corners = [(-0.5, -0.5), (right, -0.5), (right, bottom), (-0.5, bottom)].map(|(x, y)| {
            let seen = clip.intrinsics.unproject(Pixel::new(x, y), FRUSTUM_DEPTH).xyz;
            Position::new(map.rotation * seen + map.offset)
        });
        let eye = Position::new(map.offset);
        for (at, corner) in corners.iter().enumerate() {
            self.line(&eye, corner, stroke);
            self.line(corner, &corners[(at + 1) % 4], stroke);
        }
    }

    fn dotted_box(&self, [low, high]: [Vector3<f64>; 2], colour: Color32) {
        let corner = |bits: usize| {
            let pick = |axis: usize| if (bits >> axis) & 1 == 1 { high[axis] } else { low[axis] };
            Position::new(Vector3::new(pick(0), pick(1), pick(2)))
        };
        for bits in 0..8_usize {
            for other in [bits | 1, bits | 2, bits | 4].into_iter().filter(|other| *other != bits) {
                if let Some(ends) = self.view.line(&corner(bits), &corner(other)) {
                    self.painter.extend(Shape::dotted_line(&ends, colour.gamma_multiply(0.7), 4.0, 0.7));
                }
            }
        }
    }
}

/// The human's point where the robot is to have it.
fn in_torso(map: &CameraMap, seen: &Vector3<f64>) -> Position<Torso> {
    Position::new(map.beta * (map.rotation * seen) + map.offset)
}

/// The least box around all wrists that the side reaches over the clip.
fn reached_box(reports: &[SideReport]) -> Option<[Vector3<f64>; 2]> {
    let reached = reports.iter().filter(|report| report.driven && report.reachable);
    let wrists = reached.map(|report| report.reached.position().xyz);
    wrists.fold(None, |span: Option<[Vector3<f64>; 2]>, wrist| {
        Some(span.map_or([wrist, wrist], |[low, high]| [low.inf(&wrist), high.sup(&wrist)]))
    })
}
