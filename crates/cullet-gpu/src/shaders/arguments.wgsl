// Of each cluster a draw: of one instance where its bit is set, else of none.

struct Which { count: u32, mode: u32, padding: vec2<u32> }

@group(0) @binding(0) var<storage, read> bits: array<u32>;
@group(0) @binding(1) var<storage, read> seen: array<u32>;
// Five words a draw, of which the second is how many instances.
@group(0) @binding(2) var<storage, read_write> arguments: array<u32>;
@group(0) @binding(3) var<uniform> which: Which;

@compute @workgroup_size(256)
fn fill(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let number = (group.x + group.y * ROW) * 256u + lane;
    if number >= which.count { return; }
    let word = listed(bits[number / 32u], seen[number / 32u], which.mode);
    arguments[number * 5u + 1u] = (word >> (number % 32u)) & 1u;
}
