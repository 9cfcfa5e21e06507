//! Datasets of all conventions, from sources in memory.

mod asked;
mod columns;
mod completed;
mod conventions;
mod edges;
mod groups;
mod icon;
mod icon_sea;
mod layers;
mod made;
mod made_icon;
mod made_ocean;
mod memory;
mod mesh;
mod native;
mod ocean;
mod other_meshes;
mod refused;
mod two_d;
mod ugrid;
mod valid;
