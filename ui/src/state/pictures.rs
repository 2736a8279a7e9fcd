//! Pictures from the engine: asked for once, kept for a while, the latest one shown meanwhile.

use std::{collections::VecDeque, sync::Arc};

use agenticfocus::{
    clip::FrameIndex,
    engine::{Layers, OrbitCamera, PictureKind, PictureRequest, Revision, Shown},
    geometry::Size,
    image::Rgb8,
};

/// Source frames kept: about 75 MiB at 640×480, bounded by bytes at other sizes.
const KEPT_BYTES: usize = 96 << 20;

/// What the engine sent, and what is still wanted.
#[derive(Debug, Default)]
pub struct Pictures {
    sources: VecDeque<(FrameIndex, Arc<Rgb8>)>,
    source_bytes: usize,
    composite: Option<(FrameIndex, Revision, Arc<Layers>)>,
    orbit: Option<Arc<Rgb8>>,
    thumbnails: Vec<Option<Arc<Rgb8>>>,
    asked: Vec<PictureRequest>,
    wishes: Vec<PictureRequest>,
    faults: Vec<(FrameIndex, String)>,
}

impl Pictures {
    /// The frame as filmed; asks for it when it is not here yet.
    pub fn source(&mut self, frame: FrameIndex) -> Option<Arc<Rgb8>> {
        if let Some((_, picture)) = self.sources.iter().find(|(index, _)| *index == frame) {
            return Some(Arc::clone(picture));
        }
        self.want(PictureRequest { frame, kind: PictureKind::Source, revision: Revision(0) });
        None
    }

    /// Whether the frame as filmed is here; asks for nothing.
    pub fn has_source(&self, frame: FrameIndex) -> bool {
        self.sources.iter().any(|(index, _)| *index == frame)
    }

    /// Whether the finished frame for that very document is here; asks for nothing.
    pub fn has_composite(&self, frame: FrameIndex, revision: Revision) -> bool {
        self.composite.as_ref().is_some_and(|(at, made, _)| (*at, *made) == (frame, revision))
    }

    /// The newest source picture at or near `frame`, to show while the right one comes.
    pub fn nearest_source(&self, frame: FrameIndex) -> Option<Arc<Rgb8>> {
        let near = |index: &FrameIndex| index.0.abs_diff(frame.0);
        self.sources.iter().min_by_key(|(index, _)| near(index)).map(|(_, picture)| Arc::clone(picture))
    }

    /// The finished frame with its layers, and whether it is the one for this very document; asks for it otherwise.
    pub fn composite(&mut self, frame: FrameIndex, revision: Revision) -> Option<(Arc<Layers>, bool)> {
        let exact = self.composite.as_ref().is_some_and(|(at, made, _)| (*at, *made) == (frame, revision));
        if !exact {
            self.want(PictureRequest { frame, kind: PictureKind::Composite, revision });
        }
        self.composite.as_ref().map(|(_, _, layers)| (Arc::clone(layers), exact))
    }

    /// The robot from outside; asks anew whenever something about it changed.
    pub fn orbit(
        &mut self,
        frame: FrameIndex,
        revision: Revision,
        camera: OrbitCamera,
        size: Size,
    ) -> Option<Arc<Rgb8>> {
        self.want(PictureRequest { frame, kind: PictureKind::Orbit { camera, size }, revision });
        self.orbit.clone()
    }

    /// A small picture for the filmstrip; asks for it when it is not here yet.
    pub fn thumbnail(&mut self, frame: FrameIndex, height: u32) -> Option<Arc<Rgb8>> {
        if let Some(Some(picture)) = self.thumbnails.get(frame.as_usize()) {
            return Some(Arc::clone(picture));
        }
        self.want(PictureRequest { frame, kind: PictureKind::Thumbnail { height }, revision: Revision(0) });
        None
    }

    /// Why there is no picture of `frame`, in words.
    pub fn fault(&self, frame: FrameIndex) -> Option<&str> {
        self.faults.iter().rev().find(|(index, _)| *index == frame).map(|(_, fault)| fault.as_str())
    }

    /// Takes what the engine sent.
    pub fn take(&mut self, request: PictureRequest, result: Result<Shown, String>) {
        self.faults.retain(|(index, _)| *index != request.frame);
        match (request.kind, result) {
            (PictureKind::Source, Ok(Shown::Picture(picture))) => self.keep_source(request.frame, picture),
            (PictureKind::Composite, Ok(Shown::Layers(layers))) => {
                self.composite = Some((request.frame, request.revision, layers));
            }
            (PictureKind::Orbit { .. }, Ok(Shown::Picture(picture))) => self.orbit = Some(picture),
            (PictureKind::Thumbnail { .. }, Ok(Shown::Picture(picture))) => {
                let at = request.frame.as_usize();
                if self.thumbnails.len() <= at {
                    self.thumbnails.resize(at + 1, None);
                }
                self.thumbnails[at] = Some(picture);
            }
            (_, Err(fault)) => self.faults.push((request.frame, fault)),
            (_, Ok(_)) => {}
        }
    }

    fn keep_source(&mut self, frame: FrameIndex, picture: Arc<Rgb8>) {
        self.source_bytes += picture.data().len();
        self.sources.push_back((frame, picture));
        while self.source_bytes > KEPT_BYTES && self.sources.len() > 1 {
            if let Some((_, old)) = self.sources.pop_front() {
                self.source_bytes -= old.data().len();
            }
        }
    }

    fn want(&mut self, request: PictureRequest) {
        if !self.asked.contains(&request) && !self.wishes.contains(&request) {
            self.wishes.push(request);
        }
    }

    /// What was wanted since the last call and was not asked for before.
    pub fn wishes(&mut self) -> Vec<PictureRequest> {
        let wishes = std::mem::take(&mut self.wishes);
        for wish in &wishes {
            // Of one kind only the latest wish stands with the engine; others may be asked for again.
            let same = std::mem::discriminant(&wish.kind);
            let several = matches!(wish.kind, PictureKind::Thumbnail { .. });
            self.asked.retain(|old| several || std::mem::discriminant(&old.kind) != same);
            self.asked.push(*wish);
        }
        wishes
    }

    /// Forgets everything: another clip is open.
    pub fn clear(&mut self) {
        *self = Self::default();
    }
}
