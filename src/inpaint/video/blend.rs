//! What overlapping windows say about a frame, made one.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::windows::Window;

/// How windows are blended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Blend {
    /// Each window by how near the frame is to its centre (default). Does not depend on the windows' order.
    #[default]
    Triangular,
    /// The published procedure: a later window and everything before it by halves.
    Reference,
}

impl Blend {
    /// Every rule.
    pub const ALL: [Self; 2] = [Self::Triangular, Self::Reference];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Triangular => "triangular",
            Self::Reference => "reference",
        }
    }
}

/// One frame being restored.
struct Restored {
    /// RGB planes, -1 to 1, times `weight`.
    sum: Vec<f32>,
    weight: f32,
}

/// Restored frames that more windows may say something about.
pub(super) struct Blender {
    blend: Blend,
    open: BTreeMap<usize, Restored>,
}

impl Blender {
    /// Nothing restored yet.
    pub fn new(blend: Blend) -> Self {
        Self { blend, open: BTreeMap::new() }
    }

    /// Takes what the network says about one frame of `window`, RGB planes from -1 to 1.
    pub fn add(&mut self, window: &Window, frame: usize, planes: &[f32]) {
        let weight = match self.blend {
            Blend::Triangular => {
                let reach = window.centre.abs_diff(window.local.start);
                let reach = reach.max(window.local.end.saturating_sub(1).abs_diff(window.centre)) + 1;
                1.0 - window.centre.abs_diff(frame) as f32 / reach as f32
            }
            Blend::Reference => 1.0,
        };
        let entry =
            self.open.entry(frame).or_insert_with(|| Restored { sum: vec![0.0; planes.len()], weight: 0.0 });
        if self.blend == Blend::Reference && entry.weight > 0.0 {
            entry.sum.iter_mut().zip(planes).for_each(|(sum, value)| *sum = 0.5 * (*sum + value));
            return;
        }
        entry.sum.iter_mut().zip(planes).for_each(|(sum, value)| *sum += weight * value);
        entry.weight += weight;
    }

    /// The frames before `end`, in order, which no later window restores.
    pub fn finish_before(&mut self, end: usize) -> Vec<(usize, Vec<f32>)> {
        let later = self.open.split_off(&end);
        let done = std::mem::replace(&mut self.open, later);
        let scaled = |restored: Restored| {
            let scale = if self.blend == Blend::Triangular { restored.weight.recip() } else { 1.0 };
            restored.sum.into_iter().map(|value| value * scale).collect()
        };
        done.into_iter().map(|(frame, restored)| (frame, scaled(restored))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(centre: usize) -> Window {
        let local = centre - 5..centre + 6;
        Window { centre, fed: local.clone().collect(), local, references: Vec::new() }
    }

    fn blended(blend: Blend, order: &[(usize, f32)]) -> f32 {
        let mut blender = Blender::new(blend);
        for (centre, value) in order {
            blender.add(&window(*centre), 10, &[*value]);
        }
        blender.finish_before(11)[0].1[0]
    }

    #[test]
    fn the_default_does_not_depend_on_the_order_of_windows() {
        let forward = blended(Blend::Triangular, &[(5, 0.2), (10, -0.4), (15, 0.9)]);
        let backward = blended(Blend::Triangular, &[(15, 0.9), (10, -0.4), (5, 0.2)]);
        assert!((forward - backward).abs() < 1e-6);
        let expected = (0.2 / 6.0 - 0.4 + 0.9 / 6.0) / (1.0 + 2.0 / 6.0);
        assert!((forward - expected).abs() < 1e-6, "{forward} instead of {expected}");
    }

    #[test]
    fn the_published_rule_weighs_three_windows_by_a_quarter_a_quarter_and_a_half() {
        let found = blended(Blend::Reference, &[(5, 1.0), (10, 0.0), (15, 0.0)]);
        assert!((found - 0.25).abs() < 1e-6);
        let found = blended(Blend::Reference, &[(5, 0.0), (10, 0.0), (15, 1.0)]);
        assert!((found - 0.5).abs() < 1e-6);
    }

    #[test]
    fn frames_leave_in_order_and_once() {
        let mut blender = Blender::new(Blend::Triangular);
        for frame in 3..9 {
            blender.add(&window(8), frame, &[frame as f32]);
        }
        let done: Vec<_> = blender.finish_before(6).into_iter().map(|(frame, _)| frame).collect();
        assert_eq!(done, [3, 4, 5]);
        let rest: Vec<_> = blender.finish_before(100).into_iter().map(|(frame, _)| frame).collect();
        assert_eq!(rest, [6, 7, 8]);
    }
}
