//! Results as files of other programs: OpenVDB with a USD stage, VTK, Zarr, vector fields, NumPy. One step is in memory at a time.

mod arrays;
mod fga;
mod forecast;
mod job;
mod npz;
mod orient;
mod request;
mod sink;
mod source;
mod usd;
mod vdb;
mod volume;
mod vti;
mod zarr;

pub(crate) use job::run;
pub use orient::Up;
pub use request::Format;
pub(crate) use request::Request;
pub(crate) use sink::TimeScale;
pub use vdb::Codec;
