//! Published methods on the same hands and the same robot, to be compared with.
//!
//! Each takes the hand track as it is (its own cleaning is part of the method), moves the robot within its
//! position and velocity limits, and is judged by the human's wrist under the map it worked with: what
//! [`crate::retarget::SideReport`] calls the target is that wrist, not what the method itself steered by, and
//! `reachable` says whether an arm could get there, not whether the method did.

mod do_as_i_do;
mod judge;
mod masquerade;

use crate::{geometry::PerSide, hands::HandTrack, progress::Watch, robot::RobotModel};

use super::{CameraMap, params::RetargetParams, track::HumanTrack};

pub(super) use do_as_i_do::do_as_i_do;
pub(super) use masquerade::masquerade;

/// A clip that a baseline retargets.
#[derive(Clone, Copy)]
pub(super) struct BaselineClip<'a> {
    pub hands: &'a HandTrack,
    pub robot: &'a RobotModel,
    pub params: &'a RetargetParams,
    /// The hands as our method sees them: what results are judged by.
    pub tracks: &'a PerSide<HumanTrack>,
    /// The camera map of our method, β fitted.
    pub shared_map: CameraMap,
    pub watch: &'a dyn Watch,
}
