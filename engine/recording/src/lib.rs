//! Recordings: the values that ports published in a run, as a table in CSV (`asmotion run --record FILE.csv`).
//!
//! The first column, `time_s`, has the time in seconds with nine decimals. Every other column has one scalar part of the
//! samples of a port: `Driver.status.joints.0.position` is the field `position` of the first element of the field `joints`
//! of a sample of the port `status` of `Driver`. A row has the values of one instant; a port that published several samples
//! at an instant has several rows. Of lists with more than 64 elements only the length is recorded, in a column that ends in
//! `.count`.

mod read;
mod write;

pub use read::{RecordingError, read_samples};
pub use write::PortRecording;
