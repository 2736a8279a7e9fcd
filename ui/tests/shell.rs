//! The frame of the window.

mod support;

use support::{Bench, FRAMES, SIZE, long_workspace};

#[test]
fn the_sample_has_something_of_everything() {
    let bench = Bench::new(agenticfocus_ui::theme::Tokens::dark());
    let workspace = bench.workspace.as_ref().unwrap();
    assert_eq!((workspace.frame_count(), workspace.size()), (FRAMES as usize, Some(SIZE)));
    assert!(!workspace.problems().is_empty());
    assert_eq!(long_workspace(9_000).frame_count(), 9_000);
}
