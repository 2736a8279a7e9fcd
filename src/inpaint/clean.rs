//! The driver: plates along the clip, and every frame's hole drawn from the plate of its stretch.

use std::ops::Range;

use opencv::{
    core::{Mat, MatTrait, MatTraitConst, MatTraitConstManual, Rect, Scalar, Vec3b},
    imgproc,
};
use rayon::prelude::*;

use super::{
    FrameCoverage, InpaintError, InpaintParams, InpaintReport,
    cast::{Ground, Shadow, cast_shadow},
    fill::grown_rect,
    moved::{MovedColours, differs, moved_pieces},
    network::ImageNetwork,
    plate::{self, Plate, SEEN, SYNTHESISED, close_offset, take_out_pieces, with_offset},
    scene::{Loaded, Scene},
    seam::{laid_in, seam},
    survey::Survey,
};
use crate::{
    clip::{FrameIndex, FrameSource},
    geometry::Size,
    image::Rgb8,
    progress::Watch,
    segment::{MaskTrack, RleMask},
    vision::{Registration, Warp, enlarged_part, fill_smoothly, single_threaded},
};

/// A receiver's error.
pub type SinkError = Box<dyn std::error::Error + Send + Sync>;

/// Takes hands and arms out of every frame of a clip and hands the frames to `sink` in order.
///
/// `arms` and `object` are the visible masks of `frames`' clip. The visible object stays as it is
/// in the frame; behind it and behind the hand the plates know neither hand nor object, so that a
/// template drawn at its placement meets clean background. `template_region`, one mask a frame, says
/// where the template will be drawn anyway: it only changes how made-up pixels are counted.
///
/// Memory: frames kept up to `cache_mib`, two plates, and small numbers for every frame.
///
/// # Errors
/// When a track was made for another clip, a frame cannot be read, `sink` fails, or `watch` cancels.
pub fn clean(
    frames: &dyn FrameSource,
    arms: &MaskTrack,
    object: &MaskTrack,
    template_region: Option<&[RleMask]>,
    params: &InpaintParams,
    sink: &mut dyn FnMut(FrameIndex, &Rgb8) -> Result<(), SinkError>,
    watch: &dyn Watch,
) -> Result<InpaintReport, InpaintError> {
    clean_with(frames, (arms, object), template_region, params, None, sink, watch)
}

/// As [`clean`]; what no frame saw is made up by a network where one is given.
///
/// # Errors
/// As [`clean`], and when the network fails.
pub fn clean_with(
    frames: &dyn FrameSource,
    (arms, object): (&MaskTrack, &MaskTrack),
    template_region: Option<&[RleMask]>,
    params: &InpaintParams,
    mut unseen: Option<&mut ImageNetwork>,
    sink: &mut dyn FnMut(FrameIndex, &Rgb8) -> Result<(), SinkError>,
    watch: &dyn Watch,
) -> Result<InpaintReport, InpaintError> {
    single_threaded();
    let scene = Scene::new(frames, arms, object, params)?;
    let count = scene.frame_count();
    if let Some(region) = template_region
        && region.len() != count
    {
        return Err(InpaintError::Mismatch {
            what: "the template region",
            found: region.len(),
            found_size: region.first().map_or(frames.size(), RleMask::size),
            expected: count,
            expected_size: frames.size(),
        });
    }
    let survey = Survey::new(&scene, watch)?;
    let services = services(&survey, params);
    let mut coverage = Vec::with_capacity(count);
    let backend = match &unseen {
        Some(network) => format!("temporal-plate, unseen by {}", network.name()),
        None => "temporal-plate".to_owned(),
    };
    let mut make = |number: usize, previous: Option<&Plate>| -> Result<Option<Plate>, InpaintError> {
        let Some(service) = services.get(number) else { return Ok(None) };
        let fade = params.handover as usize;
        let frames = service.start.saturating_sub(fade)..(service.end + fade).min(count);
        let key = (service.start + service.end - 1) / 2;
        plate::build(&scene, &survey, key, frames, previous, unseen.as_deref_mut()).map(Some)
    };
    let mut previous: Option<Plate> = None;
    let mut current = make(0, None)?;
    for (number, service) in services.iter().enumerate() {
        watch.check()?;
        let next = make(number + 1, current.as_ref())?;
        for start in service.clone().step_by(CHUNK) {
            watch.check()?;
            let cleaned: Vec<Result<(Rgb8, FrameCoverage), InpaintError>> = (start
                ..(start + CHUNK).min(service.end))
                .into_par_iter()
                .map(|frame| {
                    let weights = shares(frame, service, params.handover as usize);
                    let plates = [previous.as_ref(), current.as_ref(), next.as_ref()];
                    let template = template_region.map(|regions| &regions[frame]);
                    clean_frame(&scene, &survey, frame, plates, weights, template)
                })
                .collect();
            for (frame, cleaned) in (start..).zip(cleaned) {
                let (picture, covered) = cleaned?;
                sink(FrameIndex(frame as u32), &picture).map_err(InpaintError::Sink)?;
                coverage.push(covered);
                watch.advance(frame + 1, count);
            }
        }
        previous = std::mem::replace(&mut current, next);
    }
    Ok(InpaintReport { coverage, plates: services.len(), backend })
}

const CHUNK: usize = 8;

/// The stretches of frames that one plate serves: as long as the camera stays near.
fn services(survey: &Survey, params: &InpaintParams) -> Vec<Range<usize>> {
    let count = survey.path.frame_count();
    let shortest = params.plate_spacing.max(1) as usize;
    let longest = shortest.max(params.longest_service as usize);
    let mut found = Vec::new();
    let mut start = 0;
    while start < count {
        // The key frame stands in the middle: from there both ends are half as far away.
        let within =
            |end: usize| survey.displacement(start, end).is_some_and(|far| far < 2.0 * params.plate_reach);
        let mut end = start + 1;
        while end < count && end - start < longest && survey.displacement(start, end).is_some() {
            if end - start >= shortest && !within(end) {
                break;
            }
            end += 1;
        }
        found.push(start..end);
        start = end;
    }
    found
}

/// How much the previous, the current and the next plate count on `frame`.
fn shares(frame: usize, service: &Range<usize>, handover: usize) -> [f32; 3] {
    let half = (handover as f32 / 2.0).max(0.5);
    let into = |distance: f32| (0.5 - 0.5 * distance / half).clamp(0.0, 0.5);
    let before = into((frame - service.start) as f32 + 0.5);
    let after = into((service.end - frame) as f32 - 0.5);
    [before, 1.0 - before - after, after]
}

fn clean_frame(
    scene: &Scene<'_>,
    survey: &Survey,
    frame: usize,
    plates: [Option<&Plate>; 3],
    weights: [f32; 3],
    template: Option<&RleMask>,
) -> Result<(Rgb8, FrameCoverage), InpaintError> {
    let loaded = scene.load(frame)?;
    let bounds = imgproc::bounding_rect(&loaded.hole)?;
    if bounds.width == 0 || bounds.height == 0 {
        return Ok((
            Rgb8::from_mat(&loaded.picture)?,
            FrameCoverage { seen: 1.0, ..FrameCoverage::default() },
        ));
    }
    let feather = InpaintParams::pixels(scene.params.feather, loaded.picture.cols() as u32, 1);
    let mut views = Vec::new();
    for (plate, weight) in plates.into_iter().zip(weights) {
        let Some(plate) = plate.filter(|_| weight > 0.0) else { continue };
        if let Some(view) = PlateView::new(scene, survey, &loaded, frame, plate, weight)? {
            views.push(view);
        }
    }
    // The plates agree about the ground: one is enough to see what lies in the shadow.
    let clearest = views.iter().max_by(|a, b| a.weight.total_cmp(&b.weight));
    let shadow = match clearest {
        Some(view) => view.shadow(&loaded, scene.params)?,
        None => None,
    };
    let bounds = shadow.as_ref().map_or(bounds, |shadow| bounds | shadow.bounds);
    let region = grown_rect(bounds, 2 * feather + 2, loaded.picture.cols(), loaded.picture.rows());
    let mut parts = Vec::new();
    for view in &views {
        parts.push(view.draw(region)?);
    }
    let template = template.map(RleMask::decode);
    let inside_template = |x: i32, y: i32| {
        template.as_ref().is_some_and(|mask| mask.get((region.x + x) as u32, (region.y + y) as u32))
    };
    let hole = Mat::roi(&loaded.hole, region)?.try_clone()?;
    let (background, coverage) =
        mixed(&loaded, region, &hole, (&parts, scene.params.change_limit), &inside_template)?;
    let core = Mat::roi(&loaded.core, region)?.try_clone()?;
    let mut alpha = seam(&hole, feather)?;
    if let Some(shadow) = &shadow {
        let shade = enlarged_part(&shadow.alpha, loaded.view.scale.full, region)?;
        let either = alpha.clone();
        opencv::core::max(&either, &shade, &mut alpha)?;
    }
    alpha.set_to(&Scalar::all(0.0), &core)?;
    let picture = laid_in(&loaded.picture, region, &background, &alpha)?;
    Ok((picture, coverage))
}

/// One plate's view of a frame's hole.
struct Part {
    picture: Mat,
    origin: Mat,
    weight: f32,
}

/// A plate as a frame's camera sees it.
struct PlateView<'a> {
    plate: &'a Plate,
    weight: f32,
    /// From the frame to the plate.
    warp: Warp,
    /// What to add to the plate's colours, in cells.
    offset: Mat,
    /// CV_8UC3 at the frame's work scale: the plate in the frame's colours.
    colour: Mat,
    /// CV_8UC1 at the frame's work scale: 255 where the plate was really seen.
    shown: Mat,
    /// Colours of what stands elsewhere on this frame.
    moved: MovedColours,
    /// CV_8UC1 at the frame's work scale: pieces of the plate that are not there on this frame.
    gone: Mat,
    full: Size,
}

impl<'a> PlateView<'a> {
    /// `None` where the plate does not fit.
    fn new(
        scene: &Scene<'_>,
        survey: &Survey,
        loaded: &Loaded,
        frame: usize,
        plate: &'a Plate,
        weight: f32,
    ) -> Result<Option<Self>, InpaintError> {
        let Some(guess) = plate.guess_from(survey, frame) else { return Ok(None) };
        let registration = Registration { parallax: scene.params.parallax };
        let still = plate.still();
        // A frame too blurred to register still lies about where the camera's path says.
        let warp = match registration.register(&loaded.view, &plate.view, &guess, Some(&still))? {
            Some(warp) => warp,
            None => Warp::along(&guess, loaded.view.scale, plate.view.scale),
        };
        let scale = loaded.view.scale;
        let (colour, shown) = warp.draw_work(&plate.view)?;
        let offset = close_offset(&loaded.view, &colour, &shown, scene.params)?;
        let whole = Rect::new(0, 0, scale.work.width as i32, scale.work.height as i32);
        let colour = with_offset(&colour, &offset, scale.work, whole)?;
        let mut both = Mat::default();
        opencv::core::bitwise_and_def(&shown, &loaded.view.valid, &mut both)?;
        let moved = MovedColours::between(&loaded.view, &colour, &both, scene.params.change_limit)?;
        let gone = moved_pieces(&loaded.view, &colour, &both, scene.params.change_limit)?;
        Ok(Some(Self { plate, weight, warp, offset, colour, shown, moved, gone, full: scale.full }))
    }

    /// The part `region` of the plate, in the frame's colours.
    fn draw(&self, region: Rect) -> opencv::Result<Part> {
        let (source, origin) = (&self.plate.picture, &self.plate.origin);
        let (picture, mut origin) =
            self.warp.draw_with_mask(source, origin, region, imgproc::INTER_NEAREST, 0.0)?;
        let picture = with_offset(&picture, &self.offset, self.full, region)?;
        self.moved.take_out(&picture, &mut origin)?;
        take_out_pieces(&self.gone, self.full, region, &mut origin)?;
        Ok(Part { picture, origin, weight: self.weight })
    }

    /// The shadow beside the hole.
    fn shadow(&self, loaded: &Loaded, params: &InpaintParams) -> opencv::Result<Option<Shadow>> {
        let scale = loaded.view.scale;
        let (hole, object) = (scale.shrink(&loaded.hole)?, scale.shrink(&loaded.core)?);
        let ground = Ground {
            frame: &loaded.view.colour,
            plate: &self.colour,
            shown: &self.shown,
            hole: &hole,
            object: &object,
        };
        cast_shadow(&ground, scale, params)
    }
}

/// The background inside `region` as 32-bit colours, from all parts, which differ beyond light by more than `limit`
/// levels where they show different states of the scene; gaps are closed smoothly.
fn mixed(
    loaded: &Loaded,
    region: Rect,
    hole: &Mat,
    (parts, limit): (&[Part], f32),
    inside_template: &dyn Fn(i32, i32) -> bool,
) -> opencv::Result<(Vec<[f32; 3]>, FrameCoverage)> {
    let own = Mat::roi(&loaded.picture, region)?.try_clone()?;
    let (own, hole) = (own.data_typed::<Vec3b>()?, hole.data_typed::<u8>()?);
    let mut sources = Vec::new();
    for part in parts {
        sources.push((part.picture.data_typed::<Vec3b>()?, part.origin.data_typed::<u8>()?, part.weight));
    }
    let mut colours = vec![[0.0_f32; 3]; own.len()];
    let mut weights = vec![1.0_f32; own.len()];
    let (mut total, mut seen, mut hidden) = (0_u64, 0_u64, 0_u64);
    for (i, colour) in colours.iter_mut().enumerate() {
        let best = sources.iter().map(|(_, origin, _)| origin[i]).max().unwrap_or(0);
        let (mut sum, mut all) = ([0.0_f32; 3], 0.0_f32);
        // What was seen wins over what was made up.
        let usable = |origin: &[u8]| origin[i] == best && best >= SYNTHESISED;
        let heaviest = sources.iter().filter(|(_, origin, _)| usable(origin)).fold(
            None,
            |heaviest: Option<(Vec3b, f32)>, (picture, _, weight)| match heaviest {
                Some((_, most)) if most >= *weight => heaviest,
                _ => Some((picture[i], *weight)),
            },
        );
        for (picture, origin, weight) in &sources {
            // Two states of the scene are never blended: a thing stands at one place or the other.
            let alike = |heaviest: &(Vec3b, f32)| !differs(picture[i].0, heaviest.0.0, limit);
            if usable(origin) && heaviest.as_ref().is_some_and(alike) {
                for (sum, value) in sum.iter_mut().zip(picture[i].0) {
                    *sum += weight * f32::from(value);
                }
                all += weight;
            }
        }
        if all > 0.0 {
            *colour = sum.map(|value| value / all);
        } else if hole[i] == 0 {
            *colour = own[i].0.map(f32::from);
        } else {
            weights[i] = 0.0;
        }
        if hole[i] != 0 {
            total += 1;
            if best == SEEN {
                seen += 1;
            } else if inside_template(i as i32 % region.width, i as i32 / region.width) {
                hidden += 1;
            }
        }
    }
    fill_smoothly(&mut colours, &weights, region.width as usize, region.height as usize);
    let share = |count: u64| if total > 0 { count as f64 / total as f64 } else { 0.0 };
    let coverage = FrameCoverage {
        hole: total,
        seen: share(seen),
        synthesised: share(total - seen - hidden),
        behind_template: share(hidden),
    };
    Ok((colours, coverage))
}
