//! What the engine found out so far.

use std::{collections::BTreeMap, sync::Arc};

use agenticfocus::{
    clip::{ClipInfo, FrameIndex},
    composite::LayerDecision,
    engine::{Finding, ModelUse},
    hands::HandTrack,
    inpaint::InpaintReport,
    landmarks::LandmarkTrack,
    retarget::RobotMotion,
    segment::{ArmTrack, MaskFrame, MaskTrack},
    session::ObjectChoice,
    template::TemplateTrack,
};

/// Artifacts, each the newest there is; some may belong to an older document than others.
#[derive(Clone, Debug, Default)]
pub struct Findings {
    /// The clip.
    pub clip: Option<Arc<ClipInfo>>,
    /// Landmarks with corrections.
    pub landmarks: Option<Arc<LandmarkTrack>>,
    /// Arm masks.
    pub arms: Option<Arc<ArmTrack>>,
    /// The object in use.
    pub choice: Option<ObjectChoice>,
    /// Object masks.
    pub object: Option<Arc<MaskTrack>>,
    /// Object masks the tracker made since, frame by frame.
    pub object_frames: BTreeMap<FrameIndex, MaskFrame>,
    /// The template; `None` where there is none or it is not known yet.
    pub template: Option<Arc<TemplateTrack>>,
    /// Coverage of the hole.
    pub background: Option<Arc<InpaintReport>>,
    /// Metric hands.
    pub hands: Option<Arc<HandTrack>>,
    /// The robot.
    pub motion: Option<Arc<RobotMotion>>,
    /// Layer order a frame.
    pub order: Option<Arc<Vec<LayerDecision>>>,
    /// Why learned models that are there are done without, a line each.
    pub model_faults: BTreeMap<ModelUse, String>,
}

impl Findings {
    /// Takes what the engine found.
    pub fn take(&mut self, finding: Finding) {
        match finding {
            Finding::Clip(clip) => self.clip = Some(clip),
            Finding::Landmarks(track) => self.landmarks = Some(track),
            Finding::Arms(track) => self.arms = Some(track),
            Finding::Choice(choice) => self.choice = choice,
            Finding::ObjectFrame(frame, mask) => {
                self.object_frames.insert(frame, *mask);
            }
            Finding::Object(track) => {
                self.object = Some(track);
                self.object_frames.clear();
            }
            Finding::Template(template) => self.template = template,
            Finding::Background(report) => self.background = Some(report),
            Finding::Hands(track) => self.hands = Some(track),
            Finding::Motion(motion) => self.motion = Some(motion),
            Finding::Order(order) => self.order = Some(order),
        }
    }

    /// Takes what the engine says of a learned model: a fault, or that nothing is wrong.
    pub fn take_model_fault(&mut self, purpose: ModelUse, fault: Option<String>) {
        match fault {
            Some(fault) => self.model_faults.insert(purpose, fault),
            None => self.model_faults.remove(&purpose),
        };
    }

    /// The machine's object mask on `frame`.
    pub fn object_on(&self, frame: FrameIndex) -> Option<&MaskFrame> {
        self.object_frames.get(&frame).or_else(|| self.object.as_ref()?.frames.get(frame.as_usize()))
    }

    /// The machine's arm mask on `frame`.
    pub fn arms_on(&self, frame: FrameIndex) -> Option<&MaskFrame> {
        self.arms.as_ref()?.union.frames.get(frame.as_usize())
    }
}
