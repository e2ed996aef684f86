// Lanes, in buckets; which of them are listed, and where in the list each has its place.

struct Lane { slot: u32, first: u32 }

@group(0) @binding(0) var<storage, read> lanes: array<Lane>;
// Bits of lanes, and how many are set before in the group: eight words for each group of 256.
@group(0) @binding(1) var<storage, read_write> words: array<vec2<u32>>;
// For each group how many of its bits are set; after the scan how many are set before it. One more at the end.
@group(0) @binding(2) var<storage, read_write> places: array<u32>;

fn is_listed_lane(lane: u32) -> bool {
    return ((words[lane / 32u].x >> (lane % 32u)) & 1u) != 0u;
}

// How many are set before a lane.
fn rank(lane: u32) -> u32 {
    let own = words[lane / 32u];
    return places[lane / 256u] + own.y + countOneBits(own.x & ((1u << (lane % 32u)) - 1u));
}

// From the bucket's first lane on.
fn place_of(lane: u32) -> u32 {
    let first = lanes[lane].first;
    return first + rank(lane) - rank(first);
}
