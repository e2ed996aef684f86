//! The file of an animated WebP (RFC 9649, section 2): chunks in a RIFF container.

use super::{Animation, vp8l};

/// Bits of a frame's last byte: do not blend with what is there, do not clear it afterwards.
const PUT: u8 = 0b10;
const BLEND: u8 = 0b00;

pub(super) fn write(of: &Animation) -> Vec<u8> {
    let mut body = b"WEBP".to_vec();
    // It is animated; some frames are clear in parts.
    let mut header = vec![0b1_0010, 0, 0, 0];
    of.size.iter().for_each(|side| header.extend(three(side - 1)));
    chunk(&mut body, b"VP8X", &header);
    // On white, again and again.
    chunk(&mut body, b"ANIM", &[255, 255, 255, 255, 0, 0]);
    for number in 0..of.frame_count() {
        chunk(&mut body, b"ANMF", &frame(of, number));
    }
    let mut file = Vec::with_capacity(body.len() + 8);
    chunk(&mut file, b"RIFF", &body);
    file
}

/// A frame: where its part lies, for how long, and the shorter of two streams of it.
fn frame(of: &Animation, number: usize) -> Vec<u8> {
    let part = of.changed(number);
    let (whole, sparse) = of.cut(number, &part);
    let stream = vp8l::stream(&whole, part.size, &of.palette, false);
    let sparse = sparse.map(|indices| vp8l::stream(&indices, part.size, &of.palette, true));
    let (stream, how) = match sparse {
        Some(sparse) if sparse.len() < stream.len() => (sparse, BLEND),
        _ => (stream, PUT),
    };
    let [from, to] = of.shown_ms(number);
    let mut bytes = Vec::with_capacity(stream.len() + 24);
    part.at.iter().for_each(|v| bytes.extend(three(v / 2)));
    part.size.iter().for_each(|v| bytes.extend(three(v - 1)));
    bytes.extend(three(to - from));
    bytes.push(how);
    chunk(&mut bytes, b"VP8L", &stream);
    bytes
}

/// The three lowest bytes, the lowest first.
fn three(v: u32) -> impl Iterator<Item = u8> {
    v.to_le_bytes().into_iter().take(3)
}

/// Adds a chunk, filled up to an even length.
fn chunk(out: &mut Vec<u8>, name: &[u8; 4], data: &[u8]) {
    out.extend(name);
    out.extend((data.len() as u32).to_le_bytes());
    out.extend(data);
    if !data.len().is_multiple_of(2) {
        out.push(0);
    }
}
