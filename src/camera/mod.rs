//! Layer 4: the third-person camera. Knows nothing of characters.
