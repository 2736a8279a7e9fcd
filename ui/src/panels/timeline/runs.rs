//! What the timeline's rows show, as runs of equal frames: computed once per change, drawn often.

use std::sync::Arc;

use agenticfocus::{
    clip::FrameIndex,
    engine::Revision,
    geometry::{PerSide, Side},
    hands::HandState,
    segment::{MaskAuthor, MaskFlag},
    session::{LayerOrder, MaskEdit, MaskLayer},
};

use crate::state::{Findings, Workspace};

/// Frames `first` to `last`, inclusive, that are alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run<T> {
    /// The first frame.
    pub first: u32,
    /// The last frame.
    pub last: u32,
    /// What they are.
    pub kind: T,
}

/// What a stretch of masks is; frames without a mask are in no run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MaskKind {
    /// Made by the machine, nothing doubtful.
    Machine,
    /// Made by the machine, to be looked at.
    Flagged,
    /// Lost by the machine: no mask, to be looked at.
    Lost,
}

/// A row of masks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MaskRow {
    /// Stretches the machine made.
    pub runs: Vec<Run<MaskKind>>,
    /// Frames a person edited, and whether they said "absent".
    pub human: Vec<(u32, bool)>,
}

/// A row of a hand.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HandRow {
    /// Stretches with a hand: seen or bridged.
    pub runs: Vec<Run<HandState>>,
    /// Frames a person corrected.
    pub human: Vec<u32>,
}

/// The row of the template.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TemplateRow {
    /// Stretches on which it is placed, whoever placed it.
    pub runs: Vec<Run<()>>,
    /// Keyframes by a person.
    pub human: Vec<u32>,
    /// First and last keyframe of stretches that a person had interpolated.
    pub spans: Vec<(u32, u32)>,
}

/// What lies in front.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OrderKind {
    /// Whether the object covers the robot.
    pub object_in_front: bool,
    /// Whether a person said so.
    pub by_person: bool,
}

/// All rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rows {
    /// Frames of the clip.
    pub count: u32,
    /// The object's masks.
    pub object: MaskRow,
    /// The arms' masks.
    pub arms: MaskRow,
    /// The template's placement.
    pub template: TemplateRow,
    /// Both hands.
    pub hands: PerSide<HandRow>,
    /// Frames on which a person exchanged left and right, first and last.
    pub swapped: Vec<(u32, u32)>,
    /// Contact of the busier hand, one a frame, 0 to 1; empty before there is a motion.
    pub contact: Vec<f32>,
    /// Layer order.
    pub order: Vec<Run<OrderKind>>,
    /// Trust in the object's mask (the arms' where there is no object), one a frame; NaN where there is none.
    pub quality: Vec<f32>,
    /// Frames that want a look.
    pub problems: Vec<FrameIndex>,
}

fn push<T: PartialEq + Copy>(runs: &mut Vec<Run<T>>, frame: u32, kind: T) {
    match runs.last_mut() {
        Some(run) if run.last + 1 == frame && run.kind == kind => run.last = frame,
        _ => runs.push(Run { first: frame, last: frame, kind }),
    }
}

fn mask_row(workspace: &Workspace, layer: MaskLayer, count: u32) -> MaskRow {
    let edits = workspace.document().masks(layer);
    let human = edits.iter().map(|(frame, edit)| (frame.0, matches!(edit, MaskEdit::Absent))).collect();
    let mut runs = Vec::new();
    for frame in (0..count).map(FrameIndex).filter(|frame| !edits.contains_key(frame)) {
        let found = match layer {
            MaskLayer::Object => workspace.found.object_on(frame),
            MaskLayer::Arms => workspace.found.arms_on(frame),
        };
        let Some(found) = found else { continue };
        let lost = found.flags.contains(&MaskFlag::Lost);
        let kind = match found.mask.is_empty() {
            true if lost => MaskKind::Lost,
            true => continue,
            false if found.author != MaskAuthor::Human && is_doubtful(found.score, &found.flags) => {
                MaskKind::Flagged
            }
            false => MaskKind::Machine,
        };
        push(&mut runs, frame.0, kind);
    }
    MaskRow { runs, human }
}

/// The rule by which [`Workspace::is_problem`] counts a mask.
fn is_doubtful(score: f64, flags: &[MaskFlag]) -> bool {
    score < 0.35 || flags.iter().any(|flag| !matches!(flag, MaskFlag::TouchesBorder | MaskFlag::Occluded))
}

fn template_row(workspace: &Workspace) -> TemplateRow {
    let edits = &workspace.document().template;
    let mut runs = Vec::new();
    if let Some(track) = &workspace.found.template {
        for (frame, _) in (0_u32..).zip(&track.placements).filter(|(_, placement)| placement.is_some()) {
            push(&mut runs, frame, ());
        }
    }
    TemplateRow {
        runs,
        human: edits.placements.keys().map(|frame| frame.0).collect(),
        spans: edits.interpolated_spans().map(|(first, last)| (first.0, last.0)).collect(),
    }
}

fn hand_row(workspace: &Workspace, side: Side) -> HandRow {
    let human = workspace.document().hand_edits[side].keys().map(|frame| frame.0).collect();
    let mut runs = Vec::new();
    if let Some(track) = &workspace.found.hands {
        for (frame, hand) in (0_u32..).zip(&track.hands[side]) {
            if hand.state != HandState::Invalid {
                push(&mut runs, frame, hand.state);
            }
        }
    }
    HandRow { runs, human }
}

fn order_row(workspace: &Workspace, count: u32) -> Vec<Run<OrderKind>> {
    let mut by_person = vec![None; count as usize];
    for range in &workspace.document().layer_orders {
        let last = range.last.as_usize().min(by_person.len().saturating_sub(1));
        for said in by_person.iter_mut().take(last + 1).skip(range.first.as_usize()) {
            *said = match range.order {
                LayerOrder::Auto => None,
                order => Some(order == LayerOrder::ObjectInFront),
            };
        }
    }
    let decided = workspace.found.order.as_deref();
    let mut runs = Vec::new();
    for (frame, said) in (0_u32..).zip(by_person) {
        let found = decided
            .and_then(|decisions| decisions.get(frame as usize))
            .map(|decision| decision.in_front.left.min(decision.in_front.right) < 0.5);
        if let Some(object_in_front) = said.or(found) {
            push(&mut runs, frame, OrderKind { object_in_front, by_person: said.is_some() });
        }
    }
    runs
}

fn quality_row(workspace: &Workspace, count: u32) -> Vec<f32> {
    let known = workspace.found.object.is_some() || !workspace.found.object_frames.is_empty();
    let layer = if known { MaskLayer::Object } else { MaskLayer::Arms };
    (0..count)
        .map(|frame| {
            workspace.mask_summary(layer, FrameIndex(frame)).map_or(f32::NAN, |(_, score, _)| score as f32)
        })
        .collect()
}

impl Rows {
    /// Looks at every frame once.
    pub fn new(workspace: &Workspace) -> Self {
        let count = workspace.frame_count() as u32;
        let contact = workspace.found.motion.as_ref().map_or_else(Vec::new, |motion| {
            let pairs = motion.sides.left.iter().zip(&motion.sides.right);
            pairs.map(|(left, right)| left.contact.max(right.contact) as f32).collect()
        });
        Self {
            count,
            object: mask_row(workspace, MaskLayer::Object, count),
            arms: mask_row(workspace, MaskLayer::Arms, count),
            template: template_row(workspace),
            hands: PerSide::from_fn(|side| hand_row(workspace, side)),
            swapped: workspace
                .document()
                .sides_swapped
                .iter()
                .map(|range| (range.first.0, range.last.0))
                .collect(),
            contact,
            order: order_row(workspace, count),
            quality: quality_row(workspace, count),
            problems: workspace.problems(),
        }
    }
}

/// Rows of the open session, computed anew only when something they show changed.
#[derive(Debug, Default)]
pub struct RowCache {
    seen: Option<Seen>,
    rows: Rows,
    /// How often rows were computed, for tests.
    made: u64,
}

/// What rows were computed from. Artifacts are held, so that a new one never lies where an old one lay.
#[derive(Debug)]
struct Seen {
    id: String,
    revision: Revision,
    found: Findings,
    streamed: usize,
}

fn same<T: ?Sized>(one: Option<&Arc<T>>, other: Option<&Arc<T>>) -> bool {
    match (one, other) {
        (Some(one), Some(other)) => Arc::ptr_eq(one, other),
        (None, None) => true,
        _ => false,
    }
}

impl Seen {
    fn new(workspace: &Workspace) -> Self {
        let found = &workspace.found;
        let held = Findings {
            clip: found.clip.clone(),
            arms: found.arms.clone(),
            object: found.object.clone(),
            template: found.template.clone(),
            hands: found.hands.clone(),
            motion: found.motion.clone(),
            order: found.order.clone(),
            ..Findings::default()
        };
        Self {
            id: workspace.document().clip.id.clone(),
            revision: workspace.revision,
            found: held,
            streamed: found.object_frames.len(),
        }
    }

    fn holds(&self, workspace: &Workspace) -> bool {
        let (old, new) = (&self.found, &workspace.found);
        self.revision == workspace.revision
            && self.id == workspace.document().clip.id
            && self.streamed == new.object_frames.len()
            && same(old.clip.as_ref(), new.clip.as_ref())
            && same(old.arms.as_ref(), new.arms.as_ref())
            && same(old.object.as_ref(), new.object.as_ref())
            && same(old.template.as_ref(), new.template.as_ref())
            && same(old.hands.as_ref(), new.hands.as_ref())
            && same(old.motion.as_ref(), new.motion.as_ref())
            && same(old.order.as_ref(), new.order.as_ref())
    }
}

impl RowCache {
    /// The rows of `workspace`.
    pub fn rows(&mut self, workspace: &Workspace) -> &Rows {
        if !self.seen.as_ref().is_some_and(|seen| seen.holds(workspace)) {
            self.seen = Some(Seen::new(workspace));
            self.rows = Rows::new(workspace);
            self.made += 1;
        }
        &self.rows
    }

    /// How often rows were computed.
    pub fn times_made(&self) -> u64 {
        self.made
    }
}
