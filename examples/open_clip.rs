//! Opens clips and prints what is known of them, how fast they open, and how fast frames come back and encode:
//! `cargo run --example open_clip -- CLIP...`
#![expect(clippy::unwrap_used, reason = "a failure ends the example")]

use std::time::Instant;

use agenticfocus::{
    clip::{ClipRequest, FrameIndex, FrameSource, open},
    export::{VideoQuality, VideoWriter},
    progress::Unwatched,
};

fn main() {
    for path in std::env::args().skip(1) {
        let scratch = tempfile::tempdir().unwrap();
        let started = Instant::now();
        let clip = match open(&ClipRequest::new(&path), scratch.path(), &Unwatched) {
            Ok(clip) => clip,
            Err(error) => {
                println!("exit {}: {error}", error.exit_code());
                continue;
            }
        };
        let opened = started.elapsed();
        let count = clip.frame_count();
        let megabytes = std::fs::metadata(clip.store().path()).unwrap().len() >> 20;
        let info = &clip.info;
        println!(
            "{path}: {} {} source frames at {:.3} Hz, {count} standard, {:?}, {megabytes} MB",
            info.size, info.source_frames, info.source_fps, info.flags
        );
        let started = Instant::now();
        for index in FrameIndex::all(count) {
            clip.frame(index).unwrap();
        }
        let read = started.elapsed();
        let shown = count.min(60);
        let mut video =
            VideoWriter::create(&scratch.path().join("out.mp4"), clip.size(), VideoQuality::Final).unwrap();
        let started = Instant::now();
        for index in FrameIndex::all(shown) {
            video.push(&clip.frame(index).unwrap()).unwrap();
        }
        video.finish().unwrap();
        let per = |time: std::time::Duration, n: usize| time.as_secs_f64() * 1e3 / n as f64;
        println!(
            "  open {:.1} ms, read {:.1} ms, read and encode {:.1} ms a frame",
            per(opened, count),
            per(read, count),
            per(started.elapsed(), shown)
        );
    }
}
