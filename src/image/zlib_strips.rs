//! Strips of a picture, each compressed on its own, and the one stream that they are joined to.
//!
//! A strip's own zlib stream ("ZLIB Compressed Data Format", RFC 1950) is a header, one block, and
//! a checksum. As a part of a longer stream, the block must not be marked as the last one, and it
//! is followed by an empty stored block, which ends on a byte boundary ("DEFLATE Compressed Data
//! Format", RFC 1951, 3.2.3 and 3.2.4), as after a sync flush of zlib.

/// The header of a stream whose compressor was fast.
const HEADER: [u8; 2] = [0x78, 0x01];

/// An empty stored block after its first three bits, which are 0 as is their padding.
const EMPTY_BLOCK: [u8; 4] = [0, 0, 0xff, 0xff];

/// An empty block of fixed codes, the last of a stream.
const LAST_BLOCK: [u8; 2] = [0x03, 0x00];

/// A part of a stream that begins and ends between two blocks, and between two bytes.
pub(super) struct ZlibStrip {
    blocks: Vec<u8>,
    /// Checksum and number of the bytes before compression.
    adler: u32,
    bytes: usize,
}

impl ZlibStrip {
    /// The strip of a stream that compresses this number of bytes in a single block, of which the
    /// last code ends in a set bit, as fdeflate writes it.
    pub(super) fn of_stream(stream: &[u8], bytes: usize) -> ZlibStrip {
        let adler = stream
            .last_chunk()
            .map_or(1, |sum| u32::from_be_bytes(*sum));
        let mut blocks = stream[HEADER.len()..stream.len() - 4].to_vec();
        // The first bit of a block is set in the last one.
        blocks[0] &= !1;
        // All bits above the highest set one are padding. The header of the next block fits there,
        // or it extends into another byte.
        if blocks.last().is_some_and(|last| last.leading_zeros() < 3) {
            blocks.push(0);
        }
        blocks.extend(EMPTY_BLOCK);
        ZlibStrip {
            blocks,
            adler,
            bytes,
        }
    }
}

/// State of a stream between two strips.
pub(super) struct StripStream {
    header: &'static [u8],
    adler: u32,
}

impl StripStream {
    pub(super) const START: StripStream = StripStream {
        header: &HEADER,
        adler: 1,
    };

    /// Adds a strip. Returns the bytes that continue the stream.
    pub(super) fn push(&mut self, strip: &ZlibStrip) -> Vec<u8> {
        self.adler = combined_adler(self.adler, strip.adler, strip.bytes);
        [std::mem::take(&mut self.header), &strip.blocks].concat()
    }

    /// The bytes that end the stream.
    pub(super) fn end(self) -> Vec<u8> {
        [&LAST_BLOCK[..], &self.adler.to_be_bytes()].concat()
    }
}

/// The Adler-32 checksum (RFC 1950, 8.2) of two sequences of bytes, one after the other, of which
/// the second has this length. The lower half is one plus the sum of all bytes, the upper half the
/// sum of the lower halves after each byte, both modulo a prime.
fn combined_adler(first: u32, second: u32, length: usize) -> u32 {
    const PRIME: u64 = 65_521;
    let halves = |adler: u32| (u64::from(adler & 0xffff), u64::from(adler >> 16));
    let ((low, high), (low_after, high_after)) = (halves(first), halves(second));
    // The sum of the first sequence's bytes, which the second's lower halves are short of.
    let before = low + PRIME - 1;
    let low = (before + low_after) % PRIME;
    let high = (high + high_after + length as u64 % PRIME * before) % PRIME;
    (high << 16 | low) as u32
}
