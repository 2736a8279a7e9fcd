//! Robot pictures, layers and files: everything of `out/ID/`.

use std::{
    path::Path,
    sync::{
        Arc,
        mpsc::{Receiver, SyncSender, sync_channel},
    },
    thread,
};

use super::{
    Understood,
    context::Context,
    frame::{self, FramePixels},
    joined, layer_files,
    layers::{LayerPlan, layer_evidence, plan_layers},
    pixels::{self, next_frame},
    report::{backends, report},
    stills,
};
use crate::{
    clip::{FrameIndex, FrameSource as _},
    composite::Compositor,
    export::{
        ClipFolder, ExportError, HandLimits, Record, RecordDescription, RecordMeta, VideoQuality, VideoWriter,
    },
    pipeline::{ClipFailure, ExitCode, Stage, batch::ClipOutcome},
    progress::Watch,
    render::RobotLayers,
    robot::{ARM_DOF, RobotModel},
};

/// What is written, and under which outcome.
pub(super) struct Parts<'a> {
    pub(super) found: &'a Understood,
    pub(super) outcome: &'a ClipOutcome,
    /// Every frame's layers too, without loss.
    pub(super) layers: bool,
}

impl std::ops::Deref for Parts<'_> {
    type Target = Understood;
    fn deref(&self) -> &Understood {
        self.found
    }
}

/// Robot pictures that may wait for the compositor: enough to overlap, few enough to bound memory.
const RENDERED_AHEAD: usize = 2;

fn failed(error: &(dyn std::error::Error + 'static)) -> ClipFailure {
    ClipFailure::from_error(error, ExitCode::Internal)
}

impl From<ExportError> for ClipFailure {
    fn from(error: ExportError) -> Self {
        Self::from_error(&error, ExitCode::InputOutput)
    }
}

/// Writes the clip's folder and publishes it when it is whole.
pub(super) fn write(context: &Context<'_>, out: &Path, parts: &Parts<'_>) -> Result<(), ClipFailure> {
    let folder = context.stage(Stage::Export, |watch| {
        let folder = ClipFolder::create(out, &parts.outcome.id)?;
        let plan = plan_layers(&context.document, parts, &layer_evidence(parts)?);
        thread::scope(|scope| {
            let (send, receive) = sync_channel(RENDERED_AHEAD);
            let renderer = scope.spawn(|| render_all(parts, &plan, send, watch));
            let (to_compositor, for_compositor) = sync_channel(pixels::READ_AHEAD);
            let (to_stills, for_stills) = sync_channel(pixels::READ_AHEAD);
            let reader = scope.spawn(|| pixels::read_all(parts, [to_compositor, to_stills], watch));
            let folder = &folder;
            let stills = scope.spawn(move || stills::write(folder, parts, for_stills, watch));
            let composed = compose_all(folder, parts, &plan, (receive, for_compositor), watch);
            let (read, rendered) = (joined(reader.join()), joined(renderer.join()));
            let stilled = joined(stills.join());
            // Who feeds the others and failed is why they ran dry: its reason comes first.
            read.and(rendered).and(composed).and(stilled)
        })?;
        write_record(&folder, context, parts)?;
        Ok(folder)
    })?;
    crate::export::write_json(&folder.file("report.json"), &report(context, parts))?;
    folder.publish(parts.outcome)?;
    Ok(())
}

/// Draws the robot of every frame, in order. The renderer belongs to this thread.
fn render_all(
    parts: &Parts<'_>,
    plan: &LayerPlan,
    send: SyncSender<RobotLayers>,
    watch: &dyn Watch,
) -> Result<(), ClipFailure> {
    let mut renderer = frame::robot_renderer(parts)?;
    for index in FrameIndex::all(parts.clip.frame_count()) {
        watch.check().map_err(|error| failed(&error))?;
        if send.send(frame::render_robot(&mut renderer, parts, plan, index)?).is_err() {
            // The compositor stopped; it says why.
            return Ok(());
        }
    }
    Ok(())
}

/// Composes every frame and writes the composite and the layer video.
fn compose_all(
    folder: &ClipFolder,
    parts: &Parts<'_>,
    plan: &LayerPlan,
    (robots, pixels): (Receiver<RobotLayers>, Receiver<Arc<FramePixels>>),
    watch: &dyn Watch,
) -> Result<(), ClipFailure> {
    let size = parts.clip.size();
    let compositor = Compositor::default();
    let mut composite = VideoWriter::create(&folder.file("composite.mp4"), size, VideoQuality::Final)?;
    let mut layers_video = VideoWriter::create(
        &folder.file("debug/layers.mp4"),
        stills::layers_size(size),
        VideoQuality::Debug,
    )?;
    let count = parts.clip.frame_count();
    for index in FrameIndex::all(count) {
        watch.advance(index.as_usize(), count);
        let Ok(robot) = robots.recv() else {
            let message = "the renderer stopped early".to_owned();
            return Err(ClipFailure { stage: None, exit: ExitCode::Internal, message });
        };
        let pixels = next_frame(&pixels)?;
        let composed = frame::compose_frame(&compositor, parts, plan, index, &pixels, &robot)?;
        composite.push(&composed.picture)?;
        layers_video.push(&stills::layers_picture(&pixels.background, &robot, &composed)?)?;
        if parts.layers {
            let order = &plan.order[index.as_usize()];
            let layers = frame::layers_of(pixels.background.clone(), robot, composed, order);
            layer_files::write(folder, index, &layers)?;
        }
    }
    composite.finish()?;
    layers_video.finish()?;
    Ok(())
}

fn write_record(folder: &ClipFolder, context: &Context<'_>, parts: &Parts<'_>) -> Result<(), ClipFailure> {
    let limits = hand_limits(&parts.robot);
    let record = Record::from_motion(&parts.motion, &parts.hands, &parts.clip.info, &limits)?;
    record.write_npz(&folder.file("record.npz"))?;
    let parameters = [
        ("method", serde_json::to_value(parts.motion.method)),
        ("map", serde_json::to_value(parts.motion.map)),
        ("alpha", serde_json::to_value(parts.motion.alpha)),
        ("retarget", serde_json::to_value(context.document.retarget)),
        ("layer_orders", serde_json::to_value(&context.document.layer_orders)),
    ];
    let mut values = std::collections::BTreeMap::new();
    for (name, value) in parameters {
        values.insert(name.to_owned(), value.map_err(std::io::Error::other)?);
    }
    let meta = RecordMeta {
        id: parts.outcome.id.clone(),
        task: context.document.task.clone().unwrap_or_default(),
        backends: backends(parts).into_iter().map(|(k, v)| (k.to_owned(), v.to_owned())).collect(),
        versions: [("agenticfocus".to_owned(), env!("CARGO_PKG_VERSION").to_owned())].into(),
        parameters: values,
    };
    RecordDescription::new(&record, &parts.clip.info, &meta).write(&folder.file("record.json"))?;
    Ok(())
}

/// Limits of the 12 hand actuators in the record's order.
fn hand_limits(robot: &RobotModel) -> HandLimits {
    let limits = robot.limits();
    std::array::from_fn(|at| [limits.lower[ARM_DOF + at], limits.upper[ARM_DOF + at]])
}
