//! The clip, decoded, and what the manifest pointed at on it.

use std::sync::Arc;

use crate::{
    clip::{self, CameraSpec, ClipFlag, ClipInfo, ClipRequest, StandardClip},
    geometry::{Pixel, PixelBox},
    pipeline::{ClipFailure, Listener, RawObjectPrompt, Stage},
    session::{Author, Document, ObjectChoice, ObjectPromptKind},
};

use super::context::Context;

/// Decodes the session's clip into the cache folder.
pub(super) fn open_clip(context: &Context<'_>) -> Result<Arc<StandardClip>, ClipFailure> {
    let request = clip_request(&context.document);
    if let Some(clip) = context.memory.and_then(|memory| memory.clip(&request)) {
        return Ok(clip);
    }
    let clip =
        context.stage(Stage::Clip, |watch| Ok(clip::open(&request, context.cache.folder(), watch)?))?;
    describe(&clip.info, context.listener);
    let clip = Arc::new(clip);
    if let Some(memory) = context.memory {
        memory.keep_clip(request, &clip);
    }
    Ok(clip)
}

/// What the session says of its clip.
pub(in crate::pipeline) fn clip_request(document: &Document) -> ClipRequest {
    let clip = &document.clip;
    ClipRequest {
        path: (&clip.path).into(),
        rotate: clip.rotate,
        camera: document.camera,
        start: clip.start,
        end: clip.end,
    }
}

fn describe(info: &ClipInfo, listener: &dyn Listener) {
    let seconds = info.frame_count() as f64 / clip::STANDARD_FPS;
    listener.note(&format!(
        "{} {}, {:.2} FPS, {} frames, used as {} at 30 FPS ({seconds:.1} s)",
        info.size,
        info.codec,
        info.source_fps,
        info.source_frames,
        info.frame_count()
    ));
    let camera = &info.intrinsics;
    let origin = match info.intrinsics_source {
        CameraSpec::Intrinsics { .. } => "given",
        CameraSpec::HorizontalFov(_) => "from the given field of view",
        CameraSpec::Unknown => "not given, a default field of view is assumed",
    };
    listener.note(&format!(
        "camera {origin}: fx {:.1}, fy {:.1}, cx {:.1}, cy {:.1}",
        camera.fx, camera.fy, camera.cx, camera.cy
    ));
    for flag in info.flags.iter().filter(|flag| **flag != ClipFlag::DefaultIntrinsics) {
        listener.note(&format!("clip flag: {}", flag_name(flag)));
    }
    for message in info.messages.iter().take(3) {
        listener.note(&format!("decoder: {message}"));
    }
}

/// A flag as reports spell it.
pub(super) fn flag_name(flag: &impl serde::Serialize) -> String {
    let value = serde_json::to_value(flag).ok();
    value.and_then(|value| value.as_str().map(str::to_owned)).unwrap_or_default()
}

/// A manifest's prompt in pixels and frames of the standardised clip.
pub(super) fn standard_prompt(raw: &RawObjectPrompt, info: &ClipInfo) -> Result<ObjectChoice, ClipFailure> {
    let frame = info.standard_index(raw.source_frame).ok_or_else(|| {
        ClipFailure::bad_input(format_args!(
            "object.frame = {}: the part of the clip in use has source frames {} to {}",
            raw.source_frame,
            info.frame_table.first().map_or(0, |row| row.source_frame),
            info.frame_table.last().map_or(0, |row| row.source_frame),
        ))
    })?;
    let turned = |points: &[[f64; 2]]| -> Vec<Pixel> {
        points.iter().map(|[x, y]| info.turned_pixel(Pixel::new(*x, *y))).collect()
    };
    let prompt = match raw.bounds {
        Some([x0, y0, x1, y1]) => {
            let bounds = PixelBox::from_corners(Pixel::new(x0, y0), Pixel::new(x1, y1));
            let inside = info.turned_box(bounds).clipped(info.size).filter(|inside| inside.area() >= 4.0);
            ObjectPromptKind::Box(inside.ok_or_else(|| {
                ClipFailure::bad_input(format_args!(
                    "object.box = {:?} lies outside the {} picture",
                    raw.bounds.unwrap_or_default(),
                    info.decoded_size
                ))
            })?)
        }
        None => ObjectPromptKind::Points { positive: turned(&raw.points), negative: turned(&raw.negative) },
    };
    Ok(ObjectChoice {
        label: raw.label.clone(),
        frame,
        prompt,
        confidence: 1.0,
        reason: "given by the manifest".to_owned(),
        author: Author::Manifest,
    })
}
