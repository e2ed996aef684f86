// The arguments of the draws that are listed, one after the other in each bucket.

struct Which { lanes: u32, groups: u32, draws: u32, mode: u32 }

// Five words a draw each.
@group(0) @binding(3) var<storage, read> all: array<u32>;
@group(0) @binding(4) var<storage, read_write> arguments: array<u32>;
@group(0) @binding(5) var<uniform> which: Which;

@compute @workgroup_size(256)
fn gather(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let number = group.x + group.y * ROW;
    if number >= which.groups { return; }
    let at = number * 256u + lane;
    if !is_listed_lane(at) { return; }
    let to = place_of(at) * 5u;
    let own = at * 5u;
    arguments[to] = all[own];
    arguments[to + 1u] = 1u;
    arguments[to + 2u] = all[own + 2u];
    arguments[to + 3u] = all[own + 3u];
    arguments[to + 4u] = all[own + 4u];
}
