//! Storage of samples: a vector of their own, or shared memory that is never copied.

use std::fmt::{self, Debug, Formatter};
use std::ops::Deref;
use std::sync::Arc;

/// Samples in memory. They read as a slice.
pub struct Storage<T>(Place<T>);

enum Place<T> {
    Own(Vec<T>),
    Shared(Arc<dyn AsRef<[T]> + Send + Sync>),
}

impl<T> Storage<T> {
    /// Samples in shared memory, such as a map of a file or the buffer of an array. The memory is kept alive as long as
    /// the storage, or any clone of it.
    ///
    /// The memory must not change meanwhile: the same slice of the same values. Data derived from the samples are
    /// cached.
    pub fn shared(samples: Arc<dyn AsRef<[T]> + Send + Sync>) -> Self {
        Self(Place::Shared(samples))
    }

    /// Whether the memory is shared with another owner.
    pub fn is_shared(&self) -> bool {
        matches!(self.0, Place::Shared(_))
    }
}

impl<T: Send + Sync + 'static> Storage<T> {
    /// The same samples, owned by all clones together: from here on a clone copies nothing.
    #[must_use]
    pub fn into_shared(self) -> Self {
        match self.0 {
            Place::Own(samples) => Self::shared(Arc::new(samples)),
            shared => Self(shared),
        }
    }
}

impl<T: Clone> Storage<T> {
    /// The vector, to be changed; shared samples are copied first.
    pub fn to_mut(&mut self) -> &mut Vec<T> {
        if self.is_shared() {
            self.0 = Place::Own(self.to_vec());
        }
        match &mut self.0 {
            Place::Own(samples) => samples,
            Place::Shared(_) => unreachable!("shared samples have just been copied"),
        }
    }
}

impl<T> Deref for Storage<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        match &self.0 {
            Place::Own(samples) => samples,
            Place::Shared(samples) => samples.as_ref().as_ref(),
        }
    }
}

impl<T> AsRef<[T]> for Storage<T> {
    fn as_ref(&self) -> &[T] {
        self
    }
}

impl<T> From<Vec<T>> for Storage<T> {
    fn from(samples: Vec<T>) -> Self {
        Self(Place::Own(samples))
    }
}

impl<T: Send + Sync + 'static> From<Arc<[T]>> for Storage<T> {
    fn from(samples: Arc<[T]>) -> Self {
        Self::shared(Arc::new(samples))
    }
}

impl<T> FromIterator<T> for Storage<T> {
    fn from_iter<I: IntoIterator<Item = T>>(samples: I) -> Self {
        Vec::from_iter(samples).into()
    }
}

/// Clones of shared samples share them.
impl<T: Clone> Clone for Storage<T> {
    fn clone(&self) -> Self {
        Self(match &self.0 {
            Place::Own(samples) => Place::Own(samples.clone()),
            Place::Shared(samples) => Place::Shared(Arc::clone(samples)),
        })
    }
}

impl<T: PartialEq> PartialEq for Storage<T> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<T: Debug> Debug for Storage<T> {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        (**self).fmt(formatter)
    }
}
