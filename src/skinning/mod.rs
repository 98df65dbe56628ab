//! Layer 3: palettes to the GPU.
