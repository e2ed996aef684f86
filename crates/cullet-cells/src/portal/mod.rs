//! Portal culling: what an eye sees of cells through the portals between them.
//!
//! From the cell of the eye through open portals, depth first, each portal clipped by what is seen
//! of the ones before (Luebke & Georges, *Portals and Mirrors: Simple, Fast Evaluation of
//! Potentially Visible Sets*, 1995, with polygons in place of their rectangles). What is left of a
//! portal bounds what is seen behind it: by the planes through the eye and its edges. Polygons are
//! clipped in coordinates relative to the eye, before any divide, so that no portal is ever too
//! near.
//!
//! Planes are made of the portals' own corners and never of corners that clipping made: clipping
//! only chooses which of them bound what is seen. So errors do not add up along a chain, and where
//! there is doubt, one plane fewer means that more is seen.
//!
//! ```
//! use cullet::View;
//! use cullet_cells::cell::{CellGraph, Portal};
//! use cullet_cells::portal::{PortalOptions, PortalView, Reached, walk_portals};
//!
//! // Three rooms in a row along −z, a door between each two: the second is out of line.
//! let door = |x: f64, z: f64| vec![[x, 0.0, z], [x + 1.0, 0.0, z], [x + 1.0, 2.0, z], [x, 2.0, z]];
//! let portals = vec![
//!     Portal { cells: [0, 1], polygon: door(0.0, -4.0) },
//!     Portal { cells: [1, 2], polygon: door(9.0, -8.0) },
//! ];
//! let graph = CellGraph::new(3, portals)?;
//! let view = View::perspective([0.5, 1.0, 0.0], [0.5, 1.0, -1.0], 1.0, 0.1, 100.0, [640, 480])?;
//! let (view, mut reached) = (PortalView::new(&view).unwrap(), Reached::default());
//! walk_portals(&graph, &view, &[0], &PortalOptions::default(), &mut reached);
//! let cells: Vec<u32> = reached.visits().iter().map(|visit| visit.cell).collect();
//! assert_eq!(cells, [0, 1]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod polygon;
mod reference;
mod view;
mod walk;

pub use reference::{RayEnd, ray_cells_ref};
pub use view::PortalView;
pub use walk::{Reached, Visit, walk_portals};

/// How portals are cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum PortalClip {
    /// Polygons. The planes through the edges of a portal bound what is seen behind it.
    #[default]
    Polygons,
    /// Rectangles of the screen around the portals. They have four planes each and are found
    /// sooner. They let more be seen where doors are not upright in the picture.
    Rectangles,
}

/// Settings of portal culling.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct PortalOptions {
    /// How portals are cut. Default [`PortalClip::Polygons`].
    pub clip: PortalClip,
    /// The most portals of a chain. What is behind the last counts as seen, as far as the view
    /// reaches. Default 64.
    pub depth: u32,
    /// The most visits to cells: one is reached once by every chain that leads to it. Of the
    /// portals that are left then, all that is behind counts as seen, as far as the view reaches.
    /// Default 4,096.
    pub visits: u32,
    /// The most mirrors of a chain. What is behind the last is left out: a picture in a mirror ends
    /// there. Default 0, for what a mirror shows is drawn by a view of its own.
    pub mirrors: u32,
}

impl Default for PortalOptions {
    fn default() -> Self {
        Self { clip: PortalClip::default(), depth: 64, visits: 4096, mirrors: 0 }
    }
}
