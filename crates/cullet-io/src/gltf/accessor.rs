//! Accessors: typed, checked against their views before anything is allocated, decoded to floats
//! and indices.

use std::cell::Cell;

use super::buffers::Buffers;
use super::json::{self, AccessorItem, Integer, Root, SparseItem};
use crate::ErrorKind;
use crate::json::FromJson;

/// An accessor without a view is all zeros, so its count is backed by no bytes: this many bytes of
/// them are granted to a file.
const MOST_ZERO_BYTES: usize = 64 << 20;

/// The type of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(code: Integer) -> Option<Self> {
        Some(match code.0 {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    fn is_index(self) -> bool {
        matches!(self, Self::U8 | Self::U16 | Self::U32)
    }

    /// Decodes numbers, as many as there is room for.
    fn decode(self, bytes: &[u8], normalized: bool, out: &mut [f32]) {
        // The rule of the specification: c / max, and not below -1.
        let scale = |max: f32| if normalized { max } else { 1.0 };
        match self {
            Self::F32 | Self::U32 => {
                for (to, &b) in out.iter_mut().zip(bytes.as_chunks::<4>().0) {
                    *to = f32::from_le_bytes(b);
                }
            }
            Self::I8 => {
                let (scale, least) = (scale(127.0), if normalized { -1.0 } else { f32::MIN });
                for (to, &b) in out.iter_mut().zip(bytes) {
                    *to = (f32::from(b as i8) / scale).max(least);
                }
            }
            Self::U8 => {
                let scale = scale(255.0);
                for (to, &b) in out.iter_mut().zip(bytes) {
                    *to = f32::from(b) / scale;
                }
            }
            Self::I16 => {
                let (scale, least) = (scale(32767.0), if normalized { -1.0 } else { f32::MIN });
                for (to, &b) in out.iter_mut().zip(bytes.as_chunks::<2>().0) {
                    *to = (f32::from(i16::from_le_bytes(b)) / scale).max(least);
                }
            }
            Self::U16 => {
                let scale = scale(65535.0);
                for (to, &b) in out.iter_mut().zip(bytes.as_chunks::<2>().0) {
                    *to = f32::from(u16::from_le_bytes(b)) / scale;
                }
            }
        }
    }
}

/// The shape of an element: columns and rows.
fn shape(kind: &str) -> Option<(usize, usize)> {
    Some(match kind {
        "SCALAR" => (1, 1),
        "VEC2" => (1, 2),
        "VEC3" => (1, 3),
        "VEC4" => (1, 4),
        "MAT2" => (2, 2),
        "MAT3" => (3, 3),
        "MAT4" => (4, 4),
        _ => return None,
    })
}

/// A run of elements in a view, whose range was checked.
#[derive(Clone, Copy, Debug)]
struct Run {
    view: usize,
    offset: usize,
    stride: usize,
    component: Component,
}

#[derive(Clone, Debug)]
struct Sparse {
    count: usize,
    indices: Run,
    values: Run,
}

/// An accessor whose ranges were checked.
#[derive(Clone, Debug)]
pub(super) struct Accessor {
    /// How many elements.
    pub(super) count: usize,
    /// The type of a component.
    pub(super) component: Component,
    /// Whether integers stand for fractions of 1.
    pub(super) normalized: bool,
    columns: usize,
    rows: usize,
    run: Option<Run>,
    sparse: Option<Sparse>,
    /// The declared least values, if there are any.
    pub(super) min: Option<Vec<f64>>,
    /// The declared greatest values.
    pub(super) max: Option<Vec<f64>>,
}

impl Accessor {
    /// Whether its elements are vectors of three.
    pub(super) fn is_vec3(&self) -> bool {
        (self.columns, self.rows) == (1, 3)
    }

    /// Whether its elements lie in a view, rather than being zeros.
    pub(super) fn has_bytes(&self) -> bool {
        self.run.is_some()
    }
}

/// All accessors of a document; `None` where the type is one of a later version or an extension.
#[derive(Debug)]
pub(super) struct Accessors {
    all: Vec<Option<Accessor>>,
    zero_bytes_left: Cell<usize>,
}

impl Accessors {
    /// Reads and checks all accessors.
    ///
    /// # Errors
    /// If one is misaligned or does not fit its view.
    pub(super) fn read(root: &Root<'_>, buffers: &Buffers<'_>) -> Result<Self, ErrorKind> {
        let mut all = Vec::new();
        for (i, json) in json::all(&root.accessors).iter().enumerate() {
            let read = AccessorItem::from_json(*json).and_then(|item| accessor(item, buffers));
            let wrong = |message| ErrorKind::invalid(format!("accessor {i}"), message);
            all.push(read.map_err(wrong)?);
        }
        Ok(Self { all, zero_bytes_left: Cell::new(MOST_ZERO_BYTES) })
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.all.len()
    }

    /// One of them.
    ///
    /// # Errors
    /// If there is none of that number, or its type is unknown; `user` is who needs it.
    pub(super) fn get(&self, index: usize, user: &str) -> Result<&Accessor, ErrorKind> {
        match self.all.get(index) {
            None => Err(ErrorKind::invalid(
                user,
                format!("names accessor {index} of {}", self.all.len()),
            )),
            Some(None) => Err(ErrorKind::invalid(
                user,
                format!("accessor {index} has a type or componentType that is not known"),
            )),
            Some(Some(accessor)) => Ok(accessor),
        }
    }

    /// One of them, if its number and type are known.
    pub(super) fn find(&self, index: usize) -> Option<&Accessor> {
        self.all.get(index)?.as_ref()
    }

    /// Decodes an accessor of `N` components into floats; 16 are those of a 4x4 matrix. Normalised
    /// integers become fractions, others keep their value.
    ///
    /// # Errors
    /// If it has another shape or is of u32, or its bytes are absent; `user` is who needs it.
    pub(super) fn floats<const N: usize>(
        &self,
        index: usize,
        buffers: &Buffers<'_>,
        user: &str,
    ) -> Result<Vec<[f32; N]>, ErrorKind> {
        let mut out = vec![[0.0; N]; self.count_of_floats(index, N, user)?];
        self.read_floats(index, N, out.as_flattened_mut(), buffers)?;
        Ok(out)
    }

    /// How many elements an accessor has, if it can be decoded into `width` floats each.
    fn count_of_floats(&self, index: usize, width: usize, user: &str) -> Result<usize, ErrorKind> {
        let a = self.get(index, user)?;
        let wrong = |message: String| ErrorKind::invalid(user, message);
        let shape = if width == 16 { (4, 4) } else { (1, width) };
        if (a.columns, a.rows) != shape || a.component == Component::U32 {
            return Err(wrong(format!(
                "accessor {index} has {}x{} components of {:?}; expected {width} of F32, I8, U8, I16 or U16",
                a.columns, a.rows, a.component
            )));
        }
        if a.run.is_none() {
            self.grant_zeros(a.count.saturating_mul(width * 4)).map_err(wrong)?;
        }
        Ok(a.count)
    }

    /// Decodes an accessor into zeros.
    fn read_floats(
        &self,
        index: usize,
        width: usize,
        out: &mut [f32],
        buffers: &Buffers<'_>,
    ) -> Result<(), ErrorKind> {
        let Some(a) = self.find(index) else { return Ok(()) };
        if let Some(run) = &a.run {
            run.floats(buffers.view(run.view)?, width, a.normalized, out);
        }
        if let Some(s) = &a.sparse {
            let at = s.indices(buffers, a.count, index)?;
            let mut values = vec![0.0; s.count * width];
            s.values.floats(buffers.view(s.values.view)?, width, a.normalized, &mut values);
            for (at, value) in at.into_iter().zip(values.chunks_exact(width)) {
                out[at as usize * width..][..width].copy_from_slice(value);
            }
        }
        Ok(())
    }

    /// Decodes an accessor of indices.
    ///
    /// # Errors
    /// If it is not of unsigned scalars, or its bytes are absent; `user` is who needs it.
    pub(super) fn indices(
        &self,
        index: usize,
        buffers: &Buffers<'_>,
        user: &str,
    ) -> Result<Vec<u32>, ErrorKind> {
        let a = self.get(index, user)?;
        let wrong = |message: String| ErrorKind::invalid(user, message);
        if a.columns * a.rows != 1 || !a.component.is_index() || a.normalized {
            return Err(wrong(format!(
                "accessor {index} is not a list of indices: {}x{} components of {:?}",
                a.columns, a.rows, a.component
            )));
        }
        let mut out = match &a.run {
            Some(run) => run.indices(buffers.view(run.view)?, a.count),
            None => {
                self.grant_zeros(a.count.saturating_mul(4)).map_err(wrong)?;
                vec![0; a.count]
            }
        };
        if let Some(s) = &a.sparse {
            let at = s.indices(buffers, a.count, index)?;
            let values = s.values.indices(buffers.view(s.values.view)?, s.count);
            at.into_iter().zip(values).for_each(|(at, v)| out[at as usize] = v);
        }
        Ok(out)
    }

    /// Whether every float of an accessor is finite; the first element that is not. Accessors
    /// without bytes, or not of floats, pass.
    pub(super) fn first_not_finite(&self, index: usize, buffers: &Buffers<'_>) -> Option<usize> {
        let a = self.find(index)?;
        let run = a.run.filter(|_| a.component == Component::F32)?;
        let bytes = buffers.view(run.view).ok()?;
        let elements = run.elements(bytes, a.count, a.columns * a.rows * 4);
        elements
            .into_iter()
            .position(|e| e.as_chunks::<4>().0.iter().any(|&c| !f32::from_le_bytes(c).is_finite()))
    }

    fn grant_zeros(&self, bytes: usize) -> Result<(), String> {
        let left = self.zero_bytes_left.get();
        let after = left.checked_sub(bytes).ok_or_else(|| {
            format!("needs {bytes} bytes of zeros, having no bufferView; {left} are left of {MOST_ZERO_BYTES}")
        })?;
        self.zero_bytes_left.set(after);
        Ok(())
    }
}

impl Run {
    /// The bytes of each element.
    fn elements<'b>(
        &self,
        bytes: &'b [u8],
        count: usize,
        size: usize,
    ) -> impl ExactSizeIterator<Item = &'b [u8]> + use<'b> {
        let (bytes, stride) = (&bytes[self.offset..], self.stride);
        (0..count).map(move |i| &bytes[i * stride..i * stride + size])
    }

    /// Decodes as many elements of `width` components as `out` has room for.
    fn floats(&self, bytes: &[u8], width: usize, normalized: bool, out: &mut [f32]) {
        let size = self.component.size();
        // Elements that follow each other are decoded as one.
        let width = if self.stride == width * size { out.len() } else { width };
        let elements = self.elements(bytes, out.len() / width, width * size);
        for (to, from) in out.chunks_exact_mut(width).zip(elements) {
            self.component.decode(from, normalized, to);
        }
    }

    fn indices(&self, bytes: &[u8], count: usize) -> Vec<u32> {
        let elements = self.elements(bytes, count, self.component.size());
        match self.component {
            Component::U8 => elements.map(|e| u32::from(e[0])).collect(),
            Component::U16 => elements.map(|e| u16::from_le_bytes([e[0], e[1]]).into()).collect(),
            _ => elements.map(|e| u32::from_le_bytes([e[0], e[1], e[2], e[3]])).collect(),
        }
    }
}

impl Sparse {
    /// Returns the indices of the replaced elements.
    fn indices(
        &self,
        buffers: &Buffers<'_>,
        elements: usize,
        accessor: usize,
    ) -> Result<Vec<u32>, ErrorKind> {
        let wrong = |message: String| {
            Err(ErrorKind::invalid(format!("accessor {accessor}, sparse indices"), message))
        };
        let at = self.indices.indices(buffers.view(self.indices.view)?, self.count);
        if let Some(i) = at.windows(2).position(|w| w[0] >= w[1]) {
            return wrong(format!("do not ascend: {} is followed by {}", at[i], at[i + 1]));
        }
        match at.last() {
            Some(&last) if last as usize >= elements => {
                wrong(format!("{last} is beyond the {elements} elements"))
            }
            _ => Ok(at),
        }
    }
}

fn accessor(item: AccessorItem<'_>, buffers: &Buffers<'_>) -> Result<Option<Accessor>, String> {
    let count = item.count.index();
    if count == 0 {
        return Err("its count is 0".into());
    }
    if item.buffer_view.is_none() && item.byte_offset.is_some() {
        return Err("has a byteOffset but no bufferView".into());
    }
    let known = (Component::of(item.component_type), shape(&item.kind));
    let (Some(component), Some((columns, rows))) = known else {
        return Ok(None);
    };
    if item.normalized && matches!(component, Component::U32 | Component::F32) {
        return Err(format!(
            "is of {component:?} and normalized; only 1 and 2-byte integers can be"
        ));
    }
    // Columns of matrices start at multiples of four bytes.
    let size = component.size();
    let column = if columns > 1 { (rows * size).next_multiple_of(4) } else { rows * size };
    let shape = ElementShape {
        component,
        size: column * (columns - 1) + rows * size,
        packed: column * columns,
        align: size,
        own_align: if columns > 1 { size.max(4) } else { size },
    };
    let run = match item.buffer_view {
        Some(view) => Some(run(view, item.byte_offset, count, &shape, true, buffers)?),
        None => None,
    };
    let sparse = match &item.sparse {
        Some(s) => Some(sparse(s, count, &shape, buffers).map_err(|m| format!("sparse {m}"))?),
        None => None,
    };
    Ok(Some(Accessor {
        count,
        component,
        normalized: item.normalized,
        columns,
        rows,
        run,
        sparse,
        min: item.min,
        max: item.max,
    }))
}

/// How elements lie in bytes.
struct ElementShape {
    component: Component,
    /// Bytes that an element takes.
    size: usize,
    /// Bytes from one to the next when tightly packed.
    packed: usize,
    /// The place in the buffer is a multiple of this.
    align: usize,
    /// The accessor's own offset is a multiple of this.
    own_align: usize,
}

fn run(
    view: Integer,
    offset: Option<Integer>,
    count: usize,
    shape: &ElementShape,
    may_stride: bool,
    buffers: &Buffers<'_>,
) -> Result<Run, String> {
    let index = view.index();
    let Some(view) = buffers.views.get(index) else {
        return Err(format!("names bufferView {index} of {}", buffers.views.len()));
    };
    if view.stride.is_some() && !may_stride {
        return Err(format!("uses bufferView {index}, whose byteStride only vertex data may have"));
    }
    let offset = offset.map_or(0, Integer::index);
    let stride = view.stride.unwrap_or(shape.packed);
    let &ElementShape { size, align, own_align, .. } = shape;
    if stride < size {
        return Err(format!(
            "bufferView {index} has a byteStride of {stride}, less than the {size} bytes of an element"
        ));
    }
    let total = offset.saturating_add(view.start());
    if !offset.is_multiple_of(own_align) || !total.is_multiple_of(align) {
        return Err(format!(
            "is misaligned: byteOffset {offset} must be a multiple of {own_align}, and {total}, the place in the buffer, of {align}"
        ));
    }
    let end =
        (count - 1).checked_mul(stride).and_then(|n| n.checked_add(size)?.checked_add(offset));
    if end.is_none_or(|end| end > view.len()) {
        return Err(format!(
            "{count} elements of {size} bytes, {stride} apart, from byte {offset} do not fit bufferView {index} of {} bytes",
            view.len()
        ));
    }
    Ok(Run { view: index, offset, stride, component: shape.component })
}

fn sparse(
    s: &SparseItem,
    elements: usize,
    shape: &ElementShape,
    buffers: &Buffers<'_>,
) -> Result<Sparse, String> {
    let count = s.count.index();
    if count == 0 || count > elements {
        return Err(format!("count is {count}; it must be from 1 to {elements}, the accessor's"));
    }
    let component = Component::of(s.indices.component_type)
        .filter(|c| c.is_index())
        .ok_or_else(|| format!("indices are of type {}", s.indices.component_type.0))?;
    let size = component.size();
    let index = ElementShape { component, size, packed: size, align: size, own_align: size };
    let indices = run(s.indices.buffer_view, s.indices.byte_offset, count, &index, false, buffers)
        .map_err(|m| format!("indices: {m}"))?;
    let values = run(s.values.buffer_view, s.values.byte_offset, count, shape, false, buffers)
        .map_err(|m| format!("values: {m}"))?;
    Ok(Sparse { count, indices, values })
}
