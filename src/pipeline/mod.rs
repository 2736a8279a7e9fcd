//! Stage graph, cache, progress, cancellation.
