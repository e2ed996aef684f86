//! Cameras, standing or moved by animations.

use cullet::{Projection, Transform};
use glam::DAffine3;

use super::json::{self, CameraItem, Root};
use super::nodes::Nodes;
use super::notes::Notes;
use crate::motion::{Clip, transform};
use crate::{CameraNode, ErrorKind};

/// More work than this to sample animations is no camera path but an attack.
const MOST_WORK: u64 = 50_000_000;

/// Makes a camera of every node in `placed` that has one: with one key where it stands, and one
/// more camera for each animation that moves it.
///
/// # Errors
/// If a camera is malformed.
pub(super) fn read(
    root: &Root<'_>,
    nodes: &Nodes,
    placed: &[(u32, DAffine3)],
    clips: &[Clip],
    notes: &mut Notes,
) -> Result<Vec<CameraNode>, ErrorKind> {
    let items = json::all(&root.cameras);
    let chains: Vec<Vec<u32>> = placed.iter().map(|&(node, _)| nodes.chain(node)).collect();
    let mut cameras = Vec::new();
    let mut work = 0u64;
    for ((node, global), chain) in placed.iter().zip(&chains) {
        let Some(index) = nodes.all[*node as usize].camera else { continue };
        let item: CameraItem<'_> = json::item(items[index as usize], "camera", index as usize)?;
        // Programs name the node or the camera; the node is where it stands, so it goes first.
        let name = match (&nodes.all[*node as usize].name, &item.name) {
            (None, Some(name)) if !name.is_empty() => super::uri::shorten(name),
            _ => nodes.name(*node),
        };
        let Some(projection) = projection(&item) else {
            notes.push(&name, "is a camera whose numbers make no projection, and is left out");
            continue;
        };
        if !global.is_finite() {
            notes.push(&name, "is a camera whose transform is not finite, and is left out");
            continue;
        }
        let moving: Vec<&Clip> = clips.iter().filter(|c| c.moves(chain)).collect();
        if moving.is_empty() {
            cameras.push(CameraNode { name, projection, keys: vec![(0.0, transform(global))] });
            continue;
        }
        for clip in &moving {
            let name = match moving.len() {
                1 => name.clone(),
                _ => format!("{name}/{}", clip.name),
            };
            work = work.saturating_add(clip.cost(chain));
            if work > MOST_WORK {
                notes.push(&name, "has more keys than can be sampled, and stands still");
                let keys = vec![(0.0, transform(global))];
                cameras.push(CameraNode { name, projection, keys });
                continue;
            }
            let keys: Vec<(f64, Transform)> = clip
                .keys(chain, nodes)
                .iter()
                .map(|(t, m)| (*t, transform(m)))
                .filter(|(_, m)| m.is_finite())
                .collect();
            cameras.push(CameraNode { name, projection, keys });
        }
    }
    Ok(cameras)
}

/// The projection of a camera, if its numbers make one.
fn projection(item: &CameraItem<'_>) -> Option<Projection> {
    let finite = |v: f64| v.is_finite().then_some(v);
    if let Some(p) = &item.perspective {
        let far = match p.zfar {
            Some(far) => finite(far)?,
            None => f64::INFINITY,
        };
        let aspect = match p.aspect_ratio {
            Some(aspect) => finite(aspect).filter(|&a| a > 0.0)?,
            None => 0.0,
        };
        let (fov_y_radians, near) = (finite(p.yfov)?, finite(p.znear)?);
        let good =
            fov_y_radians > 0.0 && fov_y_radians < std::f64::consts::PI && near > 0.0 && far > near;
        return good.then_some(Projection::Perspective { fov_y_radians, aspect, near, far });
    }
    let o = item.orthographic.as_ref()?;
    let (x, y) = (finite(o.xmag)?, finite(o.ymag)?);
    let (near, far) = (finite(o.znear)?, finite(o.zfar)?);
    let good = x != 0.0 && y != 0.0 && far > near;
    good.then_some(Projection::Orthographic { left: -x, right: x, bottom: -y, top: y, near, far })
}
