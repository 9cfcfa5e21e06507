//! Datasets of all conventions, from sources in memory.

mod columns;
mod completed;
mod conventions;
mod edges;
mod groups;
mod icon;
mod layers;
mod made;
mod made_icon;
mod memory;
mod mesh;
mod native;
mod ocean;
mod other_meshes;
mod refused;
mod two_d;
mod ugrid;
