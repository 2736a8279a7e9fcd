//! Choosing the object: proposals as boxes, a box drawn by hand, points.

use agenticfocus::{
    geometry::PixelBox,
    session::{Author, Command, MaskLayer, ObjectChoice, ObjectPromptKind, ObjectProposal},
};
use egui::{Color32, PointerButton, Pos2, Rect, vec2};

use super::{
    super::{
        input::PointerEvent,
        mask_view::{Colouring, Look, MaskView},
        scene::Scene,
        shapes::{self, LineStyle},
    },
    points::Points,
    shape::{ShapeInProgress, ShapeKind, box_between},
};
use crate::{action::Action, state::Context, ui_command::UiCommand, widgets::Icon};

/// A drag shorter than this is a click, points.
const CLICK: f32 = 4.0;
/// Commands that take a proposal, in order.
const CHOOSE: [UiCommand; 5] =
    [UiCommand::Choose1, UiCommand::Choose2, UiCommand::Choose3, UiCommand::Choose4, UiCommand::Choose5];

/// What a press on the picture means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in super::super) enum ObjectTool {
    /// A drag draws a box, a click takes a proposal (default).
    #[default]
    Box,
    /// Clicks are points.
    Points,
}

/// The tools of this step.
#[derive(Debug)]
pub(in super::super) struct ObjectTools {
    pub tool: ObjectTool,
    drag: Option<(Pos2, ShapeInProgress)>,
    pub points: Option<Points>,
    draft: MaskView,
}

impl Default for ObjectTools {
    fn default() -> Self {
        Self { tool: ObjectTool::Box, drag: None, points: None, draft: MaskView::new("object from points") }
    }
}

impl ObjectTools {
    /// Carries out what the pointer did and draws.
    pub fn show(&mut self, scene: &Scene<'_>, cx: &mut Context<'_>) {
        if self.points.as_ref().is_some_and(|points| points.frame != scene.frame) {
            self.points = None;
        }
        for event in &scene.events {
            self.handle(*event, scene, cx);
        }
        if !scene.hidden {
            self.draw(scene, cx);
        }
    }

    fn handle(&mut self, event: PointerEvent, scene: &Scene<'_>, cx: &mut Context<'_>) {
        match event {
            PointerEvent::Press { at, button, modifiers } if scene.is_writable() => {
                cx.options.playing = false;
                match (self.tool, button) {
                    (ObjectTool::Points, PointerButton::Primary | PointerButton::Secondary) => {
                        let new = || Points::new(MaskLayer::Object, scene.frame);
                        let mut points = self.points.take().unwrap_or_else(new);
                        let positive = (button == PointerButton::Primary) != modifiers.shift;
                        points.add(scene.pixel(at), positive, cx);
                        self.points = Some(points);
                    }
                    (ObjectTool::Box, PointerButton::Primary) => {
                        let shape = ShapeInProgress::new(ShapeKind::Box, true, scene.pixel(at));
                        self.drag = Some((at, shape));
                    }
                    _ => {}
                }
            }
            PointerEvent::Press { .. } => {}
            PointerEvent::Move(at) => {
                if let Some((_, shape)) = &mut self.drag {
                    shape.drag_to(scene.pixel(at));
                }
            }
            PointerEvent::Release { at, button } => {
                if button == PointerButton::Primary
                    && let Some((from, shape)) = self.drag.take()
                {
                    self.release(from, at, &shape, scene, cx);
                }
            }
        }
    }

    fn release(
        &mut self,
        from: Pos2,
        to: Pos2,
        shape: &ShapeInProgress,
        scene: &Scene<'_>,
        cx: &mut Context<'_>,
    ) {
        if from.distance(to) < CLICK {
            if let Some(command) = proposal_at(scene, to).and_then(|at| CHOOSE.get(at)) {
                cx.ask(Action::Run(*command));
            }
            return;
        }
        let first = shape.corners.first().copied().unwrap_or_default();
        let drawn = box_between(first, scene.pixel(to)).clipped(scene.size());
        if let Some(drawn) = drawn.filter(|drawn| drawn.width() >= 1.0 && drawn.height() >= 1.0) {
            choose(scene, cx, ObjectPromptKind::Box(drawn));
        }
    }

    /// Drops what is not finished; false when there was nothing.
    pub fn cancel(&mut self) -> bool {
        let busy = self.drag.is_some() || self.points.is_some();
        self.drag = None;
        self.points = None;
        busy
    }

    /// Takes what the points mean as the object; false when there are none.
    pub fn finish(&mut self, cx: &mut Context<'_>) -> bool {
        let Some(points) = &self.points else { return false };
        if !points.positive.is_empty()
            && let Some(workspace) = cx.workspace
        {
            let prompt = ObjectPromptKind::Points {
                positive: points.positive.clone(),
                negative: points.negative.clone(),
            };
            let choice = choice_of(workspace.found.choice.as_ref(), workspace.document().object.as_ref());
            let choice = ObjectProposal { frame: points.frame, prompt, ..choice };
            cx.ask(Action::Change(Command::SetObject(Some(choice))));
            self.points = None;
        }
        true
    }

    fn draw(&mut self, scene: &Scene<'_>, cx: &Context<'_>) {
        draw_proposals(scene, cx);
        if let Some((_, shape)) = &self.drag {
            shape.draw(scene, cx.tokens.object);
        }
        if let Some(points) = &self.points {
            if let Some(mask) = points.answer(scene).filter(|mask| mask.size() == scene.size()) {
                let colour = Colouring::One(cx.tokens.object);
                self.draft.sync(scene.painter.ctx(), scene.frame, &mask, colour);
                let look = Look { fill: cx.options.mask_opacity, line: 2.0, dashed: true, arm: None };
                self.draft.draw(&scene.painter, &scene.projection, look);
            }
            points.draw(scene, cx);
        }
    }
}

/// A person's choice with the name it had so far.
fn choice_of(found: Option<&ObjectChoice>, chosen: Option<&ObjectChoice>) -> ObjectChoice {
    let label = chosen.or(found).map_or_else(|| "object".to_owned(), |choice| choice.label.clone());
    ObjectProposal {
        label,
        frame: agenticfocus::clip::FrameIndex(0),
        prompt: ObjectPromptKind::Points { positive: Vec::new(), negative: Vec::new() },
        confidence: 1.0,
        reason: "pointed at by the operator".to_owned(),
        author: Author::Human,
    }
}

fn choose(scene: &Scene<'_>, cx: &mut Context<'_>, prompt: ObjectPromptKind) {
    let workspace = scene.workspace;
    let choice = choice_of(workspace.found.choice.as_ref(), workspace.document().object.as_ref());
    let choice = ObjectProposal { frame: scene.frame, prompt, ..choice };
    cx.ask(Action::Change(Command::SetObject(Some(choice))));
}

/// The box that stands for a proposal: the one it gives, or one around its points.
fn extent(prompt: &ObjectPromptKind) -> Option<PixelBox> {
    match prompt {
        ObjectPromptKind::Box(given) => Some(*given),
        ObjectPromptKind::Points { positive, .. } => {
            let boxes = positive.iter().map(|at| box_between(*at, *at).grown(12.0));
            boxes.reduce(|a, b| PixelBox {
                x0: a.x0.min(b.x0),
                y0: a.y0.min(b.y0),
                x1: a.x1.max(b.x1),
                y1: a.y1.max(b.y1),
            })
        }
    }
}

fn on_screen(scene: &Scene<'_>, prompt: &ObjectPromptKind) -> Option<Rect> {
    let extent = extent(prompt)?;
    let corner = |x, y| scene.projection.corner_to_screen(x, y);
    Some(Rect::from_two_pos(corner(extent.x0, extent.y0), corner(extent.x1, extent.y1)))
}

/// The smallest proposal at `at`.
fn proposal_at(scene: &Scene<'_>, at: Pos2) -> Option<usize> {
    let proposals = scene.workspace.document().proposals.iter().enumerate();
    let hit = proposals.filter_map(|(index, proposal)| {
        let rect = on_screen(scene, &proposal.prompt)?;
        rect.expand(3.0).contains(at).then_some((index, rect.area()))
    });
    hit.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(index, _)| index)
}

fn draw_proposals(scene: &Scene<'_>, cx: &Context<'_>) {
    let document = scene.workspace.document();
    let chosen = document.object.as_ref().or(scene.workspace.found.choice.as_ref());
    let is_chosen = |proposal: &ObjectProposal| {
        chosen.is_some_and(|chosen| chosen.prompt == proposal.prompt && chosen.frame == proposal.frame)
    };
    let hovered = scene.hover.and_then(|at| proposal_at(scene, at));
    let mut badges = Vec::new();
    if let Some(chosen) = chosen {
        let number = document.proposals.iter().position(is_chosen).map(|at| format!("{}", at + 1));
        badges.push(Badge { proposal: chosen, number: number.unwrap_or_default(), lit: false, chosen: true });
    }
    for (at, proposal) in document.proposals.iter().enumerate() {
        if !is_chosen(proposal) {
            let lit = hovered == Some(at);
            badges.push(Badge { proposal, number: format!("{}", at + 1), lit, chosen: false });
        }
    }
    // The best lies on top, and gets the best place for its words.
    let mut taken = Vec::new();
    for badge in badges.iter().rev() {
        draw_extent(scene, cx, badge);
    }
    for badge in &badges {
        draw_words(scene, cx, badge, &mut taken);
    }
}

/// A proposal with what is said about it.
struct Badge<'a> {
    proposal: &'a ObjectProposal,
    number: String,
    lit: bool,
    chosen: bool,
}

impl Badge<'_> {
    fn colour(&self, cx: &Context<'_>) -> Color32 {
        if self.chosen { cx.tokens.object } else { cx.tokens.accent }
    }
}

fn draw_extent(scene: &Scene<'_>, cx: &Context<'_>, badge: &Badge<'_>) {
    let Some(rect) = on_screen(scene, &badge.proposal.prompt) else { return };
    let colour = badge.colour(cx);
    let width = if badge.chosen || badge.lit { 3.0 } else { 1.5 };
    // Where the thing lies on another frame is a hint only.
    let style = LineStyle { width, colour, dashed: badge.proposal.frame != scene.frame };
    if badge.lit {
        scene.painter.rect_filled(rect, 0.0, colour.gamma_multiply(0.15));
    }
    shapes::rimmed_line(&scene.painter, &shapes::corners(rect), true, style);
    if let ObjectPromptKind::Points { positive, negative } = &badge.proposal.prompt {
        for (list, positive) in [(positive, true), (negative, false)] {
            for point in list {
                let at = scene.projection.to_screen(*point);
                shapes::click_mark(&scene.painter, at, positive, cx.tokens);
            }
        }
    }
}

/// Words above the box, or below it where others are in the way.
fn draw_words(scene: &Scene<'_>, cx: &Context<'_>, badge: &Badge<'_>, taken: &mut Vec<Rect>) {
    let Some(rect) = on_screen(scene, &badge.proposal.prompt) else { return };
    let Badge { proposal, number, .. } = badge;
    let mut text = format!("{number}  {}  {:.0} %", proposal.label, proposal.confidence * 100.0);
    if proposal.frame != scene.frame {
        text.push_str(&format!("  on {}", proposal.frame));
    }
    let text = text.trim_start();
    let icon = badge.chosen.then_some(Icon::Check);
    let places = [rect.left_top() - vec2(1.0, 3.0), rect.left_bottom() + vec2(-1.0, 23.0)];
    let free = |at: &egui::Pos2| {
        let place = shapes::badge_rect(&scene.painter, cx.tokens, *at, icon, text);
        !taken.iter().any(|other| other.intersects(place))
    };
    let at = places.iter().copied().find(free).unwrap_or(places[0]);
    let place = shapes::badge_with(&scene.painter, cx.tokens, at, icon, text, badge.colour(cx));
    taken.push(place);
}
