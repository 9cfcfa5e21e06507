//! Reads MPAS files: small ones that the tests write themselves, and real ones where the test data are there.

mod asked;
mod changed;
mod completed;
mod damaged;
mod icon;
mod icon_sea;
mod made;
mod made_icon;
mod made_ocean;
mod mesh;
mod native;
mod ocean;
mod real;
mod refused;
mod two_d;
mod ugrid;
mod valid;
