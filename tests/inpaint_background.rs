//! Behaviour of background restoration on pictures whose clean truth is known.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use agenticfocus::{
    clip::{FrameIndex, FramesInMemory},
    evaluate::psnr_inside,
    geometry::Size,
    image::{Mask, Rgb8},
    inpaint::{InpaintParams, InpaintReport, clean, inpaint_mask},
    progress::Unwatched,
    segment::{MaskAuthor, MaskFrame, MaskTrack, RleMask},
};

const SIZE: Size = Size::new(320, 240);
const FRAMES: usize = 24;

/// A smooth but rich table top, defined everywhere, so that a camera can move over it exactly.
fn table(x: f64, y: f64) -> [u8; 3] {
    let wave = |a: f64, b: f64, c: f64| ((x * a + y * b).sin() + (x * b - y * a + c).cos()) * 0.5;
    let grain = wave(0.31, 0.23, 1.0) * 30.0 + wave(0.11, 0.05, 2.0) * 40.0 + wave(0.53, 0.17, 0.3) * 12.0;
    let tile = (wave(0.021, 0.043, 0.0) * 25.0).round();
    [128.0 + grain + tile, 110.0 + grain * 0.8 - tile, 90.0 + grain * 0.5].map(|v| v.clamp(0.0, 255.0) as u8)
}

struct Episode {
    frames: FramesInMemory,
    truth: Vec<Rgb8>,
    arms: MaskTrack,
    object: MaskTrack,
}

fn track(masks: &[Mask]) -> MaskTrack {
    let frame = |mask: &Mask| MaskFrame {
        mask: RleMask::encode(mask),
        author: MaskAuthor::Seeded,
        score: 1.0,
        flags: Vec::new(),
    };
    MaskTrack { size: SIZE, frames: masks.iter().map(frame).collect(), backend: "truth".into() }
}

/// A hand that sweeps over the table while the head turns by `sway` pixels.
fn episode(sway: f64) -> Episode {
    let (mut frames, mut truth, mut arms, mut objects) = (vec![], vec![], vec![], vec![]);
    for t in 0..FRAMES {
        let time = t as f64 / FRAMES as f64;
        let (dx, dy) = (sway * (time * 5.0).sin(), 0.4 * sway * (time * 4.0).cos());
        let (angle, zoom) = (0.002 * sway * time, 1.0 + 0.001 * sway * time);
        let mut clean = Rgb8::new(SIZE);
        for y in 0..SIZE.height {
            for x in 0..SIZE.width {
                let (u, v) = (f64::from(x) - 160.0, f64::from(y) - 120.0);
                let (c, s) = (angle.cos() * zoom, angle.sin() * zoom);
                clean.set_pixel(x, y, table(u * c - v * s + dx + 160.0, u * s + v * c + dy + 120.0));
            }
        }
        let hand_x = 60.0 + 200.0 * time;
        let arm = Mask::from_fn(SIZE, |x, y| {
            let (x, y) = (f64::from(x), f64::from(y));
            (x - hand_x).hypot(y - 120.0) < 35.0 || (y > 120.0 && (x - hand_x).abs() < 18.0)
        });
        let object = Mask::from_fn(SIZE, |x, y| {
            (f64::from(x) - hand_x).abs() < 12.0 && (f64::from(y) - 90.0).abs() < 20.0
        });
        let arm = arm.minus(&object);
        let mut frame = clean.clone();
        for y in 0..SIZE.height {
            for x in 0..SIZE.width {
                if arm.get(x, y) {
                    frame.set_pixel(x, y, [205, 150, 120]);
                } else if object.get(x, y) {
                    frame.set_pixel(x, y, [20, 60, 200]);
                }
            }
        }
        frames.push(frame);
        truth.push(clean);
        arms.push(arm);
        objects.push(object);
    }
    let frames = FramesInMemory::new(frames).unwrap();
    Episode { frames, truth, arms: track(&arms), object: track(&objects) }
}

fn cleaned(episode: &Episode) -> (Vec<Rgb8>, InpaintReport) {
    let mut out = Vec::new();
    let params = InpaintParams::default();
    let mut sink = |index: FrameIndex, picture: &Rgb8| {
        assert_eq!(index.as_usize(), out.len());
        out.push(picture.clone());
        Ok(())
    };
    let report =
        clean(&episode.frames, &episode.arms, &episode.object, None, &params, &mut sink, &Unwatched).unwrap();
    (out, report)
}

fn mean_psnr(episode: &Episode, cleaned: &[Rgb8]) -> f64 {
    let params = InpaintParams::default();
    let each = cleaned.iter().zip(&episode.truth).enumerate().filter_map(|(t, (picture, truth))| {
        let object = episode.object.frames[t].mask.decode();
        let hole = inpaint_mask(&episode.arms.frames[t].mask.decode(), &object, &params).unwrap();
        psnr_inside(picture, truth, &hole.minus(&object)).unwrap()
    });
    let values: Vec<f64> = each.collect();
    values.iter().sum::<f64>() / values.len() as f64
}

#[test]
fn behind_a_hand_that_moves_on_the_true_table_reappears() {
    let episode = episode(0.0);
    let (cleaned, report) = cleaned(&episode);
    let psnr = mean_psnr(&episode, &cleaned);
    assert!(psnr > 36.0, "{psnr} dB");
    assert!(report.seen_share() > 0.97, "{}", report.seen_share());
    let full =
        report.coverage.iter().all(|c| (c.seen + c.synthesised + c.behind_template - 1.0).abs() < 1e-9);
    assert!(full, "shares add up");
}

#[test]
fn a_turning_head_costs_little() {
    let episode = episode(12.0);
    let (cleaned, _) = cleaned(&episode);
    let psnr = mean_psnr(&episode, &cleaned);
    assert!(psnr > 32.0, "{psnr} dB");
}

#[test]
fn the_visible_object_is_left_alone() {
    let episode = episode(0.0);
    let (cleaned, _) = cleaned(&episode);
    let hand_x = 60 + 200 * 12 / FRAMES as u32;
    assert_eq!(cleaned[12].pixel(hand_x, 90), [20, 60, 200]);
}

#[test]
fn the_same_clip_gives_the_same_bytes_on_one_thread_and_on_two() {
    let episode = episode(12.0);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| cleaned(&episode).0)
    };
    assert!(with(1) == with(2));
}
