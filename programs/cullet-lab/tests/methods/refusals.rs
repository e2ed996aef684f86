//! Clusters kept because nothing is proved: eyes that are none, and spheres.

use cullet::MeshData;
use cullet::Simd;
use cullet::bounds::Sphere;
use cullet::cull::backface::{ClusterPlanes, EllipticCone, Planes8};
use cullet_lab::methods::cluster::{Bound, ClusterBounds};
use cullet_lab::methods::{Bulk, Groups, Planes16, Planes32};
use cullet_mesh::{BackfaceMask, MaskGrid, ViewCone};

const FAR: [f64; 4] = [3.0, 5.0, 7.0, 1.0];

/// A tetrahedron wound outward.
fn solid() -> MeshData {
    MeshData {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        indices: vec![0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3],
        ..MeshData::default()
    }
}

#[test]
fn numbers_out_of_range_keep_everything() {
    let sphere = |radius: f32| Sphere { center: [0.0; 3], radius };
    // A point has one line of sight; from itself, none.
    let cone = ViewCone::to_sphere(FAR, &sphere(0.0)).expect("a point");
    assert_eq!(cone.sine, 0.0);
    assert_eq!(ViewCone::to_sphere([0.0, 0.0, 0.0, 1.0], &sphere(0.0)), None);
    for radius in [-1.0, f32::NAN, f32::INFINITY] {
        assert_eq!(ViewCone::to_sphere(FAR, &sphere(radius)), None, "{radius}");
    }

    let data = solid();
    let (positions, indices) = (&data.positions, &data.indices);
    let planes = (
        Planes8::new(positions, indices),
        Planes16::new(positions, indices),
        Planes32::new(positions, indices),
    );
    let corners = indices.as_chunks::<3>().0.iter().map(|t| t.map(|v| positions[v as usize]));
    let fits = corners.map(|t| EllipticCone::fit(&ClusterPlanes::new([t])));
    let bounds: ClusterBounds<EllipticCone> = fits.collect();
    assert_eq!(bounds.count(Simd::best(), FAR), 3);
    let groups = Groups::kd(positions, indices, 2);
    let grid = MaskGrid::new(16).expect("in range");
    let level = Simd::best();
    let mut eyes = vec![[0.0; 4], [3.0, 5.0, 7.0, -1.0]];
    for k in 0..4 {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut eye = FAR;
            eye[k] = bad;
            eyes.push(eye);
        }
    }
    for eye in eyes {
        assert_eq!(planes.0.count(level, eye), 0, "{eye:?}");
        assert_eq!(planes.1.count(level, eye), 0, "{eye:?}");
        assert_eq!(planes.2.count(level, eye), 0, "{eye:?}");
        assert_eq!(bounds.count(level, eye), 0, "{eye:?}");
        assert_eq!(ViewCone::to_sphere(eye, &sphere(1.0)), None, "{eye:?}");
        assert!(groups.masks(level, &grid, eye).all(|m| m == BackfaceMask::NOTHING), "{eye:?}");
    }
    assert_eq!(planes.0.count(level, FAR), 3);
}
