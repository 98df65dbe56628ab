//! Layer 3: the ECS, one module per stage in the order the data flows; `schedule` is the spine.

pub mod intent;
pub mod motion;
pub mod schedule;
