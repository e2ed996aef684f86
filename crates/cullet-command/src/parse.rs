//! Values of the command line: each parser says what it got, and what it wants.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// One of a few values of any type, each by its name and with a sentence for `--help`.
pub fn choice<T>(
    all: &'static [(&'static str, T, &'static str)],
) -> impl TypedValueParser<Value = T>
where
    T: Clone + Send + Sync + 'static,
{
    let named = all.iter().map(|(name, _, about)| PossibleValue::new(name).help(about));
    PossibleValuesParser::new(named).try_map(|text| {
        let found = all.iter().find(|(name, ..)| *name == text);
        // An unknown name was refused before.
        found.map(|(_, value, _)| value.clone()).ok_or_else(|| format!("'{text}' is unknown"))
    })
}

/// A file to write, in a folder that is there: known before minutes of work are done.
pub fn output(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    match folder.filter(|folder| !folder.is_dir()) {
        Some(folder) => Err(format!("there is no folder {}; make it first", folder.display())),
        None => Ok(path),
    }
}

/// `1280x720`
pub fn size(text: &str) -> Result<[u32; 2], String> {
    // Above this an ID buffer and its depth no longer fit ordinary memory.
    const LIMIT: u32 = 16384;
    let parse = || {
        let (w, h) = text.split_once(['x', 'X', '×'])?;
        Some([w.trim().parse().ok()?, h.trim().parse().ok()?])
    };
    let size: [u32; 2] =
        parse().ok_or_else(|| format!("'{text}' is not WIDTHxHEIGHT; try 1280x720"))?;
    if size.iter().any(|&v| v == 0 || v > LIMIT) {
        return Err(format!("'{text}': each side must be between 1 and {LIMIT} pixels"));
    }
    Ok(size)
}

/// A pixel, by column and row from the top left corner.
pub fn pixel(text: &str) -> Result<[u32; 2], String> {
    let values: Option<Vec<u32>> = text.split(',').map(|v| v.trim().parse().ok()).collect();
    match values.as_deref() {
        Some(&[x, y]) => Ok([x, y]),
        _ => Err(format!("'{text}' is not a column and a row, each 0 or more; try 640,360")),
    }
}

/// `1,2.5,-3`
pub fn point(text: &str) -> Result<[f64; 3], String> {
    let values: Option<Vec<f64>> = text.split(',').map(|v| v.trim().parse().ok()).collect();
    match values.as_deref() {
        Some(&[x, y, z]) if [x, y, z].iter().all(|v| v.is_finite()) => Ok([x, y, z]),
        _ => Err(format!("'{text}' is not three finite numbers; try 0,1.7,10")),
    }
}

fn number(text: &str, ok: impl Fn(f64) -> bool, want: &str) -> Result<f64, String> {
    match text.trim().parse() {
        Ok(v) if ok(v) => Ok(v),
        _ => Err(format!("'{text}' is not {want}")),
    }
}

/// Degrees of a field of view.
pub fn angle(text: &str) -> Result<f64, String> {
    number(text, |v| v > 0.0 && v < 180.0, "an angle between 0 and 180 degrees; try 60")
}

/// Distance of a plane; `inf` is one.
pub fn distance(text: &str) -> Result<f64, String> {
    number(text, |v| v > 0.0, "a distance above 0; try 0.1, or inf for a far plane")
}

/// Pixels.
pub fn pixels(text: &str) -> Result<f64, String> {
    number(text, |v| v >= 0.0 && v.is_finite(), "a number of pixels, 0 or more; try 2")
}

/// Pixels by which a level of detail may be off.
pub fn lod_pixels(text: &str) -> Result<f64, String> {
    let expected = "a number of pixels, 0 or more, by which what is drawn may be off; try 1";
    number(text, |v| v >= 0.0 && v.is_finite(), expected)
}

/// A budget of triangles.
pub fn budget(text: &str) -> Result<u64, String> {
    match text.trim().parse() {
        Ok(n) if n > 0 => Ok(n),
        _ => Err(format!("'{text}' is not a number of triangles, 1 or more; try 100000")),
    }
}

/// The radius of a ball of eyes.
pub fn ball(text: &str) -> Result<f64, String> {
    let expected = "a radius in units of the scene, 0 or more; try 0.5";
    number(text, |v| v >= 0.0 && v.is_finite(), expected)
}

/// Microseconds of a cost model.
pub fn microseconds(text: &str) -> Result<f32, String> {
    let expected = "a number of microseconds, 0 or more; try 500";
    number(text, |v| v >= 0.0 && v.is_finite(), expected).map(|v| v as f32)
}

/// A share.
pub fn share(text: &str) -> Result<f32, String> {
    let expected = "a share, 0 or more; try 0.015";
    number(text, |v| v >= 0.0 && v.is_finite(), expected).map(|v| v as f32)
}

/// A share of a bounding radius.
pub fn radii(text: &str) -> Result<f64, String> {
    let expected = "a share of the bounding radius, 0 to 1; try 0.001";
    number(text, |v| (0.0..=1.0).contains(&v), expected)
}

/// Seconds.
pub fn seconds(text: &str) -> Result<f64, String> {
    number(text, |v| v >= 0.0 && v.is_finite(), "a number of seconds, 0 or more; try 60")
}

/// A time in seconds, `1.5`, or two, `0..4`.
pub fn span(text: &str) -> Result<[f64; 2], String> {
    let second = |t: &str| t.trim().parse().ok().filter(|v: &f64| v.is_finite());
    let (from, to) = text.split_once("..").unwrap_or((text, text));
    match (second(from), second(to)) {
        (Some(from), Some(to)) => Ok([from, to]),
        _ => Err(format!("'{text}' is not a time in seconds, nor two; try 1.5, or 0..4")),
    }
}

/// The most triangles that one test may cost where clusters are made; more would change nothing.
pub const MOST_TRIANGLES: f64 = 1e6;

/// Triangles that a test costs.
pub fn triangles(text: &str) -> Result<f64, String> {
    let fine = |v| (0.0..=MOST_TRIANGLES).contains(&v);
    number(text, fine, "a number of triangles, 0 to 1e6; try 16")
}

/// Nanoseconds of something that happens.
pub fn nanoseconds(text: &str) -> Result<f64, String> {
    let fine = |v| v > 0.0 && v <= crate::measured_costs::MeasuredCosts::MOST_NS;
    number(text, fine, "a number of nanoseconds above 0, to 1e9; try 5")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_go_by_their_names() {
        let parser = choice(&[("one", 1, "The first"), ("two", 2, "The second")]);
        let of = |text: &str| {
            let command = clap::Command::new("test");
            parser.parse_ref(&command, None, text.as_ref()).map_err(|e| e.to_string())
        };
        assert_eq!((of("one"), of("two")), (Ok(1), Ok(2)));
        let refused = of("three").unwrap_err();
        assert!(refused.contains("three") && refused.contains("one, two"), "{refused}");
    }

    #[test]
    fn sizes_are_width_by_height() {
        assert_eq!(size("640x480"), Ok([640, 480]));
        for bad in ["640", "0x480", "640x", "99999x2", "-3x4", ""] {
            assert!(size(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn points_are_three_finite_numbers() {
        assert_eq!(point("1,-2.5, 3e2"), Ok([1.0, -2.5, 300.0]));
        for bad in ["1,2", "1,2,3,4", "a,b,c", "1,2,nan", "inf,0,0"] {
            assert!(point(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_time_is_a_moment_or_a_span() {
        assert_eq!(span("1.5"), Ok([1.5, 1.5]));
        assert_eq!(span("0..4"), Ok([0.0, 4.0]));
        assert_eq!(span("-1 .. 1e-3"), Ok([-1.0, 1e-3]));
        for bad in ["", "..", "1..", "..2", "0..inf", "nan", "1..2..3", "4s"] {
            assert!(span(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_file_is_written_where_there_is_a_folder() {
        for good in ["-", "a.glb", "./a.glb", "../a.glb"] {
            assert_eq!(output(good), Ok(good.into()));
        }
        for bad in ["no/such/a.glb", "Cargo.toml/a.glb"] {
            let refused = output(bad).unwrap_err();
            assert!(refused.contains("no folder") && refused.contains("make it"), "{refused}");
        }
    }

    #[test]
    fn nothing_takes_no_time() {
        assert_eq!(nanoseconds("0.5"), Ok(0.5));
        for bad in ["0", "-1", "nan", "inf", "2e9", "5ns"] {
            assert!(nanoseconds(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn levels_are_off_by_a_number_of_pixels() {
        assert_eq!((lod_pixels("0"), lod_pixels("0.5")), (Ok(0.0), Ok(0.5)));
        for bad in ["-1", "nan", "inf", "1px", ""] {
            let refused = lod_pixels(bad).unwrap_err();
            assert!(refused.contains("pixels") && refused.contains("try 1"), "{refused}");
        }
    }

    #[test]
    fn planes_may_be_infinitely_far_but_not_nowhere() {
        assert_eq!(distance("inf"), Ok(f64::INFINITY));
        assert!(distance("0").is_err() && distance("nan").is_err() && distance("-1").is_err());
        assert!(angle("180").is_err() && angle("60").is_ok());
    }
}
