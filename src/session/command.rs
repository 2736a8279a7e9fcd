//! Everything that can be done to a session.

use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};

use super::{
    HandEdit, LayerOrderRange, MaskEdit, MaskId, MaskLayer, MaskReach, ObjectAnswer, ObjectChoice,
    ObjectProposal, RetargetSettings, ReviewState, SidesSwapped, Step,
};
use crate::{
    clip::{CameraSpec, FrameIndex},
    geometry::Side,
};

/// Who did something.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Author {
    /// A person.
    Human,
    /// A manifest, written by a person beforehand.
    Manifest,
    /// A back end, by name.
    Machine(String),
}

/// A change of the document. Every command sets something to a value, so that its inverse is a
/// command of the same kind with the value from before.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Command {
    /// The task sentence.
    SetTask(Option<String>),
    /// blake3 of the clip's bytes, once known.
    SetContentHash(String),
    /// The source camera.
    SetCamera(CameraSpec),
    /// The ranked proposals.
    SetProposals(Vec<ObjectProposal>),
    /// What a model answered that was asked for the object.
    SetObjectAnswer(Option<Box<ObjectAnswer>>),
    /// The chosen object.
    SetObject(Option<ObjectChoice>),
    /// What a person says about a mask; `None` leaves the frame to the machine again.
    SetMask {
        /// Which mask.
        layer: MaskLayer,
        /// On which frame.
        frame: FrameIndex,
        /// What.
        edit: Option<MaskEdit>,
    },
    /// Which way the object's mask of a frame is spread; `None` is both.
    SetReach {
        /// The frame.
        frame: FrameIndex,
        /// Which way.
        reach: Option<MaskReach>,
    },
    /// How far the hole in the background is widened, as a share of the picture's width; `None` is the default.
    SetHoleDilation(Option<f64>),
    /// The clean frame; `None` lets the machine choose.
    SetTemplateFrame(Option<FrameIndex>),
    /// The template's mask on its frame.
    SetTemplateMask(Option<MaskId>),
    /// A placement by hand.
    SetPlacement {
        /// On which frame.
        frame: FrameIndex,
        /// Template pixels to frame pixels; `None` leaves it to the machine again.
        transform: Option<Matrix3<f64>>,
    },
    /// Whether placements run straight from a keyframe to the next one.
    SetInterpolated {
        /// The keyframe.
        frame: FrameIndex,
        /// Yes or no.
        interpolated: bool,
    },
    /// A hand track to import, absolute path.
    SetHandTrack(Option<String>),
    /// A correction of a hand.
    SetHandEdit {
        /// On which frame.
        frame: FrameIndex,
        /// Which hand.
        side: Side,
        /// What; `None` leaves it to the machine again.
        edit: Option<HandEdit>,
    },
    /// All ranges with left and right exchanged.
    SetSidesSwapped(Vec<SidesSwapped>),
    /// Retargeting.
    SetRetarget(RetargetSettings),
    /// All layer orders.
    SetLayerOrders(Vec<LayerOrderRange>),
    /// Whether a person confirmed a step.
    SetConfirmed {
        /// Which.
        step: Step,
        /// Yes or no.
        confirmed: bool,
    },
    /// Review.
    SetReview(ReviewState),
    /// Several at once: one step for undo.
    Together(Vec<Command>),
}
