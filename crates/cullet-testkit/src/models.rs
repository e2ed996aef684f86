//! Shapes of the test data, read by the plainest of means: the engine has no loader, and what is tested is not trusted.

use crate::data;
use crate::soups::Soup;

/// A model of the test data by its path there, such as `armadillo/armadillo.obj`: OBJ, OFF, or PLY as text or
/// little-endian floats, as far as the models of the test data need. Polygons become fans, and what is not geometry is left out.
/// `None` where it is not there, once that was said.
///
/// # Panics
///
/// On a file of another form.
pub fn model(name: &str) -> Option<Soup> {
    let path = data(name)?;
    let bytes = std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    if name.ends_with(".ply") && !bytes.starts_with(b"ply\nformat ascii") {
        return Some(binary_ply(&bytes));
    }
    let text = String::from_utf8_lossy(&bytes);
    Some(if name.ends_with(".obj") {
        obj(&text)
    } else if name.ends_with(".ply") {
        let end = text.find("end_header").expect("a header");
        let (header, body) = text.split_at(end);
        let counts = [count(header, "element vertex"), count(header, "element face")];
        table(&body["end_header".len()..], counts)
    } else {
        let mut lines = text.splitn(3, '\n').skip(1);
        let counts: Vec<usize> = numbers(lines.next().expect("a line of counts"));
        table(lines.next().expect("a body"), [counts[0], counts[1]])
    })
}

fn numbers<T: std::str::FromStr>(line: &str) -> Vec<T> {
    let number = |w: &str| w.parse().unwrap_or_else(|_| panic!("{w:?} is no number"));
    line.split_ascii_whitespace().map(number).collect()
}

/// The number at the end of the line that begins with `what`.
fn count(header: &str, what: &str) -> usize {
    let line = header.lines().find(|l| l.starts_with(what)).expect("a count");
    line.trim_end().rsplit(' ').next().and_then(|n| n.parse().ok()).expect("a count")
}

fn fan(indices: &mut Vec<u32>, corners: &[u32]) {
    for i in 2..corners.len() {
        indices.extend([corners[0], corners[i - 1], corners[i]]);
    }
}

fn obj(text: &str) -> Soup {
    let (mut positions, mut indices) = Soup::default();
    for line in text.lines() {
        if let Some(rest) = line.strip_prefix("v ") {
            let v: Vec<f32> = numbers(rest);
            positions.push([v[0], v[1], v[2]]);
        } else if let Some(rest) = line.strip_prefix("f ") {
            let index = |w: &str| {
                let i: i64 = w.split('/').next().and_then(|w| w.parse().ok()).expect("an index");
                (if i < 0 { positions.len() as i64 + i } else { i - 1 }) as u32
            };
            fan(&mut indices, &rest.split_ascii_whitespace().map(index).collect::<Vec<_>>());
        }
    }
    (positions, indices)
}

/// A line for each vertex, then one for each face, which begins with its number of corners.
fn table(body: &str, [vertices, faces]: [usize; 2]) -> Soup {
    let (mut positions, mut indices) = Soup::default();
    let mut lines = body.lines().filter(|l| !l.trim().is_empty());
    for line in lines.by_ref().take(vertices) {
        let v: Vec<f32> = numbers(line);
        positions.push([v[0], v[1], v[2]]);
    }
    for line in lines.take(faces) {
        let f: Vec<u32> = numbers(line);
        fan(&mut indices, &f[1..=f[0] as usize]);
    }
    (positions, indices)
}

/// Vertices are floats, faces lists of a u8 and so many u32.
fn binary_ply(bytes: &[u8]) -> Soup {
    let end = bytes.windows(11).position(|w| w == b"end_header\n").expect("a header") + 11;
    let header = String::from_utf8_lossy(&bytes[..end]);
    let stride = 4 * header.lines().filter(|l| l.starts_with("property float")).count();
    let word = |at: usize| [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
    let vertices = count(&header, "element vertex");
    let positions = (0..vertices)
        .map(|v| [0, 4, 8].map(|k| f32::from_le_bytes(word(end + v * stride + k))))
        .collect();
    let (mut at, mut indices) = (end + vertices * stride, Vec::new());
    for _ in 0..count(&header, "element face") {
        let n = usize::from(bytes[at]);
        let corners: Vec<u32> = (0..n).map(|i| u32::from_le_bytes(word(at + 1 + i * 4))).collect();
        fan(&mut indices, &corners);
        at += 1 + n * 4;
    }
    (positions, indices)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square and its shared edge, in each form.
    #[test]
    fn every_form_says_the_same() {
        let square = || {
            (vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.5]], vec![0, 1, 2, 0, 2, 3])
        };
        let text = "v 0 0 0\nv 1 0 0\nvn 0 0 1\nv 1 1 0 \nv 0 1 .5\nf 1/1 2/2 3/3 -1/4\n";
        assert_eq!(obj(text), square());
        let body = "\n0 0 0 7\n1 0 0 7\n\n1 1 0 7\n0 1 .5 7\n4 0 1 2 3\n";
        assert_eq!(table(body, [4, 1]), square());
        let mut bytes = b"ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\n\
            property float y\nproperty float z\nelement face 1\nproperty list uchar int i\nend_header\n"
            .to_vec();
        bytes.extend(square().0.as_flattened().iter().flat_map(|v| v.to_le_bytes()));
        bytes.push(4);
        bytes.extend([0_u32, 1, 2, 3].iter().flat_map(|v| v.to_le_bytes()));
        assert_eq!(binary_ply(&bytes), square());
    }
}
