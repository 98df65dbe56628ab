//! The figure as implicit shapes: model space of the file, metres, left half (the right mirrors it).

pub mod body;
pub mod boot;
pub mod field;
pub mod hand;
pub mod helmet;
pub mod loft;
