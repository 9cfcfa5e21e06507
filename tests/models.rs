//! Models that draw pictures, alone and over ranks: the examples, the hooks and plugins for real models, live pages.

mod catalyst;
mod comin;
mod live;
mod mpas;
mod shallow_water;
mod tracer;
