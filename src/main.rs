//! The game binary.

fn main() {}
