//! Layer 4: ground and obstacles. Knows nothing of characters.
