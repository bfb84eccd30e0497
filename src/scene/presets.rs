//! Ready-made scenes.
