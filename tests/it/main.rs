//! All integration tests in one binary, since each one links for seconds.

mod layers;
