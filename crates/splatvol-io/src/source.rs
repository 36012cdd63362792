//! Byte sources: regular files, slices, and the deflate family, with a bound on their length.
//!
//! [`Source::at_most`] is known before anything is read: the length of the rest of the file, times 1032 (the best
//! ratio that deflate can reach, RFC 1951) where it is compressed. A header's claims are checked against it, so that
//! a hundred bytes that claim 17 GB are refused without an allocation.

use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::{Component, Path, PathBuf};

use flate2::bufread::{GzDecoder, ZlibDecoder};

use crate::IoError;
use crate::error::Context;
use crate::files::{self, File};

/// Best ratio of deflate: 258 bytes from 2 bits.
const DEFLATE_RATIO: u64 = 1032;
/// Bytes that a tiny stream may yield beyond the ratio.
const DEFLATE_SLACK: u64 = 1024;
/// First growth step of a buffer whose final length is only declared.
const FIRST_CHUNK: usize = 1 << 20;

/// The containers of deflate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Codec {
    /// RFC 1952, any number of members.
    Gzip,
    /// RFC 1950.
    Zlib,
}

/// Bytes after the data that a header declares.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Rest {
    /// Nothing; checksums, if any, are right.
    Nothing,
    /// More bytes.
    Excess,
}

/// A buffered byte stream with a bound on its length.
pub(crate) struct Source<'a> {
    reader: Box<dyn BufRead + 'a>,
    at_most: u64,
    /// Length of what is read, where nothing is compressed: then the bound is exact.
    length: Option<u64>,
}

impl Source<'static> {
    /// Opens a regular file. Directories, FIFOs and devices are refused before they are opened, since opening one
    /// may block for ever.
    pub(crate) fn open(path: &Path) -> Result<Self, IoError> {
        Self::open_at(path, 0)
    }

    /// The same from a position on; nothing where the file ends before it.
    pub(crate) fn open_at(path: &Path, position: u64) -> Result<Self, IoError> {
        let open = |source| IoError::Open {
            source,
            path: path.to_owned(),
        };
        let metadata = files::metadata(path).map_err(open)?;
        if !metadata.is_file() {
            return Err(open(io::Error::other("not a regular file")));
        }
        let mut file = File::open(path).map_err(open)?;
        if position > 0 {
            file.seek(SeekFrom::Start(position)).map_err(open)?;
        }
        let length = metadata.len();
        let at_most = length.saturating_sub(position);
        Ok(Self {
            reader: Box::new(BufReader::with_capacity(1 << 16, file.take(at_most))),
            at_most,
            length: Some(length),
        })
    }
}

impl<'a> Source<'a> {
    /// The bytes of a slice.
    pub(crate) fn from_bytes(bytes: &'a [u8]) -> Self {
        Self {
            reader: Box::new(bytes),
            at_most: bytes.len() as u64,
            length: Some(bytes.len() as u64),
        }
    }

    /// A stream of `declared` bytes that another decoder of the deflate family produces from `compressed`
    /// bytes.
    pub(crate) fn from_decoder(reader: impl Read + 'a, compressed: u64, declared: u64) -> Self {
        let at_most = compressed
            .saturating_mul(DEFLATE_RATIO)
            .saturating_add(DEFLATE_SLACK);
        Self::bounded(reader, at_most.min(declared))
    }

    /// A stream from another decoder, of at most `at_most` bytes.
    pub(crate) fn bounded(reader: impl Read + 'a, at_most: u64) -> Self {
        Self {
            reader: Box::new(BufReader::new(reader)),
            at_most,
            length: None,
        }
    }

    /// The next bytes, at most as many, as a source of their own.
    pub(crate) fn part(&mut self, length: u64) -> Source<'_> {
        let at_most = self.at_most.min(length);
        Source {
            length: self.length.map(|_| at_most),
            reader: Box::new(self.take(length)),
            at_most,
        }
    }

    /// The decompressed bytes of this source.
    pub(crate) fn inflate(self, codec: Codec) -> Self {
        let Self { reader, at_most, .. } = self;
        Self {
            reader: match codec {
                Codec::Gzip => Box::new(BufReader::new(GzipMembers::new(reader))),
                Codec::Zlib => Box::new(BufReader::new(ZlibDecoder::new(reader))),
            },
            at_most: at_most
                .saturating_mul(DEFLATE_RATIO)
                .saturating_add(DEFLATE_SLACK),
            length: None,
        }
    }

    /// The most bytes that can still come; exact where nothing is compressed.
    pub(crate) fn at_most(&self) -> u64 {
        self.at_most
    }

    /// Bytes that were read before; `None` where they are not the file's own, but decompressed.
    pub(crate) fn position(&self) -> Option<u64> {
        self.length.map(|length| length - self.at_most)
    }

    /// The next bytes (as many as are buffered, none at the end), left in place.
    pub(crate) fn peek(&mut self, context: &Context<'_>) -> Result<&[u8], IoError> {
        self.reader.fill_buf().map_err(|error| context.read(error))
    }

    /// Refuses a declared length that this source cannot hold.
    pub(crate) fn check_declared(
        &self,
        what: &'static str,
        declared: u64,
        context: &Context<'_>,
    ) -> Result<(), IoError> {
        match (declared > self.at_most, self.length.is_some()) {
            (false, _) => Ok(()),
            (true, true) => Err(context.truncated(what, declared, self.at_most)),
            (true, false) => Err(context.too_small(what, declared, self.at_most)),
        }
    }

    /// Skips `count` bytes, or fails if there are fewer.
    pub(crate) fn skip(&mut self, count: u64, context: &Context<'_>) -> Result<(), IoError> {
        self.check_declared("skipped bytes", count, context)?;
        let skipped =
            io::copy(&mut self.by_ref().take(count), &mut io::sink()).map_err(|error| context.read(error))?;
        if skipped < count {
            return Err(context.truncated("skipped bytes", count, skipped));
        }
        Ok(())
    }

    /// Reads until `bytes` is full or the source ends; the number of bytes read.
    pub(crate) fn fill(&mut self, bytes: &mut [u8], context: &Context<'_>) -> Result<usize, IoError> {
        let mut filled = 0;
        while filled < bytes.len() {
            match self.read(&mut bytes[filled..]) {
                Ok(0) => break,
                Ok(read) => filled += read,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(context.read(error)),
            }
        }
        Ok(filled)
    }

    /// Exactly `declared` bytes. The buffer grows as they arrive and never beyond `declared`.
    pub(crate) fn read_bytes(
        &mut self,
        what: &'static str,
        declared: u64,
        context: &Context<'_>,
    ) -> Result<Vec<u8>, IoError> {
        self.check_declared(what, declared, context)?;
        let length = usize::try_from(declared).map_err(|_| context.limit(declared, usize::MAX as u64))?;
        let mut bytes: Vec<u8> = Vec::new();
        while bytes.len() < length {
            let start = bytes.len();
            grow(&mut bytes, length, context)?;
            let read = self.fill(&mut bytes[start..], context)?;
            if start + read < bytes.len() {
                return Err(context.truncated(what, declared, (start + read) as u64));
            }
        }
        Ok(bytes)
    }

    /// All remaining bytes: only for uncompressed sources, whose bound is their length.
    pub(crate) fn all_bytes(&mut self, context: &Context<'_>) -> Result<Vec<u8>, IoError> {
        debug_assert!(self.length.is_some(), "a compressed stream has no known length");
        self.read_bytes("contents", self.at_most, context)
    }

    /// Whether bytes follow. Reading past the end also makes the decoder check its checksum.
    pub(crate) fn rest(&mut self, context: &Context<'_>) -> Result<Rest, IoError> {
        match self.reader.fill_buf() {
            Ok([]) => Ok(Rest::Nothing),
            Ok(_) => Ok(Rest::Excess),
            Err(error) if error.get_ref().is_some_and(|inner| inner.is::<NotAMember>()) => Ok(Rest::Excess),
            Err(error) => Err(context.read(error)),
        }
    }
}

impl Read for Source<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.reader.read(buffer)?;
        self.at_most = self.at_most.saturating_sub(read as u64);
        Ok(read)
    }
}

impl BufRead for Source<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.reader.fill_buf()
    }

    fn consume(&mut self, amount: usize) {
        self.reader.consume(amount);
        self.at_most = self.at_most.saturating_sub(amount as u64);
    }
}

/// Lengthens `buffer` towards `length` by at most its own length (at least one chunk): memory grows with the data
/// that have arrived, not with the data that are promised.
pub(crate) fn grow<T: Copy + Default>(
    buffer: &mut Vec<T>,
    length: usize,
    context: &Context<'_>,
) -> Result<(), IoError> {
    let step = (length - buffer.len()).min(buffer.len().max(FIRST_CHUNK / size_of::<T>()));
    buffer.try_reserve_exact(step).map_err(|_| {
        let bytes = |count: usize| (count * size_of::<T>()) as u64;
        context.limit(bytes(length), bytes(buffer.len()))
    })?;
    buffer.resize(buffer.len() + step, T::default());
    Ok(())
}

/// The bytes after a gzip member are neither another member nor the end of the stream.
#[derive(Debug, thiserror::Error)]
#[error("the bytes after the end of the gzip stream are not gzip")]
struct NotAMember;

/// Decoder of all members of a gzip file, one after the other. flate2's own multi-member decoder cannot tell a bad
/// member from harmless padding after the last one.
struct GzipMembers<R: BufRead> {
    state: GzipState<R>,
}

enum GzipState<R: BufRead> {
    Member(Box<GzDecoder<R>>),
    End,
    Padding,
}

impl<R: BufRead> GzipMembers<R> {
    fn new(reader: R) -> Self {
        Self {
            state: GzipState::Member(Box::new(GzDecoder::new(reader))),
        }
    }
}

impl<R: BufRead> Read for GzipMembers<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if buffer.is_empty() {
            return Ok(0);
        }
        loop {
            match std::mem::replace(&mut self.state, GzipState::End) {
                GzipState::Member(mut decoder) => {
                    let read = decoder.read(buffer)?;
                    if read > 0 {
                        self.state = GzipState::Member(decoder);
                        return Ok(read);
                    }
                    let mut reader = decoder.into_inner();
                    self.state = match reader.fill_buf()? {
                        [] => GzipState::End,
                        [0x1f, 0x8b, ..] | [0x1f] => GzipState::Member(Box::new(GzDecoder::new(reader))),
                        _ => GzipState::Padding,
                    };
                }
                GzipState::End => return Ok(0),
                GzipState::Padding => {
                    self.state = GzipState::Padding;
                    return Err(io::Error::new(io::ErrorKind::InvalidData, NotAMember));
                }
            }
        }
    }
}

/// Reads a whole regular file; memory is bounded by its own length.
pub(crate) fn read_file(path: &Path, context: &Context<'_>) -> Result<Vec<u8>, IoError> {
    Source::open(path)?.all_bytes(context)
}

/// First bytes of a file in which the headers of most are.
pub(crate) const START: usize = 1 << 20;

/// Reads the first bytes of a regular file: as many, or all.
pub(crate) fn start_of_file(path: &Path, most: usize, context: &Context<'_>) -> Result<Vec<u8>, IoError> {
    let mut source = Source::open(path)?;
    let mut bytes = vec![0; most.min(usize::try_from(source.at_most()).unwrap_or(most))];
    let length = source.fill(&mut bytes, context)?;
    bytes.truncate(length);
    Ok(bytes)
}

/// Reads a whole regular file as text; memory is bounded by its own length. `format` is named in errors.
///
/// # Errors
/// Files that cannot be read, or are not UTF-8.
pub fn read_text(format: &'static str, path: impl AsRef<Path>) -> Result<String, IoError> {
    let path = path.as_ref();
    let context = Context::new(format, path);
    String::from_utf8(read_file(path, &context)?)
        .map_err(|error| context.field("contents", error, None, "text in UTF-8"))
}

/// The path of a data file that the header at `context.path` names in `field`.
///
/// Only names inside the header's folder are followed: no absolute path, no `..`, not the header itself, and no link
/// that leads out unless the context allows that; and it must be a regular file.
pub(crate) fn companion(
    name: &str,
    field: &'static str,
    offset: impl Into<Option<u64>>,
    context: &Context<'_>,
) -> Result<PathBuf, IoError> {
    let offset = offset.into();
    let inside = |component| matches!(component, Component::Normal(_) | Component::CurDir);
    if name.is_empty() || name.contains('\0') || !Path::new(name).components().all(inside) {
        let expected = "a file name inside the header's folder";
        return Err(context.field(field, name, offset, expected));
    }
    let folder = match context.path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let data = folder.join(name);
    let real = |path: &Path| {
        files::canonicalize(path).map_err(|source| match source.kind() {
            io::ErrorKind::NotFound => IoError::MissingDataFile {
                data: data.clone(),
                path: context.path.to_owned(),
            },
            _ => IoError::Open {
                source,
                path: path.to_owned(),
            },
        })
    };
    let (real_data, real_folder, real_header) = (real(&data)?, real(folder)?, real(context.path)?);
    if !real_data.starts_with(real_folder) && !context.allow_outside {
        return Err(IoError::Outside {
            link: data,
            target: real_data,
            path: context.path.to_owned(),
        });
    }
    if real_data == real_header {
        return Err(context.field(field, name, offset, "a data file, not the header itself"));
    }
    if !files::is_file(&real_data) {
        return Err(context.field(field, name, offset, "a regular file"));
    }
    Ok(data)
}

/// Refuses a link inside a folder that leads out of it, unless the context allows that. What does not exist passes.
pub(crate) fn check_inside(link: &Path, folder: &Path, context: &Context<'_>) -> Result<(), IoError> {
    if context.allow_outside {
        return Ok(());
    }
    let (Ok(target), Ok(folder)) = (files::canonicalize(link), files::canonicalize(folder)) else {
        return Ok(());
    };
    match target.starts_with(folder) {
        true => Ok(()),
        false => Err(IoError::Outside {
            link: link.to_owned(),
            target,
            path: context.path.to_owned(),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn context() -> Context<'static> {
        Context::new("test", Path::new("a.gz"))
    }

    /// Exactly `declared` decompressed bytes, and whether more would follow.
    fn inflate(
        codec: Codec,
        compressed: &[u8],
        declared: u64,
        context: &Context<'_>,
    ) -> Result<(Vec<u8>, Rest), IoError> {
        let mut source = Source::from_bytes(compressed).inflate(codec);
        let bytes = source.read_bytes("compressed data", declared, context)?;
        let rest = source.rest(context)?;
        Ok((bytes, rest))
    }

    fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    #[test]
    fn members_are_joined_and_padding_is_excess() {
        let mut file = [gzip(b"abc"), gzip(b""), gzip(b"def")].concat();
        let (bytes, rest) = inflate(Codec::Gzip, &file, 6, &context()).unwrap();
        assert_eq!((bytes.as_slice(), rest), (&b"abcdef"[..], Rest::Nothing));
        assert_eq!(
            inflate(Codec::Gzip, &file, 5, &context()).unwrap().1,
            Rest::Excess
        );
        file.extend([0; 9]);
        assert_eq!(
            inflate(Codec::Gzip, &file, 6, &context()).unwrap().1,
            Rest::Excess
        );
        let error = inflate(Codec::Gzip, &file, 7, &context()).unwrap_err();
        assert!(error.to_string().contains("not gzip"), "{error}");
    }

    #[test]
    fn a_wrong_checksum_is_an_error_although_all_bytes_came() {
        let mut file = gzip(b"abcdef");
        let crc = file.len() - 8;
        file[crc] ^= 1;
        assert!(matches!(
            inflate(Codec::Gzip, &file, 6, &context()),
            Err(IoError::Corrupt { .. })
        ));
    }

    #[test]
    fn a_bomb_is_refused_before_it_is_decoded() {
        let error = inflate(Codec::Gzip, &gzip(&[0; 100]), 17 << 30, &context()).unwrap_err();
        assert!(
            matches!(error, IoError::Truncated { at_most: true, .. }),
            "{error}"
        );
    }

    #[test]
    fn deflate_at_its_best_ratio_passes_the_guard() {
        let zeros = vec![0; 30 << 20];
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        encoder.write_all(&zeros).unwrap();
        let file = encoder.finish().unwrap();
        assert!(zeros.len() / file.len() > 900);
        assert_eq!(
            inflate(Codec::Gzip, &file, zeros.len() as u64, &context())
                .unwrap()
                .0,
            zeros
        );
    }

    #[test]
    fn memory_follows_the_data_and_stops_at_the_declared_length() {
        let mut buffer: Vec<u64> = Vec::new();
        grow(&mut buffer, 1 << 40, &context()).unwrap();
        assert_eq!(buffer.capacity() * 8, FIRST_CHUNK);
        grow(&mut buffer, (1 << 17) + 5, &context()).unwrap();
        assert_eq!((buffer.len(), buffer.capacity()), ((1 << 17) + 5, (1 << 17) + 5));
    }

    #[test]
    fn only_files_in_the_folder_are_followed() {
        let folder = tempfile::tempdir().unwrap();
        let header = folder.path().join("a.mhd");
        std::fs::write(&header, "x").unwrap();
        std::fs::write(folder.path().join("a.raw"), "x").unwrap();
        std::fs::create_dir(folder.path().join("d")).unwrap();
        let context = Context::new("test", &header);
        let find = |name: &str| companion(name, "file", 3, &context);
        assert!(find("a.raw").is_ok() && find("./a.raw").is_ok());
        for bad in [
            "",
            "/etc/passwd",
            "../a.raw",
            "d/../../a.raw",
            "a.mhd",
            "d",
            "d/../a.raw",
        ] {
            assert!(matches!(find(bad), Err(IoError::Format(_))), "{bad}");
        }
        assert!(matches!(find("b.raw"), Err(IoError::MissingDataFile { .. })));
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("/etc/passwd", folder.path().join("link")).unwrap();
            assert!(matches!(find("link"), Err(IoError::Outside { .. })));
            let allowed = Context {
                allow_outside: true,
                ..Context::new("test", &header)
            };
            assert!(companion("link", "file", 3, &allowed).is_ok());
        }
    }
}
