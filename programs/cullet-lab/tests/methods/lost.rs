//! No front face is lost: every form of the test, on five models, from hundreds of eyes each, near
//! and far and within the model, against f64.

use cullet::bounds::Sphere;
use cullet::cull::backface::Planes8;
use cullet::cull::backface::{ClusterPlanes, EllipticCone};
use cullet::{Mesh, MeshData, Simd};
use cullet_lab::methods::cluster::{
    Bound, ClusterBounds, EllipticConeQuantised, NormalBox, NormalBoxAtOrigin, NormalBoxTurned,
    NormalCone, Pyramid,
};
use cullet_lab::methods::{Bulk, Planes16, Planes32};
use cullet_mesh::{MaskGrid, NormalMasks, ViewCone};
use cullet_testkit::cases;
use cullet_testkit::models::model;
use cullet_testkit::vectors::{fibonacci, front};

/// One form: sets the bits of what it culls, of triangles or of clusters.
type Cull = Box<dyn Fn([f64; 4], &mut Vec<u64>)>;

struct Form {
    name: String,
    by_cluster: bool,
    cull: Cull,
    culled: u64,
}

impl Form {
    fn new(name: &str, by_cluster: bool, cull: impl Fn([f64; 4], &mut Vec<u64>) + 'static) -> Self {
        Self { name: name.to_owned(), by_cluster, cull: Box::new(cull), culled: 0 }
    }

    fn bound<B: Bound + 'static>(name: &str, planes: &[ClusterPlanes]) -> Self {
        let bounds: ClusterBounds<B> = planes.iter().map(B::fit).collect();
        Self::new(name, true, move |eye, words| bounds.cull(Simd::best(), eye, words))
    }
}

fn forms(mesh: &Mesh, sphere: Sphere) -> Vec<Form> {
    let (positions, indices) = (mesh.positions(), mesh.indices());
    let level = Simd::best();
    let mut forms = Vec::new();
    for n in [4, 16] {
        let grid = MaskGrid::new(n).expect("in range");
        let mut masks = NormalMasks::default();
        grid.encode_triangles(positions, indices, &mut masks);
        forms.push(Form::new(&format!("masks, N = {n}"), false, move |eye, words| {
            let cone = ViewCone::to_sphere(eye, &sphere);
            masks.cull(level, &grid.mask(level, cone.as_ref()), words);
        }));
    }
    let planes = Planes8::new(positions, indices);
    forms.push(Form::new("planes8", false, move |eye, words| planes.cull(level, eye, words)));
    let planes = Planes16::new(positions, indices);
    forms.push(Form::new("planes16", false, move |eye, words| planes.cull(level, eye, words)));
    let planes = Planes32::new(positions, indices);
    forms.push(Form::new("planes32", false, move |eye, words| planes.cull(level, eye, words)));

    let corners = |c: &cullet::mesh::Cluster| c.triangles().map(|t| mesh.corners(t));
    let planes: Vec<_> = mesh.clusters().iter().map(|c| ClusterPlanes::new(corners(c))).collect();
    forms.push(Form::bound::<NormalCone>("normal cone", &planes));
    forms.push(Form::bound::<NormalBox>("normal box", &planes));
    forms.push(Form::bound::<NormalBoxAtOrigin>("normal box at the origin", &planes));
    forms.push(Form::bound::<NormalBoxTurned>("normal box, turned", &planes));
    forms.push(Form::bound::<EllipticCone>("elliptic cone", &planes));
    forms.push(Form::bound::<EllipticConeQuantised>("elliptic cone, quantised", &planes));
    forms.push(Form::bound::<Pyramid<6>>("pyramid of six", &planes));
    forms.push(Form::bound::<Pyramid<8>>("pyramid of eight", &planes));
    forms
}

#[test]
fn no_form_loses_a_front_face() {
    let paths = [
        "stanford-bunny/bun_zipper.ply",
        "armadillo/armadillo.obj",
        "classic-meshes/cow.obj",
        "classic-meshes/fandisk.obj",
        "classic-meshes/rocker-arm.obj",
    ];
    for path in paths {
        let Some((positions, indices)) = model(path) else { continue };
        let data = MeshData { positions, indices, ..MeshData::default() };
        let mesh = Mesh::new(data).expect("a good mesh");
        let sphere = Sphere::from_points(mesh.positions());
        let (centre, radius) = (sphere.center.map(f64::from), f64::from(sphere.radius));
        let mut forms = forms(&mesh, sphere);
        let drawn = mesh.triangle_count() - mesh.degenerate_count();
        let (mut in_front, mut words) = (vec![0_u64; drawn.div_ceil(64) as usize], Vec::new());
        let views = cases(400) as usize;
        for view in 0..views {
            // A stride that shares no factor with their number.
            let d = fibonacci(view * 367 % views, views);
            // From well within the sphere to twenty radii, and some without a place.
            let far = radius * [0.3, 0.9, 1.05, 1.5, 3.0, 20.0][view % 6];
            let eye = match view % 25 {
                24 => [d[0], d[1], d[2], 0.0],
                _ => [centre[0] + d[0] * far, centre[1] + d[1] * far, centre[2] + d[2] * far, 1.0],
            };
            in_front.fill(0);
            for t in 0..drawn {
                let (value, size) = front(mesh.corners(t), eye);
                // A triangle that f64 cannot tell from edge-on is nobody's front.
                in_front[t as usize / 64] |= u64::from(value > size * 1e-13) << (t % 64);
            }
            for form in &mut forms {
                (form.cull)(eye, &mut words);
                let lost = |t: u32| in_front[t as usize / 64] >> (t % 64) & 1 == 1;
                let found = if form.by_cluster {
                    let gone = mesh.clusters().iter().enumerate();
                    let mut gone = gone.filter(|(c, _)| words[c / 64] >> (c % 64) & 1 == 1);
                    form.culled += gone.clone().count() as u64;
                    gone.find_map(|(_, c)| c.triangles().find(|&t| lost(t)))
                } else {
                    let drawn = words.iter().zip(&in_front).enumerate();
                    form.culled += words.iter().map(|w| u64::from(w.count_ones())).sum::<u64>();
                    let mut bad = drawn.filter(|(_, (culled, front))| *culled & *front != 0);
                    bad.next().map(|(w, (c, f))| w as u32 * 64 + (c & f).trailing_zeros())
                };
                assert_eq!(found, None, "{path}, {}: triangle lost from {eye:?}", form.name);
            }
        }
        for form in &forms {
            assert!(form.culled > 0, "{path}: {} culls nothing at all", form.name);
        }
    }
}
