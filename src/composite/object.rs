//! The object layer: its own pixels where the source shows them, the template where a hand hid them.

use nalgebra::{Matrix3, Vector3};
use opencv::{
    core::{
        BORDER_CONSTANT, CV_32FC1, CV_32FC4, Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Rect,
        Scalar, Size as CvSize, Vec4f,
    },
    imgproc,
};

use super::{CompositeError, CompositeParams, compositor::check};
use crate::{
    geometry::Size,
    image::{Mask, Rgb8, Rgba8},
    template::{Placement, TemplateTrack},
    vision::{BackgroundMotion, binary, box_blurred, fill_smoothly},
};

/// Share of a template's open pixels that have to look like the source's.
const ALIKE: f64 = 0.6;

/// What is known of the object on one frame.
#[derive(Clone, Copy, Debug)]
pub struct ObjectEvidence<'a> {
    /// The whole object.
    pub template: &'a TemplateTrack,
    /// Where it goes; `None` draws its visible pixels alone.
    pub placement: Option<&'a Placement>,
    /// The source frame.
    pub source: &'a Rgb8,
    /// The object's visible part in the source; `None` where that mask is not to be trusted. The
    /// template is drawn whole then if the source shows it there, else only where a hand hid things.
    pub visible: Option<&'a Mask>,
    /// What hid it: the arm mask.
    pub hidden: &'a Mask,
}

/// The object as it is drawn, inside a box of the frame.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectLayer {
    /// Left and top of the box on the frame.
    pub origin: (u32, u32),
    /// Size of the box.
    pub size: Size,
    /// Colours multiplied by alpha, 0 to 255, and alpha, 0 to 1, row after row.
    premultiplied: Vec<[f32; 4]>,
}

impl ObjectLayer {
    /// Draws the layer over `picture`.
    pub fn draw_over(&self, picture: &mut Rgb8) {
        let columns = picture.size().width as usize;
        let width = self.size.width as usize;
        let data = picture.data_mut();
        for (i, [r, g, b, alpha]) in self.premultiplied.iter().enumerate().filter(|(_, p)| p[3] > 0.0) {
            let (x, y) = (self.origin.0 as usize + i % width, self.origin.1 as usize + i / width);
            let at = (y * columns + x) * 3;
            for (value, colour) in data[at..at + 3].iter_mut().zip([r, g, b]) {
                *value = (f32::from(*value) * (1.0 - alpha) + colour).round().clamp(0.0, 255.0) as u8;
            }
        }
    }

    /// The layer as a picture of the frame's `size` with straight alpha.
    pub fn to_rgba(&self, size: Size) -> Rgba8 {
        let mut picture = Rgba8::new(size);
        for (i, [r, g, b, alpha]) in self.premultiplied.iter().enumerate().filter(|(_, p)| p[3] > 0.0) {
            let (x, y) = (i as u32 % self.size.width, i as u32 / self.size.width);
            let straight = [r, g, b].map(|v| (v / alpha).round().clamp(0.0, 255.0) as u8);
            let opacity = (alpha * 255.0).round().clamp(0.0, 255.0) as u8;
            let pixel = [straight[0], straight[1], straight[2], opacity];
            picture.set_pixel(self.origin.0 + x, self.origin.1 + y, pixel);
        }
        picture
    }
}

/// The template's shape at its placement: where its alpha is at least one half.
///
/// # Errors
/// When the placement is singular or OpenCV fails.
pub fn placed_shape(
    template: &TemplateTrack,
    placement: &Placement,
    size: Size,
) -> Result<Mask, CompositeError> {
    let mut shape = Mask::new(size);
    let Some(region) = placed_region(template, placement, size) else { return Ok(shape) };
    let warped = warped_template(template, placement, region)?;
    for (i, pixel) in warped.data_typed::<Vec4f>()?.iter().enumerate().filter(|(_, pixel)| pixel[3] >= 0.5) {
        let (x, y) = (i as i32 % region.width, i as i32 / region.width);
        debug_assert!(pixel[3] <= 1.01);
        shape.set((region.x + x) as u32, (region.y + y) as u32, true);
    }
    Ok(shape)
}

pub(super) fn object_layer(
    evidence: &ObjectEvidence<'_>,
    size: Size,
    params: &CompositeParams,
) -> Result<Option<ObjectLayer>, CompositeError> {
    check("the source frame", size, evidence.source.size())?;
    check("the arm mask", size, evidence.hidden.size())?;
    if let Some(visible) = evidence.visible {
        check("the object mask", size, visible.size())?;
    }
    let placement = evidence.placement.filter(|placement| placement.confidence >= params.least_confidence);
    let placed = placement.and_then(|placement| placed_region(evidence.template, placement, size));
    // A little wider than the mask, so that its softened edge ends inside.
    let frame = Rect::new(0, 0, size.width as i32, size.height as i32);
    let seen = evidence.visible.and_then(Mask::bounding_box).map(|b| b.grown(2.0));
    let seen = seen.map(|b| Rect::new(b.x0 as i32, b.y0 as i32, b.width() as i32, b.height() as i32) & frame);
    let Some(region) = [placed, seen].into_iter().flatten().reduce(|a, b| a | b) else { return Ok(None) };
    let feather = ((params.feather * f64::from(size.width)).round() as i32).max(1);
    let template = match placement.filter(|_| placed.is_some()) {
        Some(placement) => Some(warped_template(evidence.template, placement, region)?),
        None => None,
    };
    let own = own_alpha(evidence, region)?;
    let mut hidden = hidden_alpha(evidence, region, feather)?;
    if evidence.visible.is_none() && shows(evidence.source, region, template.as_ref(), &hidden, params)? {
        hidden.fill(1.0);
    }
    let premultiplied = mixed(evidence.source, region, template.as_ref(), &own, &hidden, params)?;
    let origin = (region.x as u32, region.y as u32);
    Ok(Some(ObjectLayer {
        origin,
        size: Size::new(region.width as u32, region.height as u32),
        premultiplied,
    }))
}

/// The box of the placed template on the frame; `None` when it lies outside.
fn placed_region(template: &TemplateTrack, placement: &Placement, size: Size) -> Option<Rect> {
    let (right, bottom) =
        (f64::from(template.picture.size().width) - 0.5, f64::from(template.picture.size().height) - 0.5);
    let (mut low, mut high) = ((f64::MAX, f64::MAX), (f64::MIN, f64::MIN));
    for (x, y) in [(-0.5, -0.5), (right, -0.5), (-0.5, bottom), (right, bottom)] {
        let p = placement.transform * Vector3::new(x, y, 1.0);
        let (x, y) = (p.x / p.z, p.y / p.z);
        if p.z <= 1e-9 || !x.is_finite() || !y.is_finite() {
            return None;
        }
        low = (low.0.min(x), low.1.min(y));
        high = (high.0.max(x), high.1.max(y));
    }
    let clamp = |v: f64, most: u32| v.clamp(0.0, f64::from(most)) as i32;
    let (x0, y0) = (clamp((low.0 - 1.0).floor(), size.width), clamp((low.1 - 1.0).floor(), size.height));
    let (x1, y1) = (clamp((high.0 + 2.0).ceil(), size.width), clamp((high.1 + 2.0).ceil(), size.height));
    (x1 > x0 && y1 > y0).then(|| Rect::new(x0, y0, x1 - x0, y1 - y0))
}

/// The template on the frame's grid inside `region`: CV_32FC4, colours multiplied by alpha, alpha 0 to 1.
/// Multiplying first keeps the colour of transparent pixels out of the edge.
fn warped_template(
    template: &TemplateTrack,
    placement: &Placement,
    region: Rect,
) -> Result<Mat, CompositeError> {
    let size = template.picture.size();
    let zero = Scalar::all(0.0);
    let mut premultiplied =
        Mat::new_rows_cols_with_default(size.height as i32, size.width as i32, CV_32FC4, zero)?;
    for (to, [r, g, b, a]) in
        premultiplied.data_typed_mut::<Vec4f>()?.iter_mut().zip(template.picture.pixels())
    {
        let alpha = f32::from(*a) / 255.0;
        *to = Vec4f::from([f32::from(*r) * alpha, f32::from(*g) * alpha, f32::from(*b) * alpha, alpha]);
    }
    let inverse = placement.transform.try_inverse().ok_or(CompositeError::Placement)?;
    let offset = Matrix3::new(1.0, 0.0, f64::from(region.x), 0.0, 1.0, f64::from(region.y), 0.0, 0.0, 1.0);
    let map = BackgroundMotion::known(inverse * offset);
    let flags = imgproc::INTER_LINEAR | imgproc::WARP_INVERSE_MAP;
    let target = CvSize::new(region.width, region.height);
    let mut warped = Mat::default();
    imgproc::warp_perspective(
        &premultiplied,
        &mut warped,
        &map.to_mat()?,
        target,
        flags,
        BORDER_CONSTANT,
        zero,
    )?;
    Ok(warped)
}

/// Alpha of the object's own pixels: its visible mask, softened inwards so that no background comes along.
fn own_alpha(evidence: &ObjectEvidence<'_>, region: Rect) -> Result<Vec<f32>, CompositeError> {
    let Some(visible) = evidence.visible else { return Ok(vec![0.0; region.area() as usize]) };
    let soft = softened(&Mat::roi(&visible.to_mat()?, region)?.try_clone()?, 1)?;
    Ok(soft.iter().map(|value| ((value - 0.35) / 0.6).clamp(0.0, 1.0)).collect())
}

/// How far the template stands in: 1 where a hand hid the object, falling to 0 beside it.
fn hidden_alpha(
    evidence: &ObjectEvidence<'_>,
    region: Rect,
    feather: i32,
) -> Result<Vec<f32>, CompositeError> {
    let hidden = Mat::roi(&evidence.hidden.to_mat()?, region)?.try_clone()?;
    let wide = binary::dilated(&hidden, feather + 2)?;
    softened(&wide, feather)
}

/// Whether the source, where no hand is in the way, looks like the template placed there: else the object is
/// somewhere else, and a template drawn whole would be a second one.
fn shows(
    source: &Rgb8,
    region: Rect,
    template: Option<&Mat>,
    hidden: &[f32],
    params: &CompositeParams,
) -> Result<bool, CompositeError> {
    let Some(template) = template else { return Ok(false) };
    let width = region.width as usize;
    let (mut open, mut alike) = (0_usize, 0_usize);
    for (i, t) in template.data_typed::<Vec4f>()?.iter().enumerate() {
        if t[3] > 0.98 && hidden[i] < 0.02 {
            let (x, y) = (region.x as usize + i % width, region.y as usize + i / width);
            let colour = source.pixel(x as u32, y as u32).map(f32::from);
            open += 1;
            alike += usize::from((0..3).all(|c| (colour[c] - t[c]).abs() <= params.colour_limit));
        }
    }
    Ok(alike as f64 >= ALIKE * open as f64)
}

fn softened(mask: &Mat, radius: i32) -> Result<Vec<f32>, CompositeError> {
    let mut values = Mat::default();
    mask.convert_to(&mut values, CV_32FC1, 1.0 / 255.0, 0.0)?;
    Ok(box_blurred(&values, 2 * radius + 1)?.data_typed::<f32>()?.to_vec())
}

/// `own (1 − hidden) source + hidden template`, the template's colours moved towards the source's.
fn mixed(
    source: &Rgb8,
    region: Rect,
    template: Option<&Mat>,
    own: &[f32],
    hidden: &[f32],
    params: &CompositeParams,
) -> Result<Vec<[f32; 4]>, CompositeError> {
    let nothing = Vec::new();
    let template = match template {
        Some(template) => template.data_typed::<Vec4f>()?,
        None => &nothing,
    };
    let width = region.width as usize;
    let pixel = |i: usize| {
        let (x, y) = (region.x as usize + i % width, region.y as usize + i / width);
        source.pixel(x as u32, y as u32).map(f32::from)
    };
    let offset = ColourOffset::measure(template, own, hidden, &pixel, region, params.colour_limit);
    let mut out = Vec::with_capacity(own.len());
    for i in 0..own.len() {
        let real = own[i] * (1.0 - hidden[i]);
        let mut mixed = [0.0_f32; 4];
        if real > 0.0 {
            let colour = pixel(i);
            mixed = [real * colour[0], real * colour[1], real * colour[2], real];
        }
        if let Some(t) = template.get(i).filter(|t| t[3] > 0.0 && hidden[i] > 0.0) {
            let (alpha, add) = (hidden[i] * t[3], offset.at(i % width, i / width));
            for channel in 0..3 {
                mixed[channel] += hidden[i] * (t[channel] + t[3] * add[channel]).clamp(0.0, 255.0 * t[3]);
            }
            mixed[3] += alpha;
        }
        out.push(mixed);
    }
    Ok(out)
}

/// What to add to the template's colours so that they meet the visible object's, varying slowly.
struct ColourOffset {
    columns: usize,
    rows: usize,
    cells: Vec<[f32; 3]>,
}

/// Side of a cell of [`ColourOffset`], pixels.
const CELL: usize = 8;

impl ColourOffset {
    fn measure(
        template: &[Vec4f],
        own: &[f32],
        hidden: &[f32],
        source: &dyn Fn(usize) -> [f32; 3],
        region: Rect,
        limit: f32,
    ) -> Self {
        let (width, height) = (region.width as usize, region.height as usize);
        let (columns, rows) = (width.div_ceil(CELL), height.div_ceil(CELL));
        let mut sums = vec![[0.0_f32; 3]; columns * rows];
        let mut counts = vec![0.0_f32; columns * rows];
        for (i, t) in template.iter().enumerate() {
            if own[i] > 0.98 && hidden[i] < 0.02 && t[3] > 0.98 {
                let colour = source(i);
                let difference = [0, 1, 2].map(|c| colour[c] - t[c] / t[3]);
                if difference.iter().all(|d| d.abs() <= limit) {
                    let cell = (i / width / CELL) * columns + i % width / CELL;
                    counts[cell] += 1.0;
                    for (sum, d) in sums[cell].iter_mut().zip(difference) {
                        *sum += d;
                    }
                }
            }
        }
        for (sum, count) in sums.iter_mut().zip(&mut counts) {
            if *count > 0.0 {
                *sum = sum.map(|value| value / *count);
            }
            // A few pixels say little: cells with half their pixels or more count fully.
            *count = (*count / (CELL * CELL / 2) as f32).min(1.0);
        }
        fill_smoothly(&mut sums, &counts, columns, rows);
        Self { columns, rows, cells: sums }
    }

    fn at(&self, x: usize, y: usize) -> [f32; 3] {
        let split = |fine: usize, length: usize| {
            let at = ((fine as f32 + 0.5) / CELL as f32 - 0.5).clamp(0.0, (length - 1) as f32);
            (at as usize, (at as usize + 1).min(length - 1), at - at.floor())
        };
        let ((x0, x1, fx), (y0, y1, fy)) = (split(x, self.columns), split(y, self.rows));
        let cell = |x: usize, y: usize| self.cells[y * self.columns + x];
        let (a, b, c, d) = (cell(x0, y0), cell(x1, y0), cell(x0, y1), cell(x1, y1));
        std::array::from_fn(|i| {
            let (top, bottom) = (a[i] + (b[i] - a[i]) * fx, c[i] + (d[i] - c[i]) * fx);
            top + (bottom - top) * fy
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clip::FrameIndex;

    const SIZE: Size = Size::new(80, 60);
    const RED: [u8; 3] = [200, 30, 30];

    /// A red 40×40 object whose right half a hand hides; the template is a little darker than the source.
    fn layer(visible: bool, colour: [u8; 3]) -> ObjectLayer {
        let size = Size::new(40, 40);
        let template = TemplateTrack {
            picture: Rgba8::from_data(size, [180, 20, 20, 255].repeat(size.area())).unwrap(),
            origin: (0, 0),
            frame: FrameIndex(0),
            placements: Vec::new(),
            scores: Vec::new(),
        };
        let mut transform = Matrix3::identity();
        (transform[(0, 2)], transform[(1, 2)]) = (20.0, 10.0);
        let placement = Placement { transform, confidence: 0.9, visible: 0.5 };
        let inside = |x: u32, y: u32| (20..60).contains(&x) && (10..50).contains(&y);
        let hand = Mask::from_fn(SIZE, |x, _| x >= 40);
        let seen = Mask::from_fn(SIZE, |x, y| inside(x, y) && x < 40);
        let mut source = Rgb8::new(SIZE);
        for y in 0..SIZE.height {
            for x in 0..SIZE.width {
                let own = if inside(x, y) { colour } else { [0, 90, 0] };
                source.set_pixel(x, y, if x >= 40 { [220, 170, 140] } else { own });
            }
        }
        let evidence = ObjectEvidence {
            template: &template,
            placement: Some(&placement),
            source: &source,
            visible: visible.then_some(&seen),
            hidden: &hand,
        };
        object_layer(&evidence, SIZE, &CompositeParams::default()).unwrap().unwrap()
    }

    #[test]
    fn the_hidden_half_takes_the_light_of_the_visible_half_and_no_skin_shows() {
        let picture = layer(true, RED).to_rgba(SIZE);
        for x in 22..58 {
            let [r, g, b, a] = picture.pixel(x, 30);
            assert!(
                r.abs_diff(200) <= 2 && g.abs_diff(30) <= 2 && b.abs_diff(30) <= 2 && a >= 254,
                "column {x}"
            );
        }
        assert_eq!(picture.pixel(70, 30)[3], 0);
    }

    #[test]
    fn without_a_trusted_mask_the_template_is_drawn_whole_only_where_the_source_shows_it() {
        assert_eq!(layer(false, RED).to_rgba(SIZE).pixel(30, 30), [180, 20, 20, 255]);
        let elsewhere = layer(false, [0, 90, 0]).to_rgba(SIZE);
        assert_eq!(elsewhere.pixel(25, 30)[3], 0);
        assert_eq!(elsewhere.pixel(50, 30), [180, 20, 20, 255]);
    }
}
