//! The back-face test.

mod demo;
mod solids;
mod test;

use cullet::cull::backface::{Facing, ObjectEye};
use cullet::{CullFace, FrontFace, Transform};

use crate::lecture::finding::Finding;
use crate::lecture::item::{BLANK, Item, Live, kaist, ucsd, zachmann, zhang_hoff};
use crate::lecture::lab::{Lab, LabError};

pub(super) const ITEMS: &[Item] = &[
    Item {
        number: 17,
        title: "Solids",
        places: &[zachmann("slide 8"), kaist("Back-Face Culling")],
        claim: "A solid is closed, opaque and encloses a volume. Of a solid no back face is ever visible from outside; of anything else it may be.",
        command: "cullet info solids",
        live: Some(Live { scene: "solids", state: "layout=split&look.colour=sides" }),
        chapter: "backface.md#when-it-may-be-done",
        check: solids::definition,
        ..BLANK
    },
    Item {
        number: 18,
        title: "Convex bodies have one back side",
        places: &[zachmann("slide 8")],
        claim: "Of a convex solid all that faces away from an eye outside hangs together. Of another it may be in several pieces.",
        command: "cullet picture back-regions knobs --views 8 --view 1",
        live: Some(Live { scene: "knobs", state: "layout=split&look.colour=sides" }),
        chapter: "backface.md#when-it-may-be-done",
        check: solids::back_sides,
        ..BLANK
    },
    Item {
        number: 19,
        title: "The test of a triangle",
        places: &[
            zachmann("slide 9"),
            ucsd("Backface Culling"),
            kaist("Face Plane Test"),
            zhang_hoff("section 1"),
        ],
        claim: "A triangle with outward normal n faces away if n·v is above 0, where v leads from the eye to any point of the triangle.",
        fault: Some(
            "The slides of 2013 take v to all points of the polygon. All points of a plane have the same n·(p − eye), so any one of them decides, as \
             the slides of 2014 say.",
        ),
        command: "cullet picture kinds knobs --only backface",
        live: Some(Live { scene: "knobs", state: "layout=split&look.face_normals=true" }),
        chapter: "backface.md#the-test",
        check: test::any_point,
        ..BLANK
    },
    Item {
        number: 20,
        title: "The test in a parallel view",
        places: &[zachmann("slide 9")],
        claim: "In a parallel view v is the direction of sight, the same for all triangles: in the space of a camera that looks along −Z it \
                is (0, 0, −1).",
        said: Some("v = (0, 0, 1) in 2013, (0, 0, −1) in 2014"),
        fault: Some(
            "The slides of 2013 have v = (0, 0, 1). In a right-handed space a camera looks along −Z, and then that sign culls the fronts and keeps the \
             backs; it would be right where the camera looks along +Z, as in left-handed spaces.",
        ),
        command: "cullet picture normal-partition --fov 40",
        chapter: "backface.md#the-test",
        check: test::parallel,
        ..BLANK
    },
    Item {
        number: 21,
        title: "A worked example",
        places: &[zachmann("slide 10")],
        claim: "Seen along (−1, 0, −1), the face with normal (2, 1, 2) looks towards the eye, the one with normal (−3, 1, −2) away from it.",
        said: Some("n·v = −4 and 5"),
        command: "cullet quiz backface-1",
        live: Some(Live { scene: "solids", state: "layout=split&look.colour=reason" }),
        chapter: "backface.md#the-test",
        check: worked_example,
        ..BLANK
    },
    Item {
        number: 22,
        title: "Settings of graphics libraries",
        places: &[zachmann("slide 11"), ucsd("OpenGL"), kaist("Back-Face Culling in OpenGL")],
        claim: "OpenGL culls back faces, front faces or none (glEnable and glCullFace), and takes one of two windings for front (glFrontFace); so do \
                the libraries that came after it.",
        command: "cullet view knobs",
        live: Some(Live { scene: "knobs", state: "layout=split&look.cull=front" }),
        chapter: "backface.md#in-opengl-wgpu-and-direct3d",
        check: test::settings,
        ..BLANK
    },
    Item {
        number: 23,
        title: "Demo: mesh, vertices and faces",
        places: &[zachmann("slide 12")],
        claim: "The demo has a menu of meshes, and says of the one that is shown its name and how many vertices and faces it has. So do the viewer's \
                list of scenes and its title.",
        said: Some("80 vertices, 80 faces"),
        command: "cullet view knobs && cullet scenes",
        live: Some(Live { scene: "knobs", state: "" }),
        chapter: "viewer.md#the-window",
        check: demo::counts,
        ..BLANK
    },
    Item {
        number: 24,
        title: "Demo: faces rendered",
        places: &[zachmann("slide 12")],
        claim: "The demo counts the faces that are rendered, of all, and their share. The viewer's line of figures does.",
        said: Some("80/80 (100 %)"),
        command: "cullet view knobs",
        live: Some(Live { scene: "knobs", state: "stages.depth=triangles&layout=split" }),
        chapter: "viewer.md#the-window",
        check: demo::faces_rendered,
        ..BLANK
    },
    Item {
        number: 25,
        title: "Demo: frames per second",
        places: &[zachmann("slide 12")],
        claim: "The demo shows how many frames it draws in a second. The viewer does while *draw always* is on; else it draws when something changes.",
        said: Some("61.5 frames a second"),
        command: "cullet view knobs",
        live: Some(Live { scene: "knobs", state: "always=true" }),
        chapter: "viewer.md#the-window",
        check: demo::frames_per_second,
        ..BLANK
    },
    Item {
        number: 26,
        title: "Demo: ways to draw",
        places: &[zachmann("slide 12")],
        claim: "The demo has switches for filled faces, back faces, wireframe, face normals and high quality, and so has the viewer, under *Picture*. \
                Of open meshes its switch *sides* must say one-sided, or back faces are not culled.",
        command: "cullet view knobs --one-sided",
        live: Some(Live {
            scene: "knobs:n=12",
            state: "look.wireframe=true&look.face_normals=true&look.fine=true&sides=one-sided",
        }),
        chapter: "viewer.md#the-window",
        check: demo::switches,
        ..BLANK
    },
    Item {
        number: 27,
        title: "Demo: turning and scaling",
        places: &[zachmann("slide 12")],
        claim: "In the demo the mesh is turned by the pointer and scaled by the wheel, and drawn again all the time or on demand. In the viewer \
                these are *turn on hover*, wheel, *draw always* and *Refresh*.",
        said: Some("scale 70 %"),
        command: "cullet view knobs",
        live: Some(Live { scene: "knobs", state: "hover_turns=true&always=true&layout=split" }),
        chapter: "viewer.md#keys-and-pointer",
        check: demo::turning,
        ..BLANK
    },
    Item {
        number: 28,
        title: "Demo: clear object",
        places: &[zachmann("slide 12")],
        claim: "The demo can clear its object, so that nothing is shown until another is chosen; the viewer does by *Clear*, or the key `\\`.",
        command: "cullet view knobs",
        chapter: "viewer.md#the-window",
        check: demo::clear,
        ..BLANK
    },
];

fn worked_example(_: &Lab) -> Result<Finding, LabError> {
    let view = [-1.0, 0.0, -1.0];
    // A parallel view: the eye is a direction, towards the viewer.
    let eye = [-view[0], -view[1], -view[2], 0.0];
    let eye = ObjectEye::new(eye, &Transform::IDENTITY, FrontFace::default(), CullFace::default());
    let faces: [[[f32; 3]; 3]; 2] = [
        [[0.0; 3], [1.0, 0.0, -1.0], [0.0, 2.0, -1.0]],
        [[0.0; 3], [0.0, 2.0, 1.0], [1.0, 3.0, 0.0]],
    ];
    let along = faces.map(|face| {
        let normal = normal(&face);
        (0..3).map(|a| normal[a] * view[a]).sum::<f64>()
    });
    let facing = faces.map(|face| eye.facing(&face));
    Ok(Finding::if_so(
        along == [-4.0, 5.0] && facing == [Facing::Front, Facing::Back],
        format!(
            "n·v is {} and {}; the engine sees the first from the {} and the second from the {}",
            along[0],
            along[1],
            side(facing[0]),
            side(facing[1])
        ),
    ))
}

fn side(facing: Facing) -> &'static str {
    match facing {
        Facing::Front => "front",
        Facing::Back => "back",
        Facing::Edge => "edge",
    }
}

/// (b − a) × (c − a).
fn normal(face: &[[f32; 3]; 3]) -> [f64; 3] {
    let [a, b, c] = face.map(|p| p.map(f64::from));
    let from_a = |p: [f64; 3]| [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
    let (u, v) = (from_a(b), from_a(c));
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}
