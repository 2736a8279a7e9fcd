//! Opening clips: real ones, odd ones, damaged ones. Every clip here is made by FFmpeg on the spot.
#![cfg(feature = "engine")]
#![expect(clippy::unwrap_used, reason = "a failure in a helper fails the test")]

use std::{
    path::{Path, PathBuf},
    process::Command,
    time::{Duration, Instant},
};

use agenticfocus::{
    clip::{
        CameraSpec, ClipError, ClipFlag, ClipRequest, FrameIndex, FrameSource, Rotation, StandardClip, open,
    },
    geometry::{Pixel, Size},
    progress::{Unwatched, Watch},
};

fn shared() -> Option<PathBuf> {
    let folder = std::env::var_os("AGENTICFOCUS_SHARED")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"), PathBuf::from);
    let beside = [folder, Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared")];
    beside.into_iter().find(|folder| folder.join("clips").is_dir())
}

fn ffmpeg(folder: &Path, arguments: &str, name: &str) -> PathBuf {
    let path = folder.join(name);
    let status = Command::new("ffmpeg")
        .args(["-v", "error", "-nostdin", "-y", "-threads", "1"])
        .args(arguments.split_whitespace())
        .arg(&path)
        .status()
        .unwrap();
    assert!(status.success(), "ffmpeg {arguments}");
    path
}

fn opened(request: &ClipRequest) -> Result<StandardClip, ClipError> {
    let scratch = tempfile::tempdir().unwrap();
    let started = Instant::now();
    let clip = open(request, scratch.path(), &Unwatched);
    assert!(started.elapsed() < Duration::from_secs(30), "{request:?} took {:?}", started.elapsed());
    if let Ok(clip) = &clip {
        for index in FrameIndex::all(clip.frame_count()) {
            assert_eq!(clip.frame(index).unwrap().size(), clip.size());
        }
    }
    clip
}

fn open_path(path: &Path) -> Result<StandardClip, ClipError> {
    opened(&ClipRequest::new(path))
}

const SOURCE: &str = "-f lavfi -i testsrc2=size=160x120";

#[test]
fn real_clips_open_with_the_frames_their_rates_promise() {
    let Some(shared) = shared() else {
        println!("skipped: no folder with shared clips");
        return;
    };
    for (name, source, standard) in [("epic/put.mp4", 62, 124), ("epic/scrape.mp4", 75, 150)] {
        let clip = open_path(&shared.join("clips").join(name)).unwrap();
        assert_eq!((clip.info.source_frames, clip.frame_count()), (source, standard), "{name}");
        assert_eq!(clip.info.flags, [ClipFlag::DefaultIntrinsics], "{name}");
    }
}

#[test]
fn rates_are_standardised() {
    let folder = tempfile::tempdir().unwrap();
    for (rate, source, standard) in
        [("15", 15, 30), ("30000/1001", 30, 30), ("60", 60, 30), ("24", 24, 30), ("50", 50, 30), ("7", 7, 30)]
    {
        let arguments = format!("{SOURCE}:rate={rate} -frames:v {source} -c:v libx264 -bf 2");
        let clip = open_path(&ffmpeg(folder.path(), &arguments, "rate.mp4")).unwrap();
        assert_eq!((clip.info.source_frames, clip.frame_count()), (source, standard), "{rate} Hz");
        assert_eq!(clip.info.flags, [ClipFlag::DefaultIntrinsics], "{rate} Hz");
        assert_eq!(clip.info.frame_table[0].pts, 0.0);
    }
}

#[test]
fn odd_sizes_and_single_frames_open() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = "-f lavfi -i testsrc=size=161x121:rate=25 -frames:v 1 -c:v ffv1";
    let clip = open_path(&ffmpeg(folder.path(), arguments, "odd.mkv")).unwrap();
    assert_eq!((clip.size(), clip.frame_count()), (Size::new(161, 121), 1));
}

#[test]
fn variable_rate_holds_frames_as_long_as_they_were_shown() {
    let folder = tempfile::tempdir().unwrap();
    // Frames 10 to 39 of 60 are missing: frame 9 stands for a second.
    let arguments =
        format!("{SOURCE}:rate=30 -frames:v 30 -vf select='lt(n,10)+gte(n,40)' -fps_mode vfr -c:v libx264");
    let clip = open_path(&ffmpeg(folder.path(), &arguments, "vfr.mp4")).unwrap();
    assert_eq!((clip.info.source_frames, clip.frame_count()), (30, 60));
    assert!(clip.info.has(ClipFlag::VariableFrameRate));
    let sources: Vec<u32> = clip.info.frame_table.iter().map(|row| row.source_frame).collect();
    assert_eq!(sources[8..12], [8, 9, 9, 9]);
    assert_eq!(sources[38..42], [9, 9, 10, 11]);
    assert_eq!(clip.info.standard_index(10), Some(FrameIndex(40)));
    assert_eq!(clip.info.standard_index(30), None);
}

#[test]
fn turning_turns_pixels_and_camera_alike() {
    let folder = tempfile::tempdir().unwrap();
    let path = ffmpeg(folder.path(), &format!("{SOURCE}:rate=30 -frames:v 2 -c:v ffv1"), "turn.mkv");
    let upright = open_path(&path).unwrap().frame(FrameIndex(0)).unwrap();
    let camera = CameraSpec::Intrinsics { fx: 100.0, fy: 110.0, cx: 70.0, cy: 50.0 };
    for rotate in [Rotation::Deg90, Rotation::Deg180, Rotation::Deg270] {
        let clip = opened(&ClipRequest { rotate, camera, ..ClipRequest::new(&path) }).unwrap();
        let frame = clip.frame(FrameIndex(0)).unwrap();
        for (x, y) in [(70, 50), (3, 7), (150, 110)] {
            let there = clip.info.turned_pixel(Pixel::new(f64::from(x), f64::from(y)));
            assert_eq!(upright.pixel(x, y), frame.pixel(there.x as u32, there.y as u32), "{rotate:?}");
        }
        let centre = clip.info.turned_pixel(Pixel::new(70.0, 50.0));
        assert_eq!((clip.info.intrinsics.cx, clip.info.intrinsics.cy), (centre.x, centre.y));
    }
}

#[test]
fn rotation_stated_by_the_container_is_honoured() {
    let folder = tempfile::tempdir().unwrap();
    let plain = ffmpeg(folder.path(), &format!("{SOURCE}:rate=30 -frames:v 3 -c:v libx264"), "plain.mp4");
    let arguments = format!("-i {} -c copy -metadata:s:v rotate=90", plain.display());
    let clip = open_path(&ffmpeg(folder.path(), &arguments, "turned.mp4")).unwrap();
    assert_eq!(clip.size(), Size::new(120, 160));
}

#[test]
fn start_and_end_cut_in_seconds_of_the_source() {
    let folder = tempfile::tempdir().unwrap();
    let path = ffmpeg(folder.path(), &format!("{SOURCE}:rate=15 -frames:v 30 -c:v libx264"), "cut.mp4");
    let request = ClipRequest { start: Some(0.4), end: Some(1.0), ..ClipRequest::new(&path) };
    let clip = opened(&request).unwrap();
    let sources: Vec<u32> = clip.info.frame_table.iter().map(|row| row.source_frame).collect();
    assert_eq!(sources, [6, 6, 7, 7, 8, 8, 9, 9, 10, 10, 11, 11, 12, 12, 13, 13, 14, 14]);
    assert_eq!(clip.info.frame_table[0].pts, 0.0);
    let beyond = opened(&ClipRequest { start: Some(9.0), ..ClipRequest::new(&path) });
    assert!(matches!(beyond, Err(ClipError::EmptyRange { .. })));
}

#[test]
fn edit_lists_and_reordered_frames_open_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let whole = ffmpeg(
        folder.path(),
        &format!("{SOURCE}:rate=30 -frames:v 60 -c:v libx264 -bf 3 -g 30"),
        "whole.mp4",
    );
    let arguments = format!("-ss 0.5 -i {} -c copy", whole.display());
    let clip = open_path(&ffmpeg(folder.path(), &arguments, "edited.mp4")).unwrap();
    assert!((44..=46).contains(&clip.frame_count()), "{}", clip.frame_count());
    assert!(!clip.info.has(ClipFlag::NonMonotonicPts));
}

#[test]
fn a_truncated_file_gives_its_good_frames_and_is_flagged() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = format!("{SOURCE}:rate=30 -frames:v 60 -c:v libx264 -g 10 -movflags +faststart");
    let bytes = std::fs::read(ffmpeg(folder.path(), &arguments, "whole.mp4")).unwrap();
    let path = folder.path().join("cut.mp4");
    std::fs::write(&path, &bytes[..bytes.len() * 6 / 10]).unwrap();
    let clip = open_path(&path).unwrap();
    assert!((15..55).contains(&clip.frame_count()), "{}", clip.frame_count());
    assert!(clip.info.has(ClipFlag::Truncated), "{:?}", clip.info.flags);
}

#[test]
fn what_is_no_video_is_refused_as_bad_data_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    };
    let whole = ffmpeg(folder.path(), &format!("{SOURCE}:rate=30 -frames:v 9 -c:v libx264"), "whole.mp4");
    let bytes = std::fs::read(&whole).unwrap();
    let sound = ffmpeg(folder.path(), "-f lavfi -i sine=duration=1 -c:a aac", "sound.m4a");
    let none = ffmpeg(folder.path(), &format!("{SOURCE}:rate=30 -frames:v 0 -c:v libx264"), "none.mp4");
    for path in [
        folder.path().join("missing.mp4"),
        folder.path().to_path_buf(),
        write("empty.mp4", b""),
        write("noise.mp4", &[0x5a; 5000]),
        write("text.txt", b"#EXTM3U\nfile:///etc/passwd\n"),
        write("list.ffconcat", b"ffconcat version 1.0\nfile whole.mp4\n"),
        write("headless.mp4", &bytes[..bytes.len() / 2]),
        sound,
        none,
    ] {
        let error = open_path(&path).err().unwrap_or_else(|| panic!("{} opened", path.display()));
        assert_eq!(error.exit_code(), 65, "{error}");
        let line = error.to_string();
        assert!(!line.contains('\n') && line.contains(&*path.to_string_lossy()), "{line}");
        println!("{line}");
    }
}

#[test]
fn damaged_bytes_neither_crash_nor_hang_and_decode_alike_twice() {
    let folder = tempfile::tempdir().unwrap();
    for (name, codec) in [("a.mp4", "libx264 -g 10"), ("b.mkv", "mpeg4 -q:v 4"), ("c.avi", "mjpeg")] {
        let arguments = format!("{SOURCE}:rate=30 -frames:v 30 -c:v {codec}");
        let bytes = std::fs::read(ffmpeg(folder.path(), &arguments, name)).unwrap();
        for seed in 0..4_u64 {
            let mut damaged = bytes.clone();
            let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) + 1;
            for _ in 0..60 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                let place = (state >> 33) as usize % damaged.len();
                damaged[place] ^= 1 << (state >> 61);
            }
            if seed == 3 {
                let half = damaged.len() / 2;
                damaged[half..half + 2000].fill(0);
            }
            let path = folder.path().join(format!("damaged-{name}"));
            std::fs::write(&path, &damaged).unwrap();
            match (open_path(&path), open_path(&path)) {
                (Ok(a), Ok(b)) => assert_eq!(a.info, b.info),
                (Err(a), Err(b)) => assert_eq!((a.exit_code(), a.to_string()), (65, b.to_string())),
                (a, b) => panic!("{name} {seed}: {:?} then {:?}", a.is_ok(), b.is_ok()),
            }
        }
    }
}

#[test]
fn cancelling_stops_and_leaves_nothing() {
    struct Never;
    impl Watch for Never {
        fn advance(&self, _done: usize, _total: usize) {}
        fn is_cancelled(&self) -> bool {
            true
        }
    }
    let (folder, scratch) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let path = ffmpeg(folder.path(), &format!("{SOURCE}:rate=30 -frames:v 9 -c:v libx264"), "a.mp4");
    let error = open(&ClipRequest::new(&path), scratch.path(), &Never).unwrap_err();
    assert_eq!(error.exit_code(), 130);
    assert_eq!(std::fs::read_dir(scratch.path()).unwrap().count(), 0);
}
