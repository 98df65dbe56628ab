//! Angles: degrees in RON, radians in code. Use with `#[serde(with = "super::degrees")]`.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Reads degrees, gives radians.
///
/// # Errors
/// Whatever the format says of a value that is not a number.
pub fn deserialize<'de, D: Deserializer<'de>>(source: D) -> Result<f32, D::Error> {
    f32::deserialize(source).map(f32::to_radians)
}

/// Takes radians, writes degrees.
///
/// # Errors
/// Whatever the format says of a value that it can't hold.
pub fn serialize<S: Serializer>(radians: &f32, sink: S) -> Result<S::Ok, S::Error> {
    radians.to_degrees().serialize(sink)
}
