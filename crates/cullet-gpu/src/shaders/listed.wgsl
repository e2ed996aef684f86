// Which of the visible are listed: all, those that were seen before, or those that were not.

const SEEN = 1u;
const NEW = 2u;

fn listed(visible: u32, seen: u32, mode: u32) -> u32 {
    if mode == SEEN { return visible & seen; }
    if mode == NEW { return visible & ~seen; }
    return visible;
}

