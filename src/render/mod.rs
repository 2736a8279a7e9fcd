//! MuJoCo off-screen passes.
