//! One finished frame: the same for the export and for the preview.

use super::{Understood, layers::LayerPlan};
use crate::{
    clip::FrameIndex,
    composite::{Composite, Compositor, FrameLayers, LayerDecision, ObjectEvidence, front_layer},
    engine::Layers,
    image::Rgb8,
    pipeline::{ClipFailure, ExitCode},
    render::{LayerRequest, RobotLayers, RobotRenderParams, RobotRenderer},
};

/// One frame as filmed and without the human.
#[derive(Clone, Debug)]
pub(crate) struct FramePixels {
    /// As filmed.
    pub(crate) source: Rgb8,
    /// Without the human.
    pub(crate) background: Rgb8,
}

fn failed(error: &(dyn std::error::Error + 'static)) -> ClipFailure {
    ClipFailure::from_error(error, ExitCode::Internal)
}

/// A renderer for the clip's robot through the clip's lens. It belongs to the thread that makes it.
pub(crate) fn robot_renderer(found: &Understood) -> Result<RobotRenderer, ClipFailure> {
    RobotRenderer::new(&found.robot, found.clip.info.intrinsics, RobotRenderParams::default())
        .map_err(|error| failed(&error))
}

/// Draws the robot of one frame.
pub(crate) fn render_robot(
    renderer: &mut RobotRenderer,
    found: &Understood,
    plan: &LayerPlan,
    index: FrameIndex,
) -> Result<RobotLayers, ClipFailure> {
    let at = index.as_usize();
    let request = LayerRequest { shown: plan.shown[at], ..LayerRequest::default() };
    renderer.render(&found.motion.angles[at], &found.motion.map, &request).map_err(|error| failed(&error))
}

/// Composes one frame.
pub(crate) fn compose_frame(
    compositor: &Compositor,
    found: &Understood,
    plan: &LayerPlan,
    index: FrameIndex,
    pixels: &FramePixels,
    robot: &RobotLayers,
) -> Result<Composite, ClipFailure> {
    let mask = found.object.frame(index);
    let (visible, hidden) = (mask.mask.decode(), found.arms.union.frame(index).mask.decode());
    let object = found.template.as_deref().map(|template| ObjectEvidence {
        template,
        placement: template.placements[index.as_usize()].as_ref(),
        source: &pixels.source,
        visible: mask.is_trusted().then_some(&visible),
        hidden: &hidden,
    });
    let layers = FrameLayers {
        background: &pixels.background,
        robot: Some(robot),
        object,
        order: plan.order[index.as_usize()],
    };
    compositor.compose(&layers).map_err(|error| failed(&error))
}

/// The finished frame and what it is made of: what the preview shows and what an export can keep.
pub(crate) fn layers_of(
    background: Rgb8,
    robot: RobotLayers,
    composed: Composite,
    order: &LayerDecision,
) -> Layers {
    let size = background.size();
    Layers {
        composite: composed.picture,
        object: composed.object.map(|object| object.to_rgba(size)),
        front: front_layer(&robot, order),
        robot: robot.full,
        background,
    }
}
