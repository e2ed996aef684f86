//! Hierarchies of bounding volumes.

use cullet::Simd;
use cullet::bounds::Side;
use cullet::cull::frustum::batch::{Indices, Planes, cull_boxes};
use cullet::cull::frustum::tree::Trace;

use crate::lecture::finding::Finding;
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::SIZE;

/// Nodes enclose what is below them; the walk from the top keeps what a test of each instance keeps, with fewer tests.
pub(super) fn walk(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene("city:cells=12,objects=1500")?;
    let hierarchy = model.scene.hierarchy();
    let (nodes, boxes) = (hierarchy.nodes(), hierarchy.boxes());
    if let Err(error) = hierarchy.validate() {
        return Ok(Finding::fails(format!("a node does not enclose what is below it: {error}")));
    }
    let (mut tested, mut flat, mut differ) = (0, 0, 0);
    let mut groups = [0; 3];
    let mut each = Indices::new();
    for view in lab.views(&model, "walk", 6, SIZE)? {
        let planes = Planes::new(&view.frustum().relative_to(model.scene.origin()));
        let trace = Trace::new(&planes, nodes, boxes);
        for side in trace.levels[1..].iter().flatten().flatten() {
            groups[*side as usize] += 1;
        }
        tested += trace.levels.iter().flatten().flatten().count();
        flat += boxes.len();
        cull_boxes(Simd::best(), &planes, boxes, &mut each);
        differ += usize::from(trace.visible(&planes, boxes) != *each);
    }
    let [inside, straddling, outside] =
        [Side::Inside, Side::Straddling, Side::Outside].map(|side| groups[side as usize]);
    Ok(Finding::if_so(
        differ == 0 && tested < flat && outside > 0 && inside > 0 && straddling > 0,
        format!(
            "in six views {outside} groups go whole, {inside} stay whole and {straddling} are opened: {tested} tests of groups and \
             instances in place of {flat} of instances, with another result in {differ} views"
        ),
    ))
}
