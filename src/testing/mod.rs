//! Layer 4: the public headless harness: stage, worlds, input tapes.
