//! What the engine finds out about a clip, stage by stage.

use std::sync::Arc;

use crate::{
    clip::{ClipInfo, FrameIndex},
    composite::LayerDecision,
    hands::HandTrack,
    inpaint::InpaintReport,
    landmarks::LandmarkTrack,
    retarget::RobotMotion,
    segment::{ArmTrack, MaskFrame, MaskTrack},
    session::ObjectChoice,
    template::TemplateTrack,
};

/// One artifact, or a part of one as it is being made.
#[derive(Clone, Debug)]
pub enum Finding {
    /// The clip on its standard timeline.
    Clip(Arc<ClipInfo>),
    /// Landmarks with the person's corrections.
    Landmarks(Arc<LandmarkTrack>),
    /// Arm masks.
    Arms(Arc<ArmTrack>),
    /// The object in use; `None` where nobody knows it.
    Choice(Option<ObjectChoice>),
    /// One object mask as the tracker goes along; the whole track comes later and wins.
    ObjectFrame(FrameIndex, Box<MaskFrame>),
    /// Object masks.
    Object(Arc<MaskTrack>),
    /// The object whole, and where it goes; `None` without an object.
    Template(Option<Arc<TemplateTrack>>),
    /// Where the background's pixels come from.
    Background(Arc<InpaintReport>),
    /// Metric hands.
    Hands(Arc<HandTrack>),
    /// The robot's motion. Comes again and again while parameters change.
    Motion(Arc<RobotMotion>),
    /// What lies in front of what, a frame.
    Order(Arc<Vec<LayerDecision>>),
}
