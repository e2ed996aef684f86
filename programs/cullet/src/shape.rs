//! Planes and boxes, as the command line gives them.

use cullet::bounds::Plane;
use cullet_command::exit::Failure;
use cullet_draw::clip::{ClipError, HalfSpace, Region};

fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let values: Option<Vec<f64>> = text.split(',').map(|v| v.trim().parse().ok()).collect();
    let values: [f64; N] = values?.try_into().ok()?;
    values.iter().all(|v| v.is_finite()).then_some(values)
}

/// The points with n·x = d, from `nx,ny,nz,d`.
pub fn plane(text: &str) -> Result<Plane, String> {
    let [x, y, z, d] = numbers(text)
        .ok_or_else(|| format!("'{text}' is not four finite numbers; try 0,1,0,2.5"))?;
    Plane::new([x, y, z], d)
        .normalized()
        .map(|_| Plane::new([x, y, z], d))
        .ok_or_else(|| format!("'{text}': the normal has no direction; try 0,1,0,2.5"))
}

/// Lowest and highest corner, from `x0,y0,z0,x1,y1,z1`.
pub fn bounds(text: &str) -> Result<[f64; 6], String> {
    let b: [f64; 6] = numbers(text)
        .ok_or_else(|| format!("'{text}' is not six finite numbers; try 0,0,0,1,1,1"))?;
    match (0..3).find(|&a| b[a] >= b[a + 3]) {
        Some(a) => Err(format!(
            "'{text}': its low {axis} of {} is not below its high {axis} of {}",
            b[a],
            b[a + 3],
            axis = ["x", "y", "z"][a]
        )),
        None => Ok(b),
    }
}

/// A plane of four numbers, or a box of six, and the text that it was.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Shape {
    /// The words that it was given as.
    pub(crate) text: String,
    planes: Vec<Plane>,
}

/// Either of both, told apart by the count of numbers.
pub(crate) fn shape(text: &str) -> Result<Shape, String> {
    let planes = match text.split(',').count() {
        4 => vec![plane(text)?],
        6 => of_box(bounds(text)?),
        n => {
            return Err(format!(
                "'{text}' is {n} numbers; a plane is four (0,1,0,2.5), a box six (0,0,0,1,1,1)"
            ));
        }
    };
    Ok(Shape { text: text.to_owned(), planes })
}

/// The planes of a box, which point out of it.
fn of_box([a, b, c, d, e, f]: [f64; 6]) -> Vec<Plane> {
    let sides =
        |axis: [f64; 3], low, high| [Plane::new(axis, low).flipped(), Plane::new(axis, high)];
    [sides([1.0, 0.0, 0.0], a, d), sides([0.0, 1.0, 0.0], b, e), sides([0.0, 0.0, 1.0], c, f)]
        .concat()
}

/// The region within all shapes.
pub(crate) fn region(shapes: &[Shape]) -> Result<Region<f64, 3>, Failure> {
    let planes = shapes.iter().flat_map(|s| &s.planes);
    let sides: Result<Vec<HalfSpace<f64, 3>>, ClipError> =
        planes.map(|&plane| plane.try_into()).collect();
    sides.and_then(Region::new).map_err(|e| match e {
        ClipError::Full { limit } => Failure::usage(format!("--cut: more than {limit} planes")),
        e => Failure::usage(format!("--cut: {e}")),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_and_boxes_are_checked() {
        assert_eq!(plane("0,1, 0,2.5"), Ok(Plane::new([0.0, 1.0, 0.0], 2.5)));
        for bad in ["0,0,0,1", "1,0,0", "a,0,0,1", "nan,0,0,1", "1,0,0,inf", ""] {
            assert!(plane(bad).is_err(), "{bad}");
        }
        assert_eq!(bounds("0,0,0,1,2,3"), Ok([0.0, 0.0, 0.0, 1.0, 2.0, 3.0]));
        assert!(bounds("0,0,0,1,-2,3").unwrap_err().contains("low y of 0"));
        assert!(bounds("0,0,0,1,2").is_err());
    }

    #[test]
    fn the_count_of_numbers_tells_planes_from_boxes() {
        let count = |text| shape(text).map(|s| s.planes.len());
        assert_eq!(count("0,1,0,2.5"), Ok(1));
        assert_eq!(count("0,0,0,1,2,3"), Ok(6));
        assert!(count("0,1,0").unwrap_err().contains("3 numbers"));
        assert!(count("0,0,0,1").unwrap_err().contains("no direction"));
        let many = vec![shape("0,0,0,1,2,3").expect("a box"); 6];
        assert!(region(&many[..5]).is_ok() && region(&many).is_err());
    }
}
