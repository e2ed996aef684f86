//! Occluders of meshes that Godot draws coarser from afar.
//!
//! An occluder must hide at every level, for Godot chooses which one is drawn. A box inside
//! of what one level seals off and inside of what another seals off is inside of both; so is the
//! part that two boxes share. Boxes are made for each level by the baker, and what they share is
//! kept.
//!
//! Surfaces of one mesh choose their levels one by one, but all by the distance of the node: each takes the
//! last level whose edges are no longer than some length on the screen allows. So there are no more
//! mixtures than lengths, and an occluder of a mesh of several surfaces must hide in each mixture.

use cullet::Mesh;
use cullet::bounds::Aabb;
use cullet::cull::occlusion::Occluder;
use cullet_bake::occluders::{OccluderOptions, Occluders, occluders};

/// Boxes at the most.
const MOST: usize = 16;
/// Mixtures of levels at the most: a mesh of more hides nothing, for boxes are made for each.
const MOST_MIXTURES: usize = 24;

/// Returns the level of each surface in all mixtures that Godot draws, the finest first. `edges` holds the
/// lengths from which on each surface is drawn coarser. `None` where there are too many, or one is no
/// number.
pub(crate) fn mixtures(edges: &[Vec<f32>]) -> Option<Vec<Vec<usize>>> {
    let mut lengths: Vec<f32> = edges.iter().flatten().copied().collect();
    if lengths.iter().any(|length| length.is_nan()) {
        return None;
    }
    lengths.sort_by(f32::total_cmp);
    let at = |most: f32| {
        let level = |own: &Vec<f32>| own.iter().take_while(|&&length| length <= most).count();
        edges.iter().map(level).collect::<Vec<usize>>()
    };
    let mut mixtures = vec![vec![0; edges.len()]];
    mixtures.extend(lengths.into_iter().map(at));
    mixtures.dedup();
    (mixtures.len() <= MOST_MIXTURES).then_some(mixtures)
}

/// Returns an occluder that lies within `fine` and within each of `coarse`; `None` if there is
/// none.
pub(crate) fn inside_all(fine: &Mesh, coarse: &[Mesh]) -> Option<Occluder> {
    let mut shared = boxes_of(fine)?;
    for level in coarse {
        let own = boxes_of(level)?;
        shared = both(&shared, &own);
        if shared.boxes.is_empty() {
            return None;
        }
    }
    shared.to_engine().ok()
}

/// Returns boxes inside of a mesh.
fn boxes_of(mesh: &Mesh) -> Option<Occluders> {
    let options = OccluderOptions {
        max_boxes: MOST as u32,
        max_polygons: 0,
        max_triangles: 0,
        max_near: 0,
        resolution: 48,
        directions: 0,
        ..OccluderOptions::default()
    };
    let (made, _) = occluders(mesh, &options).ok()?;
    (!made.boxes.is_empty()).then_some(made)
}

/// Returns what boxes of both share, and all that either seals off.
fn both(a: &Occluders, b: &Occluders) -> Occluders {
    let pairs = a.boxes.iter().flat_map(|x| b.boxes.iter().map(move |y| x.intersection(y)));
    let has_inside = |b: &Aabb| (0..3).all(|axis| b.max[axis] > b.min[axis]);
    let mut boxes: Vec<Aabb> = pairs.filter(has_inside).collect();
    // The largest first, without those that another holds.
    boxes.sort_by(|x, y| y.surface_area().total_cmp(&x.surface_area()));
    let mut kept: Vec<Aabb> = Vec::new();
    for one in boxes {
        let holds = |by: &&Aabb| {
            (0..3).all(|axis| by.min[axis] <= one.min[axis] && by.max[axis] >= one.max[axis])
        };
        if kept.len() < MOST && !kept.iter().any(|by| holds(&by)) {
            kept.push(one);
        }
    }
    let sealed = a.sealed.iter().chain(&b.sealed).copied().collect();
    Occluders { boxes: kept, sealed, ..Occluders::default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet::MeshData;
    use cullet::mesh::Part;

    fn block(half: [f32; 3]) -> Mesh {
        let corner =
            |i: u32| std::array::from_fn(|a| if i >> a & 1 == 1 { half[a] } else { -half[a] });
        let quads =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let indices = quads.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect();
        let parts = vec![Part { triangle_count: 12, ..Part::default() }];
        let positions = (0..8).map(corner).collect();
        Mesh::new(MeshData { positions, indices, parts, ..MeshData::default() }).unwrap()
    }

    #[test]
    fn surfaces_grow_coarser_by_the_length_of_their_edges() {
        let of =
            |edges: &[&[f32]]| mixtures(&edges.iter().map(|own| own.to_vec()).collect::<Vec<_>>());
        assert_eq!(of(&[&[]]), Some(vec![vec![0]]));
        assert_eq!(of(&[&[1.0, 2.0]]), Some(vec![vec![0], vec![1], vec![2]]));
        let two = of(&[&[1.0, 3.0], &[], &[2.0, 3.0]]).unwrap();
        assert_eq!(two, [[0, 0, 0], [1, 0, 0], [1, 0, 1], [2, 0, 2]]);
        // Godot looks no further than to the first level that is too coarse.
        assert_eq!(of(&[&[2.0, 1.0]]), Some(vec![vec![0], vec![2]]));
        assert_eq!(of(&[&[f32::NAN]]), None);
        let many: Vec<f32> = (0..30).map(|i| i as f32).collect();
        assert_eq!(of(&[&many]), None);
    }

    #[test]
    fn what_levels_share_is_inside_of_each() {
        let (a, b) = (boxes_of(&block([2.0, 1.0, 1.0])), boxes_of(&block([1.0, 2.0, 1.0])));
        let shared = both(&a.unwrap(), &b.unwrap());
        assert_eq!(shared.boxes.len(), 1);
        let [low, high] = [shared.boxes[0].min, shared.boxes[0].max];
        assert!(
            low.iter().chain(&high).all(|v| v.abs() <= 1.0 && v.abs() > 0.9),
            "{low:?} {high:?}"
        );
        assert!(inside_all(&block([1.0; 3]), &[block([0.5; 3])]).is_some());
    }

    #[test]
    fn levels_that_share_nothing_hide_nothing() {
        let apart =
            Occluders { boxes: vec![Aabb::new([5.0; 3], [6.0; 3])], ..Occluders::default() };
        let one = boxes_of(&block([1.0; 3])).unwrap();
        assert!(both(&one, &apart).boxes.is_empty());
    }
}
