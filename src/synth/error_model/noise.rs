//! Random processes of the error model.

use rand::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

/// Random numbers of one part of an episode.
#[derive(Debug)]
pub(super) struct Noise(Pcg64Mcg);

impl Noise {
    /// The stream number `part` of episode `seed`.
    pub fn new(seed: u64, part: u64) -> Self {
        let mixed =
            seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(part.wrapping_mul(0xd1b5_4a32_d192_ed03));
        Self(Pcg64Mcg::seed_from_u64(mixed))
    }

    /// Evenly from 0 to 1.
    pub fn share(&mut self) -> f64 {
        self.0.random_range(0.0..1.0)
    }

    /// Normal with mean 0 and variance 1 (Box and Muller's transform).
    pub fn normal(&mut self) -> f64 {
        let (u, v) = (1.0 - self.share(), self.share());
        (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    }

    /// A unit vector of the plane.
    pub fn direction(&mut self) -> [f64; 2] {
        let (sin, cos) = (std::f64::consts::TAU * self.share()).sin_cos();
        [cos, sin]
    }
}

/// A normal error that changes slowly.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wander {
    /// Standard deviation.
    pub spread: f64,
    /// How long it remembers, frames.
    pub frames: f64,
}

impl Wander {
    /// `count` values: white noise that passed the same first-order low-pass twice, so that its speed is finite.
    pub(super) fn draw(&self, count: usize, noise: &mut Noise) -> Vec<f64> {
        let keep = (-1.0 / self.frames.max(1e-3)).exp();
        // The variance that two equal first-order low-passes leave of white noise.
        let unit = ((1.0 - keep * keep).powi(3) / (1.0 + keep * keep)).sqrt();
        let warm_up = (8.0 * self.frames).ceil() as usize;
        let (mut first, mut second) = (0.0, 0.0);
        let all = (0..warm_up + count).map(|_| {
            first = keep * first + noise.normal();
            second = keep * second + first;
            self.spread * unit * second
        });
        all.skip(warm_up).collect()
    }
}

/// Something that begins now and then and lasts for a while.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bursts {
    /// How often one begins, a second.
    pub per_second: f64,
    /// Mean length, frames; lengths are geometric, at least 1.
    pub frames: f64,
}

impl Bursts {
    /// For each of `count` frames the number of the burst it belongs to.
    pub(super) fn draw(&self, count: usize, fps: f64, noise: &mut Noise) -> Vec<Option<usize>> {
        let begin = (self.per_second / fps).clamp(0.0, 1.0);
        let go_on = 1.0 - 1.0 / self.frames.max(1.0);
        let (mut number, mut inside) = (0, false);
        (0..count)
            .map(|_| {
                let draw = noise.share();
                if inside && draw < go_on {
                    return Some(number);
                }
                inside = noise.share() < begin;
                number += usize::from(inside);
                inside.then_some(number)
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wander_has_its_spread_and_its_memory() {
        let wander = Wander { spread: 0.02, frames: 6.0 };
        let values = wander.draw(60_000, &mut Noise::new(3, 0));
        let mean = |of: &dyn Fn(usize) -> f64| (0..50_000).map(of).sum::<f64>() / 50_000.0;
        let variance = mean(&|t| values[t].powi(2));
        assert!((variance.sqrt() / 0.02 - 1.0).abs() < 0.06, "{}", variance.sqrt());
        let later = |lag: usize| mean(&|t| values[t] * values[t + lag]) / variance;
        assert!(later(1) > 0.97 && later(6) > 0.6 && later(40) < 0.15, "{} {}", later(6), later(40));
    }

    #[test]
    fn bursts_come_as_often_and_last_as_long_as_stated() {
        let bursts = Bursts { per_second: 0.5, frames: 4.0 };
        let drawn = bursts.draw(300_000, 30.0, &mut Noise::new(5, 1));
        let inside = drawn.iter().flatten().count() as f64;
        let number = drawn.iter().flatten().max().copied().unwrap() as f64;
        assert!((inside / number - 4.0).abs() < 0.2, "{}", inside / number);
        // Those that would begin inside another one are not seen as such.
        assert!((number / (10_000.0 - inside / 30.0) - 0.5).abs() < 0.03, "{number}");
        assert!(
            Bursts { per_second: 0.0, frames: 4.0 }
                .draw(99, 30.0, &mut Noise::new(5, 1))
                .iter()
                .all(Option::is_none)
        );
    }
}
