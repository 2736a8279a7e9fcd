//! Frames as a chat message carries them.

use base64::{Engine as _, engine::general_purpose::STANDARD};
use opencv::{
    core::{BORDER_CONSTANT, Mat, Scalar, Vector, copy_make_border},
    imgcodecs, imgproc,
    prelude::VectorToVec as _,
};

use super::{error::VlmError, letterbox::Letterbox};
use crate::{
    clip::{FrameIndex, FrameSource},
    image::Rgb8,
};

/// JPEG quality: boxes need edges, not grain.
const QUALITY: i32 = 90;

/// `index` in the letterbox as a JPEG in a data address: servers need not be able to fetch anything.
pub(super) fn data_url(
    frames: &dyn FrameSource,
    index: FrameIndex,
    letterbox: &Letterbox,
) -> Result<String, VlmError> {
    let jpeg = jpeg(&frames.frame(index)?, letterbox);
    let jpeg = jpeg.map_err(|source| VlmError::Picture { frame: index, source })?;
    Ok(format!("data:image/jpeg;base64,{}", STANDARD.encode(jpeg)))
}

fn jpeg(frame: &Rgb8, letterbox: &Letterbox) -> opencv::Result<Vec<u8>> {
    let Letterbox { sent, content, .. } = *letterbox;
    let mut scaled = Mat::default();
    let to = opencv::core::Size::new(content.width as i32, content.height as i32);
    let shrinks = content.width < frame.size().width;
    let how = if shrinks { imgproc::INTER_AREA } else { imgproc::INTER_LINEAR };
    imgproc::resize(&frame.to_mat()?, &mut scaled, to, 0.0, 0.0, how)?;
    let (right, bottom) = (sent.width - content.width, sent.height - content.height);
    let (mut filled, mut swapped) = (Mat::default(), Mat::default());
    let black = Scalar::all(0.0);
    copy_make_border(&scaled, &mut filled, 0, bottom as i32, 0, right as i32, BORDER_CONSTANT, black)?;
    imgproc::cvt_color_def(&filled, &mut swapped, imgproc::COLOR_RGB2BGR)?;
    let mut bytes = Vector::<u8>::new();
    let options = Vector::from_slice(&[imgcodecs::IMWRITE_JPEG_QUALITY, QUALITY]);
    imgcodecs::imencode(".jpg", &swapped, &mut bytes, &options)?;
    Ok(bytes.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{clip::FramesInMemory, geometry::Size};

    #[test]
    fn a_frame_is_sent_in_its_colours_with_bars_right_or_below() {
        let size = Size::new(64, 32);
        let mut frame = Rgb8::new(size);
        frame.data_mut().chunks_exact_mut(3).for_each(|pixel| pixel.copy_from_slice(&[200, 100, 20]));
        let frames = FramesInMemory::new(vec![frame]).unwrap();
        let letterbox = Letterbox::new(size);
        let url = data_url(&frames, FrameIndex(0), &letterbox).unwrap();
        let bytes = STANDARD.decode(url.strip_prefix("data:image/jpeg;base64,").unwrap()).unwrap();
        let decoded =
            imgcodecs::imdecode(&Vector::<u8>::from_slice(&bytes), imgcodecs::IMREAD_COLOR).unwrap();
        let mut rgb = Mat::default();
        imgproc::cvt_color_def(&decoded, &mut rgb, imgproc::COLOR_BGR2RGB).unwrap();
        let picture = Rgb8::from_mat(&rgb).unwrap();
        assert_eq!(picture.size(), letterbox.sent);
        let near = |x, y, wanted: [u8; 3]| {
            let found = picture.pixel(x, y);
            assert!(found.iter().zip(wanted).all(|(a, b)| a.abs_diff(b) < 6), "({x}, {y}): {found:?}");
        };
        near(10, 10, [200, 100, 20]);
        near(letterbox.sent.width - 3, letterbox.sent.height - 3, [0, 0, 0]);
    }
}
