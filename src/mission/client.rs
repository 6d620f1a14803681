//! Clients of services of other systems, which a mission calls over HTTP.

#[cfg(not(feature = "http"))]
mod left_out;
#[cfg(feature = "http")]
mod open;
