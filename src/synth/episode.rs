//! Reading an episode back.

use std::{
    fs,
    path::{Path, PathBuf},
};

use super::{generate::bits, pictures, spec::SynthError, truth::EpisodeTruth};
use crate::{
    clip::FrameIndex,
    geometry::{PerSide, Side},
    image::{Mask, Rgb8, Rgba8},
    landmarks::{HandLandmarks, LandmarkTrack},
};

/// An episode on disk.
#[derive(Clone, Debug)]
pub struct Episode {
    dir: PathBuf,
    /// All that is known beside the pictures.
    pub truth: EpisodeTruth,
}

impl Episode {
    /// Opens the episode in `dir`.
    ///
    /// # Errors
    /// When `truth.json` is missing or damaged.
    pub fn load(dir: &Path) -> Result<Self, SynthError> {
        let path = dir.join("truth.json");
        let bytes = fs::read(&path).map_err(SynthError::io(&path))?;
        let truth = serde_json::from_slice(&bytes).map_err(|error| SynthError::damaged(&path, error))?;
        Ok(Self { dir: dir.to_owned(), truth })
    }

    /// The video.
    pub fn clip_path(&self) -> PathBuf {
        self.dir.join("clip.mp4")
    }

    /// Number of frames.
    pub fn frame_count(&self) -> usize {
        self.truth.frames.len()
    }

    fn picture(&self, index: FrameIndex, what: &str) -> PathBuf {
        self.dir.join("truth").join(format!("{:06}.{what}.png", index.0))
    }

    fn mask(&self, index: FrameIndex, bit: u8) -> Result<Mask, SynthError> {
        let path = self.picture(index, "masks");
        let (size, mut bytes) = pictures::read_png(&path, 1)?;
        for value in &mut bytes {
            *value &= bit;
        }
        if size != self.truth.pinhole.size {
            return Err(SynthError::damaged(path, format!("a picture of {size}")));
        }
        Mask::from_bytes(size, bytes).ok_or_else(|| SynthError::damaged(path, "too short"))
    }

    /// The part of the object that is seen.
    ///
    /// # Errors
    /// When the picture cannot be read, as for all accessors here.
    pub fn object_visible(&self, index: FrameIndex) -> Result<Mask, SynthError> {
        self.mask(index, bits::OBJECT_VISIBLE)
    }

    /// The object's full (amodal) shape inside the picture.
    ///
    /// # Errors
    /// When the picture cannot be read.
    pub fn object_full(&self, index: FrameIndex) -> Result<Mask, SynthError> {
        self.mask(index, bits::OBJECT_FULL)
    }

    /// Both hands with arms and sleeves, as seen.
    ///
    /// # Errors
    /// When the picture cannot be read.
    pub fn hands(&self, index: FrameIndex) -> Result<Mask, SynthError> {
        self.mask(index, bits::LEFT_HAND | bits::RIGHT_HAND)
    }

    /// One hand with its arm and sleeve, as seen.
    ///
    /// # Errors
    /// When the picture cannot be read.
    pub fn hand(&self, index: FrameIndex, side: Side) -> Result<Mask, SynthError> {
        self.mask(index, if side == Side::Left { bits::LEFT_HAND } else { bits::RIGHT_HAND })
    }

    fn crop(&self, index: FrameIndex, what: &str, channels: usize) -> Result<Vec<u8>, SynthError> {
        let path = self.picture(index, what);
        let (crop_size, bytes) = pictures::read_png(&path, channels)?;
        let [x, y, width, height] = self.truth.frames[index.as_usize()].crop.map(|value| value as usize);
        let size = self.truth.pinhole.size;
        if (crop_size.width as usize, crop_size.height as usize) != (width, height) {
            return Err(SynthError::damaged(path, format!("a crop of {crop_size}")));
        }
        let mut whole = vec![0; size.area() * channels];
        for (row, line) in bytes.chunks_exact(width * channels).enumerate() {
            let start = ((y + row) * size.width as usize + x) * channels;
            whole[start..start + line.len()].copy_from_slice(line);
        }
        Ok(whole)
    }

    /// The clean background, without hands, object and their shadows, around hands and object (the crop of the
    /// frame's truth); black elsewhere.
    ///
    /// # Errors
    /// When the picture cannot be read.
    pub fn background(&self, index: FrameIndex) -> Result<Rgb8, SynthError> {
        let whole = self.crop(index, "background", 3)?;
        let path = self.picture(index, "background");
        Rgb8::from_data(self.truth.pinhole.size, whole).ok_or_else(|| SynthError::damaged(path, "too short"))
    }

    /// The whole object alone, straight alpha.
    ///
    /// # Errors
    /// When the picture cannot be read.
    pub fn object(&self, index: FrameIndex) -> Result<Rgba8, SynthError> {
        let whole = self.crop(index, "object", 4)?;
        let path = self.picture(index, "object");
        Rgba8::from_data(self.truth.pinhole.size, whole).ok_or_else(|| SynthError::damaged(path, "too short"))
    }

    /// True landmarks as an estimator would report them: of hands in view, with confidence 1 and no prior.
    pub fn landmarks(&self) -> LandmarkTrack {
        let seen = |hand: &Option<super::HandTruth>| {
            let hand = hand.as_ref().filter(|hand| hand.in_view)?;
            Some(HandLandmarks { keypoints: hand.keypoints, world: None, confidence: 1.0 })
        };
        let frames = self.truth.frames.iter();
        frames.map(|frame| PerSide::from_fn(|side| seen(&frame.hands[side]))).collect()
    }
}
