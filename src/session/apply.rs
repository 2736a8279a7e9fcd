//! How a command changes a document, and the command that takes it back.

use std::mem::replace;

use nalgebra::Matrix3;

use super::{
    Command, Document, HandEdit, MaskEdit, MaskLayer, ObjectPromptKind, ObjectProposal, RetargetSettings,
    Said,
};
use crate::{
    clip::{CameraSpec, FrameIndex},
    geometry::Pixel,
    inpaint::InpaintParams,
    landmarks::KEYPOINT_COUNT,
    retarget::Beta,
};

/// Why a command was refused. The document is as before.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum ApplyError {
    /// A value outside its range.
    #[error("{name} = {value}: expected {expected}")]
    Value {
        /// The parameter.
        name: &'static str,
        /// What was given.
        value: String,
        /// What is allowed.
        expected: &'static str,
    },
}

fn refuse(name: &'static str, value: impl std::fmt::Debug, expected: &'static str) -> ApplyError {
    ApplyError::Value { name, value: format!("{value:?}"), expected }
}

impl Document {
    /// Applies `command` and returns its inverse.
    ///
    /// # Errors
    /// When a value is out of range; nothing has changed then.
    pub fn apply(&mut self, command: Command) -> Result<Command, ApplyError> {
        Ok(match command {
            Command::SetTask(task) => Command::SetTask(replace(&mut self.task, task)),
            Command::SetContentHash(hash) => {
                Command::SetContentHash(replace(&mut self.clip.content_hash, hash))
            }
            Command::SetCamera(camera) => {
                check_camera(&camera)?;
                Command::SetCamera(replace(&mut self.camera, camera))
            }
            Command::SetProposals(list) => {
                list.iter().try_for_each(check_object)?;
                Command::SetProposals(replace(&mut self.proposals, list))
            }
            Command::SetObjectAnswer(answer) => {
                if let Some(Said::Object(object)) = answer.as_ref().map(|answer| &answer.said) {
                    check_object(object)?;
                }
                let before = replace(&mut self.object_answer, answer.map(|answer| *answer));
                Command::SetObjectAnswer(before.map(Box::new))
            }
            Command::SetObject(choice) => {
                choice.iter().try_for_each(check_object)?;
                Command::SetObject(replace(&mut self.object, choice))
            }
            Command::SetMask { layer, frame, edit } => self.set_mask(layer, frame, edit),
            Command::SetReach { frame, reach } => {
                let reach = put(&mut self.object_reach, frame, reach);
                Command::SetReach { frame, reach }
            }
            Command::SetHoleDilation(share) => {
                check_dilation(share)?;
                Command::SetHoleDilation(replace(&mut self.hole_dilation, share))
            }
            Command::SetTemplateFrame(frame) => {
                Command::SetTemplateFrame(replace(&mut self.template.frame, frame))
            }
            Command::SetTemplateMask(mask) => {
                Command::SetTemplateMask(replace(&mut self.template.mask, mask))
            }
            Command::SetPlacement { frame, transform } => self.set_placement(frame, transform)?,
            Command::SetInterpolated { frame, interpolated } => {
                let keyframes = &mut self.template.interpolated;
                let before = if interpolated { !keyframes.insert(frame) } else { keyframes.remove(&frame) };
                Command::SetInterpolated { frame, interpolated: before }
            }
            Command::SetHandTrack(path) => Command::SetHandTrack(replace(&mut self.hand_track, path)),
            Command::SetHandEdit { frame, side, edit } => {
                edit.iter().try_for_each(check_hand)?;
                let edit = put(&mut self.hand_edits[side], frame, edit);
                Command::SetHandEdit { frame, side, edit }
            }
            Command::SetSidesSwapped(ranges) => {
                Command::SetSidesSwapped(replace(&mut self.sides_swapped, ranges))
            }
            Command::SetRetarget(settings) => {
                check_retarget(&settings)?;
                Command::SetRetarget(replace(&mut self.retarget, settings))
            }
            Command::SetLayerOrders(orders) => {
                Command::SetLayerOrders(replace(&mut self.layer_orders, orders))
            }
            Command::SetConfirmed { step, confirmed } => {
                let before =
                    if confirmed { !self.confirmed.insert(step) } else { self.confirmed.remove(&step) };
                Command::SetConfirmed { step, confirmed: before }
            }
            Command::SetReview(review) => Command::SetReview(replace(&mut self.review, review)),
            Command::Together(commands) => self.apply_together(commands)?,
        })
    }

    fn apply_together(&mut self, commands: Vec<Command>) -> Result<Command, ApplyError> {
        let mut inverses = Vec::with_capacity(commands.len());
        for command in commands {
            match self.apply(command) {
                Ok(inverse) => inverses.push(inverse),
                Err(error) => {
                    // All or nothing: inverses restore values that were accepted before.
                    for inverse in inverses.into_iter().rev() {
                        self.apply(inverse)?;
                    }
                    return Err(error);
                }
            }
        }
        inverses.reverse();
        Ok(Command::Together(inverses))
    }

    fn set_mask(&mut self, layer: MaskLayer, frame: FrameIndex, edit: Option<MaskEdit>) -> Command {
        let edit = put(self.masks_mut(layer), frame, edit);
        Command::SetMask { layer, frame, edit }
    }

    fn set_placement(
        &mut self,
        frame: FrameIndex,
        transform: Option<Matrix3<f64>>,
    ) -> Result<Command, ApplyError> {
        if let Some(matrix) = transform
            && !(matrix.iter().all(|v| v.is_finite()) && matrix.determinant().abs() > 1e-12)
        {
            return Err(refuse("placement", matrix, "a finite, invertible 3×3 matrix"));
        }
        let transform = put(&mut self.template.placements, frame, transform);
        Ok(Command::SetPlacement { frame, transform })
    }
}

/// Sets or removes `key` and returns what was there.
fn put<K: Ord, V>(map: &mut std::collections::BTreeMap<K, V>, key: K, value: Option<V>) -> Option<V> {
    match value {
        Some(value) => map.insert(key, value),
        None => map.remove(&key),
    }
}

fn check_dilation(share: Option<f64>) -> Result<(), ApplyError> {
    match share {
        Some(share) if !(0.0..=InpaintParams::WIDEST_DILATION).contains(&share) => {
            Err(refuse("hole_dilation", share, "a share of the picture's width from 0 to 0.05"))
        }
        _ => Ok(()),
    }
}

fn check_hand(edit: &HandEdit) -> Result<(), ApplyError> {
    debug_assert_eq!(KEYPOINT_COUNT, 21);
    for (index, point) in &edit.keypoints {
        if *index >= 21 {
            return Err(refuse("keypoint", index, "an index from 0 to 20"));
        }
        check_pixel("keypoint", point)?;
    }
    Ok(())
}

fn check_object(object: &ObjectProposal) -> Result<(), ApplyError> {
    if !object.confidence.is_finite() {
        return Err(refuse("confidence", object.confidence, "a finite number"));
    }
    match &object.prompt {
        ObjectPromptKind::Box(bounds) => {
            let fine = [bounds.x0, bounds.y0, bounds.x1, bounds.y1].iter().all(|value| value.is_finite());
            if fine { Ok(()) } else { Err(refuse("box", bounds, "finite pixels")) }
        }
        ObjectPromptKind::Points { positive, negative } => {
            positive.iter().chain(negative).try_for_each(|point| check_pixel("point", point))
        }
    }
}

/// JSON has no other numbers: a journal line with one could be written, but never read again.
fn check_pixel(name: &'static str, point: &Pixel) -> Result<(), ApplyError> {
    let fine = point.x.is_finite() && point.y.is_finite();
    if fine { Ok(()) } else { Err(refuse(name, point, "finite pixels")) }
}

fn check_camera(camera: &CameraSpec) -> Result<(), ApplyError> {
    match *camera {
        CameraSpec::Unknown => Ok(()),
        CameraSpec::HorizontalFov(degrees) if degrees > 0.0 && degrees < 180.0 => Ok(()),
        CameraSpec::HorizontalFov(degrees) => {
            Err(refuse("hfov_deg", degrees, "an angle above 0 and below 180"))
        }
        CameraSpec::Intrinsics { fx, fy, cx, cy } => {
            let fine = fx > 0.0 && fy > 0.0 && [fx, fy, cx, cy].iter().all(|value| value.is_finite());
            if fine { Ok(()) } else { Err(refuse("camera", camera, "finite numbers with fx, fy above 0")) }
        }
    }
}

fn check_retarget(settings: &RetargetSettings) -> Result<(), ApplyError> {
    if let Some(Beta::Fixed(beta)) = settings.beta
        && !(beta.is_finite() && (0.05..=5.0).contains(&beta))
    {
        return Err(refuse("beta", beta, "a number from 0.05 to 5, or \"fit\""));
    }
    if let Some(alpha) = settings.alpha
        && !(alpha > 0.0 && alpha <= 1.0)
    {
        return Err(refuse("alpha", alpha, "a number above 0 and at most 1"));
    }
    for (_, turn) in settings.wrist.iter() {
        if !turn.degrees().iter().all(|degrees| degrees.is_finite() && degrees.abs() <= 180.0) {
            return Err(refuse("wrist", turn, "finite degrees within ±180"));
        }
    }
    if let Some(offset) = settings.offset
        && !offset.iter().all(|value| value.is_finite() && value.abs() <= 10.0)
    {
        return Err(refuse("T_offset", offset, "three finite metres within ±10"));
    }
    if let Some(length) = settings.hand_length
        && !(0.1..=0.3).contains(&length)
    {
        return Err(refuse("hand_length", length, "metres from 0.1 to 0.3"));
    }
    match settings.camera_rotation.map(|rotation| rotation.matrix()) {
        None | Some(Ok(_)) => Ok(()),
        Some(Err(_)) => {
            let expected = "finite degrees, or a rotation matrix (orthonormal, determinant 1)";
            Err(refuse("R_cam", settings.camera_rotation, expected))
        }
    }
}
