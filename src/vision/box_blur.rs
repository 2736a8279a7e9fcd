use opencv::{
    core::{BORDER_REPLICATE, Mat, Point, Size, ToInputArray},
    imgproc,
};

/// The mean over windows of `side` × `side` pixels of a picture of any kind; beyond its border the picture goes on
/// as it ends.
///
/// # Errors
/// When OpenCV fails.
pub fn box_blurred(picture: &impl ToInputArray, side: i32) -> opencv::Result<Mat> {
    let mut mean = Mat::default();
    imgproc::blur(picture, &mut mean, Size::new(side, side), Point::new(-1, -1), BORDER_REPLICATE)?;
    Ok(mean)
}
