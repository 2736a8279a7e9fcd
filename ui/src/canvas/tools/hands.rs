//! Both hands as skeletons whose joints can be dragged.

use std::collections::BTreeMap;

use agenticfocus::{
    clip::FrameIndex,
    engine::Request,
    geometry::{Pixel, Side},
    hands::HandState,
    landmarks::{KEYPOINT_COUNT, keypoint},
    robot::FINGERS,
    session::{Command, HandEdit},
};
use egui::{Align2, Color32, CursorIcon, Modifiers, Pos2, Stroke, vec2};

use super::{
    super::{
        scene::Scene,
        shapes::{self, LineStyle},
    },
    held::{Follow, Held},
};
use crate::{
    action::Action,
    state::{Context, HandDraft},
    theme::Tokens,
};

/// Reach of a joint, points: its hit area is 12 points wide.
const HIT: f32 = 6.0;

/// A hand as it is shown.
#[derive(Clone, Debug, PartialEq)]
struct ShownHand {
    side: Side,
    state: HandState,
    keypoints: [Pixel; KEYPOINT_COUNT],
    /// Joints a person placed.
    placed: Vec<u8>,
}

#[derive(Clone, Debug)]
struct Drag {
    side: Side,
    joint: usize,
    /// All joints move together.
    whole: bool,
    from: Pixel,
    before: [Pixel; KEYPOINT_COUNT],
    now: [Pixel; KEYPOINT_COUNT],
}

/// The tools of this step.
#[derive(Debug, Default)]
pub(in super::super) struct HandTools {
    drag: Held<Drag>,
    /// The keypoints that the engine was asked to fit a hand to last.
    asked: Option<[Pixel; KEYPOINT_COUNT]>,
}

impl HandTools {
    /// Carries out what the pointer did and draws.
    pub fn show(&mut self, scene: &Scene<'_>, cx: &mut Context<'_>) {
        let mut hands = hands_on(scene);
        for (frame, drag) in self.drag.follow(scene, |at, modifiers| grab(at, modifiers, &hands, scene, cx)) {
            keep(frame, &drag, scene, cx);
        }
        if let Some(drag) = self.drag.get() {
            for hand in hands.iter_mut().filter(|hand| hand.side == drag.side) {
                hand.keypoints = drag.now;
            }
        }
        self.ask_for_fit(scene, cx);
        if scene.hidden {
            return;
        }
        let lit = self.drag.get().map(|drag| (drag.side, drag.joint));
        let lit = lit.or_else(|| scene.hover.and_then(|at| joint_at(&hands, at, scene)));
        for hand in &hands {
            let lit = lit.filter(|(side, _)| *side == hand.side).map(|(_, joint)| joint);
            draw_hand(hand, lit, hand.side == cx.options.side, scene, cx.tokens);
        }
        if let Some(draft) = self.drag.get().and_then(|drag| draft_of(drag, scene)) {
            draw_fit(draft, scene, cx.tokens);
        }
        if lit.is_some() && scene.is_writable() {
            scene.painter.ctx().set_cursor_icon(CursorIcon::Grab);
        }
    }

    /// The hand in space follows the joint that is dragged.
    fn ask_for_fit(&mut self, scene: &Scene<'_>, cx: &mut Context<'_>) {
        let Some(drag) = self.drag.get() else {
            self.asked = None;
            return;
        };
        if drag.now != drag.before && self.asked != Some(drag.now) {
            self.asked = Some(drag.now);
            let (frame, side, keypoints) = (scene.frame, drag.side, Box::new(drag.now));
            cx.ask(Action::Ask(Request::FitHand { frame, side, keypoints }));
        }
    }

    /// Drops a drag; false when there was none.
    pub fn cancel(&mut self) -> bool {
        self.drag.cancel()
    }
}

/// The joint under the pointer, to be dragged; with Shift the whole hand. Its side is the one commands mean then.
fn grab(
    at: Pos2,
    modifiers: Modifiers,
    hands: &[ShownHand],
    scene: &Scene<'_>,
    cx: &mut Context<'_>,
) -> Option<Drag> {
    let (side, joint) = joint_at(hands, at, scene)?;
    cx.options.side = side;
    cx.options.playing = false;
    let before = hands.iter().find(|hand| hand.side == side).filter(|_| scene.is_writable())?.keypoints;
    Some(Drag { side, joint, whole: modifiers.shift, from: scene.pixel(at), before, now: before })
}

/// The joints that were moved become the person's.
fn keep(frame: FrameIndex, drag: &Drag, scene: &Scene<'_>, cx: &mut Context<'_>) {
    if drag.now == drag.before {
        return;
    }
    let edits = &scene.workspace.document().hand_edits[drag.side];
    let mut keypoints: BTreeMap<u8, Pixel> =
        edits.get(&frame).map(|edit| edit.keypoints.clone()).unwrap_or_default();
    for (joint, (now, before)) in drag.now.iter().zip(&drag.before).enumerate() {
        if now != before {
            keypoints.insert(joint as u8, *now);
        }
    }
    // Who places a joint says that the hand is of use here.
    let edit = Some(HandEdit { keypoints, invalid: false });
    cx.ask(Action::Change(Command::SetHandEdit { frame, side: drag.side, edit }));
}

impl Follow for Drag {
    fn follow(&mut self, to: Pixel) {
        let (dx, dy) = (to.x - self.from.x, to.y - self.from.y);
        if !(dx.is_finite() && dy.is_finite()) {
            return;
        }
        for (joint, (now, before)) in self.now.iter_mut().zip(&self.before).enumerate() {
            if self.whole || joint == self.joint {
                *now = Pixel::new(before.x + dx, before.y + dy);
            }
        }
    }
}

/// The engine's newest answer for the hand that is dragged.
fn draft_of<'a>(drag: &Drag, scene: &Scene<'a>) -> Option<&'a HandDraft> {
    let draft = scene.workspace.hand_draft.as_ref()?;
    (draft.frame == scene.frame && draft.side == drag.side && drag.now != drag.before).then_some(draft)
}

/// The hand that the engine fitted to the joints, as it would be seen, with its distance and how far it is off.
fn draw_fit(draft: &HandDraft, scene: &Scene<'_>, tokens: &Tokens) {
    let Some(camera) = scene.workspace.found.clip.as_ref().map(|clip| clip.intrinsics) else { return };
    let seen: Option<Vec<Pixel>> = draft.hand.joints.iter().map(|joint| camera.project(joint)).collect();
    let wrist = scene.projection.to_screen(draft.keypoints[keypoint::WRIST]);
    let Some(seen) = seen.filter(|_| draft.hand.is_valid()) else {
        shapes::badge(&scene.painter, tokens, wrist, "No hand fits these joints", tokens.alarm);
        return;
    };
    let at: Vec<Pos2> = seen.iter().map(|pixel| scene.projection.to_screen(*pixel)).collect();
    let style = LineStyle { width: 1.5, colour: Color32::WHITE, dashed: true };
    for joint in 1..KEYPOINT_COUNT {
        shapes::rimmed_line(&scene.painter, &[at[keypoint::PARENT[joint]], at[joint]], false, style);
    }
    let off = seen.iter().zip(draft.keypoints.iter()).map(|(fit, joint)| fit.distance(*joint).powi(2));
    let off = (off.sum::<f64>() / KEYPOINT_COUNT as f64).sqrt();
    let text = format!("{:.0} cm away, {off:.1} px off", 100.0 * draft.hand.wrist().xyz.z);
    shapes::badge(&scene.painter, tokens, wrist + vec2(14.0, 14.0), &text, tokens.side(draft.side));
}

fn joint_name(joint: usize) -> String {
    if joint == keypoint::WRIST {
        return "wrist".to_owned();
    }
    let finger = FINGERS.get((joint - 1) / 4).copied().unwrap_or_default();
    if keypoint::TIPS.contains(&joint) {
        format!("{finger} tip")
    } else {
        format!("{finger}, joint {}", (joint - 1) % 4 + 1)
    }
}

/// The hands on the frame: as fitted, else as the estimator saw them, with what a person placed.
fn hands_on(scene: &Scene<'_>) -> Vec<ShownHand> {
    let (found, at) = (&scene.workspace.found, scene.frame.as_usize());
    let mut shown = Vec::new();
    for side in Side::BOTH {
        let fitted = found.hands.as_ref().and_then(|track| track.hands[side].get(at));
        let seen = found.landmarks.as_ref().and_then(|track| track.get(at)?[side].as_ref());
        let edit = scene.workspace.document().hand_edits[side].get(&scene.frame);
        let state = fitted.map_or(HandState::Observed, |hand| hand.state);
        let known = fitted.filter(|hand| hand.is_valid()).map(|hand| hand.keypoints);
        let Some(mut keypoints) = known.or_else(|| seen.map(|seen| seen.keypoints)) else { continue };
        let mut placed = Vec::new();
        let mut state = state;
        if let Some(edit) = edit {
            for (joint, pixel) in &edit.keypoints {
                if let Some(keypoint) = keypoints.get_mut(usize::from(*joint)) {
                    *keypoint = *pixel;
                    placed.push(*joint);
                }
            }
            if edit.invalid {
                state = HandState::Invalid;
            }
        }
        shown.push(ShownHand { side, state, keypoints, placed });
    }
    shown
}

/// The joint nearest to `at` whose hit area it is in.
fn joint_at(hands: &[ShownHand], at: Pos2, scene: &Scene<'_>) -> Option<(Side, usize)> {
    let joints = hands.iter().flat_map(|hand| {
        let place = |(joint, pixel): (usize, &Pixel)| (hand.side, joint, scene.projection.to_screen(*pixel));
        hand.keypoints.iter().enumerate().map(place)
    });
    let near = joints.map(|(side, joint, place)| ((side, joint), place.distance(at)));
    let near = near.filter(|(_, distance)| *distance <= HIT);
    near.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(joint, _)| joint)
}

fn draw_hand(hand: &ShownHand, lit: Option<usize>, meant: bool, scene: &Scene<'_>, tokens: &Tokens) {
    let colour = tokens.side(hand.side);
    let painter = &scene.painter;
    let at = hand.keypoints.map(|pixel| scene.projection.to_screen(pixel));
    let chain = lit.filter(|joint| *joint != keypoint::WRIST).map(|joint| (joint - 1) / 4);
    let fade = if hand.state == HandState::Observed { 1.0 } else { 0.65 };
    for joint in 1..KEYPOINT_COUNT {
        let in_chain = chain == Some((joint - 1) / 4);
        let style = LineStyle {
            width: if in_chain { 4.0 } else { 2.0 },
            colour: if in_chain { colour } else { colour.gamma_multiply(fade) },
            dashed: hand.state == HandState::Invalid,
        };
        shapes::rimmed_line(painter, &[at[keypoint::PARENT[joint]], at[joint]], false, style);
    }
    for (joint, place) in at.iter().enumerate() {
        let in_chain = lit == Some(joint);
        let radius = if in_chain {
            6.0
        } else if joint == keypoint::WRIST {
            4.5
        } else {
            3.5
        };
        match hand.state {
            // An invalid hand's joints are hollow, so that colour and dashes do not stand alone.
            HandState::Invalid => {
                painter.circle(*place, radius, Color32::TRANSPARENT, Stroke::new(1.5, colour));
            }
            HandState::Observed | HandState::Bridged => shapes::dot(painter, *place, radius, colour),
        }
        if hand.placed.contains(&(joint as u8)) {
            painter.circle_stroke(*place, radius + 2.5, Stroke::new(1.5, Color32::WHITE));
        }
    }
    if let Some(joint) = lit {
        let text = joint_name(joint);
        shapes::badge(painter, tokens, at[joint] + vec2(10.0, -8.0), &text, colour);
    }
    let letter = match hand.side {
        Side::Left => "L",
        Side::Right => "R",
    };
    let wrist = at[keypoint::WRIST] + vec2(0.0, 8.0);
    let plate = egui::Rect::from_center_size(wrist + vec2(0.0, 9.0), vec2(18.0, 16.0));
    let (ground, text) = if meant { (colour, Color32::BLACK) } else { (tokens.panel, tokens.text) };
    painter.rect_filled(plate, 4.0, ground);
    shapes::small_text(painter, plate.center(), Align2::CENTER_CENTER, letter, text);
}
