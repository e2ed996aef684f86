//! Plain data as bytes and back, with every count held against what is there.

use bytemuck::{AnyBitPattern, NoUninit};

use super::packed::UnpackError;

/// Appends to a list of bytes.
#[derive(Debug, Default)]
pub(crate) struct Writer {
    pub(crate) bytes: Vec<u8>,
}

impl Writer {
    pub(crate) fn pod<T: NoUninit>(&mut self, value: T) {
        self.bytes.extend_from_slice(bytemuck::bytes_of(&value));
    }

    pub(crate) fn pods<T: NoUninit>(&mut self, values: &[T]) {
        self.pod(values.len() as u64);
        self.bytes.extend_from_slice(bytemuck::cast_slice(values));
    }

    pub(crate) fn text(&mut self, text: &str) {
        self.pods(text.as_bytes());
    }

    pub(crate) fn texts(&mut self, texts: &[String]) {
        self.list(texts, |out, text| out.text(text));
    }

    pub(crate) fn list<T>(&mut self, items: &[T], mut each: impl FnMut(&mut Self, &T)) {
        self.pod(items.len() as u64);
        items.iter().for_each(|item| each(self, item));
    }
}

type Read<T> = Result<T, UnpackError>;

/// Reads what a [`Writer`] wrote.
#[derive(Debug)]
pub(crate) struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(bytes: &'a [u8], at: usize) -> Self {
        Self { bytes, at }
    }

    /// How far it has read.
    pub(crate) fn at(&self) -> usize {
        self.at
    }

    pub(crate) fn take(&mut self, count: usize) -> Read<&'a [u8]> {
        let end = self.at.checked_add(count);
        let taken = end.and_then(|end| self.bytes.get(self.at..end));
        self.at += taken.map_or(0, <[u8]>::len);
        taken.ok_or(UnpackError::Short(self.at))
    }

    pub(crate) fn pod<T: AnyBitPattern>(&mut self) -> Read<T> {
        let bytes = self.take(size_of::<T>())?;
        bytemuck::try_pod_read_unaligned(bytes).map_err(|e| UnpackError::Damaged(e.to_string()))
    }

    pub(crate) fn pods<T: AnyBitPattern>(&mut self) -> Read<Vec<T>> {
        let mut values = Vec::new();
        self.pods_into(&mut values)?;
        Ok(values)
    }

    /// As [`pods`](Self::pods), in place of what a list holds.
    pub(crate) fn pods_into<T: AnyBitPattern>(&mut self, values: &mut Vec<T>) -> Read<()> {
        let count = self.count(size_of::<T>())?;
        let bytes = self.take(count * size_of::<T>())?;
        values.clear();
        // They may lie anywhere, so they are copied rather than cast.
        values.extend(bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned::<T>));
        Ok(())
    }

    pub(crate) fn text(&mut self) -> Read<String> {
        String::from_utf8(self.pods()?).map_err(|e| UnpackError::Damaged(e.to_string()))
    }

    pub(crate) fn texts(&mut self) -> Read<Vec<String>> {
        self.list(Self::text)
    }

    pub(crate) fn list<T>(&mut self, mut each: impl FnMut(&mut Self) -> Read<T>) -> Read<Vec<T>> {
        // The least that an item can take is a length or three words.
        let count = self.count(8)?;
        let mut items = Vec::with_capacity(count);
        for _ in 0..count {
            items.push(each(self)?);
        }
        Ok(items)
    }

    /// A count of items of at least `size` bytes, if there can be as many.
    pub(crate) fn count(&mut self, size: usize) -> Read<usize> {
        let count: u64 = self.pod()?;
        let left = (self.bytes.len() - self.at) as u64;
        if count.checked_mul(size as u64).is_none_or(|bytes| bytes > left) {
            return Err(UnpackError::Short(self.bytes.len()));
        }
        Ok(count as usize)
    }
}
