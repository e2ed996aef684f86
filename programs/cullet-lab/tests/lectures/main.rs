//! The items of the lectures: each is whole, each claim that commands show holds, and those that
//! nothing else shows.

mod backface;
mod bounds;
mod clipping;
mod costs;
mod data;
mod joined;
mod masks;
mod planes;
mod tools;
