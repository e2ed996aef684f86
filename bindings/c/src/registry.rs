//! Objects behind handles: numbers that C can copy, keep too long and confuse, and that never
//! become a pointer.
//!
//! A handle is the kind of its object, a generation and an index. The table of a kind only grows,
//! so that any number can be looked up; nothing here waits: what another thread excludes is
//! [`Status::Busy`].

use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, OnceLock, PoisonError, RwLock};
use std::sync::{RwLockReadGuard, RwLockWriteGuard, TryLockError};

use crate::status::{Error, Result, Status};

/// Kinds of objects, as the top bits of their handles have them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Scene = 1,
    State = 2,
    Occlusion = 3,
    Boxes = 4,
    Region = 5,
    Pvs = 6,
}

impl Kind {
    const fn name(self) -> &'static str {
        match self {
            Self::Scene => "scene",
            Self::State => "state",
            Self::Occlusion => "occlusion buffer",
            Self::Boxes => "set of boxes",
            Self::Region => "region",
            Self::Pvs => "pvs",
        }
    }

    /// The name with its article.
    fn one(self) -> String {
        let article = if self == Self::Occlusion { "an" } else { "a" };
        format!("{article} {}", self.name())
    }

    fn of(id: u64) -> Option<Self> {
        let all = [Self::Scene, Self::State, Self::Occlusion, Self::Boxes, Self::Region, Self::Pvs];
        all.into_iter().find(|k| *k as u64 == id >> 56)
    }
}

/// Errors, once for all tables.
impl Kind {
    /// A handle that is 0, or of another kind.
    #[cold]
    fn wrong(self, id: u64) -> Error {
        if id == 0 {
            let message = format!("the handle of the {} is 0: it was never made", self.name());
            return Error::new(Status::NullHandle, message);
        }
        let message = match Self::of(id) {
            Some(kind) => {
                format!("{id:#x} is the handle of {}, not of {}", kind.one(), self.one())
            }
            None => format!("{id:#x} is no handle of this library; {} is needed", self.one()),
        };
        Error::new(Status::WrongHandle, message)
    }

    #[cold]
    fn stale(self, id: u64) -> Error {
        let message = format!("the {} of handle {id:#x} was destroyed", self.name());
        Error::new(Status::StaleHandle, message)
    }

    #[cold]
    fn busy(self) -> Error {
        let what = self.name();
        let message = format!("another thread is using the {what}: let it finish first");
        Error::new(Status::Busy, message)
    }

    #[cold]
    fn broken(self) -> Error {
        let what = self.name();
        let message =
            format!("a defect of cullet stopped a change of the {what}: it can only be destroyed");
        Error::new(Status::Internal, message)
    }

    #[cold]
    fn full(self, index: u32) -> Error {
        let message = format!("there are {index} of {}, as many as there can be", self.one());
        Error::new(Status::Full, message)
    }
}

/// Entries of the first chunk; each chunk has twice as many as the one before.
const FIRST: usize = 64;
/// So that an index has 24 bits.
const CHUNKS: usize = 18;

/// All objects of a kind.
pub(crate) struct Table<T: 'static> {
    kind: Kind,
    chunks: [OnceLock<Box<[Entry<T>]>>; CHUNKS],
    free: Mutex<Free>,
}

type Entry<T> = RwLock<Place<T>>;

#[derive(Debug)]
pub(crate) struct Place<T> {
    generation: u32,
    object: Option<Box<T>>,
}

struct Free {
    indices: Vec<u32>,
    /// How many were ever in use.
    used: u32,
}

/// An object that others may read meanwhile.
pub(crate) struct Shared<T: 'static>(RwLockReadGuard<'static, Place<T>>);

/// An object that nobody else uses.
pub(crate) struct Alone<T: 'static>(RwLockWriteGuard<'static, Place<T>>);

impl<T> Deref for Shared<T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.0.object.as_deref().expect("looked up")
    }
}

impl<T> Deref for Alone<T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.0.object.as_deref().expect("looked up")
    }
}

impl<T> DerefMut for Alone<T> {
    fn deref_mut(&mut self) -> &mut T {
        self.0.object.as_deref_mut().expect("looked up")
    }
}

impl<T: Send + Sync> Table<T> {
    pub(crate) const fn new(kind: Kind) -> Self {
        let free = Mutex::new(Free { indices: Vec::new(), used: 0 });
        Self { kind, chunks: [const { OnceLock::new() }; CHUNKS], free }
    }

    /// Takes an object in; returns its handle.
    pub(crate) fn insert(&'static self, object: T) -> Result<u64> {
        let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        let index = match free.indices.pop() {
            Some(index) => index,
            None => {
                let index = free.used;
                let (chunk, _) = place(index);
                let cell = self.chunks.get(chunk).ok_or_else(|| self.kind.full(index))?;
                cell.get_or_init(|| {
                    let empty = || RwLock::new(Place { generation: 1, object: None });
                    (0..FIRST << chunk).map(|_| empty()).collect()
                });
                free.used += 1;
                index
            }
        };
        drop(free);
        let entry = self.entry(index).expect("made above");
        // A stale handle may be looked up meanwhile, for an instant.
        let mut at = entry.write().unwrap_or_else(PoisonError::into_inner);
        at.object = Some(Box::new(object));
        Ok((self.kind as u64) << 56 | u64::from(at.generation) << 24 | u64::from(index))
    }

    /// The object of a handle, to read.
    pub(crate) fn get(&'static self, id: u64) -> Result<Shared<T>> {
        let place = self.look_up(id)?.try_read().map_err(|e| self.refused(&e))?;
        self.check(id, &place)?;
        Ok(Shared(place))
    }

    /// The object of a handle, to change.
    pub(crate) fn get_mut(&'static self, id: u64) -> Result<Alone<T>> {
        let place = self.look_up(id)?.try_write().map_err(|e| self.refused(&e))?;
        self.check(id, &place)?;
        Ok(Alone(place))
    }

    /// Takes an object out, also one that a panic left half changed.
    pub(crate) fn remove(&'static self, id: u64) -> Result<Box<T>> {
        let entry = self.look_up(id)?;
        let mut at = match entry.try_write() {
            Ok(at) => at,
            Err(TryLockError::Poisoned(at)) => at.into_inner(),
            Err(e @ TryLockError::WouldBlock) => return Err(self.refused(&e)),
        };
        self.check(id, &at)?;
        let object = at.object.take().expect("checked");
        entry.clear_poison();
        at.generation += 1;
        // Generations have 32 bits, and none is used twice.
        if at.generation != u32::MAX {
            let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
            free.indices.push(id as u32 & 0xff_ffff);
        }
        Ok(object)
    }

    fn entry(&'static self, index: u32) -> Option<&'static Entry<T>> {
        let (chunk, at) = place(index);
        self.chunks.get(chunk)?.get()?.get(at)
    }

    fn look_up(&'static self, id: u64) -> Result<&'static Entry<T>> {
        if Kind::of(id) != Some(self.kind) {
            return Err(self.kind.wrong(id));
        }
        self.entry(id as u32 & 0xff_ffff).ok_or_else(|| self.kind.stale(id))
    }

    fn check(&self, id: u64, place: &Place<T>) -> Result {
        let is_it = place.generation == (id >> 24) as u32 && place.object.is_some();
        if is_it { Ok(()) } else { Err(self.kind.stale(id)) }
    }

    fn refused<G>(&self, error: &TryLockError<G>) -> Error {
        match error {
            TryLockError::WouldBlock => self.kind.busy(),
            TryLockError::Poisoned(_) => self.kind.broken(),
        }
    }
}

/// Chunk of an index, and where in it.
fn place(index: u32) -> (usize, usize) {
    let of_first = index as usize / FIRST + 1;
    let chunk = of_first.ilog2() as usize;
    (chunk, index as usize - FIRST * ((1 << chunk) - 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_fill_chunks_in_order() {
        let mut expected = (0..4).flat_map(|c| (0..FIRST << c).map(move |at| (c, at)));
        for index in 0..FIRST as u32 * 15 {
            assert_eq!(Some(place(index)), expected.next());
        }
        assert_eq!(place((1 << 24) - 1).0, CHUNKS);
        assert_eq!(place((FIRST as u32) * ((1 << CHUNKS) - 1) - 1).0, CHUNKS - 1);
    }

    #[test]
    fn a_handle_names_one_object_for_ever() {
        static TABLE: Table<u32> = Table::new(Kind::Scene);
        static STATES: Table<u32> = Table::new(Kind::State);
        let first = TABLE.insert(1).unwrap();
        assert_eq!(*TABLE.get(first).unwrap(), 1);
        assert_eq!(*TABLE.remove(first).unwrap(), 1);
        let second = TABLE.insert(2).unwrap();
        assert_eq!(first & 0xff_ffff, second & 0xff_ffff);
        let status = |id| TABLE.get(id).err().map(|e| e.status);
        assert_eq!(status(first), Some(Status::StaleHandle));
        assert_eq!(TABLE.remove(first).err().map(|e| e.status), Some(Status::StaleHandle));
        assert_eq!(status(0), Some(Status::NullHandle));
        assert_eq!(status(second | 0xff_ffff), Some(Status::StaleHandle));
        assert_eq!(status(u64::MAX), Some(Status::WrongHandle));
        assert_eq!(STATES.get(second).err().map(|e| e.status), Some(Status::WrongHandle));
        let reader = TABLE.get(second).unwrap();
        assert!(TABLE.get(second).is_ok());
        assert_eq!(TABLE.get_mut(second).err().map(|e| e.status), Some(Status::Busy));
        assert_eq!(TABLE.remove(second).err().map(|e| e.status), Some(Status::Busy));
        drop(reader);
        *TABLE.get_mut(second).unwrap() = 3;
        assert_eq!(*TABLE.get(second).unwrap(), 3);
    }

    #[test]
    fn what_panicked_can_only_be_destroyed() {
        static TABLE: Table<u32> = Table::new(Kind::State);
        let id = TABLE.insert(1).unwrap();
        let status = crate::status::call("test", || {
            let _alone = TABLE.get_mut(id)?;
            panic!("half done");
        });
        assert_eq!(status, Status::Internal);
        assert_eq!(TABLE.get(id).err().map(|e| e.status), Some(Status::Internal));
        assert_eq!(TABLE.get_mut(id).err().map(|e| e.status), Some(Status::Internal));
        assert!(TABLE.remove(id).is_ok());
        let again = TABLE.insert(2).unwrap();
        assert_eq!(*TABLE.get(again).unwrap(), 2);
    }
}
