// Where what is listed has its place: sums of bits in groups of 256, and of groups. They are written to words and places, which
// the shader that takes this declares.

var<workgroup> own_bits: array<atomic<u32>, 8>;

// Writes the bits of a group, and how many are set before each word of it. For whole workgroups.
fn count_bits(number: u32, lane: u32, is_set: bool) {
    if is_set { atomicOr(&own_bits[lane / 32u], 1u << (lane % 32u)); }
    workgroupBarrier();
    if lane < 8u {
        var before = 0u;
        for (var w = 0u; w < lane; w++) { before += countOneBits(atomicLoad(&own_bits[w])); }
        let own = atomicLoad(&own_bits[lane]);
        words[number * 8u + lane] = vec2<u32>(own, before);
        if lane == 7u { places[number] = before + countOneBits(own); }
    }
}

var<workgroup> sums: array<u32, 256>;

// Turns counts of groups into sums before each, by one workgroup: sums of 256 runs of groups, their sums before, then within the
// runs. The last lane is told the sum of all.
fn scan_places(lane: u32, groups: u32) -> u32 {
    let run = (groups + 255u) / 256u;
    let first = min(lane * run, groups);
    let end = min(first + run, groups);
    var own = 0u;
    for (var i = first; i < end; i++) { own += places[i]; }
    sums[lane] = own;
    workgroupBarrier();
    for (var by = 1u; by < 256u; by <<= 1u) {
        var before = 0u;
        if lane >= by { before = sums[lane - by]; }
        workgroupBarrier();
        sums[lane] += before;
        workgroupBarrier();
    }
    var place = sums[lane] - own;
    for (var i = first; i < end; i++) {
        let count = places[i];
        places[i] = place;
        place += count;
    }
    return sums[lane];
}

