// Boxes on grids, as the CPU lays them out, and the blocks that a view tests.

struct GridBox { low_xy: u32, low_z_high_x: u32, high_yz: u32, layers: u32 }
struct InUse { block: u32, first_plane: u32, plane_count: u32, size_rows: u32 }

fn lower_half(v: u32) -> i32 { return i32(v << 16u) >> 16u; }
fn upper_half(v: u32) -> i32 { return i32(v) >> 16u; }

fn low_corner(b: GridBox) -> vec3<i32> {
    return vec3<i32>(lower_half(b.low_xy), upper_half(b.low_xy), lower_half(b.low_z_high_x));
}
fn high_corner(b: GridBox) -> vec3<i32> {
    return vec3<i32>(upper_half(b.low_z_high_x), lower_half(b.high_yz), upper_half(b.high_yz));
}

// Beyond every grid.
fn is_always(b: GridBox) -> bool { return lower_half(b.low_xy) == -32768; }
