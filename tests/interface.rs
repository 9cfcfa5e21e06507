//! The C and Fortran interfaces from outside: programs that link the library in one process.

mod abi;
mod fortran;
mod host;
mod layouts;
mod recipes;
