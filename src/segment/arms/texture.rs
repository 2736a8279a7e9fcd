//! Whether two pictures show the same texture, whatever the light.

use opencv::{
    core::{Mat, MatTraitConst, MatTraitConstManual},
    imgproc,
};

use crate::vision::box_blurred;

/// How the textures of two pictures compare, judged on every other pixel.
pub(super) struct Likeness {
    cols: usize,
    textures: Vec<Texture>,
}

impl Likeness {
    pub fn of(first: &Mat, second: &Mat) -> opencv::Result<Self> {
        let (rows, cols) = ((first.rows() + 1) / 2, (first.cols() + 1) / 2);
        let light = |lab: &Mat| -> opencv::Result<Vec<u8>> {
            let mut half = Mat::default();
            let size = opencv::core::Size::new(cols, rows);
            imgproc::resize(lab, &mut half, size, 0.0, 0.0, imgproc::INTER_AREA)?;
            Ok(half.data_bytes()?.as_chunks::<3>().0.iter().map(|lab| lab[0]).collect())
        };
        let textures = same_texture(&light(first)?, &light(second)?, (rows, cols))?;
        Ok(Self { cols: cols as usize, textures })
    }

    pub fn at(&self, x: usize, y: usize) -> Texture {
        self.textures[(y / 2) * self.cols + x / 2]
    }
}

/// How two pictures compare within 5×5 pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Texture {
    /// Neither has any.
    Flat,
    /// They vary together (correlation above a half).
    Same,
    Other,
}

fn same_texture(first: &[u8], second: &[u8], (rows, cols): (i32, i32)) -> opencv::Result<Vec<Texture>> {
    let plane = |value: &dyn Fn(usize) -> f32| -> opencv::Result<Mat> {
        let values: Vec<f32> = (0..first.len()).map(value).collect();
        let raw = Mat::new_rows_cols_with_data(rows, cols, &values)?;
        box_blurred(&raw, 5)
    };
    let (a, b) = (|i: usize| f32::from(first[i]), |i: usize| f32::from(second[i]));
    let means = [
        plane(&a)?,
        plane(&b)?,
        plane(&|i| a(i) * a(i))?,
        plane(&|i| b(i) * b(i))?,
        plane(&|i| a(i) * b(i))?,
    ];
    let [ma, mb, maa, mbb, mab] = [0, 1, 2, 3, 4].map(|i: usize| means[i].data_typed::<f32>());
    let (ma, mb, maa, mbb, mab) = (ma?, mb?, maa?, mbb?, mab?);
    let together = |i: usize| {
        let (va, vb) = (maa[i] - ma[i] * ma[i], mbb[i] - mb[i] * mb[i]);
        let covariance = mab[i] - ma[i] * mb[i];
        // Variances below two grey levels are noise.
        if va < 4.0 && vb < 4.0 {
            Texture::Flat
        } else if va >= 4.0 && vb >= 4.0 && covariance > 0.5 * (va * vb).sqrt() {
            Texture::Same
        } else {
            Texture::Other
        }
    };
    Ok((0..first.len()).map(together).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texture_that_shows_through_is_told_from_texture_that_does_not() {
        let stripes = |period: usize, scale: u8| -> Vec<u8> {
            (0..32 * 32)
                .map(|i| if ((i % 32) / period).is_multiple_of(2) { 100 / scale } else { 200 / scale })
                .collect()
        };
        let at_centre = |a: &[u8], b: &[u8]| same_texture(a, b, (32, 32)).unwrap()[16 * 32 + 16];
        assert_eq!(at_centre(&stripes(2, 1), &stripes(2, 2)), Texture::Same);
        assert_eq!(at_centre(&stripes(2, 1), &vec![90; 32 * 32]), Texture::Other);
        assert_eq!(at_centre(&vec![120; 32 * 32], &vec![90; 32 * 32]), Texture::Flat);
    }
}
