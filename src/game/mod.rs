//! Layer 5: the game.
