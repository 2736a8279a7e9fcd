//! Synthetic episodes with ground truth.
