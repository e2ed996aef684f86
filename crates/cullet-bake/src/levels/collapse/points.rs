//! Points of the original that triangles carry.

/// Sample points of the original surface that triangles stand for, triangle by triangle.
#[derive(Clone, Debug, Default)]
pub(crate) struct Points {
    pub(crate) points: Vec<[f32; 3]>,
    /// How far each is from the triangle.
    pub(crate) distances: Vec<f32>,
    /// How many each triangle has.
    pub(crate) counts: Vec<u32>,
}

/// How many of the points of a triangle are kept for being the farthest.
const FARTHEST: usize = 2;

impl Points {
    /// Adds the points of another list.
    pub(crate) fn extend(&mut self, other: &Self) {
        self.points.extend(&other.points);
        self.distances.extend(&other.distances);
        self.counts.extend(&other.counts);
    }

    /// Adds a triangle with its points, of which the farthest and some others are kept where there
    /// are more than `most`.
    pub(crate) fn add(&mut self, points: impl Iterator<Item = ([f32; 3], f32)>, most: usize) {
        let first = self.points.len();
        for (point, distance) in points {
            self.points.push(point);
            self.distances.push(distance);
        }
        let count = self.points.len() - first;
        if count > most {
            let (points, distances) = (&mut self.points[first..], &mut self.distances[first..]);
            for k in 0..FARTHEST {
                let rest = distances[k..].iter().enumerate();
                let best =
                    rest.fold((0, -1.0), |best, (i, d)| if *d > best.1 { (i, *d) } else { best });
                points.swap(k, k + best.0);
                distances.swap(k, k + best.0);
            }
            // Of the others every so many.
            let (rest, taken) = (count - FARTHEST, most - FARTHEST);
            for k in 0..taken {
                let from = FARTHEST + k * rest / taken;
                points.swap(FARTHEST + k, from);
                distances.swap(FARTHEST + k, from);
            }
            self.points.truncate(first + most);
            self.distances.truncate(first + most);
        }
        self.counts.push((self.points.len() - first) as u32);
    }
}
