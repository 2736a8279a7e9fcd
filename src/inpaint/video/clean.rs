//! The driver: windows along the clip, each restored by the network, blended and laid into the frames' holes.

use std::collections::BTreeMap;

use opencv::{
    core::{CV_8UC3, Mat, MatTrait, MatTraitConst, MatTraitManual, Point, Scalar, Size as CvSize},
    imgproc,
};

use super::{
    blend::{Blend, Blender},
    fit::Fit,
    network::{NetworkFrame, VideoNetwork},
    windows::{Window, windows},
};
use crate::{
    clip::{FrameIndex, FrameSource},
    image::Rgb8,
    inpaint::{
        FrameCoverage, InpaintError, InpaintParams, InpaintReport, SinkError,
        fill::grown_rect,
        hole::core_mat,
        scene::Scene,
        seam::{colours_of, laid_in, seam},
    },
    progress::Watch,
    segment::MaskTrack,
    vision::single_threaded,
};

/// Times that the network's hole is widened by a cross of 3×3, as in the published procedure.
const WIDENED: i32 = 4;

/// As [`crate::inpaint::clean`], by a network: every frame's hole is drawn from what the network sees in the window
/// around it and in reference frames. Outside the hole frames stay as they are.
///
/// Memory: the frames of one window at the network's size, and the frames being blended.
///
/// # Errors
/// When a track was made for another clip, a frame cannot be read, the network or `sink` fails, or `watch` cancels.
pub fn clean_by_network(
    frames: &dyn FrameSource,
    (arms, object): (&MaskTrack, &MaskTrack),
    params: &InpaintParams,
    (network, blend): (&mut VideoNetwork, Blend),
    sink: &mut dyn FnMut(FrameIndex, &Rgb8) -> Result<(), SinkError>,
    watch: &dyn Watch,
) -> Result<InpaintReport, InpaintError> {
    single_threaded();
    let scene = Scene::new(frames, arms, object, params)?;
    let count = scene.frame_count();
    let fit = network.fit(frames.size());
    let all = windows(count, network.window(), network.steps());
    let mut blender = Blender::new(blend);
    let mut near: BTreeMap<usize, NetworkFrame> = BTreeMap::new();
    let mut coverage = Vec::with_capacity(count);
    for (number, window) in all.iter().enumerate() {
        watch.check()?;
        near.retain(|frame, _| window.fed.contains(frame) || window.references.contains(frame));
        for frame in window.fed.iter().chain(&window.references) {
            if !near.contains_key(frame) {
                near.insert(*frame, network_frame(&scene, *frame, &fit)?);
            }
        }
        add_window(network, window, &near, &mut blender)?;
        let settled = all.get(number + 1).map_or(count, |next| next.local.start);
        for (frame, planes) in blender.finish_before(settled) {
            let (picture, covered) = laid(&scene, frame, &fit, &planes)?;
            sink(FrameIndex(frame as u32), &picture).map_err(InpaintError::Sink)?;
            coverage.push(covered);
            watch.advance(frame + 1, count);
        }
    }
    Ok(InpaintReport { coverage, plates: 0, backend: network.name().to_owned() })
}

fn add_window(
    network: &mut VideoNetwork,
    window: &Window,
    near: &BTreeMap<usize, NetworkFrame>,
    blender: &mut Blender,
) -> Result<(), InpaintError> {
    // Every frame of the window was put there by the caller.
    let fed: Vec<&NetworkFrame> =
        window.fed.iter().chain(&window.references).filter_map(|frame| near.get(frame)).collect();
    let local = window.local.len();
    let restored = network.restore(&fed, local)?;
    for (frame, planes) in window.local.clone().zip(restored.chunks(restored.len() / local.max(1))) {
        blender.add(window, frame, planes);
    }
    Ok(())
}

/// A frame at the network's size, and what is taken out of it: `M_hand ∩ ¬M_obj`, widened, never into the object.
fn network_frame(scene: &Scene<'_>, frame: usize, fit: &Fit) -> Result<NetworkFrame, InpaintError> {
    let index = FrameIndex(frame as u32);
    let picture = fit.shrink(&scene.frames.frame(index)?.to_mat()?)?;
    let arm = fit.shrink_mask(&scene.arms.frame(index).mask.decode().to_mat()?)?;
    let object = scene.object.frame(index).mask.decode().to_mat()?;
    let (core, object) = (fit.shrink_mask(&core_mat(&object, scene.params)?)?, fit.shrink_mask(&object)?);
    let without = |from: &Mat, what: &Mat| -> opencv::Result<Mat> {
        let (mut outside, mut left) = (Mat::default(), Mat::default());
        opencv::core::bitwise_not_def(what, &mut outside)?;
        opencv::core::bitwise_and_def(from, &outside, &mut left)?;
        Ok(left)
    };
    let cross =
        imgproc::get_structuring_element(imgproc::MORPH_CROSS, CvSize::new(3, 3), Point::new(-1, -1))?;
    let mut wide = Mat::default();
    let beyond = imgproc::morphology_default_border_value()?;
    let hand = without(&arm, &object)?;
    imgproc::dilate(
        &hand,
        &mut wide,
        &cross,
        Point::new(-1, -1),
        WIDENED,
        opencv::core::BORDER_CONSTANT,
        beyond,
    )?;
    Ok(NetworkFrame { picture, hole: without(&wide, &core)? })
}

/// The clip's frame with the network's picture in its hole.
fn laid(
    scene: &Scene<'_>,
    frame: usize,
    fit: &Fit,
    planes: &[f32],
) -> Result<(Rgb8, FrameCoverage), InpaintError> {
    let loaded = scene.cut(frame)?;
    let hole = opencv::core::count_non_zero(&loaded.hole)?.max(0) as u64;
    if hole == 0 {
        let covered = FrameCoverage { seen: 1.0, ..FrameCoverage::default() };
        return Ok((Rgb8::from_mat(&loaded.picture)?, covered));
    }
    let restored = fit.enlarge(&picture_of(planes, fit)?)?;
    let feather = InpaintParams::pixels(scene.params.feather, fit.clip.width, 1);
    let around = imgproc::bounding_rect(&loaded.hole)?;
    let region = grown_rect(around, 2 * feather + 2, restored.cols(), restored.rows());
    let part = |of: &Mat| Mat::roi(of, region)?.try_clone();
    let background = colours_of(&part(&restored)?)?;
    let mut alpha = seam(&part(&loaded.hole)?, feather)?;
    alpha.set_to(&Scalar::all(0.0), &part(&loaded.core)?)?;
    let picture = laid_in(&loaded.picture, region, &background, &alpha)?;
    // A network does not say what it saw and what it made up.
    Ok((picture, FrameCoverage { hole, synthesised: 1.0, ..FrameCoverage::default() }))
}

/// CV_8UC3, RGB, from planes of -1 to 1.
fn picture_of(planes: &[f32], fit: &Fit) -> opencv::Result<Mat> {
    let (width, height) = (fit.outer.width as i32, fit.outer.height as i32);
    let mut picture = Mat::new_rows_cols_with_default(height, width, CV_8UC3, Scalar::all(0.0))?;
    let plane = ((width * height) as usize).max(1);
    for (channel, values) in planes.chunks_exact(plane).take(3).enumerate() {
        let bytes = picture.data_bytes_mut()?.iter_mut().skip(channel).step_by(3);
        for (byte, network) in bytes.zip(values) {
            *byte = ((network + 1.0) / 2.0 * 255.0).round().clamp(0.0, 255.0) as u8;
        }
    }
    Ok(picture)
}
