//! Reads MPAS files: small ones that the tests write themselves, and real ones where the test data are there.

mod changed;
mod damaged;
mod made;
mod mesh;
mod real;
mod refused;
