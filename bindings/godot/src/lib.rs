//! Cullet for Godot 4: a node that hides, in each frame, what no camera of its world can see.
//!
//! | module | holds |
//! |---|---|
//! | [`world`] | the node [`CulletWorld`](world::CulletWorld): settings, and what Godot calls |
//! | [`inbox`], [`mover`], [`marks`] | what Godot reports: nodes that come, go, move and are marked |
//! | [`registry`] | everything of one world that is followed: drawn nodes, viewports, lights, probes |
//! | [`mirror`], [`item`], [`parts`] | the engine's scene, kept in step with drawn nodes |
//! | [`look`], [`material`] | what a node's mesh and materials say: bounds, and whether it hides |
//! | [`meshes`], [`levels`] | occluders made of Godot's meshes |
//! | [`views`], [`probes`], [`lights`] | who looks: cameras, reflection probes, lights with shadows |
//! | [`dark`] | lamps that light nothing seen |
//! | [`pvs`] | baked visibility: which nodes may be seen from where |
//! | [`scripts`], [`watched`] | what scripts may ask and be told |
//! | [`explain`], [`preview`] | why a node is drawn or not; decisions that hide nothing, for the editor |
//! | [`frame`], [`shown`], [`told`] | a frame: culling, and what follows for Godot's server |

mod convert;
mod dark;
mod entry;
mod explain;
mod frame;
mod inbox;
mod item;
mod levels;
mod lights;
mod look;
mod marks;
mod material;
mod meshes;
mod mirror;
mod mover;
mod parts;
mod preview;
mod probes;
mod pvs;
mod registry;
mod scripts;
mod shown;
mod told;
mod views;
mod watched;
mod world;
