//! Layer 3: what the gauntlet reads: slide, float, penetration, pops, reach.
