//! Modes 1 and 2: indices of triangle lists, and of anything.

use super::ByteReader;

const TRIANGLES_HEADER: u8 = 0xE1;
const SEQUENCE_HEADER: u8 = 0xD1;
/// The table of frequent vertex codes at the end of a triangle stream.
pub(super) const TRIANGLES_TAIL: usize = 16;
/// The padding at the end of an index stream.
pub(super) const SEQUENCE_TAIL: usize = 4;

/// The last 16 entries, newest first. What was never pushed reads as an index out of every range.
struct Fifo<T> {
    entries: [T; 16],
    next: usize,
}

impl<T: Copy> Fifo<T> {
    fn new(undefined: T) -> Self {
        Self { entries: [undefined; 16], next: 0 }
    }

    fn push(&mut self, value: T) {
        self.entries[self.next] = value;
        self.next = (self.next + 1) % 16;
    }

    fn get(&self, age: u8) -> T {
        self.entries[(self.next + 15 - usize::from(age & 15)) % 16]
    }
}

struct Triangles<'a> {
    data: ByteReader<'a>,
    next: u32,
    last: u32,
    edges: Fifo<[u32; 2]>,
    vertices: Fifo<u32>,
}

impl Triangles<'_> {
    fn fresh(&mut self) -> u32 {
        let v = self.next;
        self.next = v.wrapping_add(1);
        v
    }

    fn explicit(&mut self) -> Result<u32, String> {
        self.last = self.last.wrapping_add(unzigzag(self.data.varint()?));
        Ok(self.last)
    }

    /// A vertex by a nibble: 0 is the next one, 15 explicit, others lie in the FIFO. Whether it is
    /// to be pushed there comes with it.
    fn nibble(&mut self, code: u8) -> Result<(u32, bool), String> {
        Ok(match code {
            0 => (self.fresh(), true),
            15 => (self.explicit()?, true),
            _ => (self.vertices.get(code - 1), false),
        })
    }

    /// The third vertex of a triangle on a recent edge.
    fn on_edge(&mut self, age: u8, code: u8) -> Result<[u32; 3], String> {
        let [a, b] = self.edges.get(age);
        let (c, push) = match code {
            13 => {
                self.last = self.last.wrapping_sub(1);
                (self.last, true)
            }
            14 => {
                self.last = self.last.wrapping_add(1);
                (self.last, true)
            }
            // Code 0 pushes; codes 1 to 12 count the FIFO from 0, the newest, which is never read.
            1..=12 => (self.vertices.get(code), false),
            _ => self.nibble(code)?,
        };
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        if push {
            self.vertices.push(c);
        }
        Ok([a, b, c])
    }

    /// A triangle on no recent edge.
    fn apart(&mut self, a: u8, [b, c]: [u8; 2]) -> Result<[u32; 3], String> {
        // All three look into the FIFO as it was before any of them is pushed.
        let (a, _) = self.nibble(a)?;
        let (b, push_b) = self.nibble(b)?;
        let (c, push_c) = self.nibble(c)?;
        self.edges.push([b, a]);
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        self.vertices.push(a);
        if push_b {
            self.vertices.push(b);
        }
        if push_c {
            self.vertices.push(c);
        }
        Ok([a, b, c])
    }
}

/// Decodes the `count` indices of a triangle list.
pub(super) fn triangles(bytes: &[u8], count: usize) -> Result<Vec<u32>, String> {
    let (mut data, table) = ByteReader::open(bytes, TRIANGLES_HEADER, TRIANGLES_TAIL)?;
    let codes = data.take(count / 3)?;
    let mut state = Triangles {
        data,
        next: 0,
        last: 0,
        edges: Fifo::new([u32::MAX; 2]),
        vertices: Fifo::new(u32::MAX),
    };
    let mut out = Vec::with_capacity(count);
    for &code in codes {
        let (high, low) = (code >> 4, code & 15);
        let triangle = if high < 15 {
            state.on_edge(high, low)?
        } else if low < 14 {
            let pair = table[usize::from(low)];
            let nibbles = [pair >> 4, pair & 15];
            if nibbles.contains(&15) {
                return Err(format!("its table has {pair:#04x} at {low}"));
            }
            state.apart(0, nibbles)?
        } else {
            let pair = state.data.byte()?;
            if pair == 0 {
                state.next = 0;
            }
            state.apart(if low == 14 { 0 } else { 15 }, [pair >> 4, pair & 15])?
        };
        out.extend(triangle);
    }
    state.data.finish()?;
    Ok(out)
}

/// Decodes `count` indices.
pub(super) fn sequence(bytes: &[u8], count: usize) -> Result<Vec<u32>, String> {
    let (mut data, _) = ByteReader::open(bytes, SEQUENCE_HEADER, SEQUENCE_TAIL)?;
    let mut last = [0u32; 2];
    let mut out = Vec::with_capacity(count);
    for _ in 0..count {
        let v = data.varint()?;
        let base = &mut last[(v & 1) as usize];
        *base = base.wrapping_add(unzigzag(v >> 1));
        out.push(*base);
    }
    data.finish()?;
    Ok(out)
}

fn unzigzag(v: u32) -> u32 {
    (v >> 1) ^ (v & 1).wrapping_neg()
}
