//! COCO's text form of run lengths: differences to the run before last, in groups of five bits from `0` on (as
//! documented by cocoapi's mask format).

/// Why a text is no run lengths.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CocoTextError {
    /// A character out of range.
    #[error("character {found:?} at {place}: expected one of '0' to 'o'")]
    Character {
        /// Its place.
        place: usize,
        /// The byte.
        found: u8,
    },
    /// It ends within a number, or a number is no run length.
    #[error("run {run} is cut off, negative or too large")]
    Run {
        /// Its number.
        run: usize,
    },
}

/// The text of `counts`.
pub fn text_from_counts(counts: &[u32]) -> String {
    let mut text = String::new();
    for (run, count) in counts.iter().enumerate() {
        let earlier = if run > 2 { i64::from(counts[run - 2]) } else { 0 };
        let mut value = i64::from(*count) - earlier;
        loop {
            let bits = value & 0x1f;
            value >>= 5;
            // The fifth bit is the sign of what is left.
            let more = if bits & 0x10 != 0 { value != -1 } else { value != 0 };
            // At most 48 + 63: a character of ASCII.
            text.push(char::from((bits as u8 | if more { 0x20 } else { 0 }) + b'0'));
            if !more {
                break;
            }
        }
    }
    text
}

/// The run lengths of `text`.
///
/// # Errors
/// When a character is out of range, or a number is cut off, negative or over 32 bits.
pub fn counts_from_text(text: &str) -> Result<Vec<u32>, CocoTextError> {
    let mut counts: Vec<u32> = Vec::new();
    let mut bytes = text.bytes().enumerate().peekable();
    while bytes.peek().is_some() {
        let run = counts.len();
        let (mut value, mut shift) = (0_i64, 0_u32);
        loop {
            let (place, found) = bytes.next().ok_or(CocoTextError::Run { run })?;
            let bits = found.checked_sub(b'0').filter(|bits| *bits < 64);
            let bits = bits.ok_or(CocoTextError::Character { place, found })?;
            if shift > 35 {
                return Err(CocoTextError::Run { run });
            }
            value |= i64::from(bits & 0x1f) << shift;
            shift += 5;
            if bits & 0x20 == 0 {
                if bits & 0x10 != 0 {
                    value |= -1 << shift;
                }
                break;
            }
        }
        if run > 2 {
            value += i64::from(counts[run - 2]);
        }
        counts.push(u32::try_from(value).map_err(|_| CocoTextError::Run { run })?);
    }
    Ok(counts)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_text_is_the_one_pycocotools_writes() {
        // pycocotools.mask.encode of a 4 x 4 mask with its inner 2 x 2 set: runs 5 2 2 2 5.
        assert_eq!(text_from_counts(&[5, 2, 2, 2, 5]), "52203");
        assert_eq!(counts_from_text("52203").unwrap(), [5, 2, 2, 2, 5]);
        assert_eq!(text_from_counts(&[300, 40]), "\\9X1");
    }

    #[test]
    fn damaged_texts_are_refused() {
        assert!(matches!(counts_from_text("5~"), Err(CocoTextError::Character { place: 1, .. })));
        assert!(matches!(counts_from_text("o"), Err(CocoTextError::Run { run: 0 })));
        assert!(matches!(counts_from_text("oooooooooooo0"), Err(CocoTextError::Run { .. })));
        assert!(matches!(counts_from_text("O"), Err(CocoTextError::Run { run: 0 })), "negative");
    }

    proptest! {
        #[test]
        fn runs_come_back(counts in prop::collection::vec(0_u32.., 0..40)) {
            prop_assert_eq!(counts_from_text(&text_from_counts(&counts)).unwrap(), counts);
        }

        #[test]
        fn no_text_brings_it_down(text in ".{0,60}") {
            let _ = counts_from_text(&text);
        }
    }
}
