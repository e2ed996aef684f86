//! Pictures of cells and portals show what the culler found, in the colours that they say.

use cullet::{Camera, Culler, Depth, Projection, View};
use cullet_cells::InCells;
use cullet_cells::portal::Reached;
use cullet_draw::{
    PairShown, Picture, cells, depth_color, portals, pvs_matrix, shown_portals, shut_doors,
    walk_order,
};
use cullet_io::Model;

const SHUT: [u8; 3] = [0xD8, 0x2C, 0x20];
const IN_SIGHT: [u8; 3] = [0xFF, 0xD2, 0x3F];

/// A view of an office in its corridor, and a cull of it.
fn office(spec: &str) -> (Model, View, Reached) {
    let model = cullet_scenes::build(spec).unwrap();
    let world = model.in_cells();
    // In the first cell that one looks out of.
    let graph = world.graph().unwrap();
    let eye = (0..400)
        .map(|k| [f64::from(k % 20) * 1.3 + 0.7, 1.7, f64::from(k / 20) * 1.1 + 0.6])
        .find(|p| world.cell_of(*p).is_some_and(|c| graph.portals_of(c).len() > 3))
        .unwrap();
    let projection =
        Projection::Perspective { fov_y_radians: 1.2, aspect: 1.6, near: 0.05, far: f64::INFINITY };
    let target = [eye[0] + 1.0, eye[1], eye[2] + 0.08];
    let camera = Camera::look_at(eye, target, projection);
    let view = View::new(&camera, Depth::Reversed, [320, 200]).unwrap();
    let reached = world.reached(&Culler::default(), &view).expect("the eye is in cells alone");
    (model, view, reached)
}

fn count(picture: &Picture, color: [u8; 3]) -> usize {
    picture.rgb.chunks_exact(3).filter(|c| **c == color).count()
}

#[test]
fn the_order_of_the_walk_is_depth_first() {
    let (_, view, reached) = office("office:closed=0");
    let reached = &reached;
    let order = walk_order(reached);
    assert_eq!(order.len(), reached.visits().len());
    // Each comes after the one that it is seen from, and nothing of another chain between.
    let mut open: Vec<u32> = Vec::new();
    for &number in &order {
        let parent = reached.visits()[number as usize].parent;
        while open.last().copied() != parent && !open.is_empty() {
            open.pop();
        }
        assert_eq!(open.last().copied(), parent);
        open.push(number);
    }
    let shown = shown_portals(&view, reached);
    assert!(!shown.is_empty());
    for portal in &shown {
        let inside = |p: &[f64; 2]| p[0] >= -4.0 && p[0] <= 324.0 && p[1] >= -3.0 && p[1] <= 203.0;
        assert!(portal.screen.iter().all(inside), "{portal:?}");
    }
}

#[test]
fn a_shut_door_is_red_and_no_chain_leads_through_it() {
    let (mut model, view, reached) = office("office:closed=0");
    let reached = &reached;
    assert!(shut_doors(model.in_cells().graph().unwrap(), &view, reached).is_empty());
    let shown = shown_portals(&view, reached);
    // One that is seen as a whole, and no part of another: the eye is not in it.
    let door = shown.iter().find(|p| p.depth == 1 && p.screen.len() >= 3).unwrap().portal;
    let open = portals(model.in_cells(), &view, Some(reached), &[]);
    assert!(count(&open, SHUT) < 20, "{}", count(&open, SHUT));
    assert!(count(&open, depth_color(1)) > 100);

    model.placed.as_mut().unwrap().set_portal_open(door, false);
    let world = model.in_cells();
    let reached = &world.reached(&Culler::default(), &view).unwrap();
    assert!(shown_portals(&view, reached).iter().all(|portal| portal.portal != door));
    let doors = shut_doors(world.graph().unwrap(), &view, reached);
    assert_eq!(doors.iter().map(|d| d.portal).collect::<Vec<_>>(), [door]);
    assert!(count(&portals(world, &view, Some(reached), &[]), SHUT) > 100);
}

#[test]
fn a_plan_shows_what_is_in_sight_and_shut_doors() {
    let (model, view, reached) = office("office:closed=50");
    let seen = |reached: Option<&Reached>| cells(model.in_cells(), &view, reached, [640, 480]);
    let near = |picture: &Picture, color: [u8; 3]| {
        let near = |c: &[u8]| (0..3).all(|k| c[k].abs_diff(color[k]) < 50);
        picture.rgb.chunks_exact(3).filter(|c| near(c)).count()
    };
    let picture = seen(Some(&reached));
    assert_eq!((picture.width, picture.height), (640, 480));
    assert!(near(&picture, IN_SIGHT) > near(&seen(None), IN_SIGHT) + 200);
    assert!(near(&picture, SHUT) > 30);
}

#[test]
fn without_cells_there_are_words() {
    let scene = cullet_scenes::build("solids:n=3").unwrap().scene;
    let camera = Camera::look_at(
        [0.0, 0.0, 9.0],
        [0.0; 3],
        Projection::Perspective { fov_y_radians: 1.0, aspect: 1.5, near: 0.1, far: 100.0 },
    );
    let view = View::new(&camera, Depth::Reversed, [96, 64]).unwrap();
    assert_eq!(portals(InCells::from(&scene), &view, None, &[]).width, 480);
    assert_eq!(cells(InCells::from(&scene), &view, None, [96, 64]).width, 320);
    let matrix = pvs_matrix(&[], |_, _| PairShown::Hidden, "none", [300, 300]);
    assert!(matrix.height >= 300);
}
