//! The back-face test.

use cullet::cull::backface::{Facing, ObjectEye};
use cullet::{CullFace, FrontFace, Transform};

use crate::finding::Finding;
use crate::item::{BLANK, Item, Live, zachmann};
use crate::lab::{Lab, LabError};

pub(super) const ITEMS: &[Item] = &[Item {
    number: 21,
    title: "A worked example",
    places: &[zachmann("slide 10")],
    claim: "Seen along (−1, 0, −1), the face with normal (2, 1, 2) looks towards the eye, the one with normal (−3, 1, −2) away from it.",
    said: Some("n·v = −4 and 5"),
    command: "cullet quiz backface-1",
    live: Some(Live { scene: "solids", state: "layout=split&look.colour=reasons" }),
    chapter: "backface.md#the-test",
    check: worked_example,
    ..BLANK
}];

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
