//! Which frames a frame remembers.
//!
//! Procedure: facebookresearch/sam2, `sam2/modeling/sam2_base.py`, `_prepare_memory_conditioned_features`, at stride 1
//! with every conditioning frame attended and object pointers of the past alone.

use std::{collections::BTreeMap, rc::Rc};

/// Memories of masks: the conditioning ones and this many frames before.
const RECENT: usize = 6;
/// Object pointers reach this far back, beside the conditioning ones.
const POINTERS: usize = 15;

/// Which way a clip is gone through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heading {
    /// To later frames.
    Forward,
    /// To earlier frames; what is "before" lies later in the clip.
    Backward,
}

impl Heading {
    /// The frame `steps` before `frame`.
    fn before(self, frame: usize, steps: usize) -> Option<usize> {
        match self {
            Self::Forward => frame.checked_sub(steps),
            Self::Backward => frame.checked_add(steps),
        }
    }

    /// Steps from `earlier` to `frame`; `None` where it is not at or before it.
    fn steps(self, earlier: usize, frame: usize) -> Option<usize> {
        match self {
            Self::Forward => frame.checked_sub(earlier),
            Self::Backward => earlier.checked_sub(frame),
        }
    }
}

/// What is remembered of the frames gone through.
#[derive(Debug)]
pub struct Bank<E> {
    conditioning: BTreeMap<usize, Rc<E>>,
    results: BTreeMap<usize, Rc<E>>,
    /// Results near this frame are kept: the way back begins there.
    start: usize,
}

impl<E> Bank<E> {
    /// Nothing remembered yet; the clip is gone through from `start`, onwards and then back.
    pub fn new(start: usize) -> Self {
        Self { conditioning: BTreeMap::new(), results: BTreeMap::new(), start }
    }

    /// Remembers what somebody said of `frame`: it is always attended.
    pub fn condition(&mut self, frame: usize, entry: E) {
        self.conditioning.insert(frame, Rc::new(entry));
    }

    /// Remembers what was found on `frame`, and forgets what no later frame will ask for.
    pub fn remember(&mut self, frame: usize, entry: E) {
        self.results.insert(frame, Rc::new(entry));
        let start = self.start;
        self.results
            .retain(|known, _| known.abs_diff(frame) <= POINTERS || known.abs_diff(start) <= POINTERS);
    }

    /// What somebody said of `frame`.
    pub fn conditioned(&self, frame: usize) -> Option<&Rc<E>> {
        self.conditioning.get(&frame)
    }

    /// Entries whose masks `frame` attends to, each with its frame and the row of the time encoding.
    pub fn masks(&self, frame: usize, heading: Heading) -> Vec<(usize, &Rc<E>, usize)> {
        let always = self.conditioning.iter().map(|(known, entry)| (*known, entry, RECENT));
        let recent = (1..=RECENT).filter_map(|position| {
            let known = heading.before(frame, RECENT + 1 - position)?;
            Some((known, self.results.get(&known)?, RECENT - position))
        });
        always.chain(recent).collect()
    }

    /// Entries whose object pointers `frame` attends to, each with how many frames it lies before.
    pub fn pointers(&self, frame: usize, heading: Heading) -> Vec<(&Rc<E>, usize)> {
        let said = self.conditioning.iter();
        let said = said.filter_map(|(known, entry)| Some((entry, heading.steps(*known, frame)?)));
        let recent = (1..=POINTERS).filter_map(|steps| {
            let known = heading.before(frame, steps)?;
            Some((self.results.get(&known)?, steps))
        });
        said.chain(recent).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bank(said: &[usize], found: impl Iterator<Item = usize>) -> Bank<usize> {
        let mut bank = Bank::new(said[0]);
        said.iter().for_each(|frame| bank.condition(*frame, *frame));
        found.for_each(|frame| bank.remember(frame, frame));
        bank
    }

    fn recent(bank: &Bank<usize>, frame: usize, heading: Heading) -> Vec<(usize, usize)> {
        let all = bank.masks(frame, heading);
        all.into_iter().filter(|(_, _, row)| *row < RECENT).map(|(known, _, row)| (known, row)).collect()
    }

    #[test]
    fn recent_masks_are_those_of_the_published_procedure() {
        let bank = bank(&[0], 1..8);
        assert_eq!(recent(&bank, 1, Heading::Forward), []);
        assert_eq!(recent(&bank, 3, Heading::Forward), [(1, 1), (2, 0)]);
        let eight: Vec<_> = (2..8).zip((0..6).rev()).collect();
        assert_eq!(recent(&bank, 8, Heading::Forward), eight);
    }

    #[test]
    fn what_somebody_said_is_always_attended_with_the_last_row() {
        let bank = bank(&[0, 40], 1..30);
        let said: Vec<_> =
            bank.masks(30, Heading::Forward).into_iter().filter(|(_, _, row)| *row == 6).collect();
        assert_eq!(said.iter().map(|(frame, _, _)| *frame).collect::<Vec<_>>(), [0, 40]);
    }

    #[test]
    fn pointers_lie_in_the_past_with_their_distance() {
        let bank = bank(&[0, 40], 1..30);
        let distances: Vec<_> =
            bank.pointers(30, Heading::Forward).into_iter().map(|(_, steps)| steps).collect();
        let expected: Vec<usize> = [30].into_iter().chain(1..=15).collect();
        assert_eq!(distances, expected);
    }

    #[test]
    fn the_way_back_mirrors_the_way_on_and_knows_the_frames_beside_its_start() {
        let mut bank = bank(&[20], 21..60);
        bank.remember(19, 19);
        assert_eq!(recent(&bank, 18, Heading::Backward), [(24, 5), (23, 4), (22, 3), (21, 2), (19, 0)]);
        assert!(bank.results.len() <= 2 * (2 * POINTERS + 1), "{} kept", bank.results.len());
    }
}
