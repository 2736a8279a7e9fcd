//! A plate: one key frame with hand and object replaced by what other frames saw there.

use nalgebra::Matrix3;
use opencv::{
    core::{
        CV_8UC1, CV_8UC3, CV_32FC1, Mat, MatTrait, MatTraitConst, MatTraitConstManual, MatTraitManual, Rect,
        Scalar, Vec3b,
    },
    imgproc,
};
use rayon::prelude::*;

use super::{
    InpaintError, InpaintParams, fill,
    gather::{Canvas, choose_sources, needed_cells},
    moved::{MovedColours, moved_pieces},
    network::{ImageNetwork, fill_by_network},
    scene::{Loaded, Scene},
    settle::{MOST_SAMPLES, Sample, Settled, common_factor, is_brighter_within, settled},
    shadow::{LitGround, far_ground, lift},
    survey::{CELL, Survey},
};
use crate::{
    geometry::Size,
    vision::{Registration, View, WorkScale, box_blurred, colour_offset, enlarged_part, scene_change},
};

/// Nothing is known there.
pub(super) const UNKNOWN: u8 = 0;
/// Made up.
pub(super) const SYNTHESISED: u8 = 128;
/// Really seen on some frame.
pub(super) const SEEN: u8 = 255;

/// The background around one key frame.
pub(super) struct Plate {
    /// The key frame.
    pub key: usize,
    /// CV_8UC3, RGB: the frame with a margin on every side.
    pub picture: Mat,
    /// CV_8UC1: [`UNKNOWN`], [`SYNTHESISED`] or [`SEEN`].
    pub origin: Mat,
    /// The plate at work scale; valid where [`SEEN`].
    pub view: View,
    /// By which factor lit ground is brighter than ground in a hand's shadow, if that is known.
    pub shadow: Option<[f32; 3]>,
    /// Margin in full-size pixels.
    pub margin: (i32, i32),
    /// Margin in work pixels.
    pub work_margin: f64,
}

impl Plate {
    /// Takes work pixels of frame `frame` to work pixels of the plate, by the chained camera path.
    pub fn guess_from(&self, survey: &Survey, frame: usize) -> Option<Matrix3<f64>> {
        Some(shift(self.work_margin, self.work_margin) * survey.path.between(frame, self.key)?)
    }

    /// The exact full-size map from a frame whose camera stands where the key frame's stood.
    pub fn still(&self) -> Matrix3<f64> {
        shift(f64::from(self.margin.0), f64::from(self.margin.1))
    }
}

pub(super) fn shift(x: f64, y: f64) -> Matrix3<f64> {
    Matrix3::new(1.0, 0.0, x, 0.0, 1.0, y, 0.0, 0.0, 1.0)
}

/// Builds the plate of `key` for the holes of `frames`; `previous` hands on what it made up, `unseen` makes up what is
/// left, where it is given.
pub(super) fn build(
    scene: &Scene<'_>,
    survey: &Survey,
    key: usize,
    frames: std::ops::Range<usize>,
    previous: Option<&Plate>,
    unseen: Option<&mut ImageNetwork>,
) -> Result<Plate, InpaintError> {
    let params = scene.params;
    let canvas = Canvas::new(survey, params.margin);
    let loaded = scene.load(key)?;
    let mut plate = bare(scene, &canvas, key, &loaded)?;
    let needed = needed_cells(survey, &canvas, key, frames, params);
    let sources = choose_sources(survey, &canvas, key, &needed, params);
    let mut samples = Samples::new(&plate, &canvas, &needed, params)?;
    if let Some(region) = samples.region {
        // Even what the key frame shows is sampled: the hand's shadow may lie on it.
        let own = Drawn {
            picture: Mat::roi(&plate.picture, region)?.try_clone()?,
            valid: Mat::roi(&plate.origin, region)?.try_clone()?,
            far: Mat::default(),
        };
        samples.add(&own, 0)?;
        let still = plate_still(&plate);
        let mut far = far_ground(&plate.view)?;
        for batch in sources.chunks(4) {
            let drawn: Vec<Result<Option<Drawn>, InpaintError>> = batch
                .par_iter()
                .map(|&source| {
                    let Some(path) = survey.path.between(key, source) else { return Ok(None) };
                    let guess = path * shift(-plate.work_margin, -plate.work_margin);
                    let source = scene.load(source)?;
                    draw_source(&plate, &source, &guess, &still, region, params)
                })
                .collect();
            for (drawn, source) in drawn.into_iter().zip(batch) {
                if let Some(drawn) = drawn? {
                    samples.add(&drawn, *source as i32 - key as i32)?;
                    opencv::core::bitwise_or_def(&far.clone(), &drawn.far, &mut far)?;
                }
            }
        }
        let (shadow, both) = samples.settle(&mut plate, params.change_limit)?;
        plate.shadow = shadow.or(previous.and_then(|previous| previous.shadow));
        if let Some(factor) = plate.shadow {
            plate.view = view_of(&plate)?;
            lift(&mut plate, &LitGround { far, both }, factor)?;
        }
        inherit(&mut plate, previous, survey, &samples, region, params)?;
        if let Some(network) = unseen {
            fill_by_network(&mut plate.picture, &mut plate.origin, &samples.needed, network)?;
        }
        fill::fill_unseen(&mut plate.picture, &mut plate.origin, &samples.needed, params)?;
    }
    plate.view = view_of(&plate)?;
    Ok(plate)
}

fn plate_still(plate: &Plate) -> Matrix3<f64> {
    shift(-f64::from(plate.margin.0), -f64::from(plate.margin.1))
}

/// The key frame alone on its canvas.
fn bare(scene: &Scene<'_>, canvas: &Canvas, key: usize, loaded: &Loaded) -> Result<Plate, InpaintError> {
    let work_margin = (canvas.margin * CELL) as f64;
    let (sx, sy) = scene.scale.factors();
    let margin = ((work_margin / sx).round() as i32, (work_margin / sy).round() as i32);
    let full = scene.frames.size();
    let size = Size::new(full.width + 2 * margin.0 as u32, full.height + 2 * margin.1 as u32);
    let work = scene.scale.work;
    let work_size = Size::new(work.width + 2 * work_margin as u32, work.height + 2 * work_margin as u32);
    let scale = WorkScale { full: size, work: work_size };
    let mut picture = bordered(&loaded.picture, margin, opencv::core::BORDER_REPLICATE, 0.0)?;
    let blocked = bordered(&loaded.blocked, margin, opencv::core::BORDER_CONSTANT, 255.0)?;
    let mut origin = Mat::default();
    opencv::core::bitwise_not_def(&blocked, &mut origin)?;
    let view = View::new(scale, &picture, &blocked)?;
    picture.set_to(&Scalar::all(0.0), &blocked)?;
    Ok(Plate { key, picture, origin, view, shadow: None, margin, work_margin })
}

fn bordered(picture: &Mat, margin: (i32, i32), border: i32, value: f64) -> opencv::Result<Mat> {
    let mut out = Mat::default();
    let (x, y) = margin;
    opencv::core::copy_make_border(picture, &mut out, y, y, x, x, border, Scalar::all(value))?;
    Ok(out)
}

fn view_of(plate: &Plate) -> opencv::Result<View> {
    let mut blocked = Mat::default();
    imgproc::threshold(
        &plate.origin,
        &mut blocked,
        f64::from(SEEN) - 1.0,
        255.0,
        imgproc::THRESH_BINARY_INV,
    )?;
    View::new(plate.view.scale, &plate.picture, &blocked)
}

/// A source frame on the plate's grid, inside a region.
struct Drawn {
    /// CV_8UC3, colours matched to the key frame.
    picture: Mat,
    /// CV_8UC1, 255 where it shows the background.
    valid: Mat,
    /// CV_8UC1 on the plate's work grid, 255 where the background was seen far from any hand.
    far: Mat,
}

fn draw_source(
    plate: &Plate,
    source: &Loaded,
    guess: &Matrix3<f64>,
    still: &Matrix3<f64>,
    region: Rect,
    params: &InpaintParams,
) -> Result<Option<Drawn>, InpaintError> {
    let registration = Registration { parallax: params.parallax };
    let Some(warp) = registration.register(&plate.view, &source.view, guess, Some(still))? else {
        return Ok(None);
    };
    let (picture, blocked) =
        warp.draw_with_mask(&source.picture, &source.blocked, region, imgproc::INTER_LINEAR, 255.0)?;
    let mut valid = Mat::default();
    imgproc::threshold(&blocked, &mut valid, 0.0, 255.0, imgproc::THRESH_BINARY_INV)?;
    let (colour, shown) = warp.draw_work(&source.view)?;
    let mut both = Mat::default();
    opencv::core::bitwise_and_def(&shown, &plate.view.valid, &mut both)?;
    let offset = colour_offset(&plate.view.colour, &colour, &both, 32, params.colour_limit)?;
    let picture = with_offset(&picture, &offset, plate.view.scale.full, region)?;
    // Where the scene around the hole has changed since, what lay behind it will have changed too.
    let work = plate.view.scale.work;
    let whole = Rect::new(0, 0, work.width as i32, work.height as i32);
    let colour = with_offset(&colour, &offset, work, whole)?;
    let change = scene_change(&plate.view.colour, &colour, &both, 4, params.change_limit)?;
    let change = enlarged_part(&change, plate.view.scale.full, region)?;
    let mut changed = Mat::default();
    opencv::core::compare(&change, &Scalar::all(0.5), &mut changed, opencv::core::CMP_GT)?;
    valid.set_to(&Scalar::all(0.0), &changed)?;
    let moved = MovedColours::between(&plate.view, &colour, &both, params.change_limit)?;
    moved.take_out(&picture, &mut valid)?;
    let pieces = moved_pieces(&plate.view, &colour, &both, params.change_limit)?;
    take_out_pieces(&pieces, plate.view.scale.full, region, &mut valid)?;
    let far = warp.draw_work_mask(&far_ground(&source.view)?, source.view.scale)?;
    Ok(Some(Drawn { picture, valid, far }))
}

/// Clears `known`, the part `region` of a picture of size `full`, where `pieces` (work size) are.
pub(super) fn take_out_pieces(pieces: &Mat, full: Size, region: Rect, known: &mut Mat) -> opencv::Result<()> {
    if opencv::core::count_non_zero(pieces)? == 0 {
        return Ok(());
    }
    let (wide, mut gone) = (enlarged_part(pieces, full, region)?, Mat::default());
    opencv::core::compare(&wide, &Scalar::all(127.0), &mut gone, opencv::core::CMP_GT)?;
    known.set_to(&Scalar::all(0.0), &gone)?;
    Ok(())
}

/// `picture`, the part `region` of a picture of size `full`, plus a coarse map of offsets.
pub(super) fn with_offset(picture: &Mat, offset: &Mat, full: Size, region: Rect) -> opencv::Result<Mat> {
    let (wide, mut sum) = (enlarged_part(offset, full, region)?, Mat::default());
    opencv::core::add(picture, &wide, &mut sum, &opencv::core::no_array(), CV_8UC3)?;
    Ok(sum)
}

/// What to add to `colour`, a plate on `target`'s work grid and `shown` there, so that its colours match
/// closely: differences along the hole's rim are carried smoothly into it.
pub(super) fn close_offset(
    target: &View,
    colour: &Mat,
    shown: &Mat,
    params: &InpaintParams,
) -> opencv::Result<Mat> {
    let mut valid = Mat::default();
    opencv::core::bitwise_and_def(shown, &target.valid, &mut valid)?;
    colour_offset(&target.colour, colour, &valid, 8, params.colour_limit)
}

/// Samples of the pixels that the key frame does not show.
struct Samples {
    /// The box around them on the canvas.
    region: Option<Rect>,
    /// CV_8UC1 on the canvas: 255 where samples are wanted.
    needed: Mat,
    /// Indices of those pixels within the region, row after row.
    pixels: Vec<u32>,
    /// `limit` slots a pixel.
    colours: Vec<Sample>,
    /// When each source was, frames after the key frame.
    times: Vec<i32>,
    filled: Vec<u8>,
    limit: usize,
}

impl Samples {
    fn new(plate: &Plate, canvas: &Canvas, cells: &[bool], params: &InpaintParams) -> opencv::Result<Self> {
        let bytes: Vec<u8> = cells.iter().map(|needed| if *needed { 255 } else { 0 }).collect();
        let coarse = Mat::new_rows_cols_with_data(canvas.rows as i32, canvas.columns as i32, &bytes)?;
        let mut needed = Mat::default();
        imgproc::resize(&coarse, &mut needed, plate.picture.size()?, 0.0, 0.0, imgproc::INTER_NEAREST)?;
        let bounds = imgproc::bounding_rect(&needed)?;
        let region = (bounds.width > 0 && bounds.height > 0).then_some(bounds);
        let limit = params.samples.clamp(1, MOST_SAMPLES);
        let mut pixels = Vec::new();
        if let Some(region) = region {
            let part = Mat::roi(&needed, region)?.try_clone()?;
            let inside = part.data_typed::<u8>()?.iter().enumerate().filter(|(_, v)| **v != 0);
            pixels = inside.map(|(index, _)| index as u32).collect();
        }
        let count = pixels.len();
        Ok(Self {
            region,
            needed,
            pixels,
            colours: vec![Sample::default(); count * limit],
            times: Vec::new(),
            filled: vec![0; count],
            limit,
        })
    }

    /// Adds what the frame `time` frames after the key frame shows.
    fn add(&mut self, drawn: &Drawn, time: i32) -> opencv::Result<()> {
        // A plate reads `max_sources` frames, far fewer than a byte counts; any more would only be left out.
        let Ok(source) = u8::try_from(self.times.len()) else { return Ok(()) };
        self.times.push(time);
        let (colours, valid) = (drawn.picture.data_typed::<Vec3b>()?, drawn.valid.data_typed::<u8>()?);
        for (i, pixel) in self.pixels.iter().enumerate() {
            let filled = self.filled[i] as usize;
            if filled < self.limit && valid[*pixel as usize] != 0 {
                self.colours[i * self.limit + filled] = Sample { colour: colours[*pixel as usize].0, source };
                self.filled[i] += 1;
            }
        }
        Ok(())
    }

    /// Writes robust colours onto the plate. Returns by which factor lit ground is brighter than shadowed
    /// ground, where enough pixels were seen both ways.
    fn settle(&self, plate: &mut Plate, limit: f32) -> opencv::Result<(Option<[f32; 3]>, Mat)> {
        let mut both = Mat::default();
        let Some(region) = self.region else { return Ok((None, both)) };
        let columns = plate.picture.cols() as usize;
        let settled: Vec<Settled> = (0..self.pixels.len())
            .into_par_iter()
            .map(|i| {
                let start = i * self.limit;
                let samples = &self.colours[start..start + self.filled[i] as usize];
                settled(samples, &self.times, limit)
            })
            .collect();
        let lit = self.agreed(region, &settled, &|settled| settled.lit.is_some())?;
        let ever_lit =
            self.agreed(region, &settled, &|settled| settled.lit.is_some() || settled.once.is_some())?;
        let shadowed = self.agreed(region, &settled, &|settled| settled.shadow.is_some())?;
        let mut ratios: [Vec<f32>; 3] = std::array::from_fn(|_| Vec::new());
        let zero = Scalar::all(0.0);
        let mut seen_both = Mat::new_size_with_default(plate.picture.size()?, CV_8UC1, zero)?;
        let flags = seen_both.data_typed_mut::<u8>()?;
        let picture = plate.picture.data_typed_mut::<Vec3b>()?;
        let origin = plate.origin.data_typed_mut::<u8>()?;
        let place = |pixel: u32| {
            let (x, y) = (pixel as usize % region.width as usize, pixel as usize / region.width as usize);
            (region.y as usize + y) * columns + region.x as usize + x
        };
        for (i, pixel) in self.pixels.iter().enumerate() {
            if self.filled[i] == 0 {
                continue;
            }
            let at = place(*pixel);
            let colour = match settled[i].lit {
                Some(lit_colour) if lit[*pixel as usize] > 0.4 => lit_colour,
                _ => settled[i].usual,
            };
            if let Some(factor) = settled[i].shadow.filter(|_| shadowed[*pixel as usize] > 0.9) {
                for (ratios, factor) in ratios.iter_mut().zip(factor) {
                    ratios.push(factor);
                }
            }
            picture[at] = Vec3b::from(colour);
            origin[at] = SEEN;
            if settled[i].lit.is_some() || settled[i].shadow.is_some() {
                flags[at] = 255;
            }
        }
        let factor = common_factor(ratios, (self.pixels.len() / 200).max(100));
        for (i, pixel) in self.pixels.iter().enumerate() {
            if let (Some(factor), Some(once)) = (factor, settled[i].once)
                && ever_lit[*pixel as usize] > 0.4
                && is_brighter_within(once, settled[i].usual, factor)
            {
                picture[place(*pixel)] = Vec3b::from(once);
            }
        }
        // Single lines of pixels are edges that did not register, not shadows.
        let sizeable = super::hole::grown(&plate.view.scale.shrink_mask(&seen_both)?, -1)?;
        both = super::hole::grown(&sizeable, 1)?;
        Ok((factor, both))
    }

    /// Share of pixels around each pixel of the region for which `holds`: a shadow is never one pixel.
    fn agreed(
        &self,
        region: Rect,
        settled: &[Settled],
        holds: &dyn Fn(&Settled) -> bool,
    ) -> opencv::Result<Vec<f32>> {
        let zero = Scalar::all(0.0);
        let mut lit = Mat::new_rows_cols_with_default(region.height, region.width, CV_32FC1, zero)?;
        let mut known = lit.try_clone()?;
        {
            let (lit, known) = (lit.data_typed_mut::<f32>()?, known.data_typed_mut::<f32>()?);
            for ((pixel, settled), filled) in self.pixels.iter().zip(settled).zip(&self.filled) {
                known[*pixel as usize] = if *filled > 0 { 1.0 } else { 0.0 };
                lit[*pixel as usize] = if holds(settled) { 1.0 } else { 0.0 };
            }
        }
        let (lit, known) = (box_blurred(&lit, 9)?, box_blurred(&known, 9)?);
        let pairs = lit.data_typed::<f32>()?.iter().zip(known.data_typed::<f32>()?);
        Ok(pairs.map(|(lit, known)| if *known > 0.0 { lit / known } else { 0.0 }).collect())
    }
}

/// Takes over what the previous plate knew or made up where no source showed anything.
fn inherit(
    plate: &mut Plate,
    previous: Option<&Plate>,
    survey: &Survey,
    samples: &Samples,
    region: Rect,
    params: &InpaintParams,
) -> Result<(), InpaintError> {
    let Some(previous) = previous else { return Ok(()) };
    if samples.filled.iter().all(|filled| *filled > 0) {
        return Ok(());
    }
    let Some(path) = previous.guess_from(survey, plate.key) else { return Ok(()) };
    let guess = path * shift(-plate.work_margin, -plate.work_margin);
    let registration = Registration { parallax: params.parallax };
    let still = Matrix3::identity();
    let Some(warp) = registration.register(&plate.view, &previous.view, &guess, Some(&still))? else {
        return Ok(());
    };
    let (picture, origin) =
        warp.draw_with_mask(&previous.picture, &previous.origin, region, imgproc::INTER_NEAREST, 0.0)?;
    let (colour, shown) = warp.draw_work(&previous.view)?;
    let mut both = Mat::default();
    opencv::core::bitwise_and_def(&shown, &plate.view.valid, &mut both)?;
    let moved = MovedColours::between(&plate.view, &colour, &both, params.change_limit)?;
    let columns = plate.picture.cols() as usize;
    let (colours, kinds) = (picture.data_typed::<Vec3b>()?, origin.data_typed::<u8>()?);
    let (to, to_origin) = (plate.picture.data_typed_mut::<Vec3b>()?, plate.origin.data_typed_mut::<u8>()?);
    for (pixel, filled) in samples.pixels.iter().zip(&samples.filled) {
        let pixel = *pixel as usize;
        if *filled == 0 && kinds[pixel] != UNKNOWN && !moved.contains(colours[pixel].0) {
            let (x, y) = (pixel % region.width as usize, pixel / region.width as usize);
            let at = (region.y as usize + y) * columns + region.x as usize + x;
            to[at] = colours[pixel];
            to_origin[at] = kinds[pixel];
        }
    }
    Ok(())
}
