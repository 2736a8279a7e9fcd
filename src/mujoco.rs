//! What every user of MuJoCo has to keep to.

use std::sync::{Mutex, PoisonError};

/// What MuJoCo says where `errno` was set while it read numbers, by whomever.
const STRAY_ERRNO: &str = "unknown error in attribute";
/// How often a description is read before that message is believed.
const READINGS: usize = 4;

/// Runs `compile`, which reads a model description, while no other thread reads one.
///
/// MuJoCo's XML reader takes any `errno` left after a list of numbers for a fault of the list, and
/// a C library may set it on success: now and then perfectly good numbers are refused with
/// "unknown error in attribute", long lists and busy processes most. Such a reading is repeated.
pub fn compile_alone<T, E: std::fmt::Display>(compile: impl Fn() -> Result<T, E>) -> Result<T, E> {
    static READER: Mutex<()> = Mutex::new(());
    // The lock guards no data of ours, so a panic in another reader leaves nothing broken behind.
    let _guard = READER.lock().unwrap_or_else(PoisonError::into_inner);
    let mut readings = 1;
    loop {
        match compile() {
            Err(error) if readings < READINGS && error.to_string().contains(STRAY_ERRNO) => readings += 1,
            result => return result,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    #[test]
    fn a_stray_refusal_is_read_again_and_a_lasting_one_is_told() {
        let readings = Cell::new(0);
        let third_time = compile_alone(|| {
            readings.set(readings.get() + 1);
            if readings.get() < 3 { Err("XML Error: unknown error in attribute 'vertex'") } else { Ok(()) }
        });
        assert_eq!((third_time, readings.get()), (Ok(()), 3));
        assert!(compile_alone(|| Err::<(), _>("unknown error in attribute 'pos'")).is_err());
    }

    #[test]
    fn another_refusal_is_told_at_once() {
        let readings = Cell::new(0);
        let refused = compile_alone(|| {
            readings.set(readings.get() + 1);
            Err::<(), _>("XML Error: unrecognized element")
        });
        assert!(refused.is_err());
        assert_eq!(readings.get(), 1);
    }
}
