//! Tables that grow without being held in memory: arrays whose elements are in a file, apart from the last ones and those that were
//! read recently.

use std::fmt::Debug;
use std::io;
use std::sync::{Arc, Mutex, PoisonError};

/// Space for what an exploration does not hold in memory. The caller provides it, since the language accesses no files.
pub trait SpillSpace: Debug + Send + Sync {
    /// Creates an empty file, which disappears when it is dropped.
    ///
    /// # Errors
    /// There is no space.
    fn create(&self) -> io::Result<Box<dyn SpillFile>>;
}

/// A file of a [`SpillSpace`]. Several threads read it at the same time; one writes to it while no other reads.
pub trait SpillFile: Debug + Send + Sync {
    /// Reads the bytes at an offset, all of which were written before.
    ///
    /// # Errors
    /// The file cannot be read.
    fn read_at(&self, bytes: &mut [u8], offset: u64) -> io::Result<()>;

    /// Writes bytes at the end, which is at this offset.
    ///
    /// # Errors
    /// The file cannot be written; there is no space, for example.
    fn append(&self, bytes: &[u8], offset: u64) -> io::Result<()>;
}

/// A space, and the first error of any of its files.
#[derive(Clone, Debug)]
pub(crate) struct Spill {
    space: Arc<dyn SpillSpace>,
    failed: Arc<Mutex<Option<String>>>,
}

impl Spill {
    pub fn new(space: Arc<dyn SpillSpace>) -> Self {
        Self {
            space,
            failed: Arc::default(),
        }
    }

    /// Returns the first error. After one, what is read is not what was written, so nothing that was found can be relied on.
    pub fn failed(&self) -> Option<String> {
        let failed = self.failed.lock();
        failed.unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn fail(&self, error: &io::Error) {
        let mut failed = self.failed.lock().unwrap_or_else(PoisonError::into_inner);
        failed.get_or_insert_with(|| error.to_string());
    }
}

/// An element of a table.
pub(crate) trait Element: Copy + Default + Debug + Send {
    /// Number of bytes in a file.
    const BYTES: usize;

    fn write(self, to: &mut Vec<u8>);

    /// Reads an element from as many bytes.
    fn read(from: &[u8]) -> Self;
}

impl Element for u8 {
    const BYTES: usize = 1;

    fn write(self, to: &mut Vec<u8>) {
        to.push(self);
    }

    fn read(from: &[u8]) -> Self {
        from.first().copied().unwrap_or_default()
    }
}

impl Element for u32 {
    const BYTES: usize = 4;

    fn write(self, to: &mut Vec<u8>) {
        to.extend(self.to_le_bytes());
    }

    fn read(from: &[u8]) -> Self {
        from.try_into().map_or(0, Self::from_le_bytes)
    }
}

impl Element for u64 {
    const BYTES: usize = 8;

    fn write(self, to: &mut Vec<u8>) {
        to.extend(self.to_le_bytes());
    }

    fn read(from: &[u8]) -> Self {
        from.try_into().map_or(0, Self::from_le_bytes)
    }
}

/// The words of a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct WordElement<const W: usize>(pub [u64; W]);

impl<const W: usize> Default for WordElement<W> {
    fn default() -> Self {
        Self([0; W])
    }
}

impl<const W: usize> Element for WordElement<W> {
    const BYTES: usize = 8 * W;

    fn write(self, to: &mut Vec<u8>) {
        self.0.into_iter().for_each(|word| word.write(to));
    }

    fn read(from: &[u8]) -> Self {
        let mut words = [0; W];
        for (word, bytes) in words.iter_mut().zip(from.chunks_exact(8)) {
            *word = u64::read(bytes);
        }
        Self(words)
    }
}

/// Bytes of a page: what is written or read at once.
const PAGE_BYTES: usize = 1 << 13;

/// Number of pages of a table that are held in memory besides the last one.
const PAGES: usize = 256;

/// Elements in the order in which they were added.
#[derive(Debug)]
pub(crate) enum Table<T> {
    Memory(Vec<T>),
    Spilled(Box<SpilledTable<T>>),
}

impl<T> Default for Table<T> {
    fn default() -> Self {
        Self::Memory(Vec::new())
    }
}

/// A table in a file.
#[derive(Debug)]
pub(crate) struct SpilledTable<T> {
    spill: Spill,
    /// `None` until the first page is full, and if it could not be created.
    file: Option<Box<dyn SpillFile>>,
    /// Number of elements in the file.
    written: usize,
    /// The elements after those.
    tail: Vec<T>,
    /// Pages that were read, each in the place that its number gives it.
    pages: Mutex<Vec<Option<Page<T>>>>,
}

#[derive(Debug)]
struct Page<T> {
    number: usize,
    elements: Vec<T>,
}

impl<T: Element> Table<T> {
    /// Returns an empty table, in a file if there is a space.
    pub fn new(spill: Option<&Spill>) -> Self {
        match spill {
            None => Self::default(),
            Some(spill) => Self::Spilled(Box::new(SpilledTable {
                spill: spill.clone(),
                file: None,
                written: 0,
                tail: Vec::new(),
                pages: Mutex::default(),
            })),
        }
    }

    /// Returns the number of elements.
    #[inline]
    pub fn len(&self) -> usize {
        match self {
            Self::Memory(all) => all.len(),
            Self::Spilled(spilled) => spilled.written + spilled.tail.len(),
        }
    }

    /// Adds an element.
    #[inline]
    pub fn push(&mut self, element: T) {
        match self {
            Self::Memory(all) => all.push(element),
            Self::Spilled(spilled) => spilled.push(element),
        }
    }

    /// Adds elements.
    pub fn extend(&mut self, elements: impl Iterator<Item = T>) {
        match self {
            Self::Memory(all) => all.extend(elements),
            Self::Spilled(spilled) => elements.for_each(|it| spilled.push(it)),
        }
    }

    /// Returns the element with an index; `None` if there is none, or if it cannot be read.
    #[inline]
    pub fn get(&self, index: usize) -> Option<T> {
        match self {
            Self::Memory(all) => all.get(index).copied(),
            Self::Spilled(spilled) => spilled.get(index),
        }
    }

    /// Appends the elements in a range, as far as there are any.
    pub fn read(&self, range: std::ops::Range<usize>, to: &mut Vec<T>) {
        match self {
            Self::Memory(all) => to.extend_from_slice(all.get(range).unwrap_or_default()),
            Self::Spilled(spilled) => to.extend(range.map_while(|index| spilled.get(index))),
        }
    }

    /// Returns `true` if these are the elements from an index on.
    pub fn is_at(&self, start: usize, elements: &[T]) -> bool
    where
        T: PartialEq,
    {
        match self {
            Self::Memory(all) => all.get(start..start + elements.len()) == Some(elements),
            Self::Spilled(spilled) => {
                let mut all = elements.iter().zip(start..);
                all.all(|(element, index)| spilled.get(index) == Some(*element))
            }
        }
    }

    /// Returns the memory in use, in bytes.
    pub fn memory(&self) -> usize {
        match self {
            Self::Memory(all) => all.capacity() * size_of::<T>(),
            Self::Spilled(spilled) => {
                // the greatest use, which does not depend on what has been read
                let pages = if spilled.file.is_some() { PAGES + 1 } else { 1 };
                pages * SpilledTable::<T>::PAGE * size_of::<T>()
            }
        }
    }
}

impl<T: Element> SpilledTable<T> {
    /// Number of elements in a page.
    const PAGE: usize = PAGE_BYTES / T::BYTES;

    fn push(&mut self, element: T) {
        self.tail.push(element);
        if self.tail.len() == Self::PAGE {
            if let Err(error) = self.write() {
                self.spill.fail(&error);
            }
            self.written += self.tail.len();
            self.tail.clear();
        }
    }

    fn write(&mut self) -> io::Result<()> {
        let mut bytes = Vec::with_capacity(PAGE_BYTES);
        self.tail.iter().for_each(|it| it.write(&mut bytes));
        let file = match &self.file {
            Some(file) => file,
            None => self.file.insert(self.spill.space.create()?),
        };
        file.append(&bytes, (self.written * T::BYTES) as u64)
    }

    fn get(&self, index: usize) -> Option<T> {
        if let Some(at) = index.checked_sub(self.written) {
            return self.tail.get(at).copied();
        }
        let number = index / Self::PAGE;
        let mut pages = self.pages.lock().unwrap_or_else(PoisonError::into_inner);
        if pages.is_empty() {
            pages.resize_with(PAGES, || None);
        }
        let place = pages.get_mut(number % PAGES)?;
        let known = place.as_ref().filter(|page| page.number == number);
        if known.is_none() {
            match self.page(number) {
                Ok(elements) => *place = Some(Page { number, elements }),
                Err(error) => {
                    self.spill.fail(&error);
                    return None;
                }
            }
        }
        let page = place.as_ref()?;
        page.elements.get(index % Self::PAGE).copied()
    }

    fn page(&self, number: usize) -> io::Result<Vec<T>> {
        let mut bytes = vec![0; Self::PAGE * T::BYTES];
        let file = self.file.as_ref().ok_or(io::ErrorKind::NotFound)?;
        file.read_at(&mut bytes, (number * Self::PAGE * T::BYTES) as u64)?;
        Ok(bytes.chunks_exact(T::BYTES).map(T::read).collect())
    }
}
