// Which of the clusters that passed are of the level of detail of the view: those whose group they were made from is not over the
// threshold, and that in which they were simplified is. Integers only: every device gives the same answer, and one that leaves no hole.

struct Unit { slot: u32, made_from: u32, replaced_by: u32, padding: u32 }
struct Group { centre_xy: u32, centre_z: u32, radius: u32, error: u32 }
struct Eye { at: vec3<i32>, reach: u32, least: u32, ball: u32, padding: vec2<u32> }
struct View { blocks: u32, units: u32, padding: vec2<u32> }

@group(0) @binding(0) var<storage, read> in_use: array<InUse>;
@group(0) @binding(1) var<storage, read> units: array<Unit>;
@group(0) @binding(2) var<storage, read> groups: array<Group>;
@group(0) @binding(3) var<storage, read> eyes: array<Eye>;
// A bit a unit, eight words a block.
@group(0) @binding(4) var<storage, read_write> bits: array<u32>;
@group(0) @binding(5) var<uniform> view: View;

// In place of the number of a group: one that is over no threshold, or over any.
const NEVER = 0xfffffffeu;
const ALWAYS = 0xffffffffu;

// Both words of a product, the lower first.
fn product(a: u32, b: u32) -> vec2<u32> {
    let a_low = a & 0xffffu;
    let a_high = a >> 16u;
    let b_low = b & 0xffffu;
    let b_high = b >> 16u;
    let low = a_low * b_low;
    let middle = a_high * b_low + (low >> 16u);
    let rest = a_low * b_high + (middle & 0xffffu);
    let high = a_high * b_high + (middle >> 16u) + (rest >> 16u);
    return vec2<u32>((rest << 16u) | (low & 0xffffu), high);
}

fn plus(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let low = a.x + b.x;
    return vec2<u32>(low, a.y + b.y + u32(low < a.x));
}

fn saturating(a: u32, b: u32) -> u32 { return select(a + b, 0xffffffffu, a + b < a); }

fn is_over(number: u32, eye: Eye) -> bool {
    if number >= NEVER { return number == ALWAYS; }
    let own = groups[number];
    if own.error < eye.least { return false; }
    let reach = product(own.error, eye.reach);
    let whole = select((reach.y << 16u) | (reach.x >> 16u), 0xffffffffu, reach.y > 0xffffu);
    let far = saturating(saturating(own.radius, eye.ball), saturating(whole, 1u));
    let xy = vec2<i32>(lower_half(own.centre_xy), upper_half(own.centre_xy));
    let away = vec3<u32>(abs(eye.at - vec3<i32>(xy, lower_half(own.centre_z))));
    let across = plus(product(away.x, away.x), product(away.y, away.y));
    let square = plus(across, product(away.z, away.z));
    let limit = product(far, far);
    return square.y < limit.y || (square.y == limit.y && square.x <= limit.x);
}

var<workgroup> own_bits: array<atomic<u32>, 8>;

@compute @workgroup_size(256)
fn choose(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let number = group.x + group.y * ROW;
    // The same for the whole group.
    if number >= view.blocks { return; }
    let block = in_use[number].block;
    let at = block * 256u + lane;
    if at < view.units && ((bits[block * 8u + lane / 32u] >> (lane % 32u)) & 1u) != 0u {
        let own = units[at];
        let eye = eyes[own.slot];
        if !is_over(own.made_from, eye) && is_over(own.replaced_by, eye) {
            atomicOr(&own_bits[lane / 32u], 1u << (lane % 32u));
        }
    }
    workgroupBarrier();
    if lane < 8u { bits[block * 8u + lane] = atomicLoad(&own_bits[lane]); }
}
